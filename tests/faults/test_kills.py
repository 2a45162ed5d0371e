"""SIGKILL at seeded random moments of every phase: the resumed run ends as an undisturbed one, byte for byte on CPU."""

from __future__ import annotations

import json
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from forked import Forks
from leftovers import leftovers
from tiny import LEARNER

MOMENTS = {"beginning": 4, "acting": 11, "training": 13, "saving": 14, "drawing": 8}  # 50 in all
QUICK = (("beginning", 0),)  # tests/test_resume.py has a moment of each other phase


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory, forks: Forks) -> tuple[dict[str, Any], dict[str, int]]:
    """What it leaves, and how many events each of its phases has."""
    run = tmp_path_factory.mktemp("undisturbed") / "run"
    done = forks("explore", *LEARNER, f"hydra.run.dir={run}", phase="all")
    assert done.code == 0, done.error
    return leftovers(run), forks.events


def moments() -> list[Any]:
    found = [(phase, number) for phase, count in MOMENTS.items() for number in range(count)]
    return [pytest.param(*one, marks=() if one in QUICK else pytest.mark.faults) for one in found]


@pytest.mark.parametrize(("phase", "number"), moments())
def test_a_run_that_was_killed_ends_as_if_it_had_not_been(
        tmp_path: Path, forks: Forks, undisturbed: tuple[dict[str, Any], dict[str, int]], phase: str,
        number: int) -> None:
    whole, events = undisturbed
    rng = np.random.default_rng([list(MOMENTS).index(phase), number])
    at = int(rng.integers(1, 0.97 * events[phase]))
    run = tmp_path / "run"
    killed = forks("explore", *LEARNER, f"hydra.run.dir={run}", phase=phase, at=at)
    assert killed.code == -signal.SIGKILL, killed.error
    resumed = forks("resume", str(run))
    assert resumed.code == 0, f"event {at} of {events[phase]}: {resumed.error}"
    ours = leftovers(run)
    assert ours.keys() == whole.keys(), f"event {at} of {events[phase]}"
    assert [name for name in ours if ours[name] != whole[name]] == [], f"event {at} of {events[phase]}"
    assert not list(run.rglob("*.part")), json.dumps(sorted(map(str, run.rglob("*.part"))))
