"""The level pinhole camera that boxes and scans share: square images, rays one metre deep."""

from __future__ import annotations

import numpy as np

SIDES = 64, 512  # pixels: the least and the most; an odd number has a row of level rays, which meet no floor


def offsets(fov: float, side: int) -> tuple[float, np.ndarray]:
    """The tangent of half the field of view (fov, degrees), and (side,) float64: of each column's rays the metres to
    the right per metre of depth; of each row's, downwards."""
    tangent = float(np.tan(np.radians(fov) / 2.0))
    return tangent, tangent * ((np.arange(side) + 0.5) / (side / 2) - 1.0)


def check_side(side: object) -> int:
    """The side of an image in pixels. Raises ValueError unless it is an even integer within SIDES."""
    least, most = SIDES
    if not isinstance(side, int | np.integer) or isinstance(side, bool) or not least <= side <= most or side % 2:
        raise ValueError(f"size, the side of the images in pixels, must be an even integer from {least} to {most}, "
                         f"not {side!r}.")
    return int(side)
