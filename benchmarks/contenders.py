"""One simulator, stepped by a random agent in its own process: prints the seconds of CPU time a step took.

    python benchmarks/contenders.py NAME STEPS

CPU time is that of this process and its children, all threads: ViZDoom draws in a child process and
Miniworld's Mesa in threads. Making the environment and the first steps are not counted.
"""

from __future__ import annotations

import json
import os
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

HOME = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(HOME), str(HOME / "tests")]
WARM = 100  # steps before the clock starts
Step = Callable[[int], object]


def vizdoom(depth: bool, resized: bool) -> tuple[Step, int]:
    """My Way Home through ViZDoom's own Gymnasium environment, at the smallest screen it has, 160 x 120."""
    import cv2
    import gymnasium
    from vizdoom import ScreenResolution, gymnasium_wrapper  # noqa: F401 it registers the environments

    env = gymnasium.make("VizdoomMyWayHome-v1", screen_resolution=ScreenResolution.RES_160X120,
                         depth_buffer_enabled=depth).unwrapped
    env.reset(seed=0)
    actions = np.random.default_rng(0).integers(1, 4, 100_000).tolist()  # left, right, forward

    def step(index: int) -> None:
        seen, _, terminated, truncated, _ = env.step(actions[index])
        if resized:
            cv2.resize(seen["screen"], (64, 64), interpolation=cv2.INTER_AREA)
            if depth:
                cv2.resize(seen["depth"], (64, 64), interpolation=cv2.INTER_NEAREST)
        if terminated or truncated:
            env.reset()

    return step, 1


def miniworld(depth: bool) -> tuple[Step, int]:
    """Four Rooms at 64 x 64, drawn by OpenGL on EGL without a display."""
    import pyglet

    pyglet.options["headless"] = True
    import gymnasium
    import miniworld  # noqa: F401 it registers the environments

    env = gymnasium.make("MiniWorld-FourRooms-v0", obs_width=64, obs_height=64, window_width=64,
                         window_height=64).unwrapped
    env.reset(seed=0)
    actions = np.random.default_rng(0).integers(0, 3, 100_000).tolist()

    def step(index: int) -> None:
        _, _, terminated, truncated, _ = env.step(actions[index])
        if depth:
            env.render_depth()
        if terminated or truncated:
            env.reset()

    return step, 1


def curionav(scene: str, engine: str, worlds: int, reuse: bool) -> tuple[Step, int]:
    """Ours, RGB and depth. Without reuse, every step draws: pictures are forgotten, cancelled moves left out."""
    from curionav_cli.world.registration import make
    from curionav_cli.world.vector_env import NavigationVectorEnv

    where = {}
    if scene == "map":
        from office import write_office

        where["map"] = str(write_office(Path(tempfile.mkdtemp())))
    env = make(scene, engine=engine, **where)
    actions = np.random.default_rng(0).integers(0, 3, (worlds, 4 * (30_000 // worlds)))
    if not reuse:
        for row in actions:
            kept = uncancelled(env.scene, row.tolist())
            row[:len(kept)] = kept
    if worlds == 1:
        env.reset(seed=0)
        single = actions[0].tolist()
        return forgetful(env, lambda index: env.step(single[index]), reuse), 1
    many = NavigationVectorEnv(env.scene, worlds, engine=engine)
    many.reset(seed=0)
    return forgetful(many, lambda index: many.step(actions[:, index]), reuse), worlds


def forgetful(env, step: Step, reuse: bool) -> Step:
    """The same step; without reuse, of worlds that have forgotten what they saw from this place."""
    if reuse or not hasattr(env, "_pictures"):  # older versions keep the last picture only
        return step

    def forgetting(index: int) -> None:
        for world in range(getattr(env, "num_envs", 1)):
            env._pictures.forget(world)
        step(index)

    return forgetting


def uncancelled(scene, actions: list[int]) -> list[int]:
    """The actions without the forward moves that something is in the way of."""
    from curionav_cli.constants import FORWARD
    from curionav_cli.world.motion import forward

    plan, heading, kept = scene.plan, scene.start_heading, []
    x, y = plan.start[:2]
    for action in actions:
        blocked = False
        if action == FORWARD:
            x, y, blocked = forward(plan.visitable, plan.cell, x, y, heading)
        else:
            heading = (heading + 3 - 2 * action) % 36
        kept += [] if blocked else [action]
    return kept


def office() -> dict[str, float]:
    """Loading a map of 100 x 100 m: seconds of CPU time, boxes, and the most memory it took, in MB."""
    from office import write_office

    from curionav_cli.world.registration import make

    path = write_office(Path(tempfile.mkdtemp()))
    begin = time.process_time()
    env = make("map", map=str(path))
    env.reset(seed=0)
    used = time.process_time() - begin
    return {"load": used, "boxes": len(env.scene.boxes),
            "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3}


CONTENDERS: dict[str, Callable[[], tuple[Step, int]]] = {
    "ViZDoom, RGB and depth, resized to 64 x 64": lambda: vizdoom(True, True),
    "ViZDoom, RGB, resized to 64 x 64": lambda: vizdoom(False, True),
    "ViZDoom, RGB and depth as drawn, 160 x 120": lambda: vizdoom(True, False),
    "Miniworld, RGB": lambda: miniworld(False),
    "Miniworld, RGB and depth": lambda: miniworld(True),
    **{f"curionav {scene}, {engine}, {worlds} world{'s' * (worlds > 1)}{'' if reuse else ', every picture new'}":
       lambda scene=scene, engine=engine, worlds=worlds, reuse=reuse: curionav(scene, engine, worlds, reuse)
       for scene, counts in (("small_room", (1, 16, 64)), ("apartment_1", (1, 16)), ("map", (1,)))
       for engine in ("numpy", "numba") for worlds in counts
       for reuse in ((True, False) if scene == "small_room" else (True,))},
}


def spent() -> float:
    """Seconds of CPU time of this process and its living children."""
    total = time.process_time()
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text().rsplit(")", 1)[1].split()
        except OSError:  # it ended meanwhile
            continue
        if int(fields[1]) == os.getpid():
            total += (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return total


def main(name: str, steps: int) -> dict[str, float]:
    if name == "office":
        return office()
    step, worlds = CONTENDERS[name]()
    for index in range(WARM // worlds + 2):
        step(index)
    first, last = WARM // worlds + 2, WARM // worlds + 2 + steps // worlds
    begin = spent()
    for index in range(first, last):
        step(index)
    return {"seconds": (spent() - begin) / ((last - first) * worlds)}


if __name__ == "__main__":
    print(json.dumps(main(sys.argv[1], int(sys.argv[2]))))
