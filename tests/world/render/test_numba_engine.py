"""The numba engine beside the numpy one. Skips where numba is absent, but for the message about that."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

from curionav_cli.errors import SceneError
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.registration import make
from curionav_cli.world.render.renderer import Renderer
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain
from curionav_cli.world.vector_env import NavigationVectorEnv


@pytest.fixture
def needs_numba() -> None:
    pytest.importorskip("numba", reason="the extra curionav[fast] is not installed")


def test_without_numba_it_says_what_to_install(small_room: Scene, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.delitem(sys.modules, "curionav_cli.world.render.numba_engine", raising=False)
    with pytest.raises(SceneError, match=r"pip install 'curionav\[fast\]'"):
        Renderer(small_room, "numba")


def test_an_unknown_engine_is_refused() -> None:
    with pytest.raises(SceneError, match="one of numpy, numba, not 'gl'"):
        make("small_room", engine="gl")


def test_the_plain_choice_is_numpy(small_room: Scene) -> None:
    assert make("small_room").engine == NavigationEnv(small_room).engine == "numpy"


@pytest.mark.parametrize("name", ["small_room", "apartment_0", "apartment_2", "large_lab"])
def test_engines_agree(name: str, draw_spots, needs_numba) -> None:
    """Ids cannot be read off a picture, so colours stand for them: equal means the same surface and texel."""
    scene = Scene.from_dict(*plain(name))
    poses = draw_spots(scene, 60, 0)
    rgb, depth = Renderer(scene).render(*poses)
    fast, metres = Renderer(scene, "numba").render(*poses)
    assert (rgb == fast).all(axis=-1).mean() > 0.9999
    assert (np.abs(depth - metres) > 1e-3).mean() < 1e-4
    assert np.median(np.abs(depth - metres)) == 0.0


def test_engines_agree_under_a_table_in_the_dusk(small, draw_spots, needs_numba) -> None:
    scene = replace(Scene.from_dict(small), brightness=0.45)
    x, y, heading = draw_spots(scene, 40, 1)
    x[0], y[0] = 1.2, 1.4
    ours, theirs = Renderer(scene), Renderer(scene, "numba")
    assert (ours.render(x, y, heading)[0] == theirs.render(x, y, heading)[0]).all(axis=-1).mean() > 0.9999
    yaw = np.linspace(-3.0, 3.0, 40)
    assert (ours.look(x, y, yaw)[0] == theirs.look(x, y, yaw)[0]).all(axis=-1).mean() > 0.9999


def test_engines_agree_on_a_map(tmp_path, draw_spots, needs_numba) -> None:
    pixels = np.full((50, 70), 254, np.uint8)
    pixels[[0, -1]] = pixels[:40, 30] = 0
    pixels[20:24, 50:55] = 205
    (tmp_path / "map.pgm").write_bytes(b"P5\n70 50\n255\n" + pixels.tobytes())
    (tmp_path / "map.yaml").write_text("image: map.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n"
                                       "occupied_thresh: 0.65\nfree_thresh: 0.196\nnegate: 0\n")
    scene = Scene.from_dict(*plain("map", map=str(tmp_path / "map.yaml")))
    assert not scene.plan.floor.all() and len(scene.boxes) > 5
    poses = draw_spots(scene, 40, 3)
    (rgb, depth), (fast, metres) = Renderer(scene).render(*poses), Renderer(scene, "numba").render(*poses)
    assert (rgb == fast).all(axis=-1).mean() > 0.9999
    assert (np.abs(depth - metres) > 1e-3).mean() < 1e-4


@pytest.mark.parametrize("few", [0, 10**6])
def test_any_batch_and_any_choice_of_boxes_gives_the_same_bytes(few: int, small_room: Scene, draw_spots, monkeypatch,
                                                                needs_numba) -> None:
    x, y, heading = draw_spots(small_room, 17, 2)
    whole = Renderer(small_room, "numba").render(x, y, heading)
    monkeypatch.setattr("curionav_cli.world.render.culling.FEW", few)
    renderer = Renderer(small_room, "numba")
    single = [renderer.render(*pose) for pose in zip(x, y, heading, strict=True)]
    assert np.concatenate([rgb for rgb, _ in single]).tobytes() == whole[0].tobytes()
    assert np.concatenate([depth for _, depth in single]).tobytes() == whole[1].tobytes()


def test_a_vector_of_worlds_is_single_worlds(small_room: Scene, needs_numba) -> None:
    many, one = NavigationVectorEnv(small_room, 3, engine="numba"), make("small_room", engine="numba")
    assert many.engine == one.engine == "numba"
    many.reset(seed=5)
    one.reset(seed=6)
    for actions in np.random.default_rng(0).integers(0, 3, (30, 3)):
        seen, *_, info = many.step(actions)
        alone, *_, single = one.step(int(actions[1]))
        assert seen["image"][1].tobytes() == alone["image"].tobytes()
        assert seen["depth"][1].tobytes() == alone["depth"].tobytes() and (info["pose"][1] == single["pose"]).all()
