"""The YAML file of a ROS map: the path of its image, and the meaning of its greys.

Every value is text first and is read by yaml-cpp's rules (map_scalars.py); of a key that stands twice the first counts,
and of several documents the first. Follows nav2_map_server (main a3a9704, src/map_io.cpp); docs/maps.md says what
differs.
"""

from __future__ import annotations

import codecs
import math
import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath
from typing import Any

import yaml

from curionav_cli.errors import MapError
from curionav_cli.records import Pose
from curionav_cli.safe_yaml import refuse_bomb
from curionav_cli.world.scene.map_scalars import as_bool, as_float, as_int

IMAGES = (".pgm", ".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".gif", ".ppm", ".pbm", ".pnm", ".pam", ".webp")
MODES = ("trinary", "scale", "raw")
DEFAULTS = {"negate": "0", "occupied_thresh": "0.65", "free_thresh": "0.196"}  # what savers write
NEEDED = ("image", "resolution", "origin")
ROUNDED = 0.0005  # metres that a resolution of three decimals may be off
_LOADER = getattr(yaml, "CBaseLoader", yaml.BaseLoader)
_NULL = ("", "~", "null", "Null", "NULL")
_LED_BY_TABS = re.compile(r"(?m)^[ ]*\t\s*?(?=#|\r?$)")  # blank lines and comments that libyaml stumbles over
_CONTROLS = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")


class MapWarning(UserWarning):
    """Warning of a map that opens and may be misread."""


@dataclass(frozen=True)
class MapFile:
    """A map's YAML file. resolution: metres per pixel; occupied, free: thresholds, at most 1; mode: one of MODES."""

    path: Path
    image: Path
    resolution: float
    origin: Pose
    negate: bool
    occupied: float
    free: float
    mode: str
    decimals: int  # of the resolution as written

    def warn_of_rounding(self, pixels: int) -> None:
        """Warn of a resolution with three decimals, to which savers round, if that may shift the far edge by a cell."""
        if self.decimals == 3 and pixels * ROUNDED > self.resolution:
            _warn(f"{self.path}: resolution {self.resolution:g} has three decimals, to which map savers round it; over "
                  f"{pixels} pixels that may be {pixels * ROUNDED:.2g} m. Write the true one (1/80: 0.0125).")


def _warn(text: str) -> None:
    warnings.warn(text, MapWarning, stacklevel=3)


def read_map_file(path: Path) -> MapFile:
    """Read and check a map's YAML file. Raises MapError."""
    found = _values(path)
    missing = [key for key in NEEDED if key not in found]
    if missing:
        raise MapError(f"{path} is no ROS map: it lacks {', '.join(missing)}.")
    left_out = [key for key in DEFAULTS if key not in found]
    if left_out:
        said = ", ".join(f"{key} {DEFAULTS[key]}" for key in left_out)
        _warn(f"{path} lacks {' and '.join(left_out)}, which Nav2 refuses. Taken for it: {said}.")
    found = {**DEFAULTS, "mode": "trinary", **found}
    resolution = _number(found["resolution"], path, "resolution")
    if resolution <= 0.0:
        raise MapError(f"{path}: resolution is {resolution:g}; it is metres per pixel, more than 0.")
    mode = str(found["mode"]).lower()
    if mode not in MODES:
        raise MapError(f"{path}: mode must be trinary, scale or raw, not {found['mode']!r}.")
    return MapFile(path, _image(found["image"], path), resolution, _origin(found["origin"], path),
                   _truth(found["negate"], path), _share(found, "occupied_thresh", path),
                   _share(found, "free_thresh", path), mode, _decimals(str(found["resolution"])))


def _values(path: Path) -> dict[str, Any]:
    """The values of the first document's keys: text, or a list of texts; a null counts as absent."""
    if path.suffix.lower() in IMAGES:
        raise MapError(f"{path} is an image. Give the map's YAML file, which names its image, resolution and "
                       f"origin (usually {path.with_suffix('.yaml').name} beside it).")
    if not path.is_file():
        raise MapError(f"There is no map {path}. env.map is the path of a ROS map's YAML file.")
    try:
        text = _CONTROLS.sub(" ", _LED_BY_TABS.sub("", _text(path.read_bytes())))
        refuse_bomb(text, first_only=True)
        root = next(yaml.compose_all(text, _LOADER), None)
    except (yaml.YAMLError, ValueError):
        raise MapError(f"{path} is not YAML, so it is no ROS map.") from None
    found: dict[str, Any] = {}
    for key, value in root.value if isinstance(root, yaml.MappingNode) else ():
        if isinstance(key, yaml.ScalarNode) and not _is_null(value):
            found.setdefault(key.value, _plain(value))
    return found


def _text(raw: bytes) -> str:
    """UTF-8 or, by its mark, UTF-16; else what Windows writes, where every byte means something."""
    for mark, encoding in ((codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"), (b"", "utf-8-sig")):
        if raw.startswith(mark):
            try:
                return raw.decode(encoding)
            except UnicodeDecodeError:
                break
    return raw.decode("cp1252", "replace")


def _is_null(node: yaml.Node) -> bool:
    return isinstance(node, yaml.ScalarNode) and not node.style and node.value in _NULL


def _plain(node: yaml.Node) -> Any:
    if isinstance(node, yaml.SequenceNode):
        return [part.value if isinstance(part, yaml.ScalarNode) else None for part in node.value]
    return node.value if isinstance(node, yaml.ScalarNode) else None


def _number(raw: Any, path: Path, key: str) -> float:
    number = _read(as_float, raw, f"{path}: {key} must be a number")
    if not math.isfinite(number):
        raise MapError(f"{path}: {key} must be a number, not {number}.")
    return number


def _share(found: dict[str, Any], key: str, path: Path) -> float:
    number = _number(found[key], path, key)
    if number > 1.0:
        raise MapError(f"{path}: {key} is {number:g}; it is a share, at most 1. Write {number:g} per cent as "
                       f"{number / 100:g}.")
    return number


def _truth(raw: Any, path: Path) -> bool:
    try:
        return bool(as_int(str(raw)))
    except ValueError:
        return _read(as_bool, raw, f"{path}: negate must be 0 or 1, true or false")


def _read(reader: Callable[[str], Any], raw: Any, said: str) -> Any:
    try:
        if isinstance(raw, str):
            return reader(raw)
    except ValueError:
        pass
    raise MapError(f"{said}, not {raw!r}.")


def _origin(raw: Any, path: Path) -> Pose:
    if not isinstance(raw, list) or len(raw) not in (2, 3):
        raise MapError(f"{path}: origin must be [x, y, yaw], not {raw!r}.")
    if str(raw[-1]).lower().strip("+-.") == "nan" and len(raw) == 3:
        raise MapError(f"{path}: the origin's yaw is {raw[2]}, as map_saver of ROS 1 writes an unknown one. "
                       "Write 0.0 in its place.")
    return Pose(*(_number(part, path, "origin") for part in [*raw, "0"][:3]))


def _image(raw: Any, path: Path) -> Path:
    """The image's path; where there is none, the file of that name beside the YAML file, with a warning."""
    if not isinstance(raw, str) or not raw:
        raise MapError(f"{path}: image must be the name of a file, not {raw!r}.")
    image = path.parent / raw
    beside = path.parent / PureWindowsPath(raw).name
    if image.is_file():
        return image
    if not beside.is_file():
        raise MapError(f"{path}: its image {image} does not exist, and no {beside.name} is beside the YAML file.")
    _warn(f"{path}: its image {raw} does not exist; {beside} is taken for it.")
    return beside


def _decimals(text: str) -> int:
    """Of a number written in full, zeros at its end not counted among three: 0.050 has two."""
    _, point, digits = text.strip().partition(".")
    if not point or not digits.isdecimal():
        return 0
    return len(digits.rstrip("0")) if len(digits) == 3 else len(digits)
