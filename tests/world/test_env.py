"""The gymnasium face of the world."""

from __future__ import annotations

from itertools import pairwise

import gymnasium
import numpy as np
import pytest
from gymnasium.error import Error, ResetNeeded
from gymnasium.utils.env_checker import check_env

from curionav_cli.constants import HEADINGS
from curionav_cli.errors import MapError, SceneError
from curionav_cli.world import motion
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.registration import SCENES, register
from curionav_cli.world.render.renderer import Renderer
from curionav_cli.world.reward import REWARDS, Reward
from curionav_cli.world.scene import dynamics
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain
from curionav_cli.world.scene.scene_format import Move

FORWARD, LEFT, RIGHT = 0, 1, 2


@pytest.fixture
def env(small_room: Scene) -> NavigationEnv:
    return NavigationEnv(small_room)


def test_gymnasium_makes_it_with_settings() -> None:
    register()
    register()
    assert set(SCENES) <= set(gymnasium.registry)
    made = gymnasium.make("curionav_cli:curionav/SmallRoom-v0", radius=0.2, collision="slide")
    assert made.unwrapped.scene.plan.radius == 0.2
    assert made.unwrapped.scene.collision == "slide"


@pytest.mark.parametrize("name", [name for name in SCENES if name != "curionav/Scan-v0"])  # scan/test_scan_worlds.py
def test_gymnasium_finds_no_fault(name: str, a_map: str) -> None:
    """Its warnings are errors here."""
    register()
    where = {"map": a_map} if name == "curionav/Map-v0" else {}
    made = gymnasium.make(name, render_mode="rgb_array", reward="coverage", **where)
    assert made.spec.max_episode_steps == 500
    check_env(made.unwrapped)


def test_an_episode_of_a_registered_world_ends_after_500_steps() -> None:
    register()
    made = gymnasium.make("curionav/SmallRoom-v0")
    made.reset(seed=0)
    ends = [made.step(LEFT)[2:4] for _ in range(500)]
    assert ends == [(False, False)] * 499 + [(False, True)]


@pytest.mark.parametrize(("settings", "fault", "said"), [
    ({"raduis": 0.2}, TypeError, r"got an unexpected keyword argument 'raduis'\. Did you mean radius\?"),
    ({"frameskip": 1}, TypeError, r"unexpected keyword argument 'frameskip'"),
    ({"radius": "wide"}, SceneError, "radius must be a number"),
    ({"engine": "gpu"}, SceneError, "engine must be one of numpy, numba"),
    ({"render_mode": "human"}, ValueError, "render_mode must be 'rgb_array' or None, not 'human'.*HumanRendering"),
    ({"reward": "coverge"}, ValueError, "reward must be one of none, coverage, count, not 'coverge'"),
    ({"reset_mode": "go"}, ValueError, "reset_mode must be one of restart, continue, not 'go'"),
])
@pytest.mark.parametrize("maker", [gymnasium.make, gymnasium.make_vec])
def test_a_wrong_keyword_is_named(maker, settings: dict, fault: type[Exception], said: str) -> None:
    register()
    with pytest.raises(fault, match=said):
        maker("curionav/SmallRoom-v0", **settings)


def test_a_map_is_asked_for_as_a_keyword() -> None:
    register()
    with pytest.raises(SceneError, match=r"needs a ROS map, map='PATH\.yaml'"):
        gymnasium.make("curionav/Map-v0")
    with pytest.raises(MapError, match=r"There is no map lost\.yaml\. map is the path"):
        gymnasium.make("curionav/Map-v0", map="lost.yaml")


def test_spaces_are_an_environment_s_own(small_room: Scene) -> None:
    """Sampling from those of one shifts the draws of no other."""
    draws = []
    for others in (0, 5):
        one, other = NavigationEnv(small_room), NavigationEnv(small_room)
        one.observation_space.seed(3)
        for _ in range(others):
            other.observation_space["depth"].sample()
        draws.append(one.observation_space["depth"].sample().tolist())
    assert draws[0] == draws[1]


def test_nothing_can_be_done_before_reset(env: NavigationEnv) -> None:
    for call in (lambda: env.step(LEFT), env.render, env.panorama, lambda: env.now):
        with pytest.raises(ResetNeeded, match=r"call reset\(\) first"):
            call()


def test_reset_starts_a_run_and_goes_back(env: NavigationEnv) -> None:
    _, info = env.reset(seed=5)
    assert info["episode_index"] == 0 and env.events == () and not info["collided"]
    assert info["pose"].tolist() == list(env.scene.plan.start)
    env.step(LEFT)
    _, info = env.reset()
    assert info["episode_index"] == 1 and info["pose"].tolist() == list(env.scene.plan.start)
    assert env.reset(seed=5, options={"episode": 7})[1]["episode_index"] == 7
    assert env.reset()[1]["episode_index"] == 8


def test_info_has_one_structure(small) -> None:
    """Also in a world that changes: names, shapes and types of every step are those of the reset."""
    env = NavigationEnv(lively(small))
    infos = [env.reset(seed=0)[1], env.step(LEFT)[4], env.step(FORWARD)[4], env.reset()[1]]
    shapes = [{key: (type(value), value.dtype, value.shape) for key, value in info.items()} for info in infos]
    assert shapes == shapes[:1] * 4
    assert {key: dtype.str for key, (_, dtype, _) in shapes[0].items()} == {
        "pose": "<f8", "collided": "|b1", "episode_index": "<i8"}


