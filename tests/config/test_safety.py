"""Configs and files from elsewhere: nothing in them is called, nothing is written elsewhere, nothing unfolds."""

from __future__ import annotations

import json
import struct
import zipfile
import zlib
from itertools import cycle
from pathlib import Path

import numpy as np
import pytest
from entry import Cli
from omegaconf import OmegaConf

from curionav_cli.config.safety import refuse_callables
from curionav_cli.config.settings import read_settings
from curionav_cli.errors import ConfigError, MapError, RunFolderError, SceneError, UserError
from curionav_cli.files import read_arrays
from curionav_cli.records import Episode, FloorPlan
from curionav_cli.safe_yaml import refuse_bomb
from curionav_cli.world.scene.map_image import read_image
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

STOLEN = "@package _global_"
BOMB = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{chr(98 + n)}: &{chr(98 + n)} [{', '.join([f'*{chr(97 + n)}'] * 9)}]\n" for n in range(9))

SUBMITIT = "hydra_plugins.hydra_submitit_launcher.submitit_launcher"
CONFIGS = {
    "callbacks: {x: {_target_: os.mkdir, path: stolen}}": "hydra.callbacks: a config may not run code",
    "launcher: {_target_: os.mkdir}": "os.mkdir would be called",
    "sweeper: {_target_: os.mkdir}": "os.mkdir would be called",
    "job_logging: {handlers: {x: {(): os.mkdir, path: stolen}}}": "os.mkdir would be called",
    "job_logging: {handlers: {file: {class: os.mkdir}}}": "os.mkdir would be called",
    "job_logging: {handlers: {file: {filename: stolen}}}": "a log stands in the run's folder",
    "job_logging: {handlers: {file: {filename: '${hydra.runtime.output_dir}/../stolen'}}}": "a log stands in the run's",
    "hydra_logging: {handlers: {x: {(): os.mkdir}}}": "os.mkdir would be called",
    "hydra_logging: {formatters: {x: {(): colorlog.ColoredFormatter}}}": "colorlog.ColoredFormatter would be called",
    "job_logging: {handlers: {file: {class: colorlog.StreamHandler}}}": "colorlog.StreamHandler would be called",
    f"launcher: {{_target_: {SUBMITIT}.os.mkdir}}": "os.mkdir would be called",
    "output_subdir: ../../stolen": "hydra.output_subdir: ../../stolen would be written outside",
    "job: {name: ../stolen}": "hydra.job.name: ../stolen would be written outside",
    "sweep: {subdir: ../../stolen}": "hydra.sweep.subdir: ../../stolen would be written outside",
    "sweep: {subdir: '${question}'}": "hydra.sweep.subdir: ${question} would be written outside",
    "{sweep: {subdir: '${hydra.job.override_dirname}'}, sweeper: {params: {question: ../../stolen}}}": "outside",
    "job: {env_set: {LD_PRELOAD: ./stolen.so}}": "hydra.job.env_set: a config may not",
}


@pytest.mark.parametrize(("line", "words"), list(zip(CONFIGS, cycle([["seed=3"], ["-m", "seed=3,4"]]))))
def test_a_config_names_nothing_that_is_called(cli: Cli, tmp_path: Path, line: str, words: list[str]) -> None:
    (tmp_path / "own" / "experiment").mkdir(parents=True)
    (tmp_path / "own" / "experiment" / "gift.yaml").write_text(f"# {STOLEN}\nhydra:\n  {line}\n")
    answer = cli("explore", "-cd", "own", "experiment=gift", "agent=random", "loop.steps=1", "loop.episodes=1", *words)
    assert answer.code == 2 and CONFIGS[line] in answer.error, answer.error
    assert not (tmp_path / "stolen").exists() and not (tmp_path / "outputs").exists()


@pytest.mark.parametrize("target", [f"{SUBMITIT}.os.mkdir", f"{SUBMITIT}.SlurmLauncher"])
def test_deep_in_a_launcher_nothing_is_called_either(target: str) -> None:
    launcher = {"_target_": f"{SUBMITIT}.SlurmLauncher", "additional_parameters": {"x": {"_target_": target}}}
    hydra = {"launcher": launcher, "sweeper": {}, "job": {"name": "explore"}, "output_subdir": ".hydra",
             "sweep": {"subdir": "${hydra.job.num}"}}
    with pytest.raises(ConfigError, match=r"hydra.launcher.additional_parameters.x._target_: .* would be called"):
        refuse_callables(OmegaConf.create({"hydra": hydra}))


@pytest.mark.parametrize("name", ["../elsewhere", "/tmp/elsewhere", "a/b", "..", ".hidden", "", "a\nb"])
def test_a_scene_does_not_choose_where_its_runs_are_written(name: str) -> None:
    with pytest.raises(SceneError, match="is no name"):
        Scene.from_dict({**plain("small_room")[0], "name": name})


