"""Homecomings counted: requests, successes, failures by name, recoveries (paper, docking table)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from curionav_cli.records import DockReport
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
BELOW = "ratio: with Wilson's 95 % interval; error: of the believed pose where the first approach began"
FAILURES: Columns = (
    ("env", "env", "{}"), ("robot", "robot", "{}"), ("seed", "seed", "{}"), ("ended by", "code", "{}"),
    ("requests", "count", "{:,}"), ("of all", "share", "{:.1%}"),
)
RECOVERIES: Columns = (
    ("env", "env", "{}"), ("robot", "robot", "{}"), ("seed", "seed", "{}"), ("attempt", "attempt", "{}"),
    ("begun", "begun", "{:,}"), ("docked", "docked", "{:,}"), ("ratio", "ratio", "{:.0%}"),
)


def reports(run: RunFolder) -> list[DockReport]:
    """The homecomings of a run, in order."""
    return [DockReport.of({key: row[key] for key in DockReport.__dataclass_fields__}) for row in run.metrics()]


def place(run: RunFolder) -> Row:
    """Which run it is: env, robot, agent, seed."""
    settings = run.settings
    return {"env": settings["env"]["name"], "robot": settings["robot"]["name"], "agent": settings["agent"]["name"],
            "seed": settings["seed"]}


def summary(where: Row, docks: Sequence[DockReport]) -> Row:
    """One row of the table."""
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
    """How often each name ended a homecoming; the counts add up to the requests."""
    return [{**where, "code": code, "count": count, "share": count / len(docks)}
            for code, count in Counter(dock.code for dock in docks).most_common()]


def attempts(where: Row, docks: Sequence[DockReport]) -> list[Row]:
    """What each attempt brought: the staging pose's, and that after each recovery, by name."""
    begun: Counter[str] = Counter()
    docked: Counter[str] = Counter()
    for dock in docks:
        names = ["1 staging", *(f"{number} {name}" for number, name in enumerate(dock.recoveries, 2))]
        begun.update(names)
        docked[names[-1]] += dock.success
    return [{**where, "attempt": name, "begun": begun[name], "docked": docked[name],
             "ratio": docked[name] / begun[name]} for name in sorted(begun, key=lambda name: int(name.split()[0]))]


def pooled(runs: Sequence[tuple[Row, Sequence[DockReport]]]) -> list[tuple[Row, list[DockReport]]]:
    """Runs that differ in nothing but their seed, together; none where each stands alone."""
    together: dict[tuple[Any, ...], list[tuple[Row, Sequence[DockReport]]]] = {}
    for where, docks in runs:
        together.setdefault(tuple(value for key, value in where.items() if key != "seed"), []).append((where, docks))
    return [({**same[0][0], "seed": f"{len(same)} seeds"}, [dock for _, docks in same for dock in docks])
            for same in together.values() if len(same) > 1]


def share(flags: Any) -> float:
    found = list(flags)
    return sum(found) / max(1, len(found))


def quantile(values: Any, level: float) -> float | None:
    return float(np.quantile(values, level)) if len(values) else None
