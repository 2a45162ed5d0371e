"""Made-up offices as ROS maps: one of 100 x 100 m, 400 rooms, doors, furniture, pillars; and one of two rooms."""

from __future__ import annotations

from pathlib import Path

import numpy as np

PIXELS, ROOM, DOOR, WALL = 2000, 100, 22, 3


def write_office(folder: Path) -> Path:
    """Writes office.pgm and office.yaml; returns the YAML file."""
    rng = np.random.default_rng(0)
    image = np.full((PIXELS, PIXELS), 254, np.uint8)
    for at in range(0, PIXELS + 1, ROOM):
        image[at:at + WALL], image[:, at:at + WALL] = 0, 0
        image[at - WALL:at] = 0
        for door in range(0, PIXELS, ROOM):
            first = door + int(rng.integers(10, ROOM - DOOR - 10))
            if 0 < at < PIXELS:
                image[at - WALL:at + WALL, first:first + DOOR] = 254
                image[first:first + DOOR, at:at + WALL] = 254
    for row, column, tall, wide in zip(*rng.integers(0, PIXELS, (2, 1600)), *rng.integers(4, 24, (2, 1600)),
                                       strict=True):
        if rng.random() < 0.5 and (row % ROOM > 30 or column % ROOM > 30):
            image[row:row + tall, column:column + wide] = 0
    image[0], image[-1], image[:, 0], image[:, -1] = 0, 0, 0, 0
    (folder / "office.pgm").write_bytes(f"P5\n{PIXELS} {PIXELS}\n255\n".encode() + image.tobytes())
    path = folder / "office.yaml"
    path.write_text("image: office.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n"
                    "occupied_thresh: 0.65\nfree_thresh: 0.196\n", encoding="utf-8")
    return path


def write_two_rooms(folder: Path) -> Path:
    """6 x 3 m of 10 cm cells: a door, and a table of 0.8 x 0.6 m; returns the YAML file."""
    image = np.full((30, 60), 254, np.uint8)
    image[[0, -1]] = image[:, [0, -1]] = 0
    image[:12, 30:32] = image[20:, 30:32] = 0
    image[10:16, 20:28] = 0
    (folder / "office.pgm").write_bytes(b"P5\n60 30\n255\n" + image[::-1].tobytes())
    path = folder / "office.yaml"
    path.write_text("image: office.pgm\nresolution: 0.1\norigin: [-1, -2, 0]\nnegate: 0\n"
                    "occupied_thresh: 0.65\nfree_thresh: 0.196\n", encoding="utf-8")
    return path