def test_of_a_sweep_each_job_is_looked_at(cli: Cli, tmp_path: Path) -> None:
    (tmp_path / "own" / "env").mkdir(parents=True)
    room = "defaults:\n  - small_room\n\nname: ../../elsewhere\n"
    (tmp_path / "own" / "env" / "gift.yaml").write_text(room)
    answer = cli("explore", "-cd", "own", "-m", "env=small_room,gift", "agent=random")
    assert answer.code == 2 and "env.name: '../../elsewhere' is no name" in answer.error


def test_a_yaml_that_unfolds_is_refused_before_it_does(cli: Cli, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="unfolds"):
        refuse_bomb(BOMB)
    with pytest.raises(ValueError, match="unfolds"):
        refuse_bomb("[" * 200 + "]" * 200)
    refuse_bomb("a: &a {b: 1}\nc: [*a, *a]\n")
    (tmp_path / "own" / "env").mkdir(parents=True)
    (tmp_path / "own" / "env" / "gift.yaml").write_text(BOMB)
    answer = cli("explore", "-cd", "own", "agent=random")
    assert answer.code == 2 and "gift.yaml cannot be used" in answer.error
    (tmp_path / "config.yaml").write_text(BOMB)
    with pytest.raises(RunFolderError, match="unfolds"):
        read_settings(tmp_path / "config.yaml")
    (tmp_path / "map.yaml").write_text(BOMB)
    answer = cli("explore", "env=map", "env.map=map.yaml", "agent=random")
    assert answer.code == 2 and "map.yaml" in answer.error


@pytest.mark.parametrize("key", ["x", "w", "z"])
@pytest.mark.parametrize("number", [10**400, 1e299, -9e17])
def test_numbers_beyond_any_building(key: str, number: float) -> None:
    raw = plain("small_room")[0]
    raw["furniture"][1][key] = number
    with pytest.raises(SceneError, match=rf"furniture\[1\]\.{key} must be a number of at most 1e\+06"):
        Scene.from_dict(raw)


@pytest.mark.parametrize("rooms", [[[0, 0, 9e5, 4]], [[-1e6, 0, 1e6, 4]], [[0, 0, 400, 400]] * 3])
def test_rooms_with_more_lamps_than_any_building(rooms: list) -> None:
    changes = {"rooms": [{"rect": rect} for rect in rooms], "visitable": None, "visitable_sha256": None}
    with pytest.raises(SceneError, match=r"its rooms have more than 10000"):
        Scene.from_dict({**plain("small_room")[0], **changes})


@pytest.mark.parametrize("changes", [
    {"size": [1e6, 1e6]}, {"size": [4e4, 4e4], "cell": 2.0, "visitable": None, "visitable_sha256": None},
    {"repeat": [{"times": 10**9, "step": [0, 0.1], "of": {"kind": "box", "x": 1, "y": 1}}]},
])
def test_a_scene_larger_than_any_building(changes: dict) -> None:
    with pytest.raises(SceneError, match=r"are more than|must be a number from|of at most"):
        Scene.from_dict({**plain("small_room")[0], **changes})


def test_a_picture_that_is_larger_than_any_map(tmp_path: Path) -> None:
    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    header = struct.pack(">IIBBBBB", 30000, 30000, 8, 0, 0, 0, 0)
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IEND", b""))
    with pytest.raises(MapError, match="pixels"):
        read_image(tmp_path / "a.png")
    (tmp_path / "a.pgm").write_bytes(b"P5 999999999 999999999 255\n" + b"x" * 99)
    with pytest.raises(MapError):
        read_image(tmp_path / "a.pgm")


def test_arrays_are_no_larger_than_their_file_says(tmp_path: Path) -> None:
    header = b"{'descr': '|u1', 'fortran_order': False, 'shape': (1000000000000,), }"
    body = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("image.npy", body)
    with pytest.raises(RunFolderError, match="not whole"):
        read_arrays(tmp_path / "a.npz", ("image",))


@pytest.mark.parametrize("events", ["[" * 100000, "nothing", "{"])
def test_what_is_whole_and_holds_something_else(tmp_path: Path, an_episode, events: str) -> None:
    episode = an_episode(steps=2)
    arrays = {"image": episode.image, "action": episode.action, "pose": episode.pose, "collided": episode.collided}
    np.savez(tmp_path / "a.npz", **arrays, events=np.array(events))
    with pytest.raises(RunFolderError, match="does not hold what it should"):
        Episode.load(tmp_path / "a.npz")
    np.savez(tmp_path / "b.npz", **{**arrays, "pose": episode.pose[1:]}, events=np.array(json.dumps([])))
    with pytest.raises(RunFolderError, match="holds no episode"):
        Episode.load(tmp_path / "b.npz")
    mask = np.ones((2, 2), bool)
    np.savez(tmp_path / "c.npz", visitable=mask, floor=mask, solid=mask, numbers=np.array(events))
    with pytest.raises(UserError):
        FloorPlan.load(tmp_path / "c.npz")
