"""curionav map RUN: the occupancy map that a run's robot made, as a ROS map (map_server's PGM and YAML)."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np

from curionav_cli.commands.arguments import sorted_out
from curionav_cli.commands.summary import print_files, print_next
from curionav_cli.errors import ConfigError, RunFolderError
from curionav_cli.execution.screen import a_console
from curionav_cli.files import folder_for, read_arrays
from curionav_cli.records import Pose
from curionav_cli.robot.occupancy import Occupancy
from curionav_cli.storage import checkpoint
from curionav_cli.storage.run_folder import RunFolder
from curionav_cli.world.scene.map_writer import write_map
from curionav_cli.world.scene.ros_map import FREE, OCCUPIED, UNKNOWN

CHOICES: dict[str, tuple[str, ...]] = {"out": ()}


def run(words: list[str]) -> int:
    """Write map.yaml and map.pgm into the run's folder, or into out=DIR; returns the exit code.

    Raises UserError where there is no such run, it has no map, or a file would be overwritten.
    """
    paths, chosen = sorted_out("map", words, CHOICES)
    if len(paths) != 1:
        raise ConfigError("Name the folder of one run, as in: curionav map outputs/DATE/RUN")
    run = RunFolder.existing(paths[0])
    occupancy = newest_map(run)
    folder = folder_for(chosen["out"]) if "out" in chosen else run.path
    there = [folder / name for name in ("map.yaml", "map.pgm") if (folder / name).exists()]
    if there:
        raise ConfigError(f"{there[0]} exists already. Name another folder with out=DIR, or remove it first.")
    cells, corner = explored_part(occupancy, run.path)
    folder.mkdir(parents=True, exist_ok=True)
    write_map(folder / "map.yaml", cells, occupancy.cell, Pose(*corner, 0.0))
    console = a_console()
    print_files(console, folder, ["map.yaml", "map.pgm"])
    rows, columns = cells.shape
    console.print(f"{columns} x {rows} cells of {occupancy.cell * 100:g} cm: {(cells == FREE).sum():,} free, "
                  f"{(cells == OCCUPIED).sum():,} occupied", soft_wrap=True, highlight=False)
    print_next(console, [f"curionav sheet env=map env.map={shlex.quote(str(folder / 'map.yaml'))}",
                         f"curionav explore env=map env.map={shlex.quote(str(folder / 'map.yaml'))} agent=bounce"])
    return 0


def newest_map(run: RunFolder) -> Occupancy:
    """The map of the run's newest checkpoint: its agent's if that makes one, else its docking robot's.

    Raises RunFolderError where the run has neither, no checkpoint yet, or a broken one.
    """
    saved = checkpoint.finished(run.checkpoints)
    if not saved:
        raise RunFolderError(f"{run.path} has no map yet: no episode is finished. "
                             f"Go on with: curionav resume {shlex.quote(str(run.path))}")
    checkpoint.refuse_broken(saved[-1])
    if (saved[-1] / "map.npz").exists():
        return Occupancy.of(read_arrays(saved[-1] / "map.npz", Occupancy.SAVED), cell=run.plan.cell)
    if (saved[-1] / "robot_map.npz").exists():
        return Occupancy.of(read_arrays(saved[-1] / "robot_map.npz", Occupancy.SAVED))
    settings = run.settings
    raise RunFolderError(f"{run.path} has no map: agent={settings['agent']['name']} makes none, and neither does "
                         f"robot={settings['robot']['name']}. agent=mapper does, and robot=turtlebot2i.")


def explored_part(occupancy: Occupancy, run: Path) -> tuple[np.ndarray, tuple[float, float]]:
    """The cells (rows, columns) of what is known, as a ROS map has them, and the lower-left corner in metres.

    Raises RunFolderError where nothing is known.
    """
    known = [np.flatnonzero(occupancy.known.any(axis=axis)) for axis in (1, 0)]
    if not len(known[0]):
        raise RunFolderError(f"{run} has a map on which nothing is known yet.")
    (row, above), (column, right) = ((int(at[0]), int(at[-1]) + 1) for at in known)
    cells = np.where(occupancy.occupied, OCCUPIED, np.where(occupancy.known, FREE, UNKNOWN)).astype(np.int8)
    corner = occupancy.corner[0] + column * occupancy.cell, occupancy.corner[1] + row * occupancy.cell
    return cells[row:above, column:right], corner
