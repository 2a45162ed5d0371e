"""What a frame of C-BET costs, piece by piece, and the core-hours of its protocol.

    .venv/bin/python benchmarks/cbet.py              # scale=cpu, a minute; --scale paper, some minutes
    .venv/bin/python benchmarks/cbet.py --write

One thread, CPU time of the whole process. In each repeat every piece takes its turn, so that a machine that is shared
slows all alike; the median over repeats is shown.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from learner_contenders import settings
from simulator import machine, write

from curionav_cli import build
from curionav_cli.agents.cbet.transitions import Transitions
from curionav_cli.agents.cbet.unrolls import split_episode, stack_unrolls
from curionav_cli.loop import run_episode

STEPS = 500
UNROLLS = {"cpu": 5, "paper": 4}  # of an update here: frames are what counts
DESCRIBED = {"cpu": "0.6", "paper": "7.5 to 12"}  # ms a frame of acting and learning, as described to us
PROTOCOL = {"cpu": 100_000, "paper": 5_000_000}


class Nobody:
    """A watcher that does not look."""

    def acted(self, step: int) -> None:
        """One more step."""


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """CPU-ms, and what came of it."""
    began = time.process_time()
    result = work()
    return 1000 * (time.process_time() - began), result


class Pieces:
    """One agent in the small room, and what it does with an episode."""

    def __init__(self, scale: str, words: list[str]):
        chosen = settings(["env=small_room", "agent=cbet", f"scale={scale}", "device=cpu", *words])
        self.world = build.scene(chosen)
        self.env, self.agent = build.env(chosen, self.world), build.agent(chosen, self.world)
        self.unrolls, self.index, self.start = UNROLLS[scale], 0, self.env.reset(seed=0)

    def repeat(self, steps: int) -> dict[str, float]:
        """CPU-ms a frame of each piece."""
        rng, agent = np.random.default_rng(self.index), self.agent
        agent.begin()
        whole, episode = timed(lambda: run_episode(self.env, agent, *self.start, steps, Nobody()))  # type: ignore
        self.start = self.env.reset()
        world, _ = timed(lambda: [self.env.step(int(action)) for action in rng.permutation(episode.action)])
        self.start = self.env.reset()
        transitions = Transitions(episode, self.index, self.index % agent.hyper.environments)
        rewarding, (bonus, _) = timed(lambda: agent.learner.reward.episode_bonus(transitions))
        unrolls = split_episode(transitions, agent.acted, bonus, agent.hyper.unroll)
        batch = stack_unrolls(unrolls[:self.unrolls], agent.device)
        learning, _ = timed(lambda: agent.learner.update(batch))
        self.index += 1
        return {"world": world / steps, "acting": max(0.0, whole - world) / steps, "reward": rewarding / steps,
                "learning": learning / batch.action.numel()}


def measured(scale: str, words: list[str], repeats: int) -> dict[str, float]:
    pieces = Pieces(scale, words)
    pieces.repeat(STEPS)
    rows = [pieces.repeat(STEPS) for _ in range(repeats)]
    return {name: statistics.median(row[name] for row in rows) for name in rows[0]}


def table(scales: list[str], repeats: int) -> str:
    lines = ["| scale | engine | world | acting | reward | learning | all, ms a frame | acting and learning, described "
             "| core-hours of the protocol |", "|---" * 9 + "|"]
    for scale in scales:
        for engine in ("numpy", "numba"):
            found = measured(scale, [f"env.engine={engine}"], repeats)
            whole = sum(found.values())
            pieces = " | ".join(f"{found[name]:.2f}" for name in ("world", "acting", "reward", "learning"))
            hours = whole * PROTOCOL[scale] / 3.6e6
            lines.append(f"| {scale} | {engine} | {pieces} | {whole:.2f} | {found['acting'] + found['learning']:.2f}, "
                         f"{DESCRIBED[scale]} | {hours:.1f} for {PROTOCOL[scale]:,} |")
    about = f"{machine()}; torch {torch.__version__}; median of {repeats} repeats of {STEPS} steps."
    return f"{about}\n\n" + "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scale", choices=list(PROTOCOL), action="append")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--write", action="store_true", help="put the table into benchmarks/RESULTS.md")
    options = parser.parse_args()
    torch.set_num_threads(1)
    text = table(options.scale or ["cpu"], options.repeats)
    print(text)
    if options.write:
        write(text, "cbet")


if __name__ == "__main__":
    main()
