"""The camera against an independent float64 reference, and the promises it makes."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from curionav_cli.constants import HEADINGS, IMAGE_SIDE
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.motion import COS, SIN, YAW
from curionav_cli.world.render.renderer import FAR, Renderer
from curionav_cli.world.scene.boxes import Boxes
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain


def rays(scene: Scene, heading: int, side: int = IMAGE_SIDE) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """dx, dy, dz a metre of depth for each pixel: (side, side) each."""
    tangent = np.tan(np.radians(scene.fov) / 2)
    offset = ((np.arange(side) + 0.5) / (side / 2) - 1) * tangent
    right, rise = np.meshgrid(offset, -offset)
    return COS[heading] + right * SIN[heading], SIN[heading] - right * COS[heading], rise


def reference(scene: Scene, x: float, y: float, heading: int, side: int = IMAGE_SIDE) -> np.ndarray:
    """(side, side) float64 depth: each ray against each box, three slabs at once, and floor and ceiling."""
    direction = np.stack(rays(scene, heading, side), axis=-1)[..., None, :]
    eye = np.array([x, y, scene.camera])
    with np.errstate(divide="ignore"):
        one, other = (scene.boxes.low - eye) / direction, (scene.boxes.high - eye) / direction
        rise = direction[..., 2]
        plane = np.where(rise < 0, -scene.camera, scene.height - scene.camera) / rise
    enter, leave = np.minimum(one, other).max(axis=-1), np.maximum(one, other).min(axis=-1)
    enter = np.maximum(enter, 0.0)
    hit = np.where(enter < leave, enter, np.inf).min(axis=-1)
    return np.minimum(np.minimum(hit, plane[..., 0]), FAR)


@pytest.mark.parametrize(("side", "count"), [(IMAGE_SIDE, 60), (150, 9)])
def test_depth_is_that_of_the_float64_reference(small_room: Scene, draw_spots, side: int, count: int) -> None:
    x, y, heading = draw_spots(small_room, count, 0)
    _, depth = Renderer(small_room, side=side).render(x, y, heading)
    wrong = []
    for index in range(len(x)):
        error = np.abs(depth[index] - reference(small_room, x[index], y[index], int(heading[index]), side))
        wrong.append(error > 3e-4)
    assert np.mean(wrong) < 2e-5  # the odd silhouette pixel that float32 gives to its neighbour


def test_depth_under_a_table_and_through_a_door(small, draw_spots) -> None:
    scene = Scene.from_dict(small)
    x, y, heading = draw_spots(scene, 60, 1)
    x[0], y[0] = 1.2, 1.4  # under the table's top
    _, depth = Renderer(scene).render(x, y, heading)
    exact = np.stack([reference(scene, *pose) for pose in zip(x, y, heading, strict=True)])
    assert (np.abs(depth - exact) > 3e-4).mean() < 2e-5


def test_depth_is_that_of_a_march_of_millimetres(small) -> None:
    scene = Scene.from_dict(small)
    _, depth = Renderer(scene).render(0.5, 0.5, 3)
    dx, dy, dz = (part[8::16, 8::16].ravel() for part in rays(scene, 3))
    at = np.arange(0.0, 5.0, 0.001)[:, None]
    point = np.stack([0.5 + at * dx, 0.5 + at * dy, scene.camera + at * dz], axis=-1)
    hit = (point[..., 2] <= 0) | (point[..., 2] >= scene.height)
    for low, high in zip(scene.boxes.low, scene.boxes.high, strict=True):
        hit |= ((point >= low) & (point <= high)).all(axis=-1)
    assert np.abs(at[hit.argmax(axis=0), 0] - depth[0, 8::16, 8::16].ravel()).max() < 0.0021


@pytest.mark.parametrize("count", [1, 5, 16, 33])
def test_any_batch_size_gives_the_same_bytes(small_room: Scene, draw_spots, count: int) -> None:
    renderer = Renderer(small_room)
    x, y, heading = draw_spots(small_room, 33, 2)
    rgb, depth = renderer.render(x, y, heading)
    for first in range(0, 33, count):
        part = slice(first, first + count)
        some, deep = renderer.render(x[part], y[part], heading[part])
        assert some.tobytes() == rgb[part].tobytes() and deep.tobytes() == depth[part].tobytes()


def test_choosing_boxes_changes_no_picture(small_room: Scene, draw_spots, monkeypatch) -> None:
    x, y, heading = draw_spots(small_room, 40, 3)
    everything = Renderer(small_room).render(x, y, heading)
    monkeypatch.setattr("curionav_cli.world.render.culling.FEW", 0)
    chosen = Renderer(small_room).render(x, y, heading)
    assert chosen[0].tobytes() == everything[0].tobytes() and chosen[1].tobytes() == everything[1].tobytes()


def test_a_yaw_between_headings_is_drawn_too(small_room: Scene) -> None:
    renderer = Renderer(small_room)
    rgb, depth = renderer.render(0.7, 1.0, 5)
    looked, deep = renderer.look(0.7, 1.0, YAW[5])
    assert (looked != rgb).mean() < 0.01 and np.abs(deep - depth).max() < 1e-4
    between, _ = renderer.look(0.7, 1.0, YAW[5] + 0.08)
    assert (between != rgb).mean() > 0.2


def test_pictures_are_rich_and_places_look_different(small_room: Scene, draw_spots) -> None:
    x, y, heading = draw_spots(small_room, 24, 4)
    rgb, depth = Renderer(small_room).render(x, y, heading)
    assert rgb.dtype == np.uint8 and depth.dtype == np.float32
    colours = [len(np.unique(image.reshape(-1, 3), axis=0)) for image in rgb]
    assert min(colours) > 40 and np.median(colours) > 300
    differences = [np.abs(a.astype(int) - b).mean() for a, b in pairwise(rgb)]
    assert min(differences) > 8


def test_light_scales_the_picture(small_room: Scene, draw_spots) -> None:
    x, y, heading = draw_spots(small_room, 8, 5)
    renderer = Renderer(small_room)
    day, depth = renderer.render(x, y, heading)
    dusk, same = renderer.showing(replace(small_room, brightness=0.6)).render(x, y, heading)
    assert same.tobytes() == depth.tobytes()
    assert np.abs(dusk - 0.6 * day).max() < 2.5


def without(boxes: Boxes, gone: int) -> Boxes:
    keep = np.arange(len(boxes)) != gone
    return replace(boxes, **{
        key: getattr(boxes, key)[keep] for key in ("low", "high", "sides", "top", "fit", "item", "decal")})


def test_taking_a_box_away_never_brings_anything_nearer(small_room: Scene, draw_spots) -> None:
    x, y, heading = draw_spots(small_room, 12, 6)
    _, depth = Renderer(small_room).render(x, y, heading)
    for gone in range(len(small_room.boxes)):
        less = replace(small_room, boxes=without(small_room.boxes, gone))
        _, farther = Renderer(less).render(x, y, heading)
        assert (farther >= depth - 3e-4).all()


def test_a_mirrored_scene_gives_a_mirrored_picture(small) -> None:
    scene = Scene.from_dict(small)
    mirror = {
        **small, "start": [2.5, 0.5, 0], "posters": [{"at": [3.0, 0.8], "face": "west"}],
        "walls": [{"line": [1.0, 0.0, 1.0, 2.0], "gaps": [[0.6, 0.9]]}],
        "furniture": [{**piece, "x": 3.0 - piece["x"]} for piece in small["furniture"]]}
    x, y, heading = np.array([0.55, 1.0, 0.4]), np.array([0.5, 0.6, 0.9]), np.array([2, 9, 34])
    _, depth = Renderer(scene).render(x, y, heading)
    _, mirrored = Renderer(Scene.from_dict(mirror)).render(3.0 - x, y, (18 - heading) % 36)
    assert (np.abs(mirrored[:, :, ::-1] - depth) > 3e-4).mean() < 1e-3


def test_boxes_farther_than_the_haze_never_change_a_picture(draw_spots, monkeypatch) -> None:
    monkeypatch.setattr("curionav_cli.world.render.culling.MANY", 0)
    monkeypatch.setattr("curionav_cli.world.render.culling.NEAR_REACH", 4.0)
    scene = Scene.from_dict(*plain("large_lab"))
    poses = draw_spots(scene, 150, 5)
    monkeypatch.setattr("curionav_cli.world.render.culling.FEW", 0)
    chosen = Renderer(scene).render(*poses)
    monkeypatch.setattr("curionav_cli.world.render.culling.FEW", 10**9)
    every = Renderer(scene).render(*poses)
    assert chosen[0].tobytes() == every[0].tobytes() and chosen[1].tobytes() == every[1].tobytes()


def test_a_turn_of_360_degrees_gives_the_same_bytes(small_room: Scene) -> None:
    for turn in (1, 2):
        env = NavigationEnv(small_room)
        first, info = env.reset(seed=0)
        seen = {first["image"].tobytes()}
        for _ in range(HEADINGS):
            last, *_, now = env.step(turn)
            seen.add(last["image"].tobytes())
        assert len(seen) == HEADINGS, "each of the turns shows something else"
        assert all(last[key].tobytes() == first[key].tobytes() for key in first)
        assert now["pose"].tobytes() == info["pose"].tobytes()


DIGEST = """
import hashlib, numpy as np
from curionav_cli.world.registration import make
env = make("small_room")
digest = hashlib.sha256()
observation, info = env.reset(seed=3)
for action in np.random.default_rng(0).integers(0, 3, 120):
    digest.update(observation["image"].tobytes() + observation["depth"].tobytes() + info["pose"].tobytes())
    observation, _, _, _, info = env.step(int(action))
print(digest.hexdigest())
"""


def test_same_bytes_in_another_process_with_more_threads() -> None:
    seen = {
        subprocess.run([sys.executable, "-c", DIGEST], env={**os.environ, "OMP_NUM_THREADS": threads},
                       capture_output=True, text=True, check=True).stdout
        for threads in ("1", "2")}
    assert len(seen) == 1 and len(seen.pop().strip()) == 64


def test_the_wedge_keeps_every_visible_box(small_room: Scene, monkeypatch) -> None:
    monkeypatch.setattr("curionav_cli.world.render.culling.FEW", 0)
    camera = Renderer(small_room).camera
    candidates = camera.culling(np.array([1.0]), np.array([2.0]), COS[[9]], SIN[[9]])
    top = candidates.bounds[1, 1, 0]  # the northern edge of each box that is kept
    assert (top > 2.0).all() and 0 < len(top) < len(small_room.boxes)
    assert candidates.boxes[0, candidates.walls - 1] == len(small_room.boxes)
