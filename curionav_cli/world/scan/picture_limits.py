"""The limit of a mesh's pictures: their pixels, by their headers."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterable

MOST_PIXELS = 250_000_000  # of all pictures together: three of 8192 x 8192 and more


def refuse_many_pixels(pictures: Iterable[bytes]) -> None:
    """Raise ValueError for pictures that together have more than MOST_PIXELS, or one that has no header to read."""
    from PIL import Image

    total = 0
    for raw in pictures:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                with Image.open(io.BytesIO(raw)) as image:
                    total += image.size[0] * image.size[1]
            except Exception:  # Pillow raises every kind of exception for broken headers
                raise ValueError("one of its pictures is none that can be read, or is far too large") from None
        if total > MOST_PIXELS:
            raise ValueError(f"its pictures have more than {MOST_PIXELS} pixels; make them smaller")
