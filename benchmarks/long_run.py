"""A run of 600 k random steps in the lab: does memory stay flat, the disk as predicted, the speed what it was?

    python benchmarks/long_run.py [--steps 600000] [--probe 100] OUT

Runs `probe` episodes of another seed first and predicts from them the disk space of the whole run, with
two standard errors: episodes differ by a fifth in size, as pictures of a wall pack better than those of an aisle, so
that six of them would predict it to within 18 %. Then runs it, reads the process's memory from /proc after every
episode, and prints both beside what came.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

STEPS = 500  # of an episode
WORDS = ("agent=random", "env=large_lab", "env.engine=numba", f"loop.steps={STEPS}")


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--steps", type=int, default=600_000)
    asked.add_argument("--probe", type=int, default=100)
    asked.add_argument("out", type=Path)
    options = asked.parse_args()
    episodes = options.steps // STEPS
    explore(options.out / "probe", options.probe, seed=1)
    predicted, tolerance = predict(options.out / "probe", episodes)
    print(f"predicted for {episodes} episodes: {predicted / 1e9:.3f} GB, to within {tolerance:.1%}", flush=True)
    memory = explore(options.out / "run", episodes, seed=0)
    report(options.out / "run", memory, predicted)


def explore(run: Path, episodes: int, seed: int) -> list[float]:
    """MB of memory after each episode, the last reading before the next one ends."""
    process = subprocess.Popen(
        [sys.executable, "-m", "curionav_cli", "explore", *WORDS, f"seed={seed}", f"loop.episodes={episodes}",
         f"hydra.run.dir={run}"], stdout=subprocess.DEVNULL)
    memory: list[float] = []
    while process.poll() is None:
        done = lines(run / "metrics.jsonl")
        reading = resident(process.pid)
        if done > len(memory) and reading:
            memory += [reading] * (done - len(memory))
        time.sleep(0.05)
    if process.returncode:
        raise SystemExit(f"the run in {run} ended with {process.returncode}")
    return memory


def lines(path: Path) -> int:
    return path.read_bytes().count(b"\n") if path.exists() else 0


def resident(pid: int) -> float:
    """MB, 0 where the process has gone."""
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
    except (OSError, IndexError):
        return 0.0


def predict(probe: Path, episodes: int) -> tuple[float, float]:
    """Bytes, and two standard errors as a share of them. What grows with episodes: their files, and metrics."""
    sizes = [path.lstat().st_blocks * 512 for path in (probe / "episodes").iterdir()]
    line = (probe / "metrics.jsonl").stat().st_size / len(sizes)
    still = size(probe) - sum(sizes) - line * len(sizes)
    predicted = still + (statistics.mean(sizes) + line) * episodes
    error = statistics.stdev(sizes) * (1 / len(sizes) + 1 / episodes) ** 0.5 * episodes
    return predicted, 2 * error / predicted


def size(folder: Path) -> int:
    return sum(path.lstat().st_blocks * 512 for path in folder.rglob("*"))


def report(run: Path, memory: list[float], predicted: float) -> None:
    rows = [json.loads(line) for line in (run / "metrics.jsonl").read_text().splitlines()]
    tenth = max(1, len(rows) // 10)
    spent = [row["cpu_seconds_acting"] + row["cpu_seconds_learning"] for row in rows]
    first, last = (STEPS * tenth / sum(part) for part in (spent[tenth:2 * tenth], spent[-tenth:]))
    early, late = max(memory[:tenth]), max(memory[-tenth:])
    print(f"episodes {len(rows)}, steps {len(rows) * STEPS}, CPU-seconds acting {sum(spent):.0f}")
    print(f"memory: at most {early:.1f} MB in the first tenth, {late:.1f} MB in the last ({late / early:.3f})")
    print(f"disk: {size(run) / 1e9:.3f} GB, predicted {predicted / 1e9:.3f} GB ({size(run) / predicted:.3f})")
    print(f"speed: {first:.0f} steps per CPU-second in the second tenth, {last:.0f} in the last ({last / first:.3f})")


if __name__ == "__main__":
    main()
