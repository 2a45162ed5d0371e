"""The paper's figures of coverage at the paper's own axes, from runs of any length: a curve ends where its run ends.

Apartments a to d (2 M steps of ours, 5 M of C-BET), the small room's run 1 and run 2 (280 k), the large lab (600 k),
and the best heatmaps side by side.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from curionav_cli.files import file_name, read_json
from curionav_cli.results import panels, plots
from curionav_cli.results.comparison.comparison import Comparison
from curionav_cli.results.comparison.run_summaries import RunSummary
from curionav_cli.results.labels import scene_name
from curionav_cli.results.lettering import wrapped
from curionav_cli.results.plots import MAXIMUM, Look
from curionav_cli.results.runs import Run
from curionav_cli.results.tables import Columns, Row
from curionav_cli.storage.run_folder import RunFolder

APARTMENTS = ("apartment_0", "apartment_1", "apartment_2")
UNTIL = {**dict.fromkeys(APARTMENTS, 5_000_000), "small_room": 280_000, "large_lab": 600_000}  # the paper's axes
OURS, OURS_BY, OURS_UNTIL = "lbs_dreamer", "lbs", 2_000_000  # in the apartments
ALONE = {"small_room": 2, "large_lab": 1}  # environments whose figure shows our runs alone, and how many
POINTS = 400

COLUMNS: Columns = (
    ("env", "env", "{}"), ("arm", "arm", "{}"), ("seed", "seed", "{}"), ("state", "state", "{}"),
    ("steps", "steps", "{:,}"), ("the paper's", "planned", "{:,}"), ("coverage", "coverage", "{:.1%}"),
    ("area", "area", "{:.3f}"), ("CPU-hours", "hours", "{:.2f}"), ("commit", "commit", "{}"),
    ("folder", "folder", "{}"))


class Drawn(NamedTuple):
    """A run in a figure: the names of its environment and arm, and the scene's."""

    env: str
    arm: str
    scene: str
    run: RunSummary

    @property
    def ours(self) -> bool:
        """Whether it is the paper's agent in the paper's world: by surprise, with what changes there."""
        by = self.run.arm.get("agent.curiosity", OURS_BY)
        return (self.run.agent, by) == (OURS, OURS_BY) and bool(self.run.env.get("changes", True))

    @property
    def planned(self) -> int | None:
        """Steps after which the paper's curve of this agent ends; None where it has none."""
        ours = self.scene in APARTMENTS and not self.run.agent.startswith("cbet")
        return OURS_UNTIL if ours else UNTIL.get(self.scene)


def drawn(comparison: Comparison) -> list[Drawn]:
    """Every run once, the longest of those with the same arm, environment and seed."""
    names = {run: name for run, name in comparison.names.items()
             if "the same arm" not in comparison.left_out.get(run, "")}
    return [Drawn(env, arm, scene_name(run.env), run) for run, (env, arm) in names.items()]


def figures(runs: Sequence[Drawn], look: dict[str, Look]) -> Iterator[tuple[str, Figure]]:
    """Draw every figure that there are runs for; yields its name and itself."""
    for name, scenes in (("apartments", APARTMENTS), ("small_room_arms", ("small_room",)),
                         ("large_lab_arms", ("large_lab",))):
        here = [one for one in runs if one.scene in scenes]
        if here:
            yield name, curves(here, look)
    for scene, most in ALONE.items():
        ours = sorted((one for one in runs if one.scene == scene and one.ours), key=by_seed)[:most]
        if ours:
            yield scene, panels.beside([opened(one) for one in ours], UNTIL[scene])
    for env in dict.fromkeys(one.env for one in runs):
        yield f"best_{file_name(env)}", plots.heatmaps([opened(one) for one in best(runs, env)])


def by_seed(one: Drawn) -> str:
    return str(one.run.seed)


def best(runs: Sequence[Drawn], env: str) -> list[Drawn]:
    """The run of each arm that covered most of an environment, at its own end."""
    found: dict[str, Drawn] = {}
    for one in runs:
        if one.env == env and (one.arm not in found or len(one.run.curve.found) > len(found[one.arm].run.curve.found)):
            found[one.arm] = one
    return list(found.values())


def opened(one: Drawn) -> Run:
    """The run with its visits to every cell, named as in the other figures."""
    return Run(RunFolder(one.run.folder), variant=one.arm.removeprefix(one.run.agent), world=one.env)


