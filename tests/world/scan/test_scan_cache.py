"""Surveys of scans that are kept: found again, made anew where damaged, and apart for other files and settings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from meshmaking import box, room, write_ply, write_textured_obj

from curionav_cli.world.render.renderer import Renderer
from curionav_cli.world.scan import cache
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

pytest.importorskip("trimesh", reason="the extra scan is not installed")
pytest.importorskip("embreex", reason="the extra scan is not installed")


def scan(path: Path, **settings) -> Scene:
    return Scene.from_dict(*plain("scan", mesh=str(path), **{"cell": 0.1, **settings}))


def same(one: Scene, other: Scene) -> bool:
    """Whether two scans are the same cells, top view, lines and pictures."""
    seen = [Renderer(scene).render(np.full(4, 2.0), np.full(4, 1.6), np.arange(0, 36, 9)) for scene in (one, other)]
    return (np.array_equal(one.plan.visitable, other.plan.visitable) and one.view.about == other.view.about
            and np.array_equal(one.plan.picture, other.plan.picture)
            and all(np.array_equal(*pair) for pair in zip(*seen, strict=True)))


def unread(*_) -> None:
    raise AssertionError("the file was read again")


def test_a_second_scene_is_the_first_without_reading(tmp_path: Path, kept: Path, monkeypatch) -> None:
    path = write_textured_obj(tmp_path / "room.obj", room())
    first = scan(path)
    with monkeypatch.context() as patched:
        patched.setattr(cache, "survey", unread)
        assert same(first, scan(path)) and same(first, scan(path.rename(tmp_path / "other.obj"), haze=0.0, fov=79))
        for change in ({"radius": 0.2}, {"step": 0.05}, {"agent_height": 0.6}):
            with pytest.raises(AssertionError):
                scan(tmp_path / "other.obj", **change)
    (held,) = kept.iterdir()
    raw = held.read_bytes()
    for damaged in (raw[:-30], raw[:200] + bytes([raw[200] ^ 1]) + raw[201:], b""):
        held.write_bytes(damaged)
        assert same(first, scan(tmp_path / "other.obj")) and held.read_bytes() == raw


def test_a_changed_file_and_a_changed_picture_are_surveyed_again(tmp_path: Path, kept: Path) -> None:
    path = write_textured_obj(tmp_path / "room.obj", room())
    before = scan(path).plan
    (tmp_path / "room.png").write_bytes((tmp_path / "other.png").read_bytes())
    assert not np.array_equal(scan(path).plan.picture, before.picture)
    write_textured_obj(path, np.concatenate([room(), box((2, 1, 0), (3, 2, 1))]))
    assert scan(path).plan.visitable.sum() < before.visitable.sum() and len(list(kept.iterdir())) == 3


def test_the_newest_are_kept_and_an_unwritable_folder_is_told(tmp_path: Path, kept: Path, monkeypatch) -> None:
    monkeypatch.setattr(cache, "KEPT", 2)
    path = write_ply(tmp_path / "room.ply", room())
    for radius in (0.1, 0.11, 0.12):
        scan(path, radius=radius)
    assert len(list(kept.iterdir())) == 2
    monkeypatch.setenv("XDG_CACHE_HOME", str(path / "below"))
    assert any("kept for the next run it could not be" in line for line in scan(path).view.about)
