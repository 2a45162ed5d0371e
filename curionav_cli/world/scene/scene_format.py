"""The lists in a scene file, one dataclass each, and their reader, whose errors name file and key.

Metres and degrees. x points right and y up from the lower-left inner corner of the scene.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import MISSING, dataclass, fields
from difflib import get_close_matches
from typing import Any, TypeVar

from curionav_cli.errors import SceneError

Numbers = tuple[float, ...]
Pair = tuple[float, ...]  # two numbers, four: the reader counts them
Quad = tuple[float, ...]
Record = TypeVar("Record")
MOST = 1e6  # of any number in a scene, a thousand kilometres


@dataclass(frozen=True)
class Room:
    """A part of the floor: rect [x0, y0, x1, y1], and the materials of its floor and walls."""

    rect: Quad
    name: str = ""
    floor: str = "planks"
    wall: str = "plaster_white"


@dataclass(frozen=True)
class Wall:
    """An inner wall: line [x0, y0, x1, y1] along x or y; gaps [[at, width, height]], windows [[at, width, sill, top]].

    `at` is measured along the line from its first point. Without a material each side takes that of
    the room it faces. Without a height it reaches the ceiling.
    """

    line: Quad
    thickness: float = 0.1
    height: float = 0.0
    material: str = ""
    gaps: tuple[Numbers, ...] = ()
    windows: tuple[Numbers, ...] = ()


@dataclass(frozen=True)
class Solid:
    """What a ROS map shows as occupied inside rect [x0, y0, x1, y1] has this height and material."""

    rect: Quad
    height: float
    material: str = "plaster_white"
    fit: bool = False


@dataclass(frozen=True)
class Poster:
    """A flat picture on a wall: at [x, y] on the wall's surface; face: its direction; z: its lower edge."""

    at: Pair
    face: str
    art: str = "poster_1"
    width: float = 0.6
    height: float = 0.8
    z: float = 1.0


@dataclass(frozen=True)
class Furniture:
    """kind (furniture.py), x, y of the centre; w, d, h; turn in quarter turns; z of its underside."""

    kind: str
    x: float
    y: float
    w: float = 0.0
    d: float = 0.0
    h: float = 0.0
    z: float = 0.0
    turn: int = 0
    material: str = ""
    name: str = ""


@dataclass(frozen=True)
class Repeat:
    """The same piece `times` times, each `step` [dx, dy] from the last; its name gets _1, _2 ..."""

    times: int
    step: Pair
    of: dict[str, Any]


@dataclass(frozen=True)
class Tune:
    """The named piece that grows along `axis` (w or d) until the promised count is reached."""

    piece: str
    axis: str = "w"


@dataclass(frozen=True)
class Light:
    """Brightness over the episodes: 1 - drift at the trough of a wave of `period`, times noise sigma."""

    drift: float = 0.0
    sigma: float = 0.0
    period: float = 20.0


@dataclass(frozen=True)
class Move:
    """Every `every` episodes the named piece is carried to one of `to` [[x, y], ...] or back."""

    item: str
    every: int
    to: tuple[Pair, ...]


ABOVE_ZERO: dict[type, tuple[str, ...]] = {
    Wall: ("thickness",), Poster: ("width", "height"), Furniture: ("w", "d", "h"), Repeat: ("times",),
    Light: ("period",)}
NOT_NEGATIVE: dict[type, tuple[str, ...]] = {Wall: ("height",), Light: ("sigma",)}


def read(record: type[Record], raw: Any, source: str, where: str) -> Record:
    """Read a record from a plain dict. Raises SceneError naming file, key and the nearest valid key."""
    if not isinstance(raw, dict):
        raise SceneError(f"{source}: {where} must be a mapping like {{{_example(record)}}}, not {raw!r}.")
    keys = {field.name: field for field in fields(record)}  # type: ignore[arg-type]
    refuse_unknown(raw, keys, source, where)
    for name, field in keys.items():
        if name not in raw and field.default is MISSING:
            raise SceneError(f"{source}: {where} lacks the key {name}.")
    values = {name: value(raw[name], str(keys[name].type), source, f"{where}.{name}") for name in raw}
    for name, number in values.items():
        if name in ABOVE_ZERO.get(record, ()) and number <= 0:
            raise SceneError(f"{source}: {where}.{name} must be more than 0, not {number:g}.")
        if name in NOT_NEGATIVE.get(record, ()) and number < 0:
            raise SceneError(f"{source}: {where}.{name} must be 0 or more, not {number:g}.")
    return record(**values)


def refuse_unknown(raw: dict[str, Any], known: Any, source: str, where: str) -> None:
    """Raise SceneError for a key that is not one of `known`."""
    for key in raw:
        if key not in known:
            raise SceneError(f"{source}: {where or 'a scene'} has no key {key}. {hint(key, known)}")


def hint(key: object, known: Collection[str]) -> str:
    """A sentence with the nearest known name, or with all of them."""
    near = get_close_matches(str(key), list(known), 1)
    return f"Did you mean {near[0]}?" if near else f"It has: {', '.join(known)}."


def value(raw: Any, kind: str, source: str, where: str) -> Any:
    """Convert a value to the type named by an annotation above. Raises SceneError naming `source` and `where`."""
    if kind in _READERS:
        wanted, convert = _READERS[kind]
        try:
            return convert(raw)
        except (TypeError, ValueError, OverflowError) as error:
            most = f" of at most {MOST:g}" if isinstance(error, OverflowError) else ""
            raise SceneError(f"{source}: {where} must be {wanted}{most}, not {raw!r}.") from None
    return raw


def _number(raw: Any) -> float:
    if isinstance(raw, bool | str):
        raise TypeError
    number = float(raw)
    if number - number != 0:
        raise ValueError
    if abs(number) > MOST:
        raise OverflowError
    return number


def _whole(raw: Any) -> int:
    if _number(raw) != int(raw):
        raise ValueError
    return int(raw)


def _truth(raw: Any) -> bool:
    if not isinstance(raw, bool):
        raise TypeError
    return raw


def _text(raw: Any) -> str:
    if not isinstance(raw, str):
        raise TypeError
    return raw


def _numbers(raw: Any) -> Numbers:
    return tuple(_number(item) for item in _list(raw))


def _rows(raw: Any) -> tuple[Numbers, ...]:
    return tuple(_numbers(row) for row in _list(raw))


def _counted(raw: Any, count: int) -> Numbers:
    if len(raw) != count:
        raise ValueError
    return _numbers(raw)


def _list(raw: Any) -> list[Any]:
    if not isinstance(raw, list | tuple):
        raise TypeError
    return list(raw)


_READERS: dict[str, tuple[str, Any]] = {
    "float": ("a number", _number),
    "int": ("a whole number", _whole),
    "str": ("text", _text),
    "bool": ("true or false", _truth),
    "Numbers": ("a list of numbers", _numbers),
    "Pair": ("2 numbers [x, y]", lambda raw: _counted(raw, 2)),
    "Quad": ("4 numbers [x0, y0, x1, y1]", lambda raw: _counted(raw, 4)),
    "tuple[Pair, ...]": ("a list of [x, y]", lambda raw: tuple(_counted(row, 2) for row in _list(raw))),
    "tuple[Numbers, ...]": ("a list of lists of numbers", _rows),
    "dict[str, Any]": ("a mapping", lambda raw: dict(raw)),
}


def _example(record: type) -> str:
    return ", ".join(f"{field.name}: ..." for field in fields(record))
