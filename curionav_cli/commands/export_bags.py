"""curionav export RUN... --to mcap: the episodes of runs as ROS 2 bags, one an episode."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from curionav_cli import build
from curionav_cli.bags import source
from curionav_cli.bags.library import refuse_without_rosbags
from curionav_cli.commands.arguments import episode_numbers, sorted_out
from curionav_cli.commands.summary import print_files, print_next
from curionav_cli.config.schema import Config
from curionav_cli.config.settings import read_settings
from curionav_cli.errors import ConfigError, MapError, RunFolderError, SceneError
from curionav_cli.execution.interrupts import stoppable
from curionav_cli.execution.screen import a_console
from curionav_cli.files import folder_for
from curionav_cli.records import Episode, Pose
from curionav_cli.storage import pictures
from curionav_cli.storage.robot_map import explored_part, newest_map
from curionav_cli.storage.run_folder import RunFolder
from curionav_cli.world.scene.scene import Scene

CHOICES: dict[str, tuple[str, ...]] = {"to": ("mcap",), "out": (), "episodes": (), "images": ("png", "raw"),
                                       "depth": ("yes", "no"), "profile": source.names(), "rate": ()}
PROFILE, RATE = "turtlebot4", "10"
NAME_FORMAT = "Name the format, as in: curionav export outputs/DATE/RUN --to mcap"


class Job(NamedTuple):
    """An episode to write: `number` of the run, to the bag at `folder`."""

    run: RunFolder
    number: int
    folder: Path


def run(words: list[str]) -> int:
    """Write a bag for every episode; returns the exit code.

    Raises UserError where there is no such run, or a bag would be overwritten.
    """
    paths, chosen = sorted_out("export", words, CHOICES)
    if "to" not in chosen:
        raise ConfigError(NAME_FORMAT)
    refuse_without_rosbags()
    rate = steps_a_second(chosen.get("rate", RATE))
    runs = [run for path in paths for run in RunFolder.found(path)]
    if not runs:
        raise ConfigError("Name the folder of a run or a sweep, as in: curionav export outputs/DATE/RUN --to mcap")
    jobs = {run.path: planned(run, chosen, len(runs) > 1) for run in runs}
    there = [job.folder for some in jobs.values() for job in some if job.folder.exists()]
    if there:
        raise ConfigError(f"{there[0]} exists already. Name another folder with out=DIR, or remove it first.")
    console = a_console()
    for path, some in jobs.items():
        with stoppable():
            lines = list(written(some, chosen, rate))
        print_files(console, some[0].folder.parent, [job.folder.name for job in some])
        for line in dict.fromkeys(lines):
            console.print(f"{path}: {line}", soft_wrap=True, highlight=False, markup=False)
    where = shlex.quote(str(next(iter(jobs.values()))[0].folder.parent))
    print_next(console, [f"curionav train data={where} agent.action_repeat=1 loop.iterations=1000"])
    return 0


def steps_a_second(text: str) -> float:
    """The rate in words. Raises ConfigError."""
    try:
        rate = float(text)
    except ValueError:
        rate = 0.0
    if not 0.1 <= rate <= 1000.0:
        raise ConfigError(f"rate: {text!r} is not a number of steps a second from 0.1 to 1000. Default: {RATE}.")
    return rate


def planned(run: RunFolder, chosen: dict[str, str], many: bool) -> list[Job]:
    """What is written of a run. many: whether bags of other runs are written beside. Raises UserError."""
    run.refuse_holes()
    paths = run.episode_paths()
    if not paths:
        raise RunFolderError(f"{run.path} has no episodes. Name the folder of a run of curionav explore.")
    numbers = episode_numbers("episodes", chosen["episodes"], len(paths), run.path) if "episodes" in chosen else \
        range(len(paths))
    for number in numbers:
        pictures.refuse_thinned(paths[number])
    folder = folder_for(chosen["out"]) if "out" in chosen else run.path / "bags"
    name = f"{run.path.resolve().name}_" if many and "out" in chosen else ""
    return [Job(run, number, folder / f"{name}episode_{number:06d}") for number in numbers]


def written(jobs: list[Job], chosen: dict[str, str], rate: float) -> Iterator[str]:
    """Write the bags of a run; yields what there is to say."""
    from curionav_cli.bags.depth import Redrawn
    from curionav_cli.bags.export import Form, write

    run = jobs[0].run
    settings = read_settings(run.config)
    form = Form(source.named(chosen.get("profile", PROFILE)), chosen.get("images") != "raw", rate, settings.env.camera)
    scene = simulated(settings) if chosen.get("depth") != "no" else None
    redrawn = Redrawn(scene, settings.seed, settings.env.engine.value) if isinstance(scene, Scene) else None
    if isinstance(scene, str):
        yield scene
    about = {key: getattr(settings, key).name for key in ("env", "agent", "robot")} | {"seed": settings.seed}
    for job in jobs:
        episode = Episode.load(run.episode_path(job.number), depth=chosen.get("depth") != "no")
        depth = episode.depth
        if redrawn and depth is None:
            depth = redrawn.depth(episode, job.number)
        if redrawn and depth is None:
            yield f"episode {job.number} has no depth: its images are not what is drawn here from its poses"
        write(job.folder, episode, job.number, form, depth, mapped(run, episode), about)


def simulated(settings: Config) -> Scene | str:
    """The scene of a run, or why there is none to draw depth in."""
    try:
        return build.scene(settings)
    except (ConfigError, MapError, SceneError) as error:
        return f"no depth is written. {error}"


def mapped(run: RunFolder, episode: Episode) -> Any:
    """The map that the robot made, where there is one; else the cells of the ROS map, or of the scene."""
    from curionav_cli.bags.export import Map

    plan = run.plan
    try:
        occupancy = newest_map(run)
        cells, corner = explored_part(occupancy, run.path)
        return Map(cells, occupancy.cell, Pose(*corner, 0.0), "map" if episode.estimate is None else "odom")
    except RunFolderError:
        pass
    if not plan.bounded:
        return None
    known = np.where(plan.solid, 100, np.where(plan.floor, 0, -1)).astype(np.int8)
    return Map(known if plan.occupancy is None else plan.occupancy, plan.cell, Pose(0.0, 0.0, 0.0))
