"""Every number that the paper gives, beside ours: from configurations, from scenes and from run folders.

The paper's side stands here once, with the place where it is printed; ours is always computed.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from curionav_cli.constants import HEADINGS, STEP_LENGTH
from curionav_cli.files import read_arrays
from curionav_cli.records import DockReport, FloorPlan
from curionav_cli.results.comparison.comparison import Comparison, Field
from curionav_cli.results.comparison.estimates import summary
from curionav_cli.results.comparison.run_summaries import RunSummary
from curionav_cli.results.docking import reports
from curionav_cli.results.labels import scene_name
from curionav_cli.results.statistics import mean_interval, share_interval
from curionav_cli.results.summary_file import is_summary
from curionav_cli.results.tables import Columns, Row
from curionav_cli.storage.run_folder import RunFolder

Settings = Mapping[str, Any]

HYPERPARAMETERS = (  # the appendix's table, in its order: part, name, value, our key
    ("world model", "batch size", 50, "batch_size"), ("world model", "batch sequence length", 50, "sequence_length"),
    ("world model", "discrete latent state dimension", 32, "latent_dimension"),
    ("world model", "discrete latent classes", 32, "latent_classes"),
    ("world model", "GRU cell dimension", 200, "gru_units"), ("world model", "KL free nats", 1, "free_nats"),
    ("world model", "KL balancing", 0.8, "kl_balance"), ("world model", "Adam learning rate", 3e-4, "model_lr"),
    ("world model", "slow critic update interval", 100, "slow_critic_interval"),
    ("actor-critic", "imagination horizon", 15, "horizon"), ("actor-critic", "gamma", 0.99, "gamma"),
    ("actor-critic", "lambda", 0.95, "return_lambda"), ("actor-critic", "Adam learning rate, actor", 8e-5, "actor_lr"),
    ("actor-critic", "Adam learning rate, critic", 8e-5, "critic_lr"),
    ("actor-critic", "actor entropy loss scale", 1e-4, "entropy"), ("common", "MLP number of layers", 4, "mlp_layers"),
    ("common", "MLP number of units", 400, "mlp_units"), ("common", "hidden layers dimension", 400, "mlp_units"),
    ("common", "Adam epsilon", 1e-5, "adam_epsilon"), ("common", "weight decay", 1e-6, "weight_decay"),
    ("common", "gradient clipping", 100, "clip"),
)
SIZES = {  # visitable states and square metres of the appendix's table; of the others what the text says
    "apartment_0": (23476, 58.69), "apartment_1": (21328, 53.32), "apartment_2": (18123, 45.31),
    "small_room": (None, 8.0), "large_lab": (None, 230.0),
}
MEAN_AREA = 52.43  # of the three apartments, m2
COVERED = {"small_room": (140_000, 0.8, "over 80 % in 140 k steps (run 1)"),
           "large_lab": (600_000, 0.6, "60 % in 600 k steps")}
OURS, THEIRS = ("lbs_dreamer",), ("cbet", "cbet_lifelong")
STEPS = {"lbs_dreamer": "2 M", "cbet": "5 M"}  # in the apartments
FAR = 0.9  # of the cells are nearer to the start than the furthest area
ROBOT = "turtlebot2i"  # the paper's
DOCKED = {"small_room": "572 of 596 (96 %)", "large_lab": "758 of 1023 (74 %)"}

HYPERPARAMETER_COLUMNS: Columns = (("part", "part", "{}"), ("name", "name", "{}"), ("paper", "paper", "{:g}"),
                                   ("scale=paper", "ours", "{:g}"), ("scale=cpu", "cpu", "{:g}"), ("key", "key", "{}"))
SIZE_COLUMNS: Columns = (("env", "env", "{}"), ("paper, cells", "paper_cells", "{:,}"),
                         ("ours, cells", "cells", "{:,}"), ("paper, m2", "paper_area", "{:.2f}"),
                         ("ours, visitable m2", "area", "{:.2f}"),
                         ("ours, floor m2", "floor", "{:.2f}"), ("cell, cm", "cell", "{:g}"))
COLUMNS: Columns = (("where in the paper", "where", "{}"), ("what", "what", "{}"), ("paper", "paper", "{}"),
                    ("ours", "ours", "{}"), ("n", "n", "{}"), ("from", "source", "{}"))


class Number(NamedTuple):
    """A line of the page. source: the run folder, or the file of conf/ that it is from."""

    where: str
    what: str
    paper: str
    ours: str
    n: str
    source: str


def hyperparameters(paper: Settings, cpu: Settings) -> list[Row]:
    """Rows of the appendix's table beside the composed settings of the agent at both scales."""
    return [{"part": part, "name": name, "paper": value, "ours": paper[key], "cpu": cpu[key], "key": f"agent.{key}"}
            for part, name, value, key in HYPERPARAMETERS]


