"""Two trees of this repository and ViZDoom in turns: environment steps a second of CPU time, on this machine.

    python benchmarks/simulator_turns.py OLD NEW PYTHON

OLD, NEW: folders of checkouts (from 60844e6 on); PYTHON: one that has the packages of benchmarks/simulator.py.

One process a tree holds all its worlds; in every round each contender takes its turn of a few hundred steps, so that a
machine that is shared slows all alike. `every picture new` forgets the pictures of the place before each step and
leaves out moves that are cancelled. NUMBA_CPU_NAME=haswell and NPY_DISABLE_CPU_FEATURES="X86_V4 AVX512_ICL AVX512_SPR"
imitate a processor without AVX-512.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
WARM = 100


def contenders(tree: str) -> dict:
    """Name to (step, worlds) for ViZDoom or the worlds of a tree, after its first steps."""
    sys.path.insert(0, str(HERE))
    import contenders as one

    if tree == "vizdoom":
        found = {"ViZDoom, RGB and depth": one.vizdoom(True, True)}
    else:
        sys.path.insert(0, tree)
        found = {f"apartment_1, {engine}, {worlds} world{'s' * (worlds > 1)}{'' if reuse else ', every picture new'}":
                 one.curionav("apartment_1", engine, worlds, reuse)
                 for engine in ("numpy", "numba") for worlds in (1, 16) for reuse in (True, False)}
    for step, worlds in found.values():
        for index in range(WARM // worlds + 2):
            step(index)
    return found


def work(tree: str, steps: int) -> None:
    """Answer each line of the input, the name of a contender, with the seconds of CPU time of a step."""
    sys.path.insert(0, str(HERE))
    from contenders import spent

    found, at = contenders(tree), {}
    print(json.dumps(list(found)), flush=True)
    for line in sys.stdin:
        step, worlds = found[line.strip()]
        first = at.get(line, WARM // worlds + 2)
        at[line] = last = first + steps // worlds
        begin = spent()
        for index in range(first, last):
            step(index)
        print(json.dumps((spent() - begin) / ((last - first) * worlds)), flush=True)


def main(old: str, new: str, python: str, rounds: int, steps: int) -> None:
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "SDL_AUDIODRIVER": "dummy"}
    with tempfile.TemporaryDirectory() as folder:
        ways = {tree: subprocess.Popen([python, __file__, "--work", tree, str(steps)], env=environment, cwd=folder,
                                       stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
                for tree in ("vizdoom", old, new)}
        names = {tree: json.loads(way.stdout.readline()) for tree, way in ways.items()}
        seconds: dict[tuple[str, str], list[float]] = {}
        for _ in range(rounds):
            for name in [*names["vizdoom"], *names[new]]:
                for tree, way in ways.items():
                    if name in names[tree]:
                        way.stdin.write(name + "\n")
                        way.stdin.flush()
                        seconds.setdefault((tree, name), []).append(json.loads(way.stdout.readline()))
        for way in ways.values():
            way.stdin.close()
            way.wait()
    report(seconds, old, new, names["vizdoom"][0])


def report(seconds: dict[tuple[str, str], list[float]], old: str, new: str, doom: str) -> None:
    print(f"n = {len(seconds['vizdoom', doom])} rounds; load average {os.getloadavg()[0]:.1f}")
    base = np.array(seconds["vizdoom", doom])
    print("| | steps a CPU-second, old | new | x ViZDoom, old | new (quartiles) | new / old |\n" + "|---" * 6 + "|")
    print(f"| {doom} | {1 / np.median(base):.0f} | | 1 | | |")
    for (tree, name), times in seconds.items():
        if tree == new:
            before, after = np.array(seconds[old, name]), np.array(times)
            low, high = np.quantile(base / after, (0.25, 0.75))
            print(f"| {name} | {1 / np.median(before):.0f} | {1 / np.median(after):.0f} "
                  f"| {np.median(base / before):.2f} | {np.median(base / after):.2f} ({low:.2f} to {high:.2f}) "
                  f"| {np.median(before / after):.2f} |")


if __name__ == "__main__":
    if sys.argv[1] == "--work":
        work(sys.argv[2], int(sys.argv[3]))
    else:
        main(*sys.argv[1:4], rounds=int(os.environ.get("ROUNDS", "9")), steps=int(os.environ.get("STEPS", "480")))
