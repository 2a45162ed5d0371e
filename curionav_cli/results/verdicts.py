"""Verdicts on the paper's claims, by the rules of docs/paper-length.md, which were declared before the runs.

A claim is seen or not seen where nothing that is missing of the declared runs could change it, and otherwise not
decided.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from curionav_cli.results.paper_lengths import APARTMENTS, COUNTS, OURS, OURS_UNTIL, UNTIL, Drawn
from curionav_cli.results.tables import Columns, Row, percent
from curionav_cli.results.unfinished import (
    FAR,
    NEAR,
    UNDECIDED,
    UNKNOWN,
    Bounds,
    Runs,
    covered,
    given,
    mean,
    most,
    near_dock,
    reached,
)

DECLARED = {"large_lab": (0, 1), "small_room": (0, 1), **dict.fromkeys(APARTMENTS, (0,))}  # seeds of ours
WALKS, CONTROLS = (0, 1, 2), (0,)  # seeds of bounce, and of the shuffled control
CBETS = 3  # arms of C-BET
LAB_SHARE, TIMES = 0.55, 5.0
ROOM_STEPS, ROOM_SHARE = 140_000, 0.8
POINTS = 0.05  # of coverage: more than C-BET, or level with it

COLUMNS: Columns = (
    ("claim", "claim", "{}"), ("seen where", "rule", "{}"), ("env", "env", "{}"), ("arm", "arm", "{}"),
    ("ours", "ours", "{}"), ("n", "n", "{}"), ("steps", "steps", "{}"), ("could still be", "bounds", "{}"),
    ("verdict", "verdict", "{}"))
AGAINST_COLUMNS: Columns = (
    ("env", "env", "{}"), ("arm", "arm", "{}"), ("minus", "minus", "{}"), ("steps", "steps", "{:,}"),
    ("runs", "n", "{}"), ("coverage", "coverage", "{:.1%}"), ("of the other", "other", "{:.1%}"),
    ("difference, points", "difference", "{:+.1f}"), ("difference of the area", "area", "{:+.4f}"))


class Claim(NamedTuple):
    """What is claimed, the rule in words, within what the number must lie, and how that is written."""

    words: str
    rule: str
    within: tuple[float, float]
    form: str = ".1%"

    def row(self, name: tuple[str, str], runs: Runs, steps: int, ours: str, bounds: Bounds, alone: Bounds) -> Row:
        """A row of the table.

        name: environment and arm. ours: the number up to where the runs go. bounds: of the number of all declared runs;
        alone: of that of those which there are.
        """
        there = " and ".join(f"{min(run.steps, steps):,}" for run in given(runs).values())
        verdict, own = (one.verdict(*self.within) for one in (bounds, alone))
        return {"claim": self.words, "rule": self.rule, "env": name[0], "arm": name[1], "ours": ours if there else None,
                "n": f"{len(given(runs))} of {len(runs)}", "steps": f"{there or 0} of {steps:,}",
                "bounds": bounds.written(self.form) if verdict == UNDECIDED else None,
                "verdict": f"{verdict}; of these runs alone: {own}" if there and own != verdict else verdict,
                "low": bounds.low, "high": bounds.high}


def rows(shown: Sequence[Drawn]) -> list[Row]:
    """A row for each claim of the paper, and for each of the two questions beyond it."""
    return [*lab(shown), *room(shown), *(row for env in APARTMENTS for row in apartment(shown, env)), *beyond(shown)]


def ours(shown: Sequence[Drawn], scene: str) -> dict[tuple[str, str], Runs]:
    """The paper's agent in a scene: its runs by (environment, arm), those that were declared at least."""
    here = [one for one in shown if one.ours and one.scene == scene]
    names = dict.fromkeys((one.env, one.arm) for one in here) or {(scene, OURS): None}
    return {name: by_seed([one for one in here if (one.env, one.arm) == name], DECLARED[scene]) for name in names}


def by_seed(runs: Sequence[Drawn], declared: Sequence[int]) -> Runs:
    return {**dict.fromkeys(declared), **{one.run.seed: one.run for one in runs}}


def lab(shown: Sequence[Drawn]) -> Iterator[Row]:
    """60 % of the lab, and where in it."""
    steps = UNTIL["large_lab"]
    share = Claim("60 % of the lab in 600 k steps", f"mean of its runs is {LAB_SHARE:.0%} or more", (LAB_SHARE, np.inf))
    near = Claim("thoroughly near the dock, missing the rest", f"mean visits of a visitable cell within {NEAR:g} m of "
                 f"the dock are {TIMES:g} times those beyond {FAR:g} m or more", (TIMES, np.inf), ".1f")
    for name, runs in ours(shown, "large_lab").items():
        yield share.row(name, runs, steps, shares(runs, steps), mean(runs, steps), mean(given(runs), steps))
        (now, bounds), (_, alone) = (near_dock(some, steps) for some in (runs, given(runs)))
        words = f"{now:.1f} times" if np.isfinite(now) else f"never beyond {FAR:g} m"
        yield near.row(name, runs, steps, words, bounds, alone)


def room(shown: Sequence[Drawn]) -> Iterator[Row]:
    """Over 80 % of the small room."""
    claim = Claim("over 80 % of the small room in 140 k steps", f"one of its two runs is above {ROOM_SHARE:.0%}",
                  (np.nextafter(ROOM_SHARE, 1), np.inf))
    for name, runs in ours(shown, "small_room").items():
        bounds, alone = (most([UNKNOWN] * (not some) + [covered(run, ROOM_STEPS) for run in some.values()])
                         for some in (runs, given(runs)))
        yield claim.row(name, runs, ROOM_STEPS, shares(runs, ROOM_STEPS), bounds, alone)


