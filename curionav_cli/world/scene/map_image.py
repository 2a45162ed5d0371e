"""The image of a ROS map: PNG, BMP, JPEG, GIF, TIFF and WebP by Pillow, Netpbm by netpbm.py.

A file whose header claims more pixels than its bytes can hold is refused before memory is allocated: a hundred bytes
of JPEG may claim a gigabyte.
"""

from __future__ import annotations

import struct
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from curionav_cli.errors import MapError
from curionav_cli.world.scene.map_greys import Picture, picture
from curionav_cli.world.scene.netpbm import KINDS, PIXELS, read_netpbm

if TYPE_CHECKING:
    from PIL.ImageFile import ImageFile

FORMATS = ("PNG", "BMP", "JPEG", "GIF", "TIFF", "WEBP")
PACKED = 10_000  # pixels in a byte: deflate's best is 1032 bytes of eight pixels, a JPEG's 512 pixels
COLOURS = np.array([2, 1, 0, 3])  # OpenCV begins with blue
GREY16 = ("I;16", "I;16B", "I;16L")


def read_image(path: Path) -> Picture:
    """Read the first image of a file, in little more memory than twice its pixels.

    Raises MapError for a file that is no image.
    """
    with open(path, "rb") as file:
        if file.read(2) in KINDS:
            return read_netpbm(path)
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of tags unknown to Pillow
            with Image.open(path, formats=FORMATS) as image:
                _refuse_claims(*image.size, path)
                return _decoded(image, path)
    except MapError:
        raise
    except Image.DecompressionBombError:
        raise MapError(f"{path} has more than {PIXELS} pixels; no map is so large.") from None
    except Exception:  # decoders raise every kind of exception for broken files
        raise MapError(f"{path} is no image that can be read: its header or its pixels are broken, or it is none of "
                       f"PGM, PPM, PBM, PAM, {', '.join(FORMATS)}.") from None


def _refuse_claims(columns: int, rows: int, path: Path) -> None:
    """Raise MapError for an image with more pixels than any map has, or than its bytes can hold."""
    size = path.stat().st_size
    if columns * rows > PIXELS:
        raise MapError(f"{path} has more than {PIXELS} pixels; no map is so large.")
    if columns * rows > PACKED * size:
        raise MapError(f"{path} is cut off: {size} bytes for {columns} x {rows} pixels.")


def _decoded(image: ImageFile, path: Path) -> Picture:
    if image.mode in ("I", "F"):
        raise MapError(f"{path} has pixels of 32 bits, whose black and white no map says. Save it with 8 or 16 bits.")
    if image.mode in GREY16:
        return picture(np.asarray(image), 65535)
    if ";16" in str(image.tile):
        return _colours_of_16_bits(path)
    if image.has_transparency_data:
        return picture(np.asarray(image.convert("RGBA")), alpha=True)
    found = picture(np.asarray(image.convert("L" if image.mode in ("1", "L") else "RGB")))
    return Picture(found.grey, _fourth_bytes(path)) if image.format == "BMP" else found


def _colours_of_16_bits(path: Path) -> Picture:
    """By OpenCV: Pillow keeps eight bits of each."""
    import cv2

    pixels = cv2.imdecode(np.fromfile(path, np.uint8), cv2.IMREAD_UNCHANGED)
    if pixels is None:
        raise ValueError("OpenCV reads none")
    return picture(pixels[..., COLOURS[:pixels.shape[2]]], 65535, pixels.shape[2] == 4)


def _fourth_bytes(path: Path) -> np.ndarray | None:
    """Where a BMP of 32 bits is clear: its header does not say whether the fourth byte is alpha; all 0 is none."""
    with open(path, "rb") as file:
        head = file.read(34)
    at, _, columns, rows, _, bits, packed = struct.unpack_from("<IIiiHHI", head, 10)
    if (bits, packed) != (32, 0):
        return None
    alpha = np.fromfile(path, np.uint8, 4 * columns * abs(rows), offset=at)[3::4].reshape(abs(rows), columns)
    return (alpha if rows < 0 else alpha[::-1]) < 255 if alpha.any() else None
