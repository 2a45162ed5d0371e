"""What a choice of LBS Dreamer costs by its actor and by a search in its world model.

    OMP_NUM_THREADS=1 python benchmarks/planning.py [--repeats 20] [SETTING=VALUE ...]

CPU-milliseconds of one choice, filtering of its image included, in turns: each repeat takes CHOICES choices of each
row. Settings (agent.plan_samples=16, scale=paper) change all rows.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from learner_contenders import settings
from simulator import machine

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
CHOICES = 40
ROWS = {
    "actor, three actions": ("agent.options=none",),
    "actor, options": ("agent.options=seven",),
    "search one option ahead": ("agent.options=seven", "agent.behaviour=plan", "agent.plan_depth=1"),
    "search two options ahead": ("agent.options=seven", "agent.behaviour=plan", "agent.plan_depth=2"),
    "search two actions ahead": ("agent.options=none", "agent.behaviour=plan", "agent.plan_depth=2"),
    "search three options ahead": ("agent.options=seven", "agent.behaviour=plan", "agent.plan_depth=3"),
}


def chooser(overrides: list[str]):
    """A fresh agent of these settings, as a function of an image that returns its choice."""
    from curionav_cli import build

    chosen = settings(["device=cpu", *overrides])
    agent = build.agent(chosen, build.scene(chosen))
    return lambda image: agent.filtered({"image": image}, 0)


def milliseconds(choose, images: np.ndarray) -> float:
    """CPU-milliseconds of one choice."""
    began = time.process_time()
    for image in images:
        choose(image)
    return 1e3 * (time.process_time() - began) / len(images)


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--repeats", type=int, default=20)
    asked.add_argument("overrides", nargs="*")
    given = asked.parse_args()
    images = np.random.default_rng(0).integers(0, 256, (CHOICES, 64, 64, 3), np.uint8)
    choosers = {name: chooser([*given.overrides, *words]) for name, words in ROWS.items()}
    for choose in choosers.values():
        milliseconds(choose, images)  # libraries choose their kernels
    measured: dict[str, list[float]] = {name: [] for name in ROWS}
    for _ in range(given.repeats):
        for name, choose in choosers.items():
            measured[name].append(milliseconds(choose, images))
    print(f"{machine()}; medians of {given.repeats} times {CHOICES} choices, {' '.join(given.overrides)}\n")
    print("| a choice | CPU-ms | 10 % to 90 % |\n|---|---|---|")
    for name, times in measured.items():
        low, typical, high = np.percentile(times, (10, 50, 90))
        print(f"| {name} | {typical:.2f} | {low:.2f} to {high:.2f} |")


if __name__ == "__main__":
    main()
