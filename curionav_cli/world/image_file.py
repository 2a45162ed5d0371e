"""The image of a ROS map: PGM (P2, P5, with comments), PNG, BMP and JPEG.

Pixels stay as small as they are in the file, and a file that says it holds more than it can is refused before memory
is taken for it: a hundred bytes of JPEG may claim a gigabyte.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from curionav_cli.errors import MapError

PNG = b"\x89PNG\r\n\x1a\n"
PIXELS = 10**8  # ten kilometres square at a metre, half a kilometre square at 5 cm
PACKED = 10_000  # pixels in a byte: deflate's best is 1032 bytes of eight pixels, a JPEG's 512 pixels
HEAD = 2**16  # bytes in which a PGM's three numbers stand
_TOKEN = re.compile(rb"(?:\s|#[^\n]*\n)*(\S+)")
_PIECE = re.compile(rb"(?s).{1,65536}\S*")  # ends where a number does


@dataclass(frozen=True)
class Picture:
    """level (rows, columns) unsigned: the colours of a pixel added up, 0 black, `white` white, row 0 on top.

    alpha: (rows, columns) unsigned, `opaque` where nothing shines through; None where the file has none.
    """

    level: np.ndarray
    white: int
    alpha: np.ndarray | None = None
    opaque: int = 0


def read_image(path: Path) -> Picture:
    """Takes little more memory than twice the pixels. Raises MapError for a file that is no image."""
    with open(path, "rb") as file:
        plain = file.read(2)
    if plain in (b"P2", b"P5"):
        return _pgm(path, plain == b"P2")
    pixels = _decoded(path)
    most, channels = 255 if pixels.dtype == np.uint8 else 65535, 1 if pixels.ndim == 2 else pixels.shape[2]
    if channels == 1:
        return Picture(pixels.reshape(pixels.shape[:2]), most)
    colours = channels - (channels in (2, 4))
    level = pixels[..., :colours].sum(axis=2, dtype=np.uint16 if most == 255 else np.uint32)
    return Picture(level, colours * most, pixels[..., -1].copy() if colours < channels else None, most)


def _decoded(path: Path) -> np.ndarray:
    """(rows, columns) or (rows, columns, channels) uint8 or uint16; the file's bytes are given back."""
    raw = path.read_bytes()
    _refuse_claims(raw, path)
    import cv2

    try:
        pixels = cv2.imdecode(np.frombuffer(raw, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        pixels = None
    if pixels is None or pixels.dtype not in (np.uint8, np.uint16):
        raise MapError(f"{path} is no image that can be read: it is cut off or broken.")
    return pixels


def _refuse_claims(raw: bytes, path: Path) -> None:
    """Raises MapError for what is no PNG, BMP or JPEG, and for one that says it has more pixels than it can have."""
    try:
        columns, rows = declared_size(raw)
    except struct.error:
        raise MapError(f"{path} is no image that can be read. A ROS map has a PGM, PNG, BMP or JPEG image.") from None
    if columns * rows > PIXELS:
        raise MapError(f"{path} has more than {PIXELS} pixels; no map is so large.")
    if columns * rows > PACKED * len(raw):
        raise MapError(f"{path} is cut off: {len(raw)} bytes for {columns} x {rows} pixels.")


def declared_size(raw: bytes) -> tuple[int, int]:
    """Columns and rows of a PNG, BMP or JPEG, from its header. Raises struct.error where there is none."""
    if raw[:8] == PNG:
        return struct.unpack_from(">II", raw, 16)
    if raw[:2] == b"BM":
        old = struct.unpack_from("<I", raw, 14) == (12,)
        columns, rows = struct.unpack_from("<HH" if old else "<ii", raw, 18)
        return abs(columns), abs(rows)
    at = 2 if raw[:2] == b"\xff\xd8" else len(raw)
    while True:  # the segments of a JPEG up to that of its frame
        mark, kind, length, _, rows, columns = struct.unpack_from(">BBHBHH", raw, at)
        if mark != 0xFF or length < 2:
            raise struct.error("no JPEG")
        if 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):
            return columns, rows
        at += 2 + length


def _pgm(path: Path, plain: bool) -> Picture:
    """Netpbm grey, plain or binary, 8 or 16 bits. http://netpbm.sourceforge.net/doc/pgm.html"""
    try:
        with open(path, "rb") as file:
            (columns, rows, most), at = _three_numbers(file.read(HEAD))
            file.seek(at + (not plain))
            body = file.read()
        if min(columns, rows, most) < 1 or columns * rows > PIXELS or most > 65535:
            raise ValueError(f"{columns} x {rows} pixels up to {most}")
        if plain:
            pixels = _plain_numbers(body, columns * rows)
        else:
            pixels = np.frombuffer(body, np.dtype(">u2") if most > 255 else np.dtype(np.uint8), columns * rows)
        return Picture(pixels.reshape(rows, columns), most)
    except ValueError as error:
        raise MapError(f"{path} is cut off or no PGM image ({error}).") from None


def _three_numbers(head: bytes) -> tuple[list[int], int]:
    """Columns, rows and white, and where the last of them ends."""
    numbers: list[int] = []
    at = 2
    while len(numbers) < 3:
        found = _TOKEN.match(head, at)
        if found is None:
            raise ValueError("its size is missing")
        numbers.append(int(found.group(1)))
        at = found.end()
    return numbers, at


def _plain_numbers(body: bytes, count: int) -> np.ndarray:
    """The first `count` of the numbers written out in `body`, (count,) uint16; read piece by piece."""
    if b"#" in body:
        body = re.sub(rb"#[^\n]*", b"", body)
    pixels, done = np.empty(min(count, len(body)), np.uint16), 0
    for piece in _PIECE.finditer(body):
        numbers = np.fromstring(piece[0], np.int64, sep=" ")[:count - done]
        if len(numbers) and numbers.max() > np.iinfo(np.uint16).max:
            raise ValueError(f"a pixel of {numbers.max()}")
        pixels[done:done + len(numbers)] = numbers
        done += len(numbers)
    return pixels[:done]
