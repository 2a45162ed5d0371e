"""What an agent may be made from, beside its own settings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from curionav_cli.world.scene.scene import Scene


@dataclass(frozen=True)
class Setup:
    """device, compile, engine: as the settings of these names say. scene: for oracles, and for what is measured on the
    true map; its `plan` has the cells."""

    seed: int
    device: str
    compile: str
    engine: str
    scene: Scene
