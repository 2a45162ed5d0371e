"""From the pixels of an image to the input of Nav2: a grey of eight bits, and whether a pixel is transparent.

As GraphicsMagick makes it of 16 bits a channel (1.3.40, measured on every grey and colour of 8 bits): a value
goes to 0..65535, colours become luma by Rec. 601, and what is left of a division by 257 is dropped.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LUMA = np.array([299, 587, 114])  # thousandths of red, green, blue: Rec. 601
BLOCK = 2**16  # pixels in one pass, as numpy takes eight bytes for each


@dataclass(frozen=True)
class Picture:
    """A map image. grey (rows, columns) uint8, 0 black, 255 white, row 0 on top.

    clear: (rows, columns) bool, transparent pixels; None where the file has no alpha.
    """

    grey: np.ndarray
    clear: np.ndarray | None = None


def picture(pixels: np.ndarray, most: int = 255, alpha: bool = False) -> Picture:
    """Convert (rows, columns[, channels]) unsigned pixels; most: white; alpha: is the last channel alpha?"""
    if not alpha:
        return Picture(_eight_bits(pixels, most))
    colours = pixels[..., 0] if pixels.shape[2] == 2 else pixels[..., :3]
    return Picture(_eight_bits(colours, most), pixels[..., -1] < most)


def _eight_bits(pixels: np.ndarray, most: int) -> np.ndarray:
    if pixels.ndim == 2 and pixels.dtype == np.uint8 and most == 255:
        return pixels
    grey = np.empty(pixels.shape[:2], np.uint8)
    step = max(1, BLOCK // max(1, pixels.shape[1]))
    for at in range(0, len(grey), step):
        wide = np.minimum(pixels[at:at + step], most).astype(np.int64)
        wide = (wide * 65535 + most // 2) // most
        if wide.ndim == 3:
            wide = (wide @ LUMA + 500) // 1000
        grey[at:at + step] = wide // 257
    return grey