def sizes(plans: Mapping[str, FloorPlan]) -> list[Row]:
    """Rows of cells and square metres of scenes as they load, beside the paper's."""
    rows = []
    for env, plan in plans.items():
        cells, area = SIZES[env]
        visitable, floor = (float(mask.sum()) * plan.cell ** 2 for mask in (plan.visitable, plan.floor))
        rows.append({"env": env, "paper_cells": cells, "cells": int(plan.visitable.sum()), "paper_area": area,
                     "area": visitable, "floor": floor, "cell": 100 * plan.cell})
    return rows


def protocol(loop: Settings, robot: Settings, plans: Mapping[str, FloorPlan], repeat: int) -> Iterator[Number]:
    """Numbers of episodes, steps, cells and battery.

    loop, robot: composed settings of conf/config.yaml and robot=turtlebot2i; repeat: steps for which scale=cpu holds
    an action.
    """
    lifelong, setup = 'section "Lifelong learning"', 'section "Experimental Results"'
    yield Number(lifelong, "steps of an episode, N", "500", f"{loop['steps']}", "", "conf/config.yaml")
    yield Number(lifelong, "iterations between episodes, K", "100", f"{loop['iterations']}", "", "conf/config.yaml")
    yield Number(setup, "a step forward", "0.25 m", f"{STEP_LENGTH:g} m", "", "curionav_cli/constants.py")
    yield Number(setup, "a turn", "10 degrees", f"{360 / HEADINGS:g} degrees", "", "curionav_cli/constants.py")
    yield Number(setup, "an action of lbs_dreamer is held for", "1 step", f"{repeat} steps at scale=cpu", "",
                 "conf/scale/lbs_dreamer/cpu.yaml")
    for env, paper in (("apartment_0", "5 x 5 cm"), ("small_room", "10 x 10 cm"), ("large_lab", "10 x 10 cm")):
        side = f"{100 * plans[env].cell:g}"
        yield Number(setup, f"a visitable state, {env}", paper, f"{side} x {side} cm", "", f"conf/env/{env}.yaml")
    minutes = loop["steps"] * robot["step"] / 60
    yield Number('section "Real world"', "an episode of 500 steps", "about 5 minutes", f"{minutes:g} minutes", "",
                 "conf/robot/turtlebot2i.yaml")
    battery = robot["battery"]
    yield Number('section "Real world"', "operation before it returns", "up to 10 minutes",
                 f"{(battery['capacity'] - battery['reserve']) / 60:g} minutes", "", "conf/robot/turtlebot2i.yaml")


def areas(plans: Mapping[str, FloorPlan]) -> Iterator[Number]:
    """Numbers of visitable states and surfaces in square metres."""
    rows = sizes(plans)
    for row in rows:
        source = f"conf/env/{row['env']}.yaml"
        if row["paper_cells"]:
            yield Number("appendix, table of sizes", f"visitable states, {row['env']}", f"{row['paper_cells']:,}",
                         f"{row['cells']:,}", "", source)
            yield Number("appendix, table of sizes", f"surface, {row['env']}", f"{row['paper_area']:.2f} m2",
                         f"{row['area']:.2f} m2", "", source)
        else:
            yield Number('section "Real world"', f"area, {row['env']}", f"about {row['paper_area']:g} m2",
                         f"{row['floor']:.2f} m2 of floor, {row['area']:.2f} m2 visitable", "", source)
    homes = [row["area"] for row in rows if row["env"].startswith("apartment")]
    yield Number('section "Simulation"', "mean surface of the apartments", f"{MEAN_AREA} m2",
                 f"{np.mean(homes):.2f} m2", f"{len(homes)}", "conf/env")
    lab = next(row for row in rows if row["env"] == "large_lab")
    yield Number('section "Real world"', "the lab beside the mean apartment", "4 times as large",
                 f"{lab['area'] / np.mean(homes):.1f} times, by what is visitable", "", "conf/env")


def coverage(comparison: Comparison) -> Iterator[Number]:
    """Numbers of coverage of every arm, beside the paper's number where its text has one."""
    for field in comparison.fields:
        for arm, runs in field.arms.items():
            given = field.env in COVERED and comparison.arms[arm] == "lbs_dreamer"
            in_apartment = field.env not in COVERED
            where = "figure of the apartments" if in_apartment else 'section "Real world"'
            trained = STEPS.get(comparison.arms[arm]) if in_apartment else None
            curve = f"a curve, to {trained} steps" if trained else "nothing"
            reached = mean_interval(field.shares(arm, np.array([field.horizon]))[:, 0])
            yield Number(where, f"coverage, {field.env}, {arm}", COVERED[field.env][2] if given else curve,
                         f"{reached:.1%} after {field.horizon:,} steps", f"{len(runs)}", source(runs))
            if given:
                yield from reached_in_time(field, arm, runs, *COVERED[field.env])
        yield from against_cbet(field, comparison)
    for env in SIZES if comparison.fields else ():
        if env not in [field.env for field in comparison.fields]:
            real = env in COVERED
            yield Number('section "Real world"' if real else "figure of the apartments", f"coverage, {env}",
                         COVERED[env][2] if real else f"curves, to {' and '.join(STEPS.values())} steps",
                         "no run was given", "0", "")


