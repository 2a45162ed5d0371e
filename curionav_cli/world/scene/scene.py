"""A scene, frozen: boxes, reachable cells, start, and its changes between episodes. No rendering.

`Scene.from_dict` reads a file of conf/env (its lists: scene_format.py); `Scene.at` is one episode's scene.
Collision and coverage need only `plan`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from curionav_cli.records import FloorPlan, Pose
from curionav_cli.world.scene import dynamics
from curionav_cli.world.scene.boxes import FIXED, Boxes
from curionav_cli.world.scene.builder import construct
from curionav_cli.world.scene.ground import Ground
from curionav_cli.world.scene.reachability import clear_cells, component
from curionav_cli.world.scene.scene_format import Light, Move

if TYPE_CHECKING:
    from curionav_cli.world.scan.site import ScanView


@dataclass(frozen=True)
class Scene:
    """A scene; lengths in metres.

    plan.visitable: what can be reached when everything that moves is taken away. In the scene of an
    episode (`at`) it is what can be reached in that episode, a subset.
    """

    name: str
    source: str
    size: tuple[float, float]
    height: float
    camera: float
    fov: float  # degrees, horizontal and vertical
    agent_height: float
    collision: str
    plan: FloorPlan
    boxes: Boxes
    ground: Ground
    lamps: tuple[tuple[float, float], ...]
    dock: Pose
    note: str = ""
    brightness: float = 1.0
    light: Light = field(default_factory=Light)
    moves: tuple[Move, ...] = ()
    items: tuple[dynamics.Item, ...] = ()
    view: ScanView | None = None  # of a scan: what draws it, in place of the boxes

    @classmethod
    def from_dict(cls, raw: dict[str, Any], source: str = "scene") -> Scene:
        """Build the scene that a plain dict describes. Raises SceneError or MapError naming `source`."""
        return cls(**construct(raw, source))

    @property
    def start_heading(self) -> int:
        """The heading of the start, in steps of 10 degrees."""
        return round(math.degrees(self.plan.start.yaw) / 10.0) % 36

    @property
    def changing(self) -> bool:
        """True when light or furniture change between episodes."""
        return bool(self.moves) or bool(self.light.drift) or bool(self.light.sigma)

    def at(self, episode: int, seed: int) -> tuple[Scene, tuple[dict[str, Any], ...]]:
        """The scene in an episode of run `seed`, and the changes since the previous episode, as dicts."""
        if not self.changing:
            return self, ()
        boxes = self.boxes
        events: list[dict[str, Any]] = []
        for number, move in enumerate(self.moves):
            which = next(i for i, item in enumerate(self.items) if item.name == move.item)
            first = self.items[which].first
            now = dynamics.place(self.items[which], move, number, episode, seed)
            before = dynamics.place(self.items[which], move, number, max(episode - 1, 0), seed)
            boxes = boxes.moved(which, now[0] - first[0], now[1] - first[1])
            if now != before:
                events.append({"what": "move", "item": move.item, "from": list(before), "to": list(now)})
        brightness = dynamics.brightness(self.light, episode, seed)
        if self.light != Light():
            events.append({"what": "light", "brightness": brightness})
        return replace(self, boxes=boxes, brightness=brightness, plan=self._plan(boxes)), tuple(events)

    def _plan(self, boxes: Boxes) -> FloorPlan:
        """The cells that can be reached around these boxes, among those of this scene."""
        solid = boxes.solid(self.agent_height) & (boxes.item != FIXED)
        clear = self.plan.visitable & clear_cells(
            boxes.low[solid, :2], boxes.high[solid, :2], self.size, self.plan.cell, self.plan.radius)
        row, column = self.plan.cells(np.array(self.plan.start.x), np.array(self.plan.start.y))
        return replace(self.plan, visitable=component(clear, int(row), int(column)))
