"""The way home in the robot's own frame: a plan on its own map, a local layer on what depth shows, and patience.

It drives by the agent's two moves, 0.25 m and 10 degrees. At each of them it takes, among the headings that depth shows
free (those out of view by the map alone), the one from which the plan is shortest. It plans again now and then, after
a bump, and when nothing is free; when it gets no nearer it forgets the map around it, and at last gives up.
"""

from __future__ import annotations

import math
from enum import Enum

import numpy as np

from curionav_cli.constants import STEP_LENGTH, TURN_ANGLE
from curionav_cli.geometry import wrapped
from curionav_cli.records import Pose
from curionav_cli.robot.docking.action import Base
from curionav_cli.robot.localiser import Localiser
from curionav_cli.robot.occupancy import Occupancy
from curionav_cli.robot.planner import Plan, plan

TICKS = 3  # of one move: it can be cancelled between them
TURNS = np.arange(-17, 19)  # headings that are tried, in steps of 10 degrees from the present one
SEEN = 3  # steps to either side that the depth camera sees
AHEAD = np.array([0.2, 0.4])  # metres along a heading at which the plan is asked
HESITATION = 0.01  # metres that a turn of 10 degrees must save
FRESH, IDLE = 20, 45  # moves: until the next plan; without progress
PROGRESS = 0.2  # metres
NEAR, FACING = 0.12, math.radians(6.0)  # how well a place is reached
NEARBY, TRIED = 0.4, 8  # metres that will do after so many moves without progress
FORGOTTEN, RADII = 3, (0.4, 0.6, 1.0)  # how often, and how far around, the map is forgotten
BACK = 0.12  # metres back after a bump


class Way(Enum):
    """Where a journey stands."""

    going = "going"
    arrived = "arrived"
    blocked = "blocked"
    late = "late"


class Navigator:
    """Drives the base. radius: the robot's, metres; seconds: of one move."""

    def __init__(self, base: Base, localiser: Localiser, occupancy: Occupancy, radius: float, seconds: float):
        self.base, self.localiser, self.map = base, localiser, occupancy
        self.radius, self.seconds = radius, seconds
        self.metres = 0.0

    def set_out(self, goal: Pose) -> None:
        """A new goal, in the robot's frame."""
        self.goal, self.way = goal, Way.going  # where it leads in the end: self.plan.goal
        self._left = 0  # ticks of the present move
        self._side = 0  # of the turns since the last metre: it does not turn back and forth
        self._forgot, self._idle = 0, 0
        self._replan()
        self._best = self._cost()
        pose = self.localiser.pose
        known = self._best if math.isfinite(self._best) else math.hypot(goal.x - pose.x, goal.y - pose.y)
        self._time = 20.0 + 8.0 * known

    def tick(self) -> Way:
        """A third of a move, or the decision that there is none."""
        if self._left == 0:
            self._decide()
        if self.way is Way.going:
            self._move()
        return self.way

    def _move(self) -> None:
        distance, turn = self._command
        sensed = self.base.drive(distance / TICKS, turn / TICKS, self.seconds / TICKS)
        self.metres += abs(distance) / TICKS
        self._time -= self.seconds / TICKS
        self._left -= 1
        bumped = sensed.bump is not None and distance > 0.0
        done = self._left == 0 or bumped
        scan = self.base.scan() if done else None
        self.localiser.update(sensed, scan)
        if scan is not None:
            self.map.integrate_scan(self.localiser.pose, scan)
        if bumped:
            self._bumped(str(sensed.bump))

    def _bumped(self, side: str) -> None:
        """What depth did not show: it goes into the map, and back a little."""
        pose = self.localiser.pose
        angle = pose.yaw + {"left": 0.7, "centre": 0.0, "right": -0.7}[side]
        reach = self.radius + 0.5 * self.map.cell
        self.map.block(pose.x + reach * math.cos(angle), pose.y + reach * math.sin(angle))
        self._start(-BACK, 0.0)
        self._fresh = 0

    def _start(self, distance: float, turn: float) -> None:
        self._command, self._left = (distance, turn), TICKS

    def _decide(self) -> None:
        """The next move, or the end."""
        pose = self.localiser.pose
        away = math.hypot(self.plan.goal[0] - pose.x, self.plan.goal[1] - pose.y)
        if self._time < 0.0:
            self.way = Way.late
        elif away < NEAR or (away < NEARBY and self._idle > TRIED):
            self._face(wrapped(self.goal.yaw - pose.yaw))
        elif self._watch():
            self._go(pose, away)

    def _face(self, error: float) -> None:
        if abs(error) < FACING:
            self.way = Way.arrived
        else:
            self._start(0.0, max(-TURN_ANGLE, min(TURN_ANGLE, error)))

    def _watch(self) -> bool:
        """Plan anew where that is due; False where the journey ends."""
        self._fresh -= 1
        if self._fresh < 0:
            self._replan()
        cost = self._cost()
        self._idle += 1
        if cost < self._best - PROGRESS:
            self._best, self._idle = cost, 0
        if not math.isfinite(cost) or self._idle > IDLE:
            return self._forget()
        return True

    def _forget(self) -> bool:
        """The map around may be wrong; False where forgetting it has not helped."""
        if self._forgot >= FORGOTTEN:
            self.way = Way.blocked
            return False
        pose = self.localiser.pose
        self.map.forget(pose.x, pose.y, RADII[self._forgot])
        self._forgot, self._idle = self._forgot + 1, 0
        self.map.insert(pose, self.base.scan())
        self._replan()
        self._best = self._cost()
        return True

    def _go(self, pose: Pose, away: float) -> None:
        """One move towards the goal, around what depth shows."""
        turn = self._heading(pose, away)
        if turn is None:
            self._fresh, self._idle = 0, self._idle + IDLE // 3
            self._start(0.0, TURN_ANGLE)
        elif turn:
            self._side = 1 if turn > 0 else -1
            self._start(0.0, self._side * TURN_ANGLE)
        else:
            self._side = 0
            self._start(min(STEP_LENGTH, away), 0.0)

    def _heading(self, pose: Pose, away: float) -> int | None:
        """The best heading in steps of 10 degrees to the left of the present one; None where none is open."""
        yaw = pose.yaw + TURNS * TURN_ANGLE
        reach = np.minimum(AHEAD, away)[:, None]
        cost = self.plan.at(pose.x + reach * np.cos(yaw), pose.y + reach * np.sin(yaw)).max(axis=0)
        cost = cost + HESITATION * np.abs(TURNS)
        seen = np.abs(TURNS) <= SEEN
        cost[seen] = np.where(self._free(TURNS[seen] * TURN_ANGLE, min(STEP_LENGTH, away)), cost[seen], np.inf)
        cost[self._side * TURNS < 0] = np.inf
        best = int(np.argmin(cost))
        return int(TURNS[best]) if math.isfinite(cost[best]) else None

    def _free(self, heading: np.ndarray, distance: float) -> np.ndarray:
        """(H,) bool: does depth show room for a move along each heading (H,), radians from the present one?"""
        view = self.base.depth()
        at = view.bearing - heading[:, None]  # (H, A)
        ahead, aside = view.range * np.cos(at), view.range * np.sin(at)
        return ~((np.abs(aside) < self.radius) & (ahead > 0.0) & (ahead < distance + self.radius + 0.03)).any(axis=1)

    def _replan(self) -> None:
        self.plan: Plan = plan(self.map, self.goal.x, self.goal.y, self.localiser.pose[:2])
        self._fresh = FRESH

    def _cost(self) -> float:
        return float(self.plan.at(self.localiser.pose.x, self.localiser.pose.y))
