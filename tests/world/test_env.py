"""The gymnasium face of the world."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from curionav_cli.errors import SceneError
from curionav_cli.world import motion
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.motion import HEADINGS
from curionav_cli.world.registration import SCENES, make, register
from curionav_cli.world.render import Renderer
from curionav_cli.world.scene import Scene
from curionav_cli.world.scene_file import plain

FORWARD, LEFT, RIGHT = 0, 1, 2


@pytest.fixture
def env(small_room: Scene) -> NavigationEnv:
    return NavigationEnv(small_room)


def test_gymnasium_makes_it_and_finds_no_fault() -> None:
    register()
    register()
    assert set(SCENES) <= set(gymnasium.registry)
    made = gymnasium.make("curionav/SmallRoom-v0", radius=0.2, collision="slide", render_mode="rgb_array")
    check_env(made.unwrapped)
    assert made.unwrapped.scene.plan.radius == 0.2
    assert made.unwrapped.scene.collision == "slide"


def test_an_unknown_setting_is_named() -> None:
    with pytest.raises(SceneError, match=r"no key raduis\. Did you mean radius"):
        make("small_room", raduis=0.2)


def test_reset_starts_a_life_and_goes_home(env: NavigationEnv) -> None:
    _, info = env.reset(seed=5)
    assert info["episode"] == 0 and info["events"] == () and info["collided"] is False
    assert info["pose"].tolist() == list(env.scene.plan.start)
    env.step(LEFT)
    _, info = env.reset()
    assert info["episode"] == 1 and info["pose"].tolist() == list(env.scene.plan.start)
    assert env.reset(seed=5, options={"episode": 7})[1]["episode"] == 7
    assert env.reset()[1]["episode"] == 8


def test_turns_are_exact(env: NavigationEnv) -> None:
    before, info = env.reset(seed=0)
    for _ in range(HEADINGS):
        after, *_, now = env.step(LEFT)
    assert after["image"].tobytes() == before["image"].tobytes()
    assert now["pose"].tobytes() == info["pose"].tobytes()
    left = env.step(LEFT)[4]["pose"][2]
    assert left == pytest.approx((info["pose"][2] + np.pi / 18) % (2 * np.pi))


def test_a_cancelled_move_changes_nothing_and_says_so(env: NavigationEnv) -> None:
    env.reset(seed=0)
    for _ in range(40):
        observation, reward, terminated, truncated, info = env.step(FORWARD)
        if info["collided"]:
            break
    assert info["collided"] and (reward, terminated, truncated) == (0.0, False, False)
    again, *_, stuck = env.step(FORWARD)
    assert stuck["pose"].tobytes() == info["pose"].tobytes()
    assert again["image"].tobytes() == observation["image"].tobytes()


def test_an_observation_is_the_owner_s_to_change(env: NavigationEnv) -> None:
    first, _ = env.reset(seed=0)
    kept = first["image"].copy()
    first["image"][:] = 0
    env.step(LEFT)
    back, *_ = env.step(RIGHT)
    assert np.array_equal(back["image"], kept)


def test_an_unknown_action_is_refused(env: NavigationEnv) -> None:
    env.reset(seed=0)
    with pytest.raises(ValueError, match="none of 0 forward"):
        env.step(3)


def test_moved_things_are_seen_and_told(small) -> None:
    move = {"item": "box", "every": 1, "to": [[1.1, 0.5]]}
    small |= {"moves": [move], "light": {"drift": 0.5, "period": 4}}
    env = NavigationEnv(Scene.from_dict(small))
    first, info = env.reset(seed=1)
    second, later = env.reset()
    assert [event["what"] for event in info["events"]] == ["light"]
    assert [event["what"] for event in later["events"]] == ["move", "light"]
    assert later["events"][0]["to"] == [1.1, 0.5]
    assert second["depth"].min() < first["depth"].min()
    assert env.step(FORWARD)[4]["collided"] or env.step(FORWARD)[4]["collided"]
    alone, _ = NavigationEnv(Scene.from_dict(small)).reset(seed=1, options={"episode": 1})
    assert alone["image"].tobytes() == second["image"].tobytes()


def test_it_can_be_lived_in_without_drawing(small_room: Scene, monkeypatch) -> None:
    """Collision and coverage come from the plan alone."""
    def walk(step) -> list[tuple[float, float, bool]]:
        return [step(action) for action in np.random.default_rng(2).choice(3, 200, p=(0.6, 0.35, 0.05))]

    def seeing(action: int) -> tuple[float, float, bool]:
        info = env.step(int(action))[4]
        return float(info["pose"][0]), float(info["pose"][1]), info["collided"]

    env = NavigationEnv(small_room)
    env.reset(seed=0)
    seen = walk(seeing)

    def refuse(*_: object) -> None:
        raise AssertionError("something was drawn")
    for name in ("__init__", "render", "look"):
        monkeypatch.setattr(Renderer, name, refuse)
    scene = Scene.from_dict(*plain("small_room")).at(0, 0)[0]
    plan, (x, y), heading = scene.plan, scene.plan.start[:2], scene.start_heading
    visited = np.zeros_like(plan.visitable)

    def blind(action: int) -> tuple[float, float, bool]:
        nonlocal x, y, heading
        collided = False
        if action == FORWARD:
            x, y, collided = motion.forward(plan.visitable, plan.cell, x, y, heading)
        heading = (heading + (action == LEFT) - (action == RIGHT)) % HEADINGS
        visited[plan.cells(x, y)] = True
        return x, y, collided

    assert walk(blind) == seen and {collided for *_, collided in seen} == {False, True}
    assert visited.sum() > 10 and (visited <= plan.visitable).all()
