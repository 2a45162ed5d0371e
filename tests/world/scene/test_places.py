"""The places of the paper: three apartments, counted again from scratch, and a lab that changes."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from curionav_cli.app import main
from curionav_cli.records import Episode
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.materials.materials import exists
from curionav_cli.world.registration import register
from curionav_cli.world.scene.furniture import BODIES, KINDS, faces
from curionav_cli.world.scene.reachability import fingerprint
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

PAPER = {"apartment_0": 23476, "apartment_1": 21328, "apartment_2": 18123}  # visitable cells of 5 cm
LAB, LAB_STANDING_STILL = 15543, 14405
MICRON = 1_000_000


@pytest.fixture(scope="module")
def places() -> dict[str, Scene]:
    return {name: Scene.from_dict(*plain(name)) for name in [*PAPER, "large_lab"]}


def recount(scene: Scene) -> np.ndarray:
    """The visitable cells in whole micrometres: squared distances to every solid box, then a flood."""
    cell, radius = round(scene.plan.cell * MICRON), round(scene.plan.radius * MICRON)
    width, depth = (round(side * MICRON) for side in scene.size)
    x = np.arange(cell // 2, width, cell)[None, :]
    y = np.arange(cell // 2, depth, cell)[:, None]
    clear = (x > radius) & (width - x > radius) & (y > radius) & (depth - y > radius)
    boxes = scene.boxes
    for low, high, decal in zip(boxes.low, boxes.high, boxes.decal, strict=True):
        if decal or low[2] >= scene.agent_height:
            continue
        x0, y0, x1, y1 = (round(float(side) * MICRON) for side in (*low[:2], *high[:2]))
        aside = np.where(x < x0, x0 - x, np.where(x > x1, x - x1, 0))
        along = np.where(y < y0, y0 - y, np.where(y > y1, y - y1, 0))
        clear &= aside**2 + along**2 > radius**2
    return flood(clear, int(scene.plan.start.y * MICRON) // cell, int(scene.plan.start.x * MICRON) // cell)


def flood(clear: np.ndarray, row: int, column: int) -> np.ndarray:
    reached = np.zeros_like(clear)
    todo = deque([(row, column)])
    while todo:
        row, column = todo.popleft()
        if clear[row, column] and not reached[row, column]:
            reached[row, column] = True
            todo += [(row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)]
    return reached


@pytest.mark.parametrize("name", PAPER)
def test_an_apartment_has_the_cells_of_the_paper(places: dict[str, Scene], name: str) -> None:
    scene = places[name]
    plan = scene.plan
    assert (plan.cell, plan.radius, scene.camera, scene.fov, scene.agent_height) == (0.05, 0.1, 0.88, 79, 1.5)
    counted = recount(scene)
    assert counted.sum() == plan.visitable.sum() == PAPER[name]
    assert np.array_equal(counted, plan.visitable)
    assert round(PAPER[name] * 0.05**2, 2) == {"apartment_0": 58.69, "apartment_1": 53.32, "apartment_2": 45.31}[name]
    assert plain(name)[0]["visitable_sha256"] == fingerprint(counted)
    assert not scene.changing and (plan.visitable <= plan.floor).all()


def test_the_lab_has_its_cells(places: dict[str, Scene]) -> None:
    scene = places["large_lab"]
    assert scene.size == (10.0, 23.0) and scene.plan.cell == 0.1
    assert scene.plan.floor.all() and scene.plan.floor.sum() == 23000
    assert scene.plan.visitable.sum() == LAB
    still = Scene.from_dict(*plain("large_lab", changes=False))
    assert not still.changing and still.at(9, 3) == (still, ())
    counted = recount(still)
    assert counted.sum() == still.plan.visitable.sum() == LAB_STANDING_STILL
    assert np.array_equal(counted, still.plan.visitable)
    assert np.array_equal(still.plan.floor, scene.plan.floor)


def test_the_lab_is_furnished_as_its_file_says() -> None:
    raw, _ = plain("large_lab")
    kinds = [piece["kind"] for piece in raw["furniture"]]
    assert sum(str(piece.get("name", "")).startswith("table_") for piece in raw["furniture"]) == 12
    assert (kinds.count("seat"), kinds.count("box")) == (10, 14)
    rows = [row for row in raw["repeat"] if row["of"]["kind"] == "shelf"]
    assert {row["of"].get("material", KINDS["shelf"].material) for row in rows} == {"goods"}, "they look alike"
    assert sum(row["times"] for row in raw["repeat"] if row["of"]["kind"] == "pillar") == 7
    assert {move["item"].split("_")[0] for move in raw["moves"]} == {"chair", "box"}


def all_places(scene: Scene) -> dict[str, list[tuple[np.ndarray, np.ndarray]]]:
    """The boxes of each movable thing at each of its places."""
    found: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for number, (item, move) in enumerate(zip(scene.items, scene.moves, strict=True)):
        own = scene.boxes.item == number
        for place in (item.first, *move.to):
            shift = np.array([place[0] - item.first[0], place[1] - item.first[1], 0.0])
            found.setdefault(item.name, []).append((scene.boxes.low[own] + shift, scene.boxes.high[own] + shift))
    return found


def overlap(one: tuple[np.ndarray, np.ndarray], other: tuple[np.ndarray, np.ndarray]) -> bool:
    apart = (one[0][:, None] >= other[1][None] - 1e-9) | (one[1][:, None] <= other[0][None] + 1e-9)
    return not apart.any(-1).all()


def test_nothing_is_moved_into_anything(places: dict[str, Scene]) -> None:
    scene = places["large_lab"]
    fixed = (scene.boxes.item < 0) & ~scene.boxes.decal
    walls = scene.boxes.low[fixed], scene.boxes.high[fixed]
    spots = all_places(scene)
    for name, places_of_one in spots.items():
        assert not any(overlap(spot, walls) for spot in places_of_one), name
        others = [spot for other, theirs in spots.items() if other != name for spot in theirs]
        assert not any(overlap(spot, other) for spot in places_of_one for other in others), name


def test_moves_never_close_the_lab(places: dict[str, Scene]) -> None:
    scene = places["large_lab"]
    shares = [scene.at(episode, seed)[0].plan.visitable.sum() / LAB for seed in range(3) for episode in range(12)]
    assert min(shares) > 0.9 and max(shares) < 1.0 and len(set(shares)) > 10


def test_a_life_in_the_lab_changes_with_its_seed_and_is_recorded(places: dict[str, Scene], tmp_path: Path) -> None:
    env = NavigationEnv(places["large_lab"])
    seen: dict[int, Any] = {}
    for seed in (0, 1, 0):
        env.reset(seed=seed)
        observation, _ = env.reset(options={"episode": 6})
        moves = [event for event in env.events if event["what"] == "move"]
        assert moves and all(event["from"] != event["to"] for event in moves)
        state = (observation["image"].tobytes(), env.events)
        assert seen.setdefault(seed, state) == state
    assert seen[0] != seen[1]
    empty: dict[str, Any] = {"image": np.zeros((1, 64, 64, 3), np.uint8), "action": np.zeros(0, np.int64),
                             "pose": np.zeros((1, 3)), "collided": np.zeros(0, bool)}
    Episode(**empty, events=env.events).save(tmp_path / "episode.npz")
    assert Episode.load(tmp_path / "episode.npz").events == env.events


def test_every_move_begins_where_the_last_one_ended(places: dict[str, Scene]) -> None:
    scene = places["large_lab"]
    at = {item.name: list(item.first) for item in scene.items}
    for episode in range(1, 14):
        for event in scene.at(episode, 5)[1]:
            if event["what"] == "move":
                assert at[event["item"]] == event["from"]
                at[event["item"]] = event["to"]


def test_the_light_of_the_lab_drifts(places: dict[str, Scene]) -> None:
    levels = [places["large_lab"].at(episode, 2)[0].brightness for episode in range(32)]
    assert min(levels) < 0.65 and max(levels) > 0.93
    assert np.abs(np.diff(levels)).mean() < 0.15, "it drifts, it does not flash"


@pytest.mark.parametrize("name", [*PAPER, "large_lab", "small_room"])
def test_furniture_stands_inside_and_not_in_walls(name: str) -> None:
    scene = Scene.from_dict(*plain(name))
    width, depth = scene.size
    count = len(Scene.from_dict({**plain(name)[0], "furniture": [], "repeat": [], "posters": [], "moves": [],
                                 "visitable": None, "start": None, "dock": None, "tune": {}}).boxes)
    walls = scene.boxes.low[:count], scene.boxes.high[:count]
    pieces = (scene.boxes.low[count:], scene.boxes.high[count:], scene.boxes.decal[count:])
    for low, high, decal in zip(*pieces, strict=True):
        assert (low > -1e-6).all() and high[0] < width + 1e-6 and high[1] < depth + 1e-6
        assert high[2] <= scene.height + 1e-6
        if not decal:
            inside = np.minimum(high[:2], walls[1][:, :2]) - np.maximum(low[:2], walls[0][:, :2])
            crossing = (inside > 0.011).all(axis=1) & (walls[0][:, 2] < high[2] - 0.01) & (walls[1][:, 2] > low[2])
            assert not crossing.any(), (name, low, high)


@pytest.mark.parametrize("name", PAPER)
def test_a_home_has_many_rooms_materials_and_heights(places: dict[str, Scene], name: str) -> None:
    raw, _ = plain(name)
    rooms = raw["rooms"]
    assert len(rooms) >= 8
    assert len({room["wall"] for room in rooms}) >= 6 and len({room["floor"] for room in rooms}) >= 5
    for room in rooms:
        x0, y0, x1, y1 = (round(side / 0.05) for side in room["rect"])
        assert places[name].plan.visitable[y0:y1, x0:x1].any(), f"no robot can enter {room['name']}"
    boxes = places[name].boxes
    assert len(set(np.round(boxes.high[~boxes.decal, 2], 2))) > 15
    assert len(raw["posters"]) >= 15 and len(boxes) < 220


def test_no_two_places_are_alike(places: dict[str, Scene]) -> None:
    names = [set(map(str, plain(name)[0]["furniture"])) for name in PAPER]
    assert all(len(one & other) < 5 for index, one in enumerate(names) for other in names[:index])


@pytest.mark.parametrize(("name", "cells"), [("Apartment0", 23476), ("Apartment1", 21328), ("Apartment2", 18123),
                                             ("LargeLab", LAB)])
def test_gymnasium_knows_them(name: str, cells: int) -> None:
    register()
    env = gymnasium.make(f"curionav/{name}-v0")
    assert env.unwrapped.scene.plan.visitable.sum() == cells
    env.reset(seed=0)


@pytest.mark.parametrize("pattern", BODIES)
def test_a_front_is_at_the_front_only(pattern: str) -> None:
    for turn, face in ((0, 2), (90, 1), (180, 3), (270, 0)):  # south, east, north, west
        sides, top = faces(pattern, turn)
        assert sides[face] == pattern and sides.count(pattern) in (1, 2) and top != pattern and exists(top)
    assert faces(f"{pattern}_red", 0)[1] == ("wood_red" if BODIES[pattern].startswith("wood") else BODIES[pattern])


BEHIND = {"west": (1, 0), "east": (-1, 0), "south": (0, 1), "north": (0, -1)}


@pytest.mark.parametrize("name", [*PAPER, "large_lab", "small_room"])
def test_every_picture_hangs_on_a_wall(name: str) -> None:
    """Four centimetres behind each corner of a poster there is wall, and before its middle there is air."""
    scene = Scene.from_dict(*plain(name))
    boxes = scene.boxes
    for poster in plain(name)[0]["posters"]:
        behind = np.array(BEHIND[poster["face"]])
        along = np.abs(behind[::-1]) * (0.5 * poster["width"] - 0.02)
        heights = (poster["z"] + 0.02, poster["z"] + poster["height"] - 0.02)
        corners = [(*(np.array(poster["at"]) + 0.04 * behind + side * along), z)
                   for side in (-1, 1) for z in heights]
        for corner in corners:
            around = (boxes.low <= corner) & (boxes.high >= corner)
            assert (around.all(axis=1) & ~boxes.decal).any(), f"{poster} hangs in the air at {corner}"
        before = (*(np.array(poster["at"]) - 0.03 * behind), sum(heights) / 2)
        hidden = (((boxes.low < before) & (boxes.high > before)).all(axis=1) & ~boxes.decal).any()
        assert not hidden, f"{poster} is inside something"


def test_the_moves_of_a_life_are_in_its_episode_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stop:
        main(["explore", "env=large_lab", "agent=random", "seed=3", "loop.episodes=3", "loop.steps=4",
              "loop.iterations=0", "hydra.run.dir=out"])
    assert not stop.value.code
    scene = Scene.from_dict(*plain("large_lab"))
    for number in range(3):
        saved = Episode.load(tmp_path / "out" / "episodes" / f"{number:06d}.npz")
        assert saved.events == scene.at(number, 3)[1]
        assert any(event["what"] == "move" for event in saved.events) == (number > 0)
