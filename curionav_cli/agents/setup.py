"""What an agent is made from beside its own settings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from curionav_cli.world.real_floor import RealFloor
    from curionav_cli.world.scene.scene import Scene


@dataclass(frozen=True)
class Setup:
    """The run's settings that concern an agent, and the scene.

    device, compile, engine: values of the settings `device`, `compile` and `env.engine`. scene: for oracles, and for
    metrics that are measured on the true map; its `plan` has the cells. Of a real floor nothing else is known.
    """

    seed: int
    device: str
    compile: str
    engine: str
    scene: Scene | RealFloor
