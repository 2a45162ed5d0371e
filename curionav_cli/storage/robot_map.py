"""The occupancy map that a run's robot made, as its newest checkpoint holds it."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np

from curionav_cli.errors import RunFolderError
from curionav_cli.files import read_arrays
from curionav_cli.robot.occupancy import Occupancy
from curionav_cli.storage import checkpoint
from curionav_cli.storage.run_folder import RunFolder
from curionav_cli.world.scene.ros_map import FREE, OCCUPIED, UNKNOWN


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
