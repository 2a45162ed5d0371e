"""What is compared with what: arms in environments, up to a number of steps that all of them have; and by how much.

The measures of one run, all up to the environment's horizon: the area under the coverage curve (the primary one), the
coverage there and at earlier steps, the steps to 50, 80, 90 and 99 % of the counted cells, the step at which the agent
said that nothing was left, and what it cost.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from curionav_cli.results.comparison.run_summaries import RunSummary
from curionav_cli.results.labels import labels, world_labels

SHARES = (50, 80, 90, 99)  # per cent
TWICE = "the same arm, environment and seed as"  # a run that is left out


@dataclass(frozen=True)
class Field:
    """One environment. horizon: steps that are compared; arms: label -> its runs, in the order of seeds."""

    env: str
    horizon: int
    arms: dict[str, list[RunSummary]]

    def ordered(self, arms: Iterable[str]) -> Field:
        """Copy with the arms in this order."""
        return Field(self.env, self.horizon, {arm: self.arms[arm] for arm in arms if arm in self.arms})

    def scores(self, arm: str) -> np.ndarray:
        """Areas under the coverage curve (n,), in the order of seeds."""
        return np.array([run.curve.until(self.horizon).area() for run in self.arms[arm]])

    def difference(self, ours: str, theirs: str) -> np.ndarray:
        """Differences of the area (n,), ours - theirs, of the seeds that both arms have."""
        mine, other = (dict(zip((run.seed for run in self.arms[arm]), self.scores(arm))) for arm in (ours, theirs))
        return np.array([mine[seed] - other[seed] for seed in mine if seed in other])

    def shares(self, arm: str, steps: np.ndarray) -> np.ndarray:
        """Coverage (n, K) after each of these steps, between 0 and 1."""
        return np.array([run.curve.at(steps) / run.curve.cells for run in self.arms[arm]])


@dataclass(frozen=True)
class Comparison:
    """Runs sorted into environments and arms.

    fields: one for each environment; arms: label -> name of its agent, in order of appearance.
    names: (environment, arm) of every run. left_out: runs that are in no field, each with the reason.
    """

    fields: list[Field]
    arms: dict[str, str]
    names: dict[RunSummary, tuple[str, str]]
    left_out: dict[RunSummary, str]

    @property
    def common(self) -> list[Field]:
        """The environments in which every arm has runs."""
        return [field for field in self.fields if field.arms.keys() == self.arms.keys()]


def compare(runs: Sequence[RunSummary]) -> Comparison:
    """Sort runs into environments and arms."""
    arms = labels([run.agent for run in runs], [run.arm for run in runs], [run.preset for run in runs])
    envs = world_labels([run.env for run in runs], [run.world for run in runs])
    names = dict(zip(runs, zip(envs, arms)))
    left_out = duplicates(names)
    fields = [field_of(env, {run: names[run][1] for run in runs if names[run][0] == env}, left_out)
              for env in dict.fromkeys(envs)]
    present = {arm: run.agent for run, (_, arm) in names.items() if run not in left_out}
    return Comparison([field.ordered(present) for field in fields], present, names, left_out)


def duplicates(names: dict[RunSummary, tuple[str, str]]) -> dict[RunSummary, str]:
    """Find runs that another stands for already: whole ones and long ones stand first."""
    first: dict[tuple[str, str, int | str], RunSummary] = {}
    for run in sorted(names, key=lambda run: (not run.whole, -run.steps)):
        first.setdefault((*names[run], run.seed), run)
    return {run: f"{TWICE} {first[*names[run], run.seed].folder}"
            for run in names if first[*names[run], run.seed] is not run}


def field_of(env: str, arms: dict[RunSummary, str], left_out: dict[RunSummary, str]) -> Field:
    """Make the field of one environment, up to the end of its shortest whole run (if none is whole, of its shortest).

    arms: the arm of every run in it. Adds those that are shorter to left_out.
    """
    runs = [run for run in arms if run not in left_out]
    horizon = min([run.steps for run in runs if run.whole] or [run.steps for run in runs])
    short = [run for run in runs if run.steps < horizon]
    left_out |= {run: f"{run.steps:,} steps, and {horizon:,} are compared" for run in short}
    field = Field(env, horizon, {})
    for run in sorted(set(runs) - set(short), key=lambda run: (isinstance(run.seed, str), run.seed)):
        field.arms.setdefault(arms[run], []).append(run)
    return field


def measures(run: RunSummary, horizon: int, at: Sequence[int]) -> dict[str, Any]:
    """Measure one run up to the horizon; shares between 0 and 1, None where not reached or not noted."""
    curve = run.curve.until(horizon)
    spent = {key: None if np.isnan(number) else number for key, number in run.spent(horizon).items()}
    return {
        "coverage": int(curve.at(horizon)) / curve.cells,
        **{f"coverage_at_{step}": int(curve.at(step)) / curve.cells for step in at if step <= horizon},
        "area_under_curve": curve.area(), **{f"steps_to_{share}": curve.steps_to(share / 100) for share in SHARES},
        "steps_to_explored": run.explored if run.explored and run.explored <= horizon else None,
        **spent,
    }
