"""The rule that cancels a forward move: something stands in the corridor that the robot would drive through."""

from __future__ import annotations

import numpy as np

from curionav_cli.robot.measurements import Scan


def occupied(scan: Scan, radius: float, length: float) -> bool:
    """Whether a scan shows something that a disc of `radius` metres would touch on a move of `length` metres ahead."""
    ahead, aside = scan.range * np.cos(scan.bearing), np.abs(scan.range * np.sin(scan.bearing))
    inside = (aside < radius) & (ahead > 0.0)
    return bool((ahead[inside] < length + np.sqrt(radius**2 - aside[inside] ** 2)).any())
