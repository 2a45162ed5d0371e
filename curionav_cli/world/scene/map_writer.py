"""Writing an occupancy grid as a robot's map saver does: a PGM and the YAML file that names it.

The greys and keys of nav2_map_server's trinary mode, which ROS 1, Nav2 and ros_map.py all read back as the same cells;
the resolution is written in full, where Nav2's own saver rounds it to three decimals.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from curionav_cli.files import write_whole
from curionav_cli.records import ORIGIN, Pose
from curionav_cli.world.scene.ros_map import FREE, OCCUPIED, UNKNOWN

GREYS = {FREE: 254, OCCUPIED: 0, UNKNOWN: 205}


def write_map(path: Path, cells: np.ndarray, resolution: float, origin: Pose = ORIGIN) -> None:
    """Write `path` (YAML) and a PGM of the same name beside it, each finished or absent.

    cells (rows, columns) of FREE, OCCUPIED and UNKNOWN, row 0 the lowest; resolution in metres a cell; origin of the
    lower-left corner, in metres and radians. Raises ValueError for any other value.
    """
    image = path.with_suffix(".pgm")
    grey = np.zeros(cells.shape, np.uint8)
    for value, shade in GREYS.items():
        grey[cells == value] = shade
    if not np.isin(cells, list(GREYS)).all():
        raise ValueError(f"a map's cells are one of {', '.join(map(str, GREYS))}")
    rows, columns = cells.shape
    head = f"P5\n# {float(resolution)!r} m/pix\n{columns} {rows}\n255\n".encode()
    text = (f"image: {json.dumps(image.name, ensure_ascii=False)}\nmode: trinary\nresolution: {float(resolution)!r}\n"
            f"origin: {[float(part) for part in origin]}\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n")
    write_whole(image, lambda file: file.write(head + grey[::-1].tobytes()))
    write_whole(path, lambda file: file.write(text.encode()))