def curves(runs: Sequence[Drawn], look: dict[str, Look]) -> Figure:
    """Draw a panel for each environment, and one of the mean share over them where there are several scenes."""
    envs, several = list(dict.fromkeys(one.env for one in runs)), len({one.scene for one in runs}) > 1
    count = len(envs) + several
    figure = Figure((0.6 + 3.3 * min(count, 4), 0.9 + 3.1 * -(-count // 4)), layout="constrained")
    all_axes = list(figure.subplots(-(-count // 4), min(count, 4), squeeze=False).flat)
    for letter, axes, env in zip("abcdefgh", all_axes, envs):
        here = [one for one in runs if one.env == env]
        draw_cells(axes, here, look)
        axes.set_title(wrapped(f"{letter}  {env}", 2.6), loc="left")
    if several:
        draw_mean(all_axes[len(envs)], runs, envs, look)
        all_axes[len(envs)].set_title(f"{'abcdefgh'[len(envs)]}  over all runs", loc="left")
    for axes in all_axes[count:]:
        axes.set_axis_off()
    handles = {label: line for axes in all_axes for line, label in zip(*axes.get_legend_handles_labels())}
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=min(4, max(1, count)))
    words = "every run to its own end (dot), and the mean up to the end of the shortest"
    figure.suptitle(wrapped(words, 3.3 * min(count, 4)), fontsize=9)
    return figure


def draw_cells(axes: Axes, runs: Sequence[Drawn], look: dict[str, Look]) -> None:
    """Draw visited cells and their share over the paper's steps; the number of cells is dotted."""
    cells = runs[0].run.curve.cells
    for arm in dict.fromkeys(one.arm for one in runs):
        same = [one for one in runs if one.arm == arm]
        colour, dashes, _ = look[arm]
        for one in same:
            steps = moments(one.run.steps)
            axes.plot(steps, one.run.curve.at(steps), color=colour, linewidth=0.5, alpha=0.6)
            axes.plot(steps[-1], one.run.curve.at(steps[-1]), ".", color=colour, markersize=4)
        steps = moments(min(one.run.steps for one in same))
        axes.plot(steps, np.mean([one.run.curve.at(steps) for one in same], axis=0), color=colour, linestyle=dashes,
                  linewidth=1.6, label=arm)
    until = UNTIL.get(runs[0].scene, max(one.run.steps for one in runs))
    axes.set(xlabel=f"steps{cut_short(runs)}", ylabel=f"visited of {cells:,} cells", xlim=(0, until))
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    plots.draw_total(axes, cells, "visitable")


def cut_short(runs: Sequence[Drawn]) -> str:
    """In words, which arms end before the paper's curve does."""
    short = {one.arm: min(other.run.steps for other in runs if other.arm == one.arm)
             for one in runs if one.planned and one.run.steps < one.planned}
    words = [f"{arm} ends at {EngFormatter(sep='')(steps)}" for arm, steps in short.items()]
    return wrapped(f"\n{'; '.join(words)}", 3.0) if words else ""


def draw_mean(axes: Axes, runs: Sequence[Drawn], envs: Sequence[str], look: dict[str, Look]) -> None:
    """Draw the mean over environments of the mean share over seeds, of arms that have runs in all of them."""
    for arm in dict.fromkeys(one.arm for one in runs):
        each = [[one.run for one in runs if (one.arm, one.env) == (arm, env)] for env in envs]
        if all(each):
            steps = moments(min(run.steps for same in each for run in same))
            share = np.mean([np.mean([100 * run.curve.at(steps) / run.curve.cells for run in same], axis=0)
                             for same in each], axis=0)
            axes.plot(steps, share, color=look[arm].color, linestyle=look[arm].dashes, linewidth=1.6, label=arm)
    axes.axhline(100, color=MAXIMUM, linestyle=":", linewidth=1.4)
    axes.set(xlabel="steps", ylabel="mean share of the cells (%)", ylim=(0, 104),
             xlim=(0, max(UNTIL.get(one.scene, one.run.steps) for one in runs)))
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))


def moments(steps: int) -> np.ndarray:
    """The steps at which a curve that ends there is drawn."""
    return np.unique(np.linspace(0, steps, POINTS + 1).astype(int))


def rows(runs: Sequence[Drawn]) -> list[Row]:
    """A row for each run: how far it came of the paper's steps, what it covered and what it cost."""
    return [row(one) for one in runs]


def row(one: Drawn) -> Row:
    run = one.run
    seconds, about = run.budget["cpu_seconds"][-1], read_json(run.folder / "run.json")
    return {"env": one.env, "arm": one.arm, "seed": run.seed, "state": run.state, "steps": run.steps,
            "planned": one.planned, "coverage": int(run.curve.at(run.steps)) / run.curve.cells,
            "area": run.curve.area(), "hours": None if np.isnan(seconds) else float(seconds) / 3600,
            "commit": str(about.get("git_commit") or "")[:7] or None, "folder": str(run.folder)}
