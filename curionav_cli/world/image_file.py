"""The image of a ROS map: PGM (P2, P5, with comments) and whatever OpenCV reads."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from curionav_cli.errors import MapError

PNG = b"\x89PNG\r\n\x1a\n"
PIXELS = 10**8  # ten kilometres square at a metre, half a kilometre square at 5 cm
_TOKEN = re.compile(rb"(?:\s|#[^\n]*\n)*(\S+)")


def read_image(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    """Shade (rows, columns) float64 in [0, 1], 1 white, row 0 on top; alpha likewise, or None.

    Raises MapError for a file that is no image.
    """
    raw = path.read_bytes()
    if raw[:2] in (b"P2", b"P5"):
        return _pgm(raw, path), None
    import cv2

    if raw[:8] == PNG and int.from_bytes(raw[16:20], "big") * int.from_bytes(raw[20:24], "big") > PIXELS:
        raise MapError(f"{path} has more than {PIXELS} pixels; no map is so large.")
    pixels = cv2.imdecode(np.frombuffer(raw, np.uint8), cv2.IMREAD_UNCHANGED) if raw else None
    if pixels is None:
        raise MapError(f"{path} is no image that can be read. A ROS map has a PGM or PNG image.")
    scaled = pixels.reshape(*pixels.shape[:2], -1) / (65535.0 if pixels.dtype == np.uint16 else 255.0)
    channels = scaled.shape[2]
    alpha = scaled[..., -1] if channels in (2, 4) else None
    return scaled[..., :channels - (alpha is not None)].mean(axis=2), alpha


def _pgm(raw: bytes, path: Path) -> np.ndarray:
    """Netpbm grey, plain or binary, 8 or 16 bits. http://netpbm.sourceforge.net/doc/pgm.html"""
    try:
        numbers: list[int] = []
        at = 2
        while len(numbers) < 3:
            found = _TOKEN.match(raw, at)
            assert found is not None
            numbers.append(int(found.group(1)))
            at = found.end()
        columns, rows, most = numbers
        if raw[:2] == b"P2":
            body = re.sub(rb"#[^\n]*", b"", raw[at:])
            pixels = np.array(body.split(), np.int64)[:rows * columns]
        else:
            wide = np.dtype(">u2") if most > 255 else np.dtype(np.uint8)
            pixels = np.frombuffer(raw, wide, rows * columns, at + 1)
        return pixels.reshape(rows, columns) / float(most)
    except (AssertionError, ValueError, ZeroDivisionError) as error:
        raise MapError(f"{path} is cut off or no PGM image ({error}).") from None
