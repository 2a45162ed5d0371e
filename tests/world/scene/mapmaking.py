"""Small map files for the tests of how maps are read."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from curionav_cli.world.scene.ros_map import FREE, OCCUPIED, UNKNOWN, read_map

HEAD = ("image: {image}\nresolution: 0.1\norigin: [-1.0, 2.0, 0.3]\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n")
LETTERS = {FREE: ".", OCCUPIED: "#", UNKNOWN: "?"}


def write_map(folder: Path, pixels: np.ndarray, more: str = "negate: 0\n", name: str = "map.pgm") -> Path:
    """A map of these pixels, row 0 on top; PGM written by hand with a comment, PNG by OpenCV."""
    if name.endswith(".pgm"):
        rows, columns = pixels.shape
        head = f"P5\n# CREATOR: a test 0.1 m/pix\n{columns} {rows}\n255\n".encode()
        (folder / name).write_bytes(head + pixels.astype(np.uint8).tobytes())
    else:
        cv2.imwrite(str(folder / name), pixels)
    return describe(folder, HEAD.format(image=name) + more)


def describe(folder: Path, text: str | bytes) -> Path:
    """folder/map.yaml of this text."""
    (folder / "map.yaml").write_bytes(text if isinstance(text, bytes) else text.encode())
    return folder / "map.yaml"


def drawn(path: Path) -> list[str]:
    """The cells of a map as lines of text, the top row first; what is none of free, occupied, unknown as a number."""
    return ["".join(LETTERS.get(int(cell), f"<{cell}>") for cell in row) for row in read_map(path).cells[::-1]]