def reached_in_time(field: Field, arm: str, runs: Sequence[RunSummary], steps: int, share: float, paper: str
                    ) -> Iterator[Number]:
    """Numbers of steps to the share that the paper names; in the small room also to the furthest area."""
    needed = summary("steps_to", [run.curve.until(field.horizon).steps_to(share) for run in runs])
    until = "" if field.horizon >= steps else f", of {field.horizon:,} steps"
    yield Number('section "Real world"', f"steps to {share:.0%}, {field.env}, {arm}: median (runs that arrived)", paper,
                 f"{needed:,.0f}{until}", f"{len(runs)}", source(runs))
    runs = [run for run in runs if not is_summary(run.folder)]  # which have no poses
    if field.env == "small_room" and runs:
        first = summary("steps_to", [first_far(run.folder) for run in runs])
        yield Number("figure of the small room", f"steps to the furthest area, {arm}: median (runs that arrived)",
                     "only after 250 k steps (run 2)", f"{first:,.0f}", f"{len(runs)}", source(runs))


def first_far(folder: Path) -> int | None:
    """Find the first step that ended in the tenth of visitable cells furthest from the start; None without one."""
    plan = FloorPlan.load(folder / "plan.npz")
    away = plan.away(plan.start)
    far, done = plan.visitable & (away >= np.quantile(away[plan.visitable], FAR)), 0
    for path in sorted((folder / "episodes").glob("*.npz")):
        pose = read_arrays(path, ("pose",))["pose"]
        there = np.flatnonzero(far[plan.cells(pose[:, 0], pose[:, 1])])
        if len(there):
            return done + int(there[0])
        done += len(pose) - 1
    return None


def against_cbet(field: Field, comparison: Comparison) -> Iterator[Number]:
    """The paper's claim about the apartments, as paired differences of areas under the curve from each C-BET."""
    ours, theirs = ([arm for arm in field.arms if comparison.arms[arm] in agents] for agents in (OURS, THEIRS))
    paper = "about equal (appendix)" if field.env == "apartment_2" else "ours covers more"
    if field.env.startswith("apartment") and ours and theirs:
        best = max(theirs, key=lambda arm: float(np.mean(field.scores(arm))))
        for arm in theirs:
            difference = field.difference(ours[0], arm)
            if len(difference):
                which = f", the best C-BET of {len(theirs)}" if arm == best else ""
                yield Number('section "Simulation"', f"{ours[0]} minus {arm}{which}, {field.env}: area under the curve",
                             paper, f"{mean_interval(difference):+.4f}", f"{len(difference)} pairs",
                             source([*field.arms[ours[0]], *field.arms[arm]]))


def docking(runs: Sequence[RunSummary], trials: Sequence[RunFolder]) -> Iterator[Number]:
    """Count the returns to dock of ROBOT that ended docked without a person's help.

    runs: of curionav explore, whose episodes hold them; trials: of curionav dock.
    """
    for env, paper in DOCKED.items():
        here = {run.folder: list(dock_reports(run.folder)) for run in runs
                if (scene_name(run.env), run.arm.get("robot.name")) == (env, ROBOT)}
        here |= {run.path: reports(run) for run in trials
                 if (run.settings["env"]["name"], run.settings["robot"]["name"]) == (env, ROBOT)}
        here = {path: several for path, several in here.items() if several}
        found = [report for several in here.values() for report in several]
        if found:
            docked = sum(report.success and not report.human for report in found)
            yield Number("appendix, table of docking", f"auto docking, {env}", paper,
                         f"{docked:,} of {len(found):,}: {share_interval(docked, len(found)):.1%}",
                         f"{len(here)} run{'s' * (len(here) != 1)}", parents(list(here)))


def dock_reports(folder: Path) -> Iterator[DockReport]:
    """Read the return to dock before every episode that began with one."""
    for path in sorted((folder / "episodes").glob("*.npz")):
        plain = json.loads(str(read_arrays(path, ("action",), ("dock",)).get("dock", "null")))
        if plain:
            yield DockReport.of(plain)


def source(runs: Sequence[RunSummary]) -> str:
    """Name the sweeps that these runs are in."""
    return parents([run.folder for run in runs])


def parents(folders: Sequence[Path]) -> str:
    return ", ".join(dict.fromkeys(str(folder.parent) for folder in folders))
