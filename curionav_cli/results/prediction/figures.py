"""Predictions of runs: figures, a line of errors and a table of surprise for every run that has predictions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.box import SIMPLE
from rich.table import Table

from curionav_cli.files import file_name
from curionav_cli.results import plots
from curionav_cli.results.prediction import novelty, stored_predictions
from curionav_cli.results.prediction import plots as prediction_plots
from curionav_cli.results.prediction.stored_predictions import Errors
from curionav_cli.results.runs import Run


def draw(run: Run, folder: Path) -> list[str]:
    """Draw a run's predictions and their error; returns file names, none where it has no predictions."""
    errors = stored_predictions.errors(run)
    if errors is None:
        return []
    last = max(run.predictions)
    held_out = f"{run.label}: episodes before learning from them"
    strips = prediction_plots.chosen(stored_predictions.strips(run))  # none of a run that kept no images
    figures = {**({"predictions": prediction_plots.pictures(strips, held_out)} if strips else {}),
               "prediction_error": prediction_plots.error_curve(
                   errors, run.agent, f"episodes {last - len(errors.predicted) + 1} to {last}", run.label)}
    for name, figure in figures.items():
        plots.save(figure, folder / f"{name}.png")
    return [f"{name}.png" for name in figures]


def draw_beside(runs: Sequence[Run], out: Path) -> list[Path]:
    """Draw a window of each environment in one figure, as in the paper; none where fewer than two have predictions."""
    first = {run.env: run for run in reversed(runs) if run.predictions}
    names = [env for env in dict.fromkeys(run.env for run in runs) if env in first]
    chosen = {env: prediction_plots.chosen(stored_predictions.strips(first[env])) for env in names}
    names = [env for env in names if chosen[env]]
    strips = [chosen[env][0] for env in names]
    if len({(strip.step.tobytes(), strip.unit) for strip in strips}) != 1 or len(names) < 2:
        return []
    plots.save(prediction_plots.pictures(strips, "Episodes before learning from them", names),
               out / "predictions.png")
    return [out / "predictions.png"]


def draw_seeds(runs: Sequence[Run], out: Path | None = None) -> list[Path]:
    """Draw the error over the seeds of one agent (or variant) in one environment, in `out` or the folder that has all.

    Nothing for runs that hold actions for different numbers of steps: there is no axis for both.
    """
    drawn = []
    for env, agent in dict.fromkeys((run.env, run.agent) for run in runs):
        same = [run for run in runs if (run.env, run.agent) == (env, agent)]
        several = [errors for run in same if (errors := stored_predictions.errors(run))]
        if len(several) < 2 or len({errors.every for errors in several}) > 1:
            continue
        above = {run.folder.path.resolve().parent for run in same}
        if not out and len(above) > 1:
            continue
        folder = out or next(iter(above)) / "figures"
        folder.mkdir(parents=True, exist_ok=True)
        figure = prediction_plots.error_curve(stored_predictions.over_runs(several), agent, f"{len(several)} seeds",
                                              f"{env}, {agent}")
        drawn.append(folder / f"prediction_error_{file_name(f'{env} {agent}')}.png")
        plots.save(figure, drawn[-1])
    return drawn


def line(run: Run) -> str | None:
    """Mean squared errors of open-loop prediction, as a line."""
    errors: Errors | None = stored_predictions.errors(run)
    if errors is None:
        return None
    actions = [n for n in (1, 5, 15) if n <= errors.predicted.shape[1]]
    ours, still = zip(*(errors.after(n) for n in actions))
    steps = errors.steps[np.array(actions) - 1]
    return (f"{run.label}: open-loop error after {numbers(steps, '{}')} {errors.unit} {numbers(ours, '{:.4f}')}, "
            f"of the repeated last frame {numbers(still, '{:.4f}')}, over the newest {len(errors.predicted)} episodes")


def surprise_table(run: Run) -> Table | None:
    """Table of surprise and predicted reward of new and known views; None where there are too few predictions."""
    found = novelty.views(run)
    if found is None:
        return None
    table = Table(box=SIMPLE, pad_edge=False, caption_justify="left", title_justify="left", title=run.label,
                  caption="KL in nats and predicted reward, before learning from the episode. New: no earlier view "
                          f"that way within {novelty.NEW} m; known: within {novelty.KNOWN} m. KL by position in a "
                          "window: " + ", ".join(f"{n}: {nats:.1f}" for n, nats in novelty.by_position(found).items()))
    headings = ["views", "new", "known", *(f"{signal} {key}" for signal in novelty.SIGNALS
                                           for key in ("new", "known", "ratio", "auc"))]
    for heading in headings:
        table.add_column(heading, justify="left" if heading == "views" else "right", no_wrap=True)
    for row in novelty.table(found):
        table.add_row(*(written(row[heading]) for heading in headings))
    return table


def written(cell: str | float | None) -> str:
    return "-" if cell is None else f"{cell:.2f}" if isinstance(cell, float) else str(cell)


def numbers(values: Sequence[float] | np.ndarray, form: str) -> str:
    return ", ".join(form.format(value) for value in values)
