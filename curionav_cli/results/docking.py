"""Returns to dock, counted: requests, successes, failures by name, recoveries (paper, docking table)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from curionav_cli.files import read_json
from curionav_cli.records import DockReport
from curionav_cli.results.labels import flat, labels, world_labels, world_settings
from curionav_cli.results.statistics import share_interval
from curionav_cli.results.tables import Columns, Row
from curionav_cli.storage.run_folder import RunFolder

TABLE: Columns = (
    ("env", "env", "{}"), ("robot", "robot", "{}"), ("agent", "agent", "{}"), ("seed", "seed", "{}"),
    ("requests", "requests", "{:,}"), ("success", "docked", "{:,}"), ("ratio", "ratio", "{:.1%}"),
    ("carried by a person", "human", "{:,}"), ("needed recovery", "recovered", "{:.1%}"),
    ("error median", "error_median", "{:.2f} m"), ("90 %", "error_90", "{:.2f} m"), ("most", "error_most", "{:.2f} m"),
    ("yaw median", "yaw_median", "{:.1f} deg"), ("time median", "seconds_median", "{:.0f} s"),
    ("battery left", "battery_median", "{:.0%}"),
)
BELOW = "ratio: with Wilson's 95 % interval; error: of the estimated pose where the first approach began"
FAILURES: Columns = (
    ("env", "env", "{}"), ("robot", "robot", "{}"), ("seed", "seed", "{}"), ("ended by", "code", "{}"),
    ("requests", "count", "{:,}"), ("of all", "share", "{:.1%}"),
)
RECOVERIES: Columns = (
    ("env", "env", "{}"), ("robot", "robot", "{}"), ("seed", "seed", "{}"), ("attempt", "attempt", "{}"),
    ("tried", "tried", "{:,}"), ("docked", "docked", "{:,}"), ("ratio", "ratio", "{:.0%}"),
)


def came_home(run: RunFolder) -> bool:
    """Whether it is a run of curionav dock with at least one return to dock in it."""
    return any("code" in row for row in run.metrics()[:1])


def reports(run: RunFolder) -> list[DockReport]:
    """Read the returns to dock of a run, in order."""
    return [DockReport.of({key: row[key] for key in DockReport.__dataclass_fields__}) for row in run.metrics()]


class Counted(NamedTuple):
    """Returns to dock of one run, or of several that differ in their seed only. where: their cells of a table."""

    run: RunFolder
    where: Row
    docks: list[DockReport]


def counted(runs: Sequence[RunFolder]) -> tuple[list[Counted], list[Counted]]:
    """Count each run by itself, and runs that differ in nothing but their seed together, of each seed the first.

    A run without such others is not in the second list.
    """
    fixed, settings = [read_json(run.path / "fixed.json") for run in runs], [run.settings for run in runs]
    presets = [one["scale"] for one in settings]
    envs = world_labels([one["env"] for one in settings], list(map(world_settings, fixed)))
    robots = labels([one["robot"]["name"] for one in settings], [flat(one["robot"]) for one in fixed], presets)
    agents = labels([one["agent"]["name"] for one in settings],
                    [flat({key: one[key] for key in ("agent", "loop")}) for one in fixed], presets)
    each = [Counted(run, {"env": env, "robot": robot, "agent": agent, "seed": one["seed"]}, reports(run))
            for run, env, robot, agent, one in zip(runs, envs, robots, agents, settings)]
    alike: dict[tuple[str, str, str], dict[int, Counted]] = {}
    for one, *key in zip(each, envs, robots, agents):
        alike.setdefault((key[0], key[1], key[2]), {}).setdefault(one.where["seed"], one)
    return each, [Counted(first.run, {**first.where, "seed": f"{len(same)} seeds"},
                          [dock for one in same.values() for dock in one.docks])
                  for same in alike.values() if len(same) > 1 for first in [next(iter(same.values()))]]


def summary(where: Row, docks: Sequence[DockReport]) -> Row:
    """Make a row of TABLE. Distances in metres, yaw in degrees, times in seconds, battery between 0 and 1."""
    docked = sum(dock.success for dock in docks)
    error = np.array([dock.error for dock in docks if dock.error]).reshape(-1, 3)
    away = np.hypot(error[:, 0], error[:, 1])
    return {
        **where, "requests": len(docks), "docked": docked, "ratio": share_interval(docked, len(docks)),
        "human": sum(dock.human for dock in docks), "recovered": share(bool(dock.recoveries) for dock in docks),
        "error_median": quantile(away, 0.5), "error_90": quantile(away, 0.9), "error_most": quantile(away, 1.0),
        "yaw_median": quantile(np.degrees(np.abs(error[:, 2])), 0.5),
        "seconds_median": quantile([dock.seconds for dock in docks], 0.5),
        "battery_median": quantile([dock.battery for dock in docks], 0.5),
    }


def endings(where: Row, docks: Sequence[DockReport]) -> list[Row]:
    """Count how often each name ended a return to dock; the counts add up to the requests."""
    return [{**where, "code": code, "count": count, "share": count / len(docks)}
            for code, count in Counter(dock.code for dock in docks).most_common()]


def attempts(where: Row, docks: Sequence[DockReport]) -> list[Row]:
    """Count attempts and successes: the first from the staging pose, then one after each recovery, by name.

    The drive that an attempt begins with belongs to it, so that it may fail before the dock is seen.
    """
    tried: Counter[str] = Counter()
    docked: Counter[str] = Counter()
    for dock in docks:
        names = ["1 staging", *(f"{number} {name}" for number, name in enumerate(dock.recoveries, 2))]
        tried.update(names)
        docked[names[-1]] += dock.success
    return [{**where, "attempt": name, "tried": tried[name], "docked": docked[name],
             "ratio": docked[name] / tried[name]} for name in sorted(tried, key=lambda name: int(name.split()[0]))]


def share(flags: Any) -> float:
    found = list(flags)
    return sum(found) / max(1, len(found))


def quantile(values: Any, level: float) -> float | None:
    return float(np.quantile(values, level)) if len(values) else None
