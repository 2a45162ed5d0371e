"""curionav list: the groups of settings and their options, and every environment with its size."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.config import catalogue
from curionav_cli.config.compose import compose
from curionav_cli.config.override_errors import OverrideErrors
from curionav_cli.config.sources import opened
from curionav_cli.config.suggestions import closest, did_you_mean
from curionav_cli.errors import ConfigError, UserError
from curionav_cli.execution.screen import a_console, table

ENV_COLUMNS = (("env", "left"), ("floor m2", "right"), ("visitable m2", "right"), ("visitable cells", "right"),
               ("cell cm", "right"), ("", "left"))


def run(group: str | None, config_dir: Path | None) -> int:
    """Print the groups, or the options of one; returns the exit code. Raises ConfigError for an unknown group."""
    console = a_console()
    with opened("list", config_dir) as hydra:
        groups = catalogue.groups(hydra)
        if group is not None and group not in groups:
            raise ConfigError(f"There is no group {group}.{did_you_mean(closest(group, groups))} "
                              f"The groups are: {', '.join(groups)}.")
        if group == "env":
            rows = [(name, *environment(hydra, name)) for name in groups["env"]]
            console.print(table(ENV_COLUMNS, rows))
        elif group is not None:
            notes = [(name, catalogue.note(hydra, group, name)) for name in groups[group]]
            console.print(table(((group, "left"), ("", "left")), notes))
        else:
            rows = [(name, ", ".join(options)) for name, options in groups.items()]
            console.print(table((("group", "left"), ("options", "left")), rows))
            console.print("curionav list env   (or another group: what its options are)", highlight=False)
    return 0


def environment(hydra: Any, name: str) -> tuple[str, ...]:
    """The cells of an environment's row, or why it does not load. hydra: as `opened` returns it."""
    job = [f"env={name}"]
    try:
        settings, _ = compose(hydra, OverrideErrors(hydra, job), job)
        if settings.env.map is None and settings.env.size is None:
            return "", "", "", "", settings.env.note
        plan = build.scene(settings).plan
    except UserError as error:
        return "", "", "", "", f"does not load: {str(error).splitlines()[0]}"
    square = plan.cell**2
    return (f"{plan.floor.sum() * square:.2f}", f"{plan.visitable.sum() * square:.2f}",
            str(plan.visitable.sum()), f"{plan.cell * 100:g}", settings.env.note)
