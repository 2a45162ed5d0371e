"""What results cost: `compare` of a hundred runs of 600 k steps, and a heatmap of 2 M poses; on this machine.

    .venv/bin/python benchmarks/results.py            two CPU-minutes, 0.3 GB in a folder of its own
    .venv/bin/python benchmarks/results.py --write    also puts the table into benchmarks/RESULTS.md

Runs are made of a few recorded episodes (agent=bounce in an apartment, pictures and all) and are linked under as
many names as a long run has episodes, so that the disk's cache holds them: the reading of a cold disk comes on top.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from datetime import date
from pathlib import Path

from simulator import machine, write

from curionav_cli.files import read_json
from curionav_cli.results import plots
from curionav_cli.results.runs import Run
from curionav_cli.storage.run_folder import RunFolder

STEPS, STORED, ARMS = 500, 40, ("random", "sticky", "bounce", "frontier")


def explored(folder: Path) -> Path:
    """Record a run of STORED episodes by `curionav explore`."""
    command("explore", "env=apartment_0", "agent=bounce", "env.engine=numba", f"loop.episodes={STORED}",
            f"hydra.run.dir={folder}")
    return folder


def command(*words: str) -> tuple[float, float]:
    """Its CPU-seconds and its seconds on the wall."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run([sys.executable, "-m", "curionav_cli", *words], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, time.perf_counter() - began


def longer(source: Path, folder: Path, episodes: int, agent: str, seed: int) -> Path:
    """Make a run of so many episodes, agent and seed, from links to those of `source`."""
    shutil.copytree(source, folder, ignore=shutil.ignore_patterns("episodes", "figures", "checkpoint*"))
    (folder / "episodes").mkdir()
    for episode in range(episodes):
        os.link(source / f"episodes/{episode % STORED:06d}.npz", folder / f"episodes/{episode:06d}.npz")
    rows = RunFolder(source).metrics()
    RunFolder(folder).write_metrics([
        {**rows[episode % STORED], "episode": episode, "steps": (episode + 1) * STEPS,
         **({"found": [], "visited": rows[-1]["visited"]} if episode >= STORED else {})}
        for episode in range(episodes)])
    write_json(folder / "status.json", {**read_json(source / "status.json"), "episode": episodes,
                                        "steps": episodes * STEPS})
    fixed = read_json(source / "fixed.json")
    write_json(folder / "fixed.json", {**fixed, "seed": seed, "agent": {**fixed["agent"], "name": agent}})
    config = (source / "config.yaml").read_text()
    (folder / "config.yaml").write_text(config.replace("name: bounce", f"name: {agent}").replace(
        f"seed: {fixed['seed']}\n", f"seed: {seed}\n"))
    return folder


def write_json(path: Path, held: object) -> None:
    path.write_text(json.dumps(held))


def heatmap(folder: Path) -> tuple[float, float]:
    """CPU-seconds of counting every pose of the run, and of drawing and saving the picture as PNG and PDF."""
    began = time.process_time()
    coverage = Run.open(folder).coverage
    counted = time.process_time()
    plots.save(plots.heatmap(coverage, "2 M poses"), folder / "heatmap.png")
    return counted - began, time.process_time() - counted


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--steps", type=int, default=600_000)
    parser.add_argument("--poses", type=int, default=2_000_000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--write", action="store_true", help="put the table into benchmarks/RESULTS.md")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=Path.cwd()) as name:
        root = Path(name)
        source = explored(root / "source")
        one = longer(source, root / "long", chosen.poses // STEPS, "bounce", 0)
        for run in range(chosen.runs):
            longer(source, root / f"sweep/{run}_run", chosen.steps // STEPS, ARMS[run % len(ARMS)], run // len(ARMS))
        pairs = [(heatmap(one), command("compare", str(root / "sweep"), f"out={root / 'compare'}"))
                 for _ in range(chosen.repeats)]
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e6
    table = "\n".join([
        f"{machine()}, {date.today()}; least to most of {chosen.repeats} repeats.", "",
        "| what | CPU-s | seconds on the wall | memory of the largest process |", "|---|---|---|---|",
        f"| `compare` of {chosen.runs} runs of {chosen.steps:,} steps | {spread(compare[0] for _, compare in pairs)} | "
        f"{spread(compare[1] for _, compare in pairs)} | {peak:.2f} GB |",
        f"| counting {chosen.poses:,} poses | {spread(count for (count, _), _ in pairs)} | | |",
        f"| drawing their heatmap, PNG and PDF | {spread(draw for (_, draw), _ in pairs)} | | |"])
    print(table)
    if chosen.write:
        write(table, "results")


def spread(numbers: Iterable[float]) -> str:
    every = sorted(numbers)
    return f"{every[0]:.1f} to {every[-1]:.1f}"


if __name__ == "__main__":
    main()
