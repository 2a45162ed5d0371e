"""Where each attempt begins: the staging pose first, then what the profile's recoveries say.

There is one attempt more than places in PLACES of the recoveries listed in docking.recoveries (conf/robot/): two with
[restage].
"""

from __future__ import annotations

from collections.abc import Iterator

from curionav_cli.robot.docking_settings import ByLight, Recovery

Place = tuple[float, float]  # metres before the dock, metres to its left

# From the staging pose: metres farther out, metres to the dock's left. None: from where the robot stands.
PLACES: dict[Recovery, tuple[Place | None, ...]] = {
    Recovery.rescan: (None,),
    Recovery.back_off: ((0.5, 0.0),),
    Recovery.back_off_far: ((1.0, 0.0),),
    Recovery.sidestep_left: ((0.0, 0.5),),
    Recovery.sidestep_right: ((0.0, -0.5),),
    Recovery.restage: ((0.0, 0.0),),
    Recovery.search: ((0.5, 0.8), (0.5, -0.8), (1.0, 1.2), (1.0, -1.2), (1.5, 0.0)),
}


def attempts(settings: ByLight) -> Iterator[tuple[str, Place | None]]:
    """Yields (name, place) of each attempt: the staging pose, then the places of the recoveries in their order."""
    yield "staging", (settings.staging, 0.0)
    for recovery in settings.recoveries:
        for place in PLACES[recovery]:
            yield recovery.value, (settings.staging + place[0], place[1]) if place else None
