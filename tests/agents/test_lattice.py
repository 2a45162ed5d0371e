"""The search over poses: by numpy, by numba and by its definition, over random grids, the same to the bit."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator

import numpy as np
import pytest

from curionav_cli.agents import lattice, lattice_numpy
from curionav_cli.agents.lattice import PAYS, Lattice, grower
from curionav_cli.agents.lattice_numpy import Waves
from curionav_cli.constants import ACTIONS, FORWARD, HEADINGS
from curionav_cli.world.motion import moved


def grids(count: int, side: int) -> Iterator[tuple[Lattice, tuple[float, float, int]]]:
    """Grids of 3 to `side` - 1 cells a side, half of them with turned headings, half with cells that count as further
    away."""
    rng = np.random.default_rng(0)
    for number in range(count):
        shape, cell = tuple(rng.integers(3, side, 2)), rng.choice([0.05, 0.1, 0.25])
        free, goal = rng.random(shape) > rng.uniform(0.0, 0.4), rng.random(shape) < rng.choice([0.03, 0.3])
        further = rng.integers(0, 40, shape).astype(np.int16) * 5 if number % 2 else None
        turned = rng.uniform(-0.09, 0.09) if number % 4 > 1 else 0.0
        y, x = rng.uniform(0.0, 1.0, 2) * shape * cell
        yield Lattice(free, goal, cell, turned, None, further), (float(x), float(y), int(rng.integers(HEADINGS)))


def by_definition(made: Lattice, x: float, y: float, heading: int) -> tuple[list[int], int]:
    """The search written down plainly, pose by pose and to the end: (the actions, cells looked at)."""
    rows, columns = made.free.shape
    waves: list[list[tuple[float, float, int, list[int]]]] = [[(x, y, heading, [])]]
    seen: set[tuple[int, int, int]] = set()
    best: tuple[float, list[int]] = (math.inf, [])
    while waves[-1]:
        waves.append([])
        for action in range(len(ACTIONS)):
            for x, y, heading, way in waves[-2]:
                if action == FORWARD:
                    x, y, collided = moved(made.free, made.cell, x, y, float(made.dx[heading]), float(made.dy[heading]))
                    if collided:
                        continue
                heading = (heading + (0, 1, -1)[action]) % HEADINGS
                at = (min(max(math.floor(y / made.cell), 0), rows - 1),
                      min(max(math.floor(x / made.cell), 0), columns - 1))
                if (*at, heading) in seen:
                    continue
                seen.add((*at, heading))
                waves[-1].append((x, y, heading, [*way, action]))
                cost = len(way) + 1 + float(made.further[at])
                if made.goal[at] and cost < best[0]:
                    best = cost, [*way, action]
    return best[1], len({at[:2] for at in seen})


def waves_of(made: Lattice, x: float, y: float, heading: int, waves: type) -> Iterator[tuple[np.ndarray, ...]]:
    """Poses, places, actions and parents of every wave, until no pose is new."""
    pose, seen = np.array([[x, y, heading]]), np.zeros(made.free.size * HEADINGS, bool)
    place, wave = made._place(x, y, heading), waves(made.free, seen, made.cell, made.dx, made.dy)
    while len(pose):
        pose, place, *_ = found = wave(pose, place)
        yield found


@pytest.mark.parametrize(("engine", "at_once"), [("numpy", False), ("numpy", True), ("numba", False)])
def test_it_is_the_search_by_its_definition(engine: str, at_once: bool, monkeypatch) -> None:
    """at_once: numpy's waves as when they are large."""
    module = pytest.importorskip(f"curionav_cli.agents.lattice_{engine}", reason="the extra curionav[fast] is missing")
    if at_once:
        monkeypatch.setattr(lattice_numpy, "FEW", 0)
        monkeypatch.setattr(lattice_numpy, "MANY", 0)
    monkeypatch.setattr(lattice, "grower", lambda searched: module.Waves)
    found = 0
    for made, at in grids(16, 6):
        way, looked = by_definition(made, *at)
        assert made.search(*at) == way
        assert way or made.reached == looked
        assert not made.seen.any(), "the next search begins with nothing seen"
        found += bool(way)
    assert 4 < found < 16, "some searches find a goal, some none"


def test_numba_finds_the_same_poses_to_the_bit() -> None:
    fast = pytest.importorskip("curionav_cli.agents.lattice_numba", reason="the extra curionav[fast] is missing")
    count = 0
    for made, at in grids(12, 14):
        for ours, theirs in zip(waves_of(made, *at, Waves), waves_of(made, *at, fast.Waves), strict=True):
            for one, other in zip(ours, theirs, strict=True):
                assert one.dtype == other.dtype and one.tobytes() == other.tobytes()
            count += len(ours[0])
    assert count > 5_000


def test_numba_is_loaded_where_that_pays(monkeypatch) -> None:
    """At once where it is loaded already, else after many poses; numpy goes on where it is not installed."""
    fast = pytest.importorskip("curionav_cli.agents.lattice_numba", reason="the extra curionav[fast] is missing")
    assert grower(0) is fast.Waves
    monkeypatch.delitem(sys.modules, "numba")
    assert grower(0) is Waves and grower(PAYS + 1) is fast.Waves
    monkeypatch.setitem(sys.modules, "curionav_cli.agents.lattice_numba", None)
    lattice._compiled.cache_clear()
    assert grower(PAYS + 1) is Waves
    lattice._compiled.cache_clear()
