"""curionav map RUN: the occupancy map that a run's robot made, as a ROS map (map_server's PGM and YAML)."""

from __future__ import annotations

import shlex

from curionav_cli.commands.arguments import sorted_out
from curionav_cli.commands.summary import print_files, print_next
from curionav_cli.errors import ConfigError
from curionav_cli.execution.screen import a_console
from curionav_cli.files import folder_for
from curionav_cli.records import Pose
from curionav_cli.storage.robot_map import explored_part, newest_map
from curionav_cli.storage.run_folder import RunFolder
from curionav_cli.world.scene.map_writer import write_map
from curionav_cli.world.scene.ros_map import FREE, OCCUPIED

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
