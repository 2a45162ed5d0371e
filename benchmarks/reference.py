"""The curves that every learner must beat: baselines that do not learn, in every environment.

    python benchmarks/reference.py            # 100 k steps, five seeds: minutes on one core
    python benchmarks/reference.py --steps 10000 --seeds 2 --out /tmp/reference

Coverage does not depend on what is drawn, so nothing is drawn. Writes reference.md, reference.csv and a figure for
each environment into docs/reference.
"""

from __future__ import annotations

import argparse
import csv
import statistics
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from curionav_cli.agents.agent import Agent
from curionav_cli.agents.baselines import Bounce, Random, Sticky
from curionav_cli.agents.frontier import Frontier
from curionav_cli.loop import run_episode
from curionav_cli.results import plots
from curionav_cli.results.coverage import Coverage, Curve
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

ENVIRONMENTS = ("small_room", "apartment_0", "apartment_1", "apartment_2", "large_lab")
EPISODE = 500
AT = (0.1, 0.3, 1.0)  # of all steps
NOTHING = np.zeros((1, 1, 3), np.uint8)


class Undrawn(NavigationEnv):
    """An environment that moves the robot and renders nothing."""

    def _observe(self) -> dict[str, np.ndarray]:
        return {"image": NOTHING, "depth": NOTHING}


class NoCallbacks:
    """Callbacks that do nothing."""

    def acted(self, step: int) -> None:
        """One more step."""


AGENTS: dict[str, Callable[[int, Scene], Agent]] = {  # as conf/agent sets them
    "random": lambda seed, world: Random(seed),
    "sticky": lambda seed, world: Sticky(seed, repeat=0.75),
    "bounce": lambda seed, world: Bounce(seed, least=3, most=18),
    "frontier": Frontier,
}


def explore(env: str, name: str, seed: int, steps: int) -> tuple[Curve, bool]:
    """Explore in episodes of 500 steps, each from the start: the curve, and whether anything was drawn at random."""
    world = Scene.from_dict(*plain(env))
    agent, world_env, coverage = AGENTS[name](seed, world), Undrawn(world), Coverage(world.plan)
    before = agent.rng.bit_generator.state
    observation, info = world_env.reset(seed=seed)
    for _ in range(steps // EPISODE):
        coverage.add(run_episode(world_env, agent, observation, info, EPISODE, NoCallbacks()).pose)  # type: ignore[arg-type]
        observation, info = world_env.reset()
    return coverage.curve(), world.changing or agent.rng.bit_generator.state != before


def curves_of(env: str, seeds: int, steps: int, pool: ProcessPoolExecutor) -> dict[str, list[Curve]]:
    """The curves of every agent. Without randomness, in a world that does not change, one run stands for all seeds."""
    first = {name: pool.submit(explore, env, name, 0, steps) for name in reversed(AGENTS)}
    chance = {name: future.result()[1] for name, future in first.items()}
    more = {name: [pool.submit(explore, env, name, seed, steps) for seed in range(1, seeds)]
            for name in reversed(AGENTS) if chance[name]}
    others = {name: more.get(name, [first[name]] * (seeds - 1)) for name in AGENTS}
    return {name: [future.result()[0] for future in (first[name], *others[name])] for name in AGENTS}


def rows(env: str, curves: dict[str, list[Curve]]) -> Iterator[dict[str, Any]]:
    for agent, found in curves.items():
        for seed, curve in enumerate(found):
            shares = {f"coverage_at_{int(part * curve.steps)}": int(curve.at(int(part * curve.steps))) / curve.total
                      for part in AT}
            yield {"env": env, "agent": agent, "seed": seed, "steps": curve.steps, "cells": curve.total, **shares,
                   "area_under_curve": curve.area(), "steps_to_50": curve.steps_to(0.5),
                   "steps_to_80": curve.steps_to(0.8), "steps_to_90": curve.steps_to(0.9),
                   "steps_to_99": curve.steps_to(0.99)}


def picture(env: str, curves: dict[str, list[Curve]]) -> Figure:
    """Every seed as a line, on a logarithmic axis of steps."""
    figure = Figure((6.4, 3.8), layout="constrained")
    axes = figure.add_subplot()
    for name, runs in curves.items():
        colour, dashes, _ = plots.STYLES[name]
        for number, curve in enumerate(runs):
            steps = np.unique(np.geomspace(100, curve.steps, 300).astype(int))
            axes.plot(steps, 100 * curve.at(steps) / curve.total, color=colour, linestyle=dashes, linewidth=1.1,
                      label=None if number else name)
    axes.set(xscale="log", xlabel="steps", ylabel="share of visitable cells (%, landing)", ylim=(0, 102),
             title=f"{env}: {runs[0].total} visitable cells, {len(runs)} seeds")
    figure.legend(loc="outside lower center", ncols=4)
    return figure


def markdown(table: list[dict[str, Any]]) -> str:
    """Mean and standard deviation over seeds."""
    columns = [key for key in table[0] if key.startswith(("coverage_at", "area"))]
    lines = ["| env | agent | n | " + " | ".join(key.replace("_", " ") for key in columns) + " |",
             "|---" * (3 + len(columns)) + "|"]
    for env, agent in dict.fromkeys((row["env"], row["agent"]) for row in table):
        same = [row for row in table if (row["env"], row["agent"]) == (env, agent)]
        numbers = [[row[key] for row in same] for key in columns]
        spread = [f"{statistics.mean(values):.3f} ± {statistics.stdev(values) if len(values) > 1 else 0:.3f}"
                  for values in numbers]
        lines.append(f"| {env} | {agent} | {len(same)} | " + " | ".join(spread) + " |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=100_000)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent.parent / "docs" / "reference")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    table: list[dict[str, Any]] = []
    with ProcessPoolExecutor() as pool:
        for env in ENVIRONMENTS:
            curves = curves_of(env, options.seeds, options.steps, pool)
            table += rows(env, curves)
            plots.save(picture(env, curves), options.out / f"coverage_{env}.png")
            print(markdown([row for row in table if row["env"] == env]), flush=True)
    with open(options.out / "reference.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, list(table[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)
    (options.out / "reference.md").write_text(
        "# The reference that every learner must beat\n\n"
        f"Written by `benchmarks/reference.py`: {options.steps} steps in episodes of {EPISODE} from one start, "
        f"{options.seeds} seeds. Mean ± standard deviation of the coverage (share of visitable cells, marked by "
        "landing) and of the area under its curve. `frontier` is an oracle with map access; in a world that "
        "does not change it draws nothing at random until it has been everywhere, so that its seeds agree.\n\n"
        + markdown(table) + "\n\n" + "\n".join(f"![{env}](coverage_{env}.png)" for env in ENVIRONMENTS) + "\n")


if __name__ == "__main__":
    main()