@pytest.mark.parametrize(("seed", "said"), [(-1, "from 0 to"), (2**64, "from 0 to"), (1.5, "an integer, not 1.5"),
                                            ("a", "an integer, not 'a'")])
def test_a_seed_that_is_none_is_refused(env: NavigationEnv, seed, said: str) -> None:
    with pytest.raises(Error, match=said):
        env.reset(seed=seed)


@pytest.mark.parametrize("episode", ["x", -1, 2.0, 2**63])
def test_an_episode_that_is_none_is_refused(env: NavigationEnv, episode) -> None:
    with pytest.raises(ValueError, match="must be an integer from 0 to 2\\*\\*63 - 1"):
        env.reset(options={"episode": episode})


def lively(small) -> Scene:
    move = {"item": "box", "every": 1, "to": [[1.1, 0.5], [0.4, 1.2]]}
    return Scene.from_dict(small | {"moves": [move], "light": {"drift": 0.5, "period": 4}})


def test_reset_mode_continue_ignores_later_seeds(small) -> None:
    """restart: always episode 0. continue: the first seed names the run; an episode that is named is taken in both."""
    scene = lively(small)
    seen = {}
    for mode in ("restart", "continue"):
        env = NavigationEnv(scene, reset_mode=mode)
        infos = [env.reset(seed=seed)[1] for seed in (4, 9, 9)]
        seen[mode] = [int(info["episode_index"]) for info in infos]
    assert seen == {"restart": [0, 0, 0], "continue": [0, 1, 2]}
    alone = NavigationEnv(scene)
    alone.reset(seed=4, options={"episode": 2})
    assert env.events == alone.events
    env.reset(seed=9, options={"episode": 2})
    alone.reset(seed=9, options={"episode": 2})
    assert env.events == alone.events and env.reset(seed=1)[1]["episode_index"] == 3


@pytest.mark.parametrize("episode", [dynamics.PERIODS - 1, 10**9, 2**63 - 1])
def test_no_episode_is_far_away(small, episode: int) -> None:
    env = NavigationEnv(lively(small))
    _, info = env.reset(seed=1, options={"episode": episode})
    assert info["episode_index"] == episode and {event["what"] for event in env.events} >= {"light"}


def test_a_thing_moves_in_every_period_and_near_episodes_are_what_they_were() -> None:
    item, move = dynamics.Item("box", (0.0, 0.0)), Move("box", 1, ((1.0, 0.0), (2.0, 0.0)))
    near = [int(dynamics.place(item, move, 0, episode, 7)[0]) for episode in range(8)]
    assert near == [0, 2, 0, 2, 1, 2, 0, 2]
    far = [dynamics.place(item, move, 0, dynamics.PERIODS + episode, 7) for episode in range(50)]
    assert all(one != other for one, other in pairwise(far)) and set(far) == {(0, 0), (1, 0), (2, 0)}


def test_reward_counts_the_cells_where_steps_end(small_room: Scene) -> None:
    walk = [int(action) for action in np.random.default_rng(2).choice(3, 150, p=(0.6, 0.35, 0.05))]
    earned = {}
    for name in REWARDS:
        env = NavigationEnv(small_room, reward=name)
        plan, visits = env.scene.plan, []
        for episode in range(2):
            visits = [plan.cells(*env.reset(seed=3 if episode == 0 else None)[1]["pose"][:2])]
            earned[name] = []
            for action in walk:
                _, reward, _, _, info = env.step(action)
                visits.append(plan.cells(*info["pose"][:2]))
                earned[name].append(reward)
    visits = [tuple(map(int, cell)) for cell in visits]
    assert earned["none"] == [0.0] * len(walk)
    assert sum(earned["coverage"]) == len(set(visits)) - 1 > 10
    assert earned["count"] == pytest.approx([visits[:t + 1].count(visits[t]) ** -0.5 for t in range(1, len(visits))])


def test_a_reward_for_coverage_is_for_visitable_cells_only(small_room: Scene) -> None:
    reward, (row, column) = Reward("coverage"), np.argwhere(~small_room.plan.visitable)[0]
    reward.reset(small_room.plan, *small_room.plan.start[:2])
    cell = small_room.plan.cell
    assert reward.step((column + 0.5) * cell, (row + 0.5) * cell) == 0.0


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


def test_moved_items_are_visible_and_in_events(small) -> None:
    move = {"item": "box", "every": 1, "to": [[1.1, 0.5]]}
    small |= {"moves": [move], "light": {"drift": 0.5, "period": 4}}
    env = NavigationEnv(Scene.from_dict(small))
    first, _ = env.reset(seed=1)
    assert [event["what"] for event in env.events] == ["light"]
    second, _ = env.reset()
    assert [event["what"] for event in env.events] == ["move", "light"]
    assert env.events[0]["to"] == [1.1, 0.5]
    assert second["depth"].min() < first["depth"].min()
    assert env.step(FORWARD)[4]["collided"] or env.step(FORWARD)[4]["collided"]
    alone, _ = NavigationEnv(Scene.from_dict(small)).reset(seed=1, options={"episode": 1})
    assert alone["image"].tobytes() == second["image"].tobytes()


def test_steps_need_no_rendering(small_room: Scene, monkeypatch) -> None:
    """Collision and coverage come from the plan alone."""
    def walk(step) -> list[tuple[float, float, bool]]:
        return [step(action) for action in np.random.default_rng(2).choice(3, 200, p=(0.6, 0.35, 0.05))]

    def seeing(action: int) -> tuple[float, float, bool]:
        info = env.step(int(action))[4]
        return float(info["pose"][0]), float(info["pose"][1]), bool(info["collided"])

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
