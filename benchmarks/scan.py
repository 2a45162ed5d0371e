"""Scans: frames a CPU-second, load time and memory of a mesh, on this machine.

    python benchmarks/scan.py                    a room of a million triangles, with colours at its corners
    python benchmarks/scan.py --triangles 100000
    python benchmarks/scan.py --mesh FILE.glb    a file of yours

One process, one thread; frames of 64 x 64 pixels from random places and headings.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from pathlib import Path

import numpy as np

from curionav_cli.world.render.renderer import Renderer
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

SIDES = ((0, 1), (0, 2), (1, 2))  # the axes of floor and ceiling, and of the walls
EXTENT = np.array([8.0, 6.0, 2.5])  # metres
NOISE = 0.004  # metres, of a scanner


def write_room(path: Path, triangles: int) -> None:
    """Write a closed room of about so many triangles as PLY, rough as a scan is."""
    rng, side = np.random.default_rng(0), max(2, round((triangles / 12) ** 0.5) + 1)
    places, corners = [], []
    for axes in SIDES:
        for far in (0.0, 1.0):
            at = np.zeros((side, side, 3))
            at[..., axes[0]], at[..., axes[1]] = np.meshgrid(*[np.linspace(0, EXTENT[axis], side) for axis in axes])
            across = ({0, 1, 2} - set(axes)).pop()
            at[..., across] = far * EXTENT[across] + rng.normal(0.0, NOISE, (side, side))
            number = np.arange(side * side).reshape(side, side) + len(places) * side * side
            one, other = (number[:-1, :-1], number[1:, :-1], number[1:, 1:]), (number[:-1, :-1], number[1:, 1:],
                                                                            number[:-1, 1:])
            corners += [np.stack(three, axis=-1).reshape(-1, 3) for three in (one, other)]
            places.append(at.reshape(-1, 3))
    whole, faces = np.concatenate(places), np.concatenate(corners)
    vertex = np.zeros(len(whole), [("place", "<f4", 3), ("colour", "u1", 3)])
    vertex["place"], vertex["colour"] = whole, rng.integers(0, 256, (len(whole), 3))
    face = np.zeros(len(faces), [("count", "u1"), ("corner", "<i4", 3)])
    face["count"], face["corner"] = 3, faces
    names = "".join(f"property float {name}\n" for name in "xyz")
    names += "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    head = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(whole)}\n{names}element face {len(faces)}\n"
            "property list uchar int vertex_indices\nend_header\n")
    path.write_bytes(head.encode() + vertex.tobytes() + face.tobytes())


def memory() -> float:
    """The most memory that this process has taken, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def measure(path: Path, frames: int, repeats: int) -> None:
    """Print what loading and drawing take."""
    before, began = memory(), time.process_time()
    scene = Scene.from_dict(*plain("scan", mesh=str(path)))
    loaded = time.process_time() - began
    triangles = scene.view.triangles
    print(f"{triangles:,} triangles, {path.stat().st_size / 1e6:.0f} MB: loaded in {loaded:.1f} CPU-s, "
          f"{memory() - before:.0f} MB more memory at most")
    rng, renderer = np.random.default_rng(0), Renderer(scene)
    rows, columns = np.nonzero(scene.plan.visitable)
    rates = []
    for _ in range(repeats):
        which = rng.integers(0, len(rows), frames)
        began = time.process_time()
        renderer.render((columns[which] + 0.5) * scene.plan.cell, (rows[which] + 0.5) * scene.plan.cell,
                        rng.integers(0, 36, frames))
        rates.append(frames / (time.process_time() - began))
    low, middle, high = np.quantile(rates, (0.25, 0.5, 0.75))
    print(f"{middle:.0f} frames a CPU-second, quartiles {low:.0f} to {high:.0f}, {repeats} repeats of {frames} frames")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mesh", type=Path)
    parser.add_argument("--triangles", type=int, default=1_000_000)
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--repeats", type=int, default=7)
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = chosen.mesh or Path(folder) / "room.ply"
        if not chosen.mesh:
            write_room(path, chosen.triangles)
        measure(path, chosen.frames, chosen.repeats)


if __name__ == "__main__":
    main()
