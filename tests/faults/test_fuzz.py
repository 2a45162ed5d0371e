"""Readers under fuzz: whatever a file holds, our own error or a value comes of it, and no more memory than it tells.

Quick: a few hundred examples, always the same. Slow: as long as CURIONAV_FUZZ_SECONDS says, an hour without it.
"""

from __future__ import annotations

import json
import os
import tempfile
import time
import tracemalloc
import warnings
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from safetensors.numpy import save

from curionav_cli.agents.weights import read_tensors
from curionav_cli.config.settings import read_settings
from curionav_cli.errors import RunFolderError, UserError
from curionav_cli.records import Episode, FloorPlan, Pose, read_json, sealed
from curionav_cli.storage import checkpoint
from curionav_cli.world.rosmap import read_map
from curionav_cli.world.scene import Scene
from curionav_cli.world.scene_file import plain

hypothesis = pytest.importorskip("hypothesis", reason="needs the extra dev")
from hypothesis import HealthCheck, given, settings  # noqa: E402
from hypothesis import strategies as st  # noqa: E402

QUICK, SLACK = 60, 4 * 2**20  # examples; bytes for what a reader needs whatever the file
SECONDS = float(os.environ.get("CURIONAV_FUZZ_SECONDS", "3600"))
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8)
    | st.sampled_from([10**9, 1e308, -1, 0, "box", "[" * 50, float("nan")]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner, max_size=3), max_leaves=8)
HARM = st.lists(st.tuples(st.floats(0, 1), st.binary(max_size=6), st.integers(0, 40)), min_size=1, max_size=4)


def harmed(body: bytes, places: list[tuple[float, bytes, int]]) -> bytes:
    """At some places some bytes are left out and others put in."""
    for place, new, gone in places:
        at = int(place * len(body))
        body = body[:at] + new + body[at + gone:]
    return body


def an_episode(folder: Path) -> tuple[Path, Callable[[Path], Any]]:
    rng = np.random.default_rng(0)
    episode = Episode(rng.integers(0, 255, (4, 64, 64, 3), np.uint8), np.array([0, 1, 2]), np.zeros((4, 3)),
                      np.zeros(3, bool), ({"what": "light", "brightness": 1.0},))
    episode.save(folder / "episode.npz")
    return folder / "episode.npz", Episode.load


def a_plan(folder: Path) -> tuple[Path, Callable[[Path], Any]]:
    mask = np.ones((9, 7), bool)
    FloorPlan(mask, mask, ~mask, 0.1, Pose(0.1, 0.1, 0.0), 0.18, "room").save(folder / "plan.npz")
    return folder / "plan.npz", FloorPlan.load


def weights(folder: Path) -> tuple[Path, Callable[[Path], Any]]:
    (folder / "weights.safetensors").write_bytes(save({"a/b": np.arange(12, dtype=np.float32).reshape(3, 4)}))
    return folder / "weights.safetensors", read_tensors


def a_status(folder: Path) -> tuple[Path, Callable[[Path], Any]]:
    (folder / "status.json").write_text(sealed({"state": "done", "episode": 3, "coverage": 0.25}))
    return folder / "status.json", read_json


def a_marker(folder: Path) -> tuple[Path, Callable[[Path], Any]]:
    checkpoint.save(folder, 1, {"seed": 0}, lambda inner: (inner / "rng.json").write_text("{}"))
    return folder / "000001" / "checksums.json", lambda path: checkpoint.newest(folder, {"seed": 0})


def a_config(folder: Path) -> tuple[Path, Callable[[Path], Any]]:
    (folder / "config.yaml").write_text(
        "seed: 0\ndevice: cpu\nagent: {name: random}\nenv: {name: room, size: [2, 3], radius: 0.1, camera: 0.4}\n")
    return folder / "config.yaml", read_settings


def a_map(folder: Path) -> tuple[Path, Callable[[Path], Any]]:
    (folder / "map.yaml").write_text(
        "image: map.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\n"
        "free_thresh: 0.196\n")
    (folder / "map.pgm").write_bytes(b"P5 # a map\n9 7\n255\n" + bytes(range(63)))
    return folder / "map.yaml", read_map


def a_pgm(folder: Path) -> tuple[Path, Callable[[Path], Any]]:
    where, read = a_map(folder)
    return where.with_name("map.pgm"), lambda path: read(where)


