"""The finder of moved objects against the truth: the lab drawn twice, with an episode's moves and without them."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest

from curionav_cli.results.prediction import moved_objects
from curionav_cli.world.render.renderer import Renderer
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

SEED, EPISODES, EACH = 4, (2, 6, 12), 40


def blurred(images, rng):
    """The prediction of a world model that has seen the old layout only: soft, spotted and a little dark."""
    spots = rng.normal(0, 40, images.shape).astype(np.float32)
    soft = [cv2.GaussianBlur(image + spot, (0, 0), 1.5) for image, spot in zip(images.astype(np.float32), spots)]
    return (0.9 * np.stack(soft)).clip(0, 255).astype(np.uint8)


def facing(scene, places, rng):
    """EACH poses from 0.8 to 4 m in front of one of the places, and as many anywhere: x, y, yaw (n,)."""
    rows, columns = np.nonzero(scene.plan.visitable)
    which = rng.integers(0, len(rows), 4000)
    x, y = (columns[which] + 0.5) * scene.plan.cell, (rows[which] + 0.5) * scene.plan.cell
    east, north = np.array(places)[rng.integers(0, len(places), 4000)].T
    yaw = np.arctan2(north - y, east - x) + rng.uniform(-0.5, 0.5, 4000)
    apart = np.hypot(east - x, north - y)
    near = np.flatnonzero((apart > 0.8) & (apart < 4))[:EACH]
    poses = np.stack([x, y, yaw], 1)
    return np.concatenate([poses[near], poses[-EACH:]])


@pytest.fixture(scope="module")
def views():
    """For every episode: poses, places, the pictures with its moves and without."""
    scene = Scene.from_dict(*plain("large_lab"))
    renderer, rng, found = Renderer(scene), np.random.default_rng(0), []
    for episode in EPISODES:
        now, events = scene.at(episode, SEED)
        old = replace(now, boxes=scene.at(episode - 1, SEED)[0].boxes)
        places = moved_objects.places(events)
        poses = facing(now, places, rng)
        pictures = [renderer.showing(shown).look(*poses.T)[0] for shown in (now, old)]
        found.append((poses, places, *pictures))
    return moved_objects.Camera(scene.camera, math.tan(math.radians(scene.fov / 2))), found


def test_circles_are_where_an_object_moved_and_most_of_those_that_can_be_seen_have_one(views):
    camera, found = views
    rng = np.random.default_rng(1)
    differences = [moved_objects.difference(blurred(old, rng), new) for _, _, new, old in found]
    usual = moved_objects.usual(np.concatenate(differences))
    circled = right = changed = seen = 0
    for (poses, places, new, old), pictures in zip(found, differences):
        change = np.abs(new.astype(int) - old).max(-1)
        for pose, apart, true, plain_to_see in zip(poses, pictures, change > 12, change > 40):
            regions = moved_objects.regions(apart, usual, moved_objects.around(places, pose, camera, 64))
            circled += len(regions)
            right += sum((region & true).sum() > 0.5 * region.sum() for region in regions)
            if plain_to_see.sum() > 60:
                changed += 1
                seen += any((region & plain_to_see).any() for region in regions)
    assert changed > 60 and right / circled > 0.9 and seen / changed > 0.75, (circled, right, changed, seen)


def test_where_nothing_moved_blur_is_not_circled(views):
    camera, found = views
    rng = np.random.default_rng(2)
    differences = [moved_objects.difference(blurred(new, rng), new) for _, _, new, _ in found]
    usual = moved_objects.usual(np.concatenate(differences))
    pictures = [moved_objects.regions(apart, usual, moved_objects.around(places, pose, camera, 64))
                for (poses, places, _, _), several in zip(found, differences) for pose, apart in zip(poses, several)]
    assert sum(map(bool, pictures)) < 0.05 * len(pictures)


def test_a_change_of_the_light_is_no_difference():
    image = np.full((1, 64, 64, 3), 100, np.uint8)
    assert moved_objects.difference(image + 40, image).max() < 1e-6
    image[:, 20:40, 20:40] += 60
    apart = moved_objects.difference(image + 40, np.full_like(image, 100))
    assert apart[0, 30, 30] == pytest.approx(60 / 255, rel=0.01) and apart[0, 5, 5] < 0.01


def test_an_object_is_looked_for_where_the_camera_sees_it():
    camera = moved_objects.Camera(0.45, 1.0)
    ahead = moved_objects.around([(3.0, 1.0)], np.array([1.0, 1.0, 0.0]), camera, 64)
    rows, columns = np.nonzero(ahead)
    assert (columns.min() + columns.max() + 1) / 2 == 32 and rows.max() + 1 == 32 + round(16 * 0.45)
    left = moved_objects.around([(3.0, 2.0)], np.array([1.0, 1.0, 0.0]), camera, 64)
    assert np.nonzero(left)[1].mean() == pytest.approx(16, abs=1)
    assert not moved_objects.around([(3.0, 1.0)], np.array([1.0, 1.0, math.pi]), camera, 64).any()


def test_an_ellipse_holds_its_region():
    region = np.zeros((64, 64), bool)
    region[10:20, 30:50] = True
    around = moved_objects.ellipse(region)
    assert (around.x, around.y) == (40, 15) and around.width > 20 and around.height > 10
