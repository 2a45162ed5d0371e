"""Registration of the scenes with Gymnasium; imports little, because it is loaded together with gymnasium."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from curionav_cli.world.env import NavigationEnv

SCENES = {
    "curionav/SmallRoom-v0": "small_room",
    "curionav/Apartment0-v0": "apartment_0",
    "curionav/Apartment1-v0": "apartment_1",
    "curionav/Apartment2-v0": "apartment_2",
    "curionav/LargeLab-v0": "large_lab",
    "curionav/Map-v0": "map",
    "curionav/Scan-v0": "scan",
}
STEPS = 500  # of an episode (paper: N); our own loop has loop.steps


def register() -> None:
    """Register the scenes. Called by curionav_cli/__init__.py as soon as gymnasium is imported."""
    from gymnasium.envs.registration import register as register_one
    from gymnasium.envs.registration import registry

    for name, scene in SCENES.items():
        if name not in registry:
            register_one(name, entry_point="curionav_cli.world.registration:make", kwargs={"scene": scene},
                         vector_entry_point="curionav_cli.world.vector_env:make", max_episode_steps=STEPS)


def make(scene: str, render_mode: str | None = None, reward: str = "none", reset_mode: str = "restart",
         observation: str = "dict", action: str = "discrete", size: int = 64, **settings: Any) -> NavigationEnv:
    """Make a NavigationEnv of conf/env/<scene>.yaml; settings are keys of that file, as radius=0.2.

    action: discrete, or continuous (ContinuousEnv). size: of the square images, pixels a side (a scene's own size is
    no keyword). Raises ValueError for others.
    """
    from curionav_cli.world.continuous import ContinuousEnv
    from curionav_cli.world.env import NavigationEnv
    from curionav_cli.world.keywords import build_scene, check_size

    if action not in ("discrete", "continuous"):
        raise ValueError(f"action must be one of discrete, continuous, not {action!r}.")
    world, engine = build_scene(make, scene, settings)
    maker = ContinuousEnv if action == "continuous" else NavigationEnv
    return maker(world, render_mode, engine, reward, reset_mode, observation, check_size(size, engine))
