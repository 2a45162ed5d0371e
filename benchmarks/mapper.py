"""What a step of the mapping explorer costs, the world's pictures not counted.

    python benchmarks/mapper.py                       # every world, ten episodes each
    python benchmarks/mapper.py small_room large_lab --episodes 4

Prints CPU-milliseconds of `act` and `begin` a step: the median of the episodes, their quartiles, and the dearest.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from curionav_cli.agents.mapper.agent import Mapper
from curionav_cli.agents.mapper.memory import Memory
from curionav_cli.robot.depth_camera import DepthCamera
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

ENVIRONMENTS = ("small_room", "apartment_0", "apartment_1", "apartment_2", "large_lab")
STEPS, REACH = 500, 5.0  # of an episode; metres, as conf/agent/mapper.yaml sets it


def costs(name: str, episodes: int) -> list[float]:
    """CPU-milliseconds a step of each episode."""
    scene = Scene.from_dict(*plain(name))
    env = NavigationEnv(scene, engine="numba")
    agent = Mapper(0, DepthCamera(scene.fov, scene.camera, scene.agent_height),
                   Memory(scene.plan.cell, REACH, scene.plan.radius), "unvisited")
    found, (observation, info) = [], env.reset(seed=0)
    for _ in range(episodes):
        began = time.process_time()
        agent.begin()
        spent = time.process_time() - began
        for _ in range(STEPS):
            began = time.process_time()
            action = agent.act(observation, info)
            spent += time.process_time() - began
            observation, *_, info = env.step(action)
        found.append(1000 * spent / STEPS)
        observation, info = env.reset()
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("worlds", nargs="*", default=ENVIRONMENTS)
    parser.add_argument("--episodes", type=int, default=10)
    options = parser.parse_args()
    print("| world | episodes | CPU-ms a step | quartiles | dearest episode |\n|---|---|---|---|---|")
    for name in options.worlds:
        found = costs(name, options.episodes)
        low, middle, high = np.quantile(found, (0.25, 0.5, 0.75))
        print(f"| {name} | {len(found)} | {middle:.2f} | {low:.2f} to {high:.2f} | {max(found):.2f} |", flush=True)


if __name__ == "__main__":
    main()
