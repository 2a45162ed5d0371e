"""Scans: frames a CPU-second, what Embree alone takes of it, load time and memory of a mesh, on this machine.

    python benchmarks/scan.py                    a room of a million triangles, with colours at its corners
    python benchmarks/scan.py --triangles 100000
    python benchmarks/scan.py --mesh FILE.glb    a file of yours
    python benchmarks/scan.py --turns            rooms of three sizes and apartment_1 exported, beside ViZDoom, in turns

One process, one thread; frames of 64 x 64 pixels from random places and headings. Surveys are kept in a folder of this
run, so that the first start is a first one. --turns: steps of a random agent; ViZDoom where it is installed.
"""

from __future__ import annotations

import argparse
import os
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from curionav_cli.world.render.renderer import Renderer
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

HERE = Path(__file__).resolve().parent
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


@contextmanager
def embree_clock(scene: Scene) -> Iterator[list[float]]:
    """Count the CPU-seconds that the scene's rays spend in Embree, into a list of one number."""
    spent, inner = [0.0], scene.view.tracer._scene

    class Timed:
        def run(self, *rays, **words):
            began = time.process_time()
            found = inner.run(*rays, **words)
            spent[0] += time.process_time() - began
            return found

    scene.view.tracer._scene = Timed()
    yield spent
    scene.view.tracer._scene = inner


def load(path: Path) -> Scene:
    """The scene of a mesh; prints what loading it took."""
    before, began = memory(), time.process_time()
    scene = Scene.from_dict(*plain("scan", mesh=str(path)))
    print(f"{scene.view.triangles:,} triangles, {path.stat().st_size / 1e6:.0f} MB: loaded in "
          f"{time.process_time() - began:.1f} CPU-s, {memory() - before:.0f} MB more memory at most")
    return scene


def measure(path: Path, frames: int, repeats: int) -> None:
    """Print what loading, loading again and drawing take."""
    load(path)
    scene = load(path)
    rng, renderer = np.random.default_rng(0), Renderer(scene)
    rows, columns = np.nonzero(scene.plan.visitable)
    rates, alone = [], []
    for _ in range(repeats):
        which, headings = rng.integers(0, len(rows), frames), rng.integers(0, 36, frames)
        x, y = (columns[which] + 0.5) * scene.plan.cell, (rows[which] + 0.5) * scene.plan.cell
        with embree_clock(scene) as spent:
            began = time.process_time()
            for pose in zip(x, y, headings, strict=True):
                renderer.render(*pose)
            rates.append(frames / (time.process_time() - began))
        alone.append(frames / spent[0])
    for name, found in (("frames a CPU-second", rates), ("in Embree alone", alone)):
        print(f"{row(found)} {name}, {repeats} repeats of {frames} frames")


def row(found: list[float]) -> str:
    """Median and quartiles."""
    low, middle, high = np.quantile(found, (0.25, 0.5, 0.75))
    return f"{middle:.0f} ({low:.0f} to {high:.0f})"


def turns(folder: Path, steps: int, rounds: int) -> None:
    """Print a table: steps of a random agent a CPU-second in scans and in ViZDoom, each a turn in every round."""
    from contenders import spent

    contenders = dict(drivers(folder))
    found: dict[str, list[float]] = {name: [] for name in contenders}
    for turn in range(rounds + 1):  # the first one warms up
        for name, step in contenders.items():
            began = spent()
            for index in range(turn * steps, (turn + 1) * steps):
                step(index)
            found[name].append(steps / (spent() - began))
    beside = next((np.array(rates) for name, rates in found.items() if name.startswith("ViZDoom")), np.nan)
    for name, rates in found.items():
        print(f"| {name} | {row(rates[1:])} | {np.median((np.array(rates) / beside)[1:]):.2f} |")


def drivers(folder: Path) -> Iterator[tuple[str, Callable[[int], object]]]:
    """Name and step(index) of each contender."""
    from importlib.util import find_spec

    from contenders import vizdoom

    if find_spec("vizdoom"):
        yield "ViZDoom, RGB and depth, resized to 64 x 64", vizdoom(True, True)[0]
    for name, path in meshes(folder):
        for reuse in (True, False):
            yield f"{name}{'' if reuse else ', every picture new'}", walker(path, reuse)


def meshes(folder: Path) -> Iterator[tuple[str, Path]]:
    """Name and file of each mesh, made here."""
    from curionav_cli.world.scan.export import export

    triangles = export(Scene.from_dict(*plain("apartment_1")), folder / "apartment_1.glb")
    yield f"apartment_1 exported, {triangles:,} triangles with textures", folder / "apartment_1.glb"
    for triangles in (10_000, 100_000, 1_000_000):
        write_room(folder / f"{triangles}.ply", triangles)
        yield f"a room, {triangles:,} triangles with colours", folder / f"{triangles}.ply"


def walker(path: Path, reuse: bool) -> Callable[[int], object]:
    """The step of a random agent in a mesh; without reuse every step draws."""
    from contenders import forgetful, uncancelled

    from curionav_cli.world.registration import make

    env, actions = make("scan", mesh=str(path)), np.random.default_rng(0).integers(0, 3, 100_000).tolist()
    env.reset(seed=0)
    actions = actions if reuse else uncancelled(env.scene, actions)
    return forgetful(env, lambda index: env.step(actions[index]), reuse)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mesh", type=Path)
    parser.add_argument("--triangles", type=int, default=1_000_000)
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--turns", action="store_true")
    chosen = parser.parse_args()
    sys.path[:0] = [str(HERE), str(HERE.parent / "tests")]
    with tempfile.TemporaryDirectory() as name:
        os.environ["XDG_CACHE_HOME"], folder = name, Path(name)
        if chosen.turns:
            turns(folder, chosen.frames, chosen.repeats)
            return
        path = chosen.mesh or folder / "room.ply"
        if not chosen.mesh:
            write_room(path, chosen.triangles)
        measure(path, chosen.frames, chosen.repeats)


if __name__ == "__main__":
    main()