def apartment(shown: Sequence[Drawn], scene: str) -> Iterator[Row]:
    """More than C-BET in apartments 0 and 1, level with it in 2: ours at its end beside the best arm at C-BET's."""
    where = scene.replace("_", " ")
    claim = Claim(f"level with C-BET in {where}", f"{OURS} at 2 M within five points of the best C-BET at 5 M",
                  (-POINTS, POINTS), "+.1%")
    if scene != APARTMENTS[2]:
        claim = Claim(f"more than C-BET in {where}", f"{OURS} at 2 M five points or more above the best C-BET at 5 M",
                      (POINTS, np.inf), "+.1%")
    for name, runs in ours(shown, scene).items():
        arms = cbets(shown, name[0])
        each = [mean(theirs, UNTIL[scene]) for theirs in arms.values()]
        bounds = mean(runs, OURS_UNTIL).less(most(each + [UNKNOWN] * (CBETS - len(arms))))
        alone = mean(given(runs), OURS_UNTIL).less(most(each or [UNKNOWN]))
        words = f"{shares(runs, OURS_UNTIL)}{beside_best(arms, UNTIL[scene])}; {len(arms)} of {CBETS} arms"
        yield claim.row(name, runs, OURS_UNTIL, words, bounds, alone)


def beside_best(arms: Mapping[str, Runs], steps: int) -> str:
    """In words, which arm of C-BET covered most, in how many steps; empty where there is none."""
    share = {arm: float(np.mean(reached(runs, steps))) for arm, runs in arms.items()}
    best = max(share, key=lambda arm: share[arm], default="")
    return best and f" beside {percent(share[best])} ({best}, {shortest(arms[best]):,} steps)"


def shortest(*arms: Runs) -> int:
    """Steps that all given runs of some arms have."""
    return min(run.steps for runs in arms for run in given(runs).values())


def cbets(shown: Sequence[Drawn], env: str) -> dict[str, Runs]:
    """Runs of each arm of C-BET in an environment, those with its own reward."""
    here = [one for one in shown if one.env == env and one.run.agent in ("cbet", "cbet_lifelong")
            and one.run.arm.get("agent.reward", "cbet") == "cbet"]
    return {arm: by_seed([one for one in here if one.arm == arm], ()) for arm in dict.fromkeys(one.arm for one in here)}


def others(shown: Sequence[Drawn], env: str) -> list[tuple[str, str, Runs]]:
    """What ours is asked to pass in an environment: a question, the arm and its runs."""
    found = []
    for question, agent, curiosity, declared in (("passes bounce", "bounce", None, WALKS),
                                                 ("passes its shuffled control", OURS, "shuffled", CONTROLS)):
        here = [one for one in shown if one.env == env
                and (one.run.agent, one.run.arm.get("agent.curiosity")) == (agent, curiosity)]
        arm = here[0].arm if here else f"{agent} curiosity={curiosity}" if curiosity else agent
        found.append((question, arm, by_seed([one for one in here if one.arm == arm], declared)))
    return found


def beyond(shown: Sequence[Drawn]) -> Iterator[Row]:
    """Beyond the paper: whether ours passes what does not learn, and its control, at the end of the lab's curve."""
    steps = UNTIL["large_lab"]
    for name, runs in ours(shown, "large_lab").items():
        for question, arm, theirs in others(shown, name[0]):
            claim = Claim(f"beyond the paper: {question} in the lab", "its mean at 600 k is above the other's",
                          (np.nextafter(0, 1), np.inf), "+.1%")
            bounds, alone = (mean(mine, steps).less(mean(other, steps))
                             for mine, other in ((runs, theirs), (given(runs), given(theirs))))
            equal = min(steps, shortest(runs, theirs)) if given(runs) else steps
            words = " beside ".join(shares(some, equal) for some in (runs, theirs))
            yield claim.row(name, runs, steps, f"{words} at {equal:,} steps; {len(given(theirs))} of {len(theirs)} of "
                            f"{arm}", bounds, alone)


def shares(runs: Runs, steps: int) -> str:
    """Coverages of runs in so many steps, and their mean where there are several and none was cut before."""
    values = reached(runs, steps)
    each = ", ".join(map(percent, values)) or "no run"
    whole = len(values) > 1 and shortest(runs) >= steps
    return f"{percent(float(np.mean(values)))} ({each})" if whole else each


def against(shown: Sequence[Drawn]) -> list[Row]:
    """Ours beside bounce and beside its control at equal steps: those reported, and the last that all of them have."""
    return [found for scene in UNTIL for name, runs in ours(shown, scene).items()
            for _, arm, theirs in others(shown, name[0]) if given(runs) and given(theirs)
            for found in equal_steps(name, runs, arm, theirs)]


def equal_steps(name: tuple[str, str], runs: Runs, arm: str, theirs: Runs) -> Iterator[Row]:
    """Rows of differences between the means of two arms."""
    last = shortest(runs, theirs)
    for steps in dict.fromkeys([*(count for count in COUNTS if count <= last), last]):
        mine, other = (np.mean([(int(run.curve.at(steps)) / run.curve.cells, run.curve.until(steps).area() or 0.0)
                                for run in given(some).values()], axis=0) for some in (runs, theirs))
        yield {"env": name[0], "arm": name[1], "minus": arm, "steps": steps,
               "n": f"{len(given(runs))} and {len(given(theirs))}", "coverage": float(mine[0]),
               "other": float(other[0]), "difference": 100 * float(mine[0] - other[0]),
               "area": float(mine[1] - other[1])}
