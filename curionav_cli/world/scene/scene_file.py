"""Reading a scene file: every key and value checked, each refusal naming the file and the key."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, fields, replace
from enum import Enum
from pathlib import Path
from typing import Any

import yaml

from curionav_cli.bounds import a_number
from curionav_cli.errors import SceneError
from curionav_cli.places import conf_dir
from curionav_cli.world.motion import COLLISIONS
from curionav_cli.world.scene import layout
from curionav_cli.world.scene.scene_format import (
    Furniture,
    Light,
    Move,
    Poster,
    Repeat,
    Room,
    Solid,
    Tune,
    Wall,
    read,
    refuse_unknown,
)
from curionav_cli.world.settings import Env, Scan

TIMES = 1000  # the most that a piece is repeated
HYDRA_KEYS = ("defaults",)  # in the file for Hydra, of no meaning for a scene


@dataclass(frozen=True)
class Lists:
    """The checked lists of one file."""

    rooms: tuple[Room, ...]
    walls: tuple[Wall, ...]
    solids: tuple[Solid, ...]
    posters: tuple[Poster, ...]
    furniture: tuple[Furniture, ...]
    moves: tuple[Move, ...]
    tune: Tune | None
    light: Light


def env_dir() -> Path:
    """Where the scene files of this package are."""
    return conf_dir() / "env"


def plain(name: str, **changes: Any) -> tuple[dict[str, Any], str]:
    """Read conf/env/<name>.yaml without Hydra: its dict with `changes`, and the file's name. Raises SceneError."""
    path = env_dir() / f"{name}.yaml"
    if not path.is_file():
        names = ", ".join(sorted(file.stem for file in env_dir().glob("*.yaml")))
        raise SceneError(f"There is no scene {name} in {env_dir()}. There is {names}.")
    return {**yaml.safe_load(path.read_text(encoding="utf-8")), **changes}, path.name


def settings(raw: dict[str, Any], source: str) -> Env:
    """Check the keys of a scene and make its Env, which checks the ranges. Raises SceneError naming `source`."""
    raw = {key: value for key, value in raw.items() if key not in HYDRA_KEYS}
    kind = Scan if "mesh" in raw else Env
    keys = {field.name: field for field in fields(kind)}
    refuse_unknown(raw, keys, source, "")
    for name, field in keys.items():
        if name not in raw and field.default is MISSING and field.default_factory is MISSING:
            raise SceneError(f"{source}: a scene needs the key {name}.")
    if not isinstance(raw["name"], str):
        raise SceneError(f"{source}: name must be a word, not {raw['name']!r}.")
    try:
        env = kind(**raw)
    except ValueError as error:
        raise SceneError(f"{source}: {error}.") from None
    if isinstance(env, Scan):
        return env
    if not env.map and not env.size:
        raise SceneError(f"{source}: this scene needs a ROS map, env.map=PATH.yaml, or a size: [x, y] in metres.")
    if not env.map and not env.cell:
        raise SceneError(f"{source}: a scene needs the side of its coverage cells in metres, as cell: 0.1")
    return env


def _check_number(value: Any, least: float, most: float, what: str) -> None:
    try:
        a_number(what, value, least, most)
    except ValueError as error:
        raise SceneError(f"{error}.") from None


def collision_of(env: Env, source: str) -> str:
    """The name of the collision mode. Raises SceneError naming `source`."""
    name = env.collision.value if isinstance(env.collision, Enum) else env.collision
    if name not in COLLISIONS:
        raise SceneError(f"{source}: collision must be one of {', '.join(COLLISIONS)}, not {name!r}.")
    return name


def lists_of(env: Env, source: str) -> Lists:
    """Check the lists of a scene, expand repeated pieces, fill in sizes of kinds. Raises SceneError."""
    light = Light()
    if env.light and env.changes:
        light = read(Light, env.light, source, "light")
    return Lists(
        rooms=_each(env, "rooms", Room, source), walls=_each(env, "walls", Wall, source),
        solids=_solids(env, source),
        posters=_each(env, "posters", Poster, source), furniture=_furniture(env, source),
        moves=_each(env, "moves", Move, source) if env.changes else (),
        tune=read(Tune, env.tune, source, "tune") if env.tune else None, light=light)


def _each(env: Env, key: str, record: Any, source: str) -> tuple[Any, ...]:
    raw = getattr(env, key) or []
    if not isinstance(raw, list | tuple):
        raise SceneError(f"{source}: {key} must be a list, not {raw!r}.")
    return tuple(read(record, item, source, f"{key}[{index}]") for index, item in enumerate(raw))


def _solids(env: Env, source: str) -> tuple[Solid, ...]:
    solids = _each(env, "solids", Solid, source)
    if solids and not env.map:
        raise SceneError(f"{source}: solids describes what a ROS map shows as occupied, and this scene opens no map. "
                         "Build it of walls and furniture.")
    for index, solid in enumerate(solids):
        _check_number(solid.height, 0.01, env.height, f"{source}: solids[{index}].height")
    return solids


def _furniture(env: Env, source: str) -> tuple[Furniture, ...]:
    pieces = [layout.complete(piece, source, f"furniture[{index}]")
              for index, piece in enumerate(_each(env, "furniture", Furniture, source))]
    for index, row in enumerate(_each(env, "repeat", Repeat, source)):
        _check_number(row.times, 1, TIMES, f"{source}: repeat[{index}].times")
        where = f"repeat[{index}].of"
        first = layout.complete(read(Furniture, row.of, source, where), source, where)
        pieces += [replace(first, x=first.x + n * row.step[0], y=first.y + n * row.step[1],
                           name=first.name and f"{first.name}_{n + 1}") for n in range(row.times)]
    return tuple(pieces)
