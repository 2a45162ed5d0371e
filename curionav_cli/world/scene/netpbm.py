"""Netpbm images, P1 to P7 (PBM, PGM, PPM, PAM), plain and binary, with comments and any largest value.

Read here because libraries take 255 or 65535 for granted as the largest value, where map tools write 1, 100 or 254.
http://netpbm.sourceforge.net/doc/
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from curionav_cli.errors import MapError
from curionav_cli.world.scene.map_greys import Picture, picture

PIXELS = 10**8  # ten kilometres square at a metre, half a kilometre square at 5 cm
KINDS = (b"P1", b"P2", b"P3", b"P4", b"P5", b"P6", b"P7")
_PLAIN = (b"P1", b"P2", b"P3")
_BITS = (b"P1", b"P4")  # 1 is black
_HEAD = 2**16  # bytes in which the numbers of the header stand
_TOKEN = re.compile(rb"(?:\s|#[^\n]*\n)*(\S+)")
_PIECE = re.compile(rb"(?s).{1,65536}\S*")  # ends where a number does
_COMMENT = re.compile(rb"#[^\n]*")


def read_netpbm(path: Path) -> Picture:
    """Read a Netpbm image. Raises MapError for a file that is cut off or no such image."""
    try:
        with open(path, "rb") as file:
            head = file.read(_HEAD)
            kind = head[:2]
            (columns, rows, channels, most), at = _pam_header(head) if kind == b"P7" else _header(head)
            if min(columns, rows, most) < 1 or columns * rows > PIXELS or most > 65535 or not 1 <= channels <= 4:
                raise ValueError(f"{columns} x {rows} pixels of {channels} channels up to {most}")
            file.seek(at)
            pixels = _pixels(kind, file.read(), (rows, columns, channels), most)
    except ValueError as error:
        raise MapError(f"{path} is cut off or no PGM image ({error}).") from None
    return picture(pixels[..., 0] if channels == 1 else pixels, most, channels in (2, 4))


def _header(head: bytes) -> tuple[tuple[int, int, int, int], int]:
    """Columns, rows, channels and white, and where the pixels begin."""
    kind, at = head[:2], 2
    numbers: list[int] = []
    while len(numbers) < (2 if kind in _BITS else 3):
        found = _TOKEN.match(head, at)
        if found is None:
            raise ValueError("its size is missing")
        numbers.append(int(found.group(1)))
        at = found.end()
    columns, rows, most = (*numbers, 1)[:3]
    return (columns, rows, 3 if kind in (b"P3", b"P6") else 1, most), at + (kind not in _PLAIN)


def _pam_header(head: bytes) -> tuple[tuple[int, int, int, int], int]:
    text, end, _ = head.partition(b"\nENDHDR\n")
    found = dict(line.split(None, 1) for line in text.split(b"\n")[1:] if line.strip() and line[:1] != b"#")
    try:
        columns, rows, channels, most = (int(found[key]) for key in (b"WIDTH", b"HEIGHT", b"DEPTH", b"MAXVAL"))
    except KeyError as error:
        raise ValueError(f"its header lacks {error.args[0].decode()}") from None
    return (columns, rows, channels, most), len(text) + len(end)


def _pixels(kind: bytes, body: bytes, shape: tuple[int, int, int], most: int) -> np.ndarray:
    """(rows, columns, channels) unsigned, 0 black."""
    rows, columns, channels = shape
    if kind == b"P4":
        packed = np.frombuffer(body, np.uint8, rows * -(-columns // 8)).reshape(rows, -1)
        return 1 - np.unpackbits(packed, axis=1, count=columns)[..., None]
    if kind == b"P1":
        bits = np.frombuffer(_COMMENT.sub(b"", body).translate(None, b" \t\r\n\v\f"), np.uint8)
        return (bits[:rows * columns] == ord("0")).view(np.uint8).reshape(shape)
    if kind in _PLAIN:
        return _plain_numbers(body, rows * columns * channels).reshape(shape)
    return np.frombuffer(body, np.dtype(">u2") if most > 255 else np.dtype(np.uint8), rows * columns * channels
                         ).reshape(shape)


def _plain_numbers(body: bytes, count: int) -> np.ndarray:
    """The first `count` of the numbers written out in `body`, (count,) uint16; read piece by piece."""
    if b"#" in body:
        body = _COMMENT.sub(b"", body)
    pixels, done = np.empty(min(count, len(body)), np.uint16), 0
    for piece in _PIECE.finditer(body):
        numbers = np.fromstring(piece[0], np.int64, sep=" ")[:count - done]
        if len(numbers) and numbers.max() > np.iinfo(np.uint16).max:
            raise ValueError(f"a pixel of {numbers.max()}")
        pixels[done:done + len(numbers)] = numbers
        done += len(numbers)
    return pixels[:done]
