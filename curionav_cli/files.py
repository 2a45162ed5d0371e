"""Files that are finished or absent, and known for broken when they are read: npz archives and sealed JSON.

Nothing that is read here is ever unpickled, and no array becomes larger than its file says.
"""

from __future__ import annotations

import io
import json
import os
import re
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import IO, Any

import numpy as np

from curionav_cli.errors import ConfigError, RunFolderError

SEAL = "crc32"  # the key of a JSON file's checksum
BROKEN = (OSError, ValueError, TypeError, OverflowError, LookupError, EOFError, RuntimeError, zipfile.BadZipFile,
          zlib.error, tokenize.TokenError)  # what zipfile and numpy say of an npz that is none


def write_arrays(path: Path, arrays: dict[str, np.ndarray]) -> None:
    """An npz that numpy.load reads, same bytes for the same arrays, finished or absent."""
    def body(file: IO[bytes]) -> None:
        with zipfile.ZipFile(file, "w") as archive:
            for name, array in arrays.items():
                raw = io.BytesIO()
                np.lib.format.write_array(raw, np.asanyarray(array), allow_pickle=False)
                archive.writestr(zipfile.ZipInfo(f"{name}.npy"), raw.getvalue(), zipfile.ZIP_DEFLATED, 1)
    write_whole(path, body)


def read_arrays(path: Path, names: tuple[str, ...], optional: tuple[str, ...] = ()) -> dict[str, np.ndarray]:
    """The named arrays of an npz, the optional ones if it has them. Raises RunFolderError where the file is broken or
    lacks another."""
    with opened(path) as archive:
        held = archive.namelist() if optional else []
        names += tuple(name for name in optional if f"{name}.npy" in held)
        return {name: decoded(unpacked(archive, f"{name}.npy")) for name in names}


def unpacked(archive: zipfile.ZipFile, name: str) -> bytes:
    """A member, of which no more is unpacked than the table of contents tells of; bzip2 and LZMA know no such limit."""
    info = archive.getinfo(name)
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError(f"{name} is packed in a way that curionav does not write")
    with archive.open(info) as member:
        return member.read(info.file_size)


def checksum(path: Path) -> str:
    """Of the arrays of an npz, from its table of contents alone. Raises RunFolderError where it is broken."""
    with opened(path) as archive:
        held = [(info.filename, info.CRC, info.file_size) for info in archive.infolist()]
    return f"{zlib.crc32(json.dumps(held).encode()):08x}"


def refuse_broken(path: Path) -> None:
    """Raises RunFolderError where an npz is not what was saved, by the checksums that it holds."""
    with opened(path) as archive:
        bad = archive.testzip()
        if bad:
            raise ValueError(f"{bad} is broken")


@contextmanager
def understood(path: Path) -> Iterator[None]:
    """Raises RunFolderError for what is whole and yet holds something else."""
    try:
        yield
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        raise RunFolderError(f"{path} does not hold what it should ({error}).") from error


@contextmanager
def opened(path: Path) -> Iterator[zipfile.ZipFile]:
    """An npz to read from. Raises RunFolderError for what is found broken or missing meanwhile."""
    try:
        with open(path, "rb") as file, zipfile.ZipFile(file) as archive:
            yield archive
    except BROKEN as error:
        raise RunFolderError(f"{path} is not whole ({error}). Restore it from a copy.") from error


def decoded(raw: bytes) -> np.ndarray:
    """The array of a .npy file as write_arrays writes it. Raises ValueError for any other."""
    body = 10 + int.from_bytes(raw[8:10], "little")
    shape, fortran, dtype = header(raw[:body])
    return np.frombuffer(raw, dtype, offset=body).reshape(shape, order="F" if fortran else "C").copy("K")


@lru_cache(64)
def header(raw: bytes) -> tuple[tuple[int, ...], bool, np.dtype]:
    """Shape, order and type of a .npy file; parsed once where a thousand episodes begin alike."""
    file = io.BytesIO(raw)
    if np.lib.format.read_magic(file) != (1, 0):
        raise ValueError("the npy format is not version 1.0")
    return np.lib.format.read_array_header_1_0(file)


def read_json(path: Path) -> Any:
    """What a JSON file holds. Raises RunFolderError where it is missing or broken, or not what `sealed` sealed."""
    try:
        held = json.loads(path.read_text())
    except (OSError, ValueError, RecursionError) as error:
        raise RunFolderError(f"{path} cannot be read ({error}). Restore it from a copy.") from error
    if isinstance(held, dict) and SEAL in held and held.pop(SEAL) != seal(held):
        raise RunFolderError(f"{path} cannot be read (its checksum is another one). Restore it from a copy.")
    return held


def sealed(held: dict[str, Any]) -> str:
    """JSON with a checksum of itself, by which read_json finds a flipped bit."""
    return json.dumps({**held, SEAL: seal(held)}, indent=2)


def seal(held: dict[str, Any]) -> str:
    return f"{zlib.crc32(json.dumps(held).encode()):08x}"


def place(text: str | Path) -> Path:
    """A path as a person types it: the shell leaves the ~ of out=~/figures to us."""
    try:
        return Path(text).expanduser()
    except RuntimeError:  # ~ of nobody is a name as any other
        return Path(text)


def conf_dir() -> Path:
    """conf/ inside the package (installed from a wheel), or beside it (a checkout)."""
    package = Path(__file__).resolve().parent
    inside = package / "conf"
    return inside if inside.is_dir() else package.parent / "conf"


def folder_for(path: str | Path) -> Path:
    """A folder to write into, made by who writes. Raises ConfigError where a file is in the way."""
    path = place(path)
    file = next((place for place in (path, *path.parents) if place.exists() and not place.is_dir()), None)
    if file:
        raise ConfigError(f"{file} is a file. Name a folder.")
    return path


def write_whole(path: Path, body: Callable[[IO[bytes]], object]) -> None:
    """Write beside, flush, rename: after a crash the file is the old one or the new one."""
    beside = path.with_name(f".{path.name}.part")
    try:
        with open(beside, "wb") as file:
            body(file)
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise


LONGEST = 120  # bytes of a label in a file's name, of which a disk takes 255


def file_name(label: str) -> str:
    """A label as a part of a file's name; of a long one the beginning and a checksum."""
    name = re.sub(r"[^\w.=-]+", "_", label)
    whole = name.encode()
    return name if len(whole) <= LONGEST else f"{whole[:LONGEST].decode(errors='ignore')}_{zlib.crc32(whole):08x}"
