"""A small sound file of every kind that is read, each with its reader."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from PIL import Image
from safetensors.numpy import save

from curionav_cli.agents.weights import read_tensors
from curionav_cli.config.settings import read_settings
from curionav_cli.files import CRC32, read_json
from curionav_cli.records import Episode, FloorPlan, Pose
from curionav_cli.storage import checkpoint
from curionav_cli.world.scene.ros_map import read_map
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

Sample = tuple[Path, Callable[[Path], Any]]


def an_episode(folder: Path) -> Sample:
    rng = np.random.default_rng(0)
    episode = Episode(rng.integers(0, 255, (4, 64, 64, 3), np.uint8), np.array([0, 1, 2]), np.zeros((4, 3)),
                      np.zeros(3, bool), ({"what": "light", "brightness": 1.0},))
    episode.save(folder / "episode.npz")
    return folder / "episode.npz", Episode.load


def a_plan(folder: Path) -> Sample:
    mask = np.ones((9, 7), bool)
    FloorPlan(mask, mask, ~mask, 0.1, Pose(0.1, 0.1, 0.0), 0.18, "room").save(folder / "plan.npz")
    return folder / "plan.npz", FloorPlan.load


def weights(folder: Path) -> Sample:
    (folder / "weights.safetensors").write_bytes(save({"a/b": np.arange(12, dtype=np.float32).reshape(3, 4)}))
    return folder / "weights.safetensors", read_tensors


def a_status(folder: Path) -> Sample:
    (folder / "status.json").write_text(CRC32.sealed({"state": "done", "episode": 3, "coverage": 0.25}))
    return folder / "status.json", read_json


def a_marker(folder: Path) -> Sample:
    checkpoint.save(folder, 1, {"seed": 0}, lambda inner: (inner / "rng.json").write_text("{}"))
    return folder / "000001" / "checksums.json", lambda path: checkpoint.newest(folder, {"seed": 0})


def a_config(folder: Path) -> Sample:
    (folder / "config.yaml").write_text(
        "seed: 0\ndevice: cpu\nagent: {name: random}\nenv: {name: room, size: [2, 3], radius: 0.1, camera: 0.4}\n")
    return folder / "config.yaml", read_settings


def a_map(folder: Path) -> Sample:
    (folder / "map.yaml").write_text(
        "image: map.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\n"
        "free_thresh: 0.196\n")
    (folder / "map.pgm").write_bytes(b"P5 # a map\n9 7\n255\n" + bytes(range(63)))
    return folder / "map.yaml", read_map


def a_pgm(folder: Path) -> Sample:
    where, read = a_map(folder)
    return where.with_name("map.pgm"), lambda path: read(where)


def a_plain_pgm(folder: Path) -> Sample:
    path, read = a_pgm(folder)
    path.write_bytes(b"P2 # a map\n9 7\n255\n" + " ".join(map(str, range(63))).encode())
    return path, read


def a_picture(folder: Path, kind: str, channels: int) -> Sample:
    """A map whose image is of this kind."""
    where, read = a_map(folder)
    where.write_text(where.read_text().replace("pgm", kind))
    pixels = np.arange(63 * channels, dtype=np.uint8).reshape(7, 9, channels)
    Image.fromarray(pixels[..., 0] if channels == 1 else pixels).save(folder / f"map.{kind}")
    return folder / f"map.{kind}", lambda path: read(where)


def a_png(folder: Path) -> Sample:
    return a_picture(folder, "png", 1)


def a_clear_png(folder: Path) -> Sample:
    return a_picture(folder, "png", 4)


def a_bmp(folder: Path) -> Sample:
    return a_picture(folder, "bmp", 3)


def a_jpg(folder: Path) -> Sample:
    return a_picture(folder, "jpg", 1)


def a_gif(folder: Path) -> Sample:
    return a_picture(folder, "gif", 1)


def a_tiff(folder: Path) -> Sample:
    return a_picture(folder, "tiff", 3)


def a_clear_webp(folder: Path) -> Sample:
    return a_picture(folder, "webp", 4)


def a_pam(folder: Path) -> Sample:
    path, read = a_pgm(folder)
    path.write_bytes(b"P7\nWIDTH 9\nHEIGHT 7\nDEPTH 2\nMAXVAL 255\nENDHDR\n" + bytes(range(126)))
    return path, read


def a_bitmap(folder: Path) -> Sample:
    path, read = a_pgm(folder)
    path.write_bytes(b"P4 9 7\n" + bytes(range(14)))
    return path, read


def a_scene(folder: Path) -> Sample:
    raw = {key: value for key, value in plain("small_room")[0].items() if not key.startswith("visitable")}
    (folder / "scene.yaml").write_text(yaml.safe_dump(raw))

    def read(path: Path) -> Scene:
        raw = yaml.safe_load(path.read_text())
        return Scene.from_dict(raw if isinstance(raw, dict) else {}, "scene.yaml")
    return folder / "scene.yaml", read


READERS = (an_episode, a_plan, weights, a_status, a_marker, a_config, a_map, a_pgm, a_plain_pgm, a_png, a_clear_png,
           a_bmp, a_jpg, a_gif, a_tiff, a_clear_webp, a_pam, a_bitmap, a_scene)
