"""What a step of acting costs the explorers that map, beside LBS Dreamer, the world's pictures not counted.

    OMP_NUM_THREADS=1 python benchmarks/explorers.py --write          # every world, five episodes each, into RESULTS.md
    OMP_NUM_THREADS=1 python benchmarks/explorers.py small_room --episodes 3

CPU-milliseconds of `act` and `begin` a step, in turns: an episode of each row, then the next of each. Each row acts in
a world of its own, with the weights that it begins with. No one learns; `curious_mapper` ascribes what its untrained
model measures. Beside another commit, and late in a run: explorers_turns.py.
"""

from __future__ import annotations

import argparse
import os
import time
from datetime import date

import numpy as np
from learner_contenders import settings
from simulator import machine, write

from curionav_cli import build
from curionav_cli.agents.agent import Agent
from curionav_cli.world.env import NavigationEnv

WORLDS = ("small_room", "apartment_0", "apartment_1", "apartment_2", "large_lab")
STEPS = 500  # of an episode
ROWS = {
    "mapper": ("agent=mapper",),
    "curious_mapper": ("agent=curious_mapper",),
    "its control `visits`": ("agent=curious_mapper", "agent.surprise=visits"),
    "lbs_dreamer": ("agent=lbs_dreamer",),
    "lbs_dreamer, an action a step": ("agent=lbs_dreamer", "agent.action_repeat=1"),
}
BESIDE = "lbs_dreamer"


class Acting:
    """An agent in its world."""

    def __init__(self, world: str, words: tuple[str, ...]):
        chosen = settings([f"env={world}", "device=cpu", "compile=none", "env.engine=numba", *words])
        scene = build.scene(chosen)
        self.agent: Agent = build.agent(chosen, scene)
        self.env = NavigationEnv(scene, engine="numba")
        self.seen = self.env.reset(seed=0)
        self.actions: list[int] = []  # of the last episode

    def episode(self) -> float:
        """Act for an episode; CPU-milliseconds a step."""
        observation, info = self.seen
        spent = -time.process_time()
        self.agent.begin()
        spent += time.process_time()
        self.actions = []
        for _ in range(STEPS):
            spent -= time.process_time()
            action = self.agent.act(observation, info)
            spent += time.process_time()
            self.actions.append(action)
            observation, *_, info = self.env.step(action)
        self.seen = self.env.reset()
        return 1000 * spent / STEPS


def table(world: str, episodes: int) -> list[str]:
    """The rows of a world; the ratio is the median of those to LBS Dreamer's episode of the same turn."""
    acting = {name: Acting(world, words) for name, words in ROWS.items()}
    for one in acting.values():
        one.episode()  # libraries choose their kernels
    turns = [{name: one.episode() for name, one in acting.items()} for _ in range(episodes)]
    lines = []
    for name in ROWS:
        low, middle, high = np.quantile([turn[name] for turn in turns], (0.25, 0.5, 0.75))
        ratio = np.median([turn[name] / turn[BESIDE] for turn in turns])
        lines.append(f"| {world} | {name} | {middle:.2f} | {low:.2f} to {high:.2f} | {ratio:.2f} |")
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("worlds", nargs="*", default=WORLDS)
    parser.add_argument("--episodes", type=int, default=5)
    parser.add_argument("--write", action="store_true", help="put the table into benchmarks/RESULTS.md")
    options = parser.parse_args()
    before = os.getloadavg()[0]
    rows = [line for world in options.worlds for line in table(world, options.episodes)]
    text = "\n".join([
        f"{machine()}, {date.today()}; {options.episodes} episodes of {STEPS} steps each, one thread; load average "
        f"{before:.1f} before and {os.getloadavg()[0]:.1f} after.", "",
        "| world | agent | CPU-ms a step | quartiles | x lbs_dreamer |", "|---|---|---|---|---|", *rows])
    print(text)
    if options.write:
        write(text, "explorers")


if __name__ == "__main__":
    main()
