"""Cost of a return to dock: CPU-seconds of exploring, of driving home and docking, by room; on this machine.

    .venv/bin/python benchmarks/docking.py            about a CPU-minute
    .venv/bin/python benchmarks/docking.py --write    also puts the table into benchmarks/RESULTS.md

Rooms take turns, so that a machine that is shared slows them alike.
"""

from __future__ import annotations

import argparse
import time
from datetime import date

import numpy as np
from simulator import machine, write

from curionav_cli import build
from curionav_cli.config.compose import compose
from curionav_cli.config.override_errors import OverrideErrors
from curionav_cli.config.schema import Config
from curionav_cli.config.sources import opened

ROOMS = ("small_room", "large_lab")


def settings(room: str, robot: str) -> Config:
    words = [f"env={room}", f"robot={robot}", "agent=bounce"]
    with opened("dock") as hydra:
        return compose(hydra, OverrideErrors(hydra, words), words)[0]


class Trial:
    """A robot that explores and returns to its dock; measure() gives CPU-seconds of both, and its own seconds."""

    def __init__(self, room: str, robot: str):
        self.settings = settings(room, robot)
        world = build.scene(self.settings)
        self.env, self.agent = build.robot_env(self.settings, world, pictures=False), build.agent(self.settings, world)
        self.seen = self.env.reset(seed=0)

    def measure(self) -> tuple[float, float, float]:
        observation, info = self.seen
        began = time.process_time()
        self.agent.begin()
        for _ in range(self.settings.loop.steps):
            observation, _, _, _, info = self.env.step(self.agent.act(observation, info))
        explored = time.process_time()
        self.seen = self.env.reset()
        return explored - began, time.process_time() - explored, self.seen[1]["dock"]["seconds"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--requests", type=int, default=40, help="returns to dock in each room")
    parser.add_argument("--robot", nargs="*", default=["turtlebot2i", "turtlebot2i_plus"])
    parser.add_argument("--write", action="store_true", help="put the table into benchmarks/RESULTS.md")
    chosen = parser.parse_args()
    trials = {(room, robot): Trial(room, robot) for robot in chosen.robot for room in ROOMS}
    measured = {key: np.array([]).reshape(0, 3) for key in trials}
    for _ in range(chosen.requests):
        for key, trial in trials.items():
            measured[key] = np.vstack([measured[key], trial.measure()])
    lines = ["| room | robot | exploring, CPU-s | return to dock, CPU-s | returns a CPU-minute | "
             "seconds that passed for the robot, a CPU-second |", "|---|---|---|---|---|---|"]
    for (room, robot), rows in measured.items():
        explore, home, passed = rows.mean(axis=0)
        used = trials[room, robot].settings
        lines.append(f"| {room} | {robot} | {explore:.3f} | {home:.3f} ± {rows[:, 1].std(ddof=1):.3f} | "
                     f"{60 / (explore + home):.0f} | "
                     f"{(used.loop.steps * used.robot.step + passed) / (explore + home):.0f} |")
    text = (f"{machine()}, {date.today()}; means over {chosen.requests} returns each (± sd), "
            f"each after 500 steps of `bounce`.\n\n" + "\n".join(lines))
    print(text)
    if chosen.write:
        write(text, "docking")


if __name__ == "__main__":
    main()
