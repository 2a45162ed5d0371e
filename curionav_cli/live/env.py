"""A real robot as a Gymnasium environment, with the actions, observations and info of RobotEnv."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from curionav_cli.constants import ACTIONS, FORWARD, LEFT, RIGHT, STEP_LENGTH, TURN_ANGLE
from curionav_cli.errors import RunFailed
from curionav_cli.live.base import LiveBase
from curionav_cli.live.clock import Clock
from curionav_cli.live.dry_run import StandStill
from curionav_cli.live.home import Home, Person
from curionav_cli.live.safety import Displaced, Fault, Geofence
from curionav_cli.live.sensors import Sensors
from curionav_cli.live.settings import Rosbridge
from curionav_cli.live.transport import Transport
from curionav_cli.robot.corridor import occupied
from curionav_cli.robot.depth_camera import DepthCamera
from curionav_cli.robot.occupancy import Occupancy
from curionav_cli.world.env import Observation, actions, observations, step_info
from curionav_cli.world.real_floor import RealFloor
from curionav_cli.world.resets import EpisodeCounter, seed_of

TURNS = {LEFT: TURN_ANGLE, RIGHT: -TURN_ANGLE}
RESUMED = "the run goes on after an interruption"


class LiveRobot(gymnasium.Env[Any, Any]):
    """A real robot on a real floor. A fault stops it, truncates the episode and is noted in `events`.

    info["pose"] is the estimate, as info["estimate"] is: nothing measures the true one. A step is also truncated when
    the battery is down to the reserve. reset returns to the dock or start; it raises RunFailed where the robot does not
    come back within `patience`.
    """

    def __init__(self, floor: RealFloor, settings: Rosbridge, transport: Transport, clock: Clock, person: Person):
        self.floor, self.settings, self.transport, self.clock = floor, settings, transport, clock
        self.action_space, self.observation_space = actions(), observations()
        camera = DepthCamera(floor.fov, floor.camera, floor.agent_height)
        sensors = Sensors(transport, settings.profile, settings.namespace, settings.stale, clock, camera)
        self.base = LiveBase(transport, settings, floor, sensors, clock)
        self.home: Home | StandStill = StandStill(self.base, floor.plan.start) if settings.dry_run else \
            Home(self.base, floor.plan.start, floor.plan.radius, person)
        self.fence = Geofence(floor.plan.start, settings.geofence)
        self.counter = EpisodeCounter("restart")
        self.events: tuple[dict[str, Any], ...] = ()
        self.map = Occupancy()
        self._lost = ""

    def reset(self, *, seed: int | None = None,
              options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        """reset(seed) starts a run where a person has put the robot, or continues the one of `load`; reset() returns
        to the dock or start."""
        seed = seed_of(seed)
        super().reset(seed=seed)
        begins = seed is not None or self.counter.episode < 0
        dock = None
        try:
            self._wait_for_robot(docked=begins)
            if begins and not self._lost:
                self.home.begin()
            else:
                dock = asdict(self.home.come_back(self.map, self._lost))
            self.home.leave()
            self.base.wait_for_view()
        except Fault as fault:
            self.base.halt()
            raise RunFailed(f"The robot does not begin an episode: {fault}. Its wheels were stopped.") from fault
        except BaseException:
            self.base.halt()
            raise
        self._lost, self.events, self.map = "", (), Occupancy()
        self.counter.reset(seed, (options or {}).get("episode"))
        self._look()
        return self._observation(), {**self._info(False), "dock": dock}

    def step(self, action: int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        self.counter.require()
        if action not in ACTIONS:
            raise ValueError(f"action {action!r} is none of 0 forward, 1 left, 2 right")
        collided, truncated = False, False
        try:
            collided = self._forward() if action == FORWARD else self._turn(TURNS[action])
            self.base.wait_for_view()
            self._look()
            truncated = self._battery_low()
        except Fault as fault:
            truncated = True
            self._close_episode(fault)
        except BaseException:
            self.base.halt()
            raise
        return self._observation(), 0.0, False, truncated, self._info(collided)

    def render(self) -> np.ndarray:
        """The newest image, (64, 64, 3) uint8."""
        self.counter.require()
        return self._image.copy()

    def close(self) -> None:
        """Stop the wheels and end the connection."""
        self.base.halt()
        self.transport.close()

    def save(self, folder: Path) -> None:
        """Write where the robot was at the end of an episode, for people: `load` cannot rely on it."""
        state = {"episode": self.counter.episode, "pose": self.base.localiser.pose}
        (folder / "robot.json").write_text(json.dumps(state))

    def load(self, folder: Path) -> None:
        """Continue a run. Where the robot has been since nobody knows: the next reset asks a person to put it back."""
        self._lost = RESUMED

    def _forward(self) -> bool:
        """Drive ahead, unless something is in the way or the geofence is; returns whether that, or a touch, cut it."""
        base = self.base
        base.sensors.bumped()
        if occupied(base.depth(), self.floor.plan.radius, STEP_LENGTH) or self._fenced():
            base.pause()
            return True
        short = base.mover.forward(STEP_LENGTH, base.pause)
        return bool(base.sensors.bumped()) or short

    def _fenced(self) -> bool:
        """Whether the geofence forbids a move ahead; the first time in an episode is noted."""
        forbidden = self.fence.forbids(self.base.localiser.pose, STEP_LENGTH)
        if forbidden and not any(event["what"] == "geofence" for event in self.events):
            self.events += ({"what": "geofence", "metres": self.fence.radius},)
        return forbidden

    def _turn(self, angle: float) -> bool:
        self.base.mover.turn(angle, self.base.pause)
        return False

    def _look(self) -> None:
        """Take the observation that belongs to this step, and put the scan on the map."""
        sensors = self.base.sensors
        self._image, self._depth = sensors.image(), sensors.depth()
        self.map.integrate_scan(self.base.localiser.pose, sensors.around())

    def _close_episode(self, fault: Fault) -> None:
        """Stop, and note why. The step keeps the image before it."""
        self.base.halt()
        self.events += ({"what": "closed", "why": str(fault)},)
        if isinstance(fault, Displaced):
            self._lost = str(fault)

    def _battery_low(self) -> bool:
        share = self.base.sensors.charge()
        low = share is not None and share <= self.settings.reserve
        if low:
            self.events += ({"what": "closed", "why": f"the battery is down to {share:.0%}"},)
        return low

    def _wait_for_robot(self, docked: bool) -> None:
        """Wait until the robot sends all that is needed. Raises Fault after `patience`."""
        base, until = self.base, self.clock.now() + self.settings.patience
        base.allow_darkness(docked and self.home.has_dock)
        while True:
            try:
                base.pause()
                return
            except Displaced as fault:
                self._lost = str(fault)
            except Fault:
                if self.clock.now() > until:
                    raise

    def _observation(self) -> Observation:
        return {"image": self._image.copy(), "depth": self._depth.copy()}

    def _info(self, collided: bool) -> dict[str, Any]:
        pose = self.base.localiser.pose
        return step_info(pose, collided, self.counter.episode) | {"estimate": np.array(pose)}
