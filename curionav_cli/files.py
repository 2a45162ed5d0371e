"""Files that are whole or absent and whose damage is found by reading them: npz archives and sealed JSON.

Nothing that is read here is ever unpickled, and no array becomes larger than its file declares.
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
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import IO, Any

import numpy as np

from curionav_cli.errors import ConfigError, RunFolderError
from curionav_cli.places import place

BROKEN = (OSError, ValueError, TypeError, OverflowError, LookupError, EOFError, RuntimeError, zipfile.BadZipFile,
          zlib.error, tokenize.TokenError)  # what zipfile and numpy raise for an npz that is none


@dataclass(frozen=True)
class Seal:
    """A checksum that a JSON object holds of itself, by which a flipped bit is found.

    key: where it is held. checksum: of the object without it. indent: of the text, as json.dumps takes it.
    """

    key: str
    checksum: Callable[[dict[str, Any]], str]
    indent: int | None = None

    def sealed(self, plain: dict[str, Any]) -> str:
        """The JSON text of an object, its checksum included."""
        return json.dumps({**plain, self.key: self.checksum(plain)}, indent=self.indent)

    def removed(self, held: dict[str, Any]) -> bool:
        """Take the checksum out of an object that was read; whether it was there and right."""
        return held.pop(self.key, None) == self.checksum(held)


FAST, SMALL = 1, 6  # levels of zlib: images of an episode take 2.0 MB or 1.7 MB
CRC32 = Seal("crc32", lambda plain: f"{zlib.crc32(json.dumps(plain).encode()):08x}", indent=2)


def write_arrays(path: Path, arrays: dict[str, np.ndarray], level: int = FAST) -> None:
    """Write an npz that numpy.load reads: same bytes for the same arrays, whole or absent. level: of zlib, 0 for none.
    """
    kind = zipfile.ZIP_DEFLATED if level else zipfile.ZIP_STORED

    def body(file: IO[bytes]) -> None:
        with zipfile.ZipFile(file, "w") as archive:
            for name, array in arrays.items():
                raw = io.BytesIO()
                np.lib.format.write_array(raw, np.asanyarray(array), allow_pickle=False)
                archive.writestr(zipfile.ZipInfo(f"{name}.npy"), raw.getvalue(), kind, level)
    write_whole(path, body)


def read_arrays(path: Path, names: tuple[str, ...], optional: tuple[str, ...] = ()) -> dict[str, np.ndarray]:
    """The arrays of an npz with these names, and the optional ones that it has.

    Raises RunFolderError where the file is broken or lacks a name.
    """
    with opened(path) as archive:
        held = archive.namelist() if optional else []
        names += tuple(name for name in optional if f"{name}.npy" in held)
        return {name: decoded(unpacked(archive, f"{name}.npy")) for name in names}


def unpacked(archive: zipfile.ZipFile, name: str) -> bytes:
    """The bytes of a member, no more than the table of contents declares.

    Raises ValueError for bzip2 and LZMA, which Python unpacks without such a limit.
    """
    info = archive.getinfo(name)
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError(f"{name} is packed in a way that curionav does not write")
    with archive.open(info) as member:
        return member.read(info.file_size)


def checksum(path: Path) -> str:
    """Checksum of the arrays of an npz, from its table of contents alone. Raises RunFolderError where it is broken."""
    with opened(path) as archive:
        held = [(info.filename, info.CRC, info.file_size) for info in archive.infolist()]
    return f"{zlib.crc32(json.dumps(held).encode()):08x}"


def refuse_broken(path: Path) -> None:
    """Raises RunFolderError where the members of an npz do not match the checksums that it holds."""
    with opened(path) as archive:
        bad = archive.testzip()
        if bad:
            raise ValueError(f"{bad} is broken")


@contextmanager
def understood(path: Path) -> Iterator[None]:
    """Turns errors of interpreting a whole file into RunFolderError, which says that it holds something else."""
    try:
        yield
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        raise RunFolderError(f"{path} does not hold what it should ({error}).") from error


@contextmanager
def opened(path: Path) -> Iterator[zipfile.ZipFile]:
    """An npz to read from; errors of reading it become RunFolderError."""
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
    """(shape, Fortran order, dtype) of a .npy header; cached, because a thousand episodes begin alike."""
    file = io.BytesIO(raw)
    if np.lib.format.read_magic(file) != (1, 0):
        raise ValueError("the npy format is not version 1.0")
    return np.lib.format.read_array_header_1_0(file)


def read_json(path: Path) -> Any:
    """What a JSON file holds. Raises RunFolderError where it is missing or broken, or its CRC32 seal does not fit."""
    try:
        held = json.loads(path.read_text())
    except (OSError, ValueError, RecursionError) as error:
        raise RunFolderError(f"{path} cannot be read ({error}). Restore it from a copy.") from error
    if isinstance(held, dict) and CRC32.key in held and not CRC32.removed(held):
        raise RunFolderError(f"{path} cannot be read (its checksum is another one). Restore it from a copy.")
    return held


def folder_for(path: str | Path) -> Path:
    """A path to make a folder at. Raises ConfigError where a file is in the way."""
    path = place(path)
    file = next((place for place in (path, *path.parents) if place.exists() and not place.is_dir()), None)
    if file:
        raise ConfigError(f"{file} is a file. Name a folder.")
    return path


def write_bytes(path: Path, raw: bytes) -> None:
    """Write bytes as `write_whole` does."""
    write_whole(path, lambda file: file.write(raw))


def write_whole(path: Path, body: Callable[[IO[bytes]], object]) -> None:
    """Write beside, flush, rename: after a crash the file is the old one or the new one. Raises OSError."""
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
    """A label as part of a file's name; a long one is cut to LONGEST bytes and a checksum."""
    name = re.sub(r"[^\w.=-]+", "_", label)
    whole = name.encode()
    return name if len(whole) <= LONGEST else f"{whole[:LONGEST].decode(errors='ignore')}_{zlib.crc32(whole):08x}"


def disk(folder: Path) -> int:
    """Bytes of all files in a folder; a run that goes on may remove one of them meanwhile."""
    size = 0
    for where, _, names in os.walk(folder):
        for name in names:
            with suppress(FileNotFoundError):
                size += Path(where, name).stat().st_size
    return size
