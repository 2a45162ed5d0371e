"""What a second thread in every process brings to a sweep whose runs already share the cores.

    python benchmarks/threads.py [--repeats 3]

The same sweep of two learners side by side, with one thread a process and with two, in turns; prints CPU-seconds of
all its processes and seconds on the wall.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time

SWEEP = ("explore", "-m", "env=small_room", "agent=lbs_dreamer", "scale=cpu", "seed=0,1", "launcher=cores",
         "loop.steps=100", "loop.iterations=30", "loop.episodes=2")


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--repeats", type=int, default=3)
    measured: dict[int, list[tuple[float, float]]] = {1: [], 2: []}
    for _ in range(asked.parse_args().repeats):
        for threads, rows in measured.items():
            rows.append(swept(threads))
            print(f"{threads} threads: {rows[-1][0]:.1f} CPU-seconds, {rows[-1][1]:.1f} s", flush=True)
    for name, column in (("CPU-seconds", 0), ("seconds on the wall", 1)):
        ratios = [two[column] / one[column] for one, two in zip(measured[1], measured[2], strict=True)]
        print(f"{name}, two threads over one: median {statistics.median(ratios):.2f}, "
              f"{min(ratios):.2f} to {max(ratios):.2f}, n = {len(ratios)}")


def swept(threads: int) -> tuple[float, float]:
    """CPU-seconds of all processes of one sweep, and seconds."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, "-m", "curionav_cli", *SWEEP, f"hydra.sweep.dir={folder}/sweep"], check=True,
                       stdout=subprocess.DEVNULL, env={**os.environ, "OMP_NUM_THREADS": str(threads)})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, time.perf_counter() - began


if __name__ == "__main__":
    main()
