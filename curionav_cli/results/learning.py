"""The course of learning over a run: losses, KL, entropies, errors, and whether surprise tells new views from known.

Readable over thousands of episodes: a run is cut into at most BINS stretches of equal length, and each is drawn as its
mean and the middle four fifths of its values. Numbers stand in a table of STAGES parts.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from curionav_cli.files import write_bytes
from curionav_cli.records import Prediction
from curionav_cli.results import plots, tables
from curionav_cli.results.lettering import wrapped
from curionav_cli.results.prediction import novelty
from curionav_cli.results.runs import Run
from curionav_cli.results.tables import Row

LEAST = 20  # episodes: the course of fewer is their table
BINS, STAGES = 100, 10
JUDGED = 4  # episodes of a stage whose surprise is judged
PANELS = (  # title, metrics that are drawn together
    ("loss of the world model", ("model_loss", "image_loss")),
    ("loss of policy and value", ("policy_loss", "value_loss")),
    ("KL, nats", ("kl", "curiosity_target")),
    ("squared error, five actions ahead", ("open_loop_mse_5", "repeat_mse_5")),
    ("entropy of the policy, nats", ("actor_entropy", "policy_entropy", "plan_entropy")),
    ("intrinsic reward, deviation", ("curiosity_reward_deviation", "reward_deviation")),
    ("correlation of reward and surprise", ("curiosity_correlation",)),
    ("value", ("critic_value", "critic_target", "value")), ("cells in an episode", ("cells_in_episode",)),
)
LINES = (("#0b5fa5", "-"), ("#c2410c", "--"), ("#15803d", ":"))
NOVELTY = "surprise, new over known views"


def draw(run: Run, folder: Path) -> list[str]:
    """Draw a run that learns, and write its table; returns their names in the folder, none of a short run."""
    metrics = run.folder.metrics()
    if len(metrics) < LEAST or not any(row.get("updates") for row in metrics):
        return []
    rows = list(stages(run, metrics))
    plots.save(figure(run, metrics, rows), folder / "learning.png")
    write_bytes(folder / "learning.csv", tables.comma_separated(rows).encode())
    return ["learning.png", "learning.csv"]


def stages(run: Run, metrics: list[Row]) -> Iterator[Row]:
    """Mean of every drawn metric, novelty ratio and AUC in each tenth of the run; None where there is nothing."""
    cuts = np.linspace(0, len(metrics), STAGES + 1).astype(int)
    ratios = separation(run, cuts)
    for stage, (first, end) in enumerate(pairwise(cuts.tolist())):
        found: Row = {"first_episode": first, "last_episode": end - 1, "steps": metrics[end - 1]["steps"]}
        for name in dict.fromkeys(name for _, names in PANELS for name in names):
            values = [row[name] for row in metrics[first:end] if name in row]
            found[name] = float(np.mean(values)) if values else None
        yield {**found, **ratios[stage]}


def separation(run: Run, cuts: np.ndarray) -> list[Row]:
    """Whether surprise separates new views from known, in each stage, from JUDGED episodes spread over it."""
    files = run.predictions
    stored = np.array(list(files), np.int64)
    inside = [stored[(stored >= first) & (stored < end)] for first, end in pairwise(cuts)]
    chosen = [some[np.linspace(0, len(some) - 1, min(JUDGED, len(some))).astype(int)] for some in inside]
    surprise = {int(index): Prediction.load_surprise(files[int(index)]) for some in chosen for index in some}
    judged = novelty.each(run, surprise)
    rows = []
    for some in chosen:
        parts = [judged[index] for index in some.tolist() if index in judged]
        whole = novelty.table(novelty.Views(*(np.concatenate(part, -1) for part in zip(*parts))))[0] if parts else {}
        rows.append({"novelty_ratio": whole.get("kl ratio"), "novelty_auc": whole.get("kl auc"),
                     "new_views": whole.get("new"), "known_views": whole.get("known")})
    return rows


def figure(run: Run, metrics: list[Row], rows: list[Row]) -> Figure:
    """Draw a panel for each group of metrics that the run has, and one of novelty."""
    shown = [(title, here) for title, names in PANELS
             if (here := [name for name in names if any(name in row for row in metrics)])]
    ratio = [(row["steps"], row["novelty_ratio"]) for row in rows if row["novelty_ratio"] is not None]
    down = -(-(len(shown) + bool(ratio)) // 3)
    drawn = Figure((9.6, 2.3 * down + 0.4), layout="constrained")
    panels = list(drawn.subplots(down, 3, squeeze=False).flat)
    for axes, (title, names) in zip(panels, shown):
        for name, look in zip(names, LINES):
            draw_line(axes, metrics, name, look)
        finish(axes, title, len(names) > 1)
    if ratio:
        panels[len(shown)].plot(*zip(*ratio), color=LINES[0][0], marker="o", markersize=3, linewidth=1.4)
        panels[len(shown)].axhline(1.0, color="#6b7280", linestyle=":", linewidth=1.0)
        finish(panels[len(shown)], NOVELTY, False)
    for axes in panels[len(shown) + bool(ratio):]:
        axes.set_axis_off()
    each = -(-len(metrics) // BINS)
    drawn.suptitle(wrapped(f"{run.label}: mean and middle four fifths of {each} episode{'s' * (each > 1)} each", 9.0),
                   fontsize=9)
    return drawn


def draw_line(axes: Axes, metrics: list[Row], name: str, look: tuple[str, str]) -> None:
    """Draw a metric as the mean and the middle four fifths of each stretch, over the steps at its end."""
    steps, low, mean, high = stretches([(row["steps"], row[name]) for row in metrics if name in row])
    axes.plot(steps, mean, color=look[0], linestyle=look[1], linewidth=1.3, label=name.replace("_", " "))
    axes.fill_between(steps, low, high, color=look[0], alpha=0.18, linewidth=0)


def stretches(points: list[tuple[int, float]]) -> np.ndarray:
    """Rows (4, at most BINS) of (step, value) points: last step, lower tenth, mean and upper tenth of each stretch."""
    parts: list[Any] = np.array_split(np.array(points, np.float64), min(BINS, len(points)))
    return np.array([[part[-1, 0], np.quantile(part[:, 1], 0.1), part[:, 1].mean(), np.quantile(part[:, 1], 0.9)]
                     for part in parts]).T


def finish(axes: Axes, title: str, named: bool) -> None:
    """Name a panel and its axis."""
    axes.set_title(title, loc="left", fontsize=8)
    axes.set_xlabel("steps", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    if named:
        axes.legend(fontsize=7)
