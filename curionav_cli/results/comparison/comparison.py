"""What is compared with what: arms in environments, up to a number of steps that all of them lived; and by how much.

The measures of one run, all up to the environment's horizon: the area under the coverage curve (the primary one), the
coverage there and at earlier steps, the steps to 50, 80 and 90 %, and what it cost.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from curionav_cli.results.comparison.run_summaries import RunSummary
from curionav_cli.results.labels import labels, world_labels

SHARES = (50, 80, 90)  # per cent


@dataclass(frozen=True)
class Field:
    """One environment. horizon: steps that are compared; arms: label -> the lives of its seeds, in their order."""

    env: str
    horizon: int
    arms: dict[str, list[RunSummary]]

    def ordered(self, arms: Iterable[str]) -> Field:
        """The same with its arms in this order."""
        return Field(self.env, self.horizon, {arm: self.arms[arm] for arm in arms if arm in self.arms})

    def scores(self, arm: str) -> np.ndarray:
        """(n,) areas under the coverage curve, in the order of seeds."""
        return np.array([life.curve.until(self.horizon).area() for life in self.arms[arm]])

    def difference(self, ours: str, theirs: str) -> np.ndarray:
        """(n,) differences of the area, ours - theirs, of the seeds that both arms lived."""
        mine, other = (dict(zip((life.seed for life in self.arms[arm]), self.scores(arm))) for arm in (ours, theirs))
        return np.array([mine[seed] - other[seed] for seed in mine if seed in other])

    def shares(self, arm: str, steps: np.ndarray) -> np.ndarray:
        """(n, K) coverage after each of these steps."""
        return np.array([life.curve.at(steps) / life.curve.total for life in self.arms[arm]])


@dataclass(frozen=True)
class Comparison:
    """fields: one for each environment that was lived in; arms: label -> name of its agent, in order of appearance.

    names: (environment, arm) of every life. left_out: lives that are in no field, each with the reason.
    """

    fields: list[Field]
    arms: dict[str, str]
    names: dict[RunSummary, tuple[str, str]]
    left_out: dict[RunSummary, str]

    @property
    def common(self) -> list[Field]:
        """The environments in which every arm lived."""
        return [field for field in self.fields if field.arms.keys() == self.arms.keys()]


def compare(lives: Sequence[RunSummary]) -> Comparison:
    """Sort lives into environments and arms."""
    arms = labels([life.agent for life in lives], [life.arm for life in lives], [life.preset for life in lives])
    envs = world_labels([life.env for life in lives], [life.world for life in lives])
    names = dict(zip(lives, zip(envs, arms)))
    left_out = again(names)
    fields = [field_of(env, {life: names[life][1] for life in lives if names[life][0] == env}, left_out)
              for env in dict.fromkeys(envs)]
    present = {arm: life.agent for life, (_, arm) in names.items() if life not in left_out}
    return Comparison([field.ordered(present) for field in fields], present, names, left_out)


def again(names: dict[RunSummary, tuple[str, str]]) -> dict[RunSummary, str]:
    """Lives that another stands for already: whole ones and long ones first."""
    first: dict[tuple[str, str, int], RunSummary] = {}
    for life in sorted(names, key=lambda life: (not life.whole, -life.steps)):
        first.setdefault((*names[life], life.seed), life)
    return {life: f"the same arm, environment and seed as {first[*names[life], life.seed].folder}"
            for life in names if first[*names[life], life.seed] is not life}


def field_of(env: str, arms: dict[RunSummary, str], left_out: dict[RunSummary, str]) -> Field:
    """One environment, up to the end of its shortest whole life (if none is whole, of its shortest).

    arms: the arm of every life in it. Adds those that are shorter to left_out.
    """
    lives = [life for life in arms if life not in left_out]
    horizon = min([life.steps for life in lives if life.whole] or [life.steps for life in lives])
    short = [life for life in lives if life.steps < horizon]
    left_out |= {life: f"{life.steps:,} steps, and {horizon:,} are compared" for life in short}
    field = Field(env, horizon, {})
    for life in sorted(set(lives) - set(short), key=lambda life: life.seed):
        field.arms.setdefault(arms[life], []).append(life)
    return field


def measures(life: RunSummary, horizon: int, at: Sequence[int]) -> dict[str, Any]:
    """The numbers of one run; shares between 0 and 1, None where a share was not reached or a cost not noted."""
    curve = life.curve.until(horizon)
    spent = {key: None if np.isnan(number) else number for key, number in life.spent(horizon).items()}
    return {
        "coverage": int(curve.at(horizon)) / curve.total,
        **{f"coverage_at_{step}": int(curve.at(step)) / curve.total for step in at if step <= horizon},
        "area_under_curve": curve.area(), **{f"steps_to_{share}": curve.steps_to(share / 100) for share in SHARES},
        **spent,
    }
