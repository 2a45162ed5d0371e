"""The figure of one run's world model on the building's probe."""

from __future__ import annotations

from pathlib import Path

from curionav_cli.results import plots
from curionav_cli.results.probing import plots as probe_plots
from curionav_cli.results.probing.curves import read, sort_into_fields


def draw(run: Path, folder: Path, names: tuple[str, str] | None = None) -> list[str]:
    """Draw probe.png of the run into `folder`; returns its name, none where nothing was measured.

    names: what to call its environment and its agent.
    """
    curve = read(run)
    if not curve:
        return []
    [field], _ = sort_into_fields([curve], {run: names} if names else {})
    plots.save(probe_plots.figure(field, plots.looks(field.looks())), folder / "probe.png")
    return ["probe.png"]
