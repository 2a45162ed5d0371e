"""Images that a robot has seen more than once: a third of an episode's, after turns to and fro and blocked moves.

Networks and hash keys compute each of them once. The results are the same; gradients are summed in another order.
"""

from __future__ import annotations

import numpy as np


def distinct(images: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Index of the first of each set of equal images (U,), and for each of the N images (N, ...) its set (N,)."""
    sets: dict[bytes, int] = {}
    which = np.array([sets.setdefault(image.tobytes(), len(sets)) for image in images], np.int64)
    return np.unique(which, return_index=True)[1], which