def a_png(folder: Path) -> tuple[Path, Callable[[Path], Any]]:
    where, read = a_map(folder)
    where.write_text(where.read_text().replace("pgm", "png"))
    cv2.imwrite(str(folder / "map.png"), np.arange(63, dtype=np.uint8).reshape(7, 9))
    return folder / "map.png", lambda path: read(where)


def a_scene(folder: Path) -> tuple[Path, Callable[[Path], Any]]:
    raw = {key: value for key, value in plain("small_room")[0].items() if not key.startswith("visitable")}
    (folder / "scene.yaml").write_text(yaml.safe_dump(raw))

    def read(path: Path) -> Scene:
        raw = yaml.safe_load(path.read_text())
        return Scene.from_dict(raw if isinstance(raw, dict) else {}, "scene.yaml")
    return folder / "scene.yaml", read


READERS = (an_episode, a_plan, weights, a_status, a_marker, a_config, a_map, a_pgm, a_png, a_scene)


def honest(path: Path) -> int:
    """Bytes that the file says it holds."""
    try:
        with zipfile.ZipFile(path) as archive:
            return sum(info.file_size for info in archive.infolist() if info.file_size < 2**40)
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        return path.stat().st_size


def endure(read: Callable[[Path], Any], path: Path) -> None:
    """Reads it, or is refused by name; and takes little more memory than twice what the file holds."""
    tracemalloc.start()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            read(path)
    except UserError as error:
        assert str(error)
    except (yaml.YAMLError, UnicodeDecodeError):
        assert path.name == "scene.yaml"  # which Hydra opens, and answers for
    finally:
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    assert most <= 2 * honest(path) + SLACK, f"{most} bytes for a file of {honest(path)}"


def tried(make: Callable[[Path], tuple[Path, Callable[[Path], Any]]], examples: int, fixed: bool) -> None:
    """Examples of one reader: bytes of a sound file changed at some places."""
    with tempfile.TemporaryDirectory() as name:
        path, read = make(Path(name))
        whole = path.read_bytes()
        endure(read, path)

        @settings(max_examples=examples, deadline=None, derandomize=fixed, database=None,
                  suppress_health_check=list(HealthCheck))
        @given(HARM)
        def one(places: list[tuple[float, bytes, int]]) -> None:
            path.write_bytes(harmed(whole, places))
            endure(read, path)
        one()


@pytest.mark.parametrize("make", READERS, ids=lambda make: make.__name__)
def test_a_changed_file_is_read_or_refused(make: Callable[[Path], tuple[Path, Callable[[Path], Any]]]) -> None:
    tried(make, QUICK if make is not a_scene else 10, fixed=True)


def changed_scenes(examples: int, fixed: bool) -> None:
    """Scenes in which a value somewhere is another one."""
    raw = {key: value for key, value in plain("small_room")[0].items() if not key.startswith("visitable")}
    places = list(spots(raw))

    @settings(max_examples=examples, deadline=None, derandomize=fixed, database=None,
              suppress_health_check=list(HealthCheck))
    @given(st.sampled_from(places), VALUES)
    def one(place: tuple[Any, ...], value: Any) -> None:
        scene = json.loads(json.dumps(raw))
        spot = scene
        for key in place[:-1]:
            spot = spot[key]
        spot[place[-1]] = value
        try:
            Scene.from_dict(scene, "scene.yaml")
        except UserError as error:
            assert len(str(error)) < 10_000
    one()


def spots(tree: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The way to every value of nested lists and dictionaries."""
    inner = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in inner:
        yield (*place, key)
        yield from spots(value, (*place, key))


def test_a_scene_with_another_value_stands_or_is_refused() -> None:
    changed_scenes(40, fixed=True)


@pytest.mark.slow
@pytest.mark.timeout(0)
def test_for_an_hour() -> None:
    """Every reader in turn, other examples each time; what it did is printed (pytest -s)."""
    end, rounds = time.process_time() + SECONDS, 0
    while time.process_time() < end:
        for make in READERS:
            tried(make, 300 if make is not a_scene else 30, fixed=False)
        changed_scenes(100, fixed=False)
        rounds += 1
        print(f"round {rounds}: {rounds * (300 * (len(READERS) - 1) + 130)} examples", flush=True)


def test_what_is_refused_is_named(tmp_path: Path) -> None:
    path, read = an_episode(tmp_path)
    path.write_bytes(b"")
    with pytest.raises(RunFolderError, match=r"episode\.npz"):
        read(path)
