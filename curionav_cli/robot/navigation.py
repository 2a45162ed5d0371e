"""Navigation to a pose in the robot's own frame: a global plan on its own map, a local layer on depth.

The robot drives by the agent's moves, 0.25 m and 10 degrees. Before each it takes, among the headings that the depth
camera shows free (those out of its view by the map alone), the one with the least cost to go. It replans periodically,
after a bump, and when no heading is free; without progress it clears the map around itself, and at last is blocked.
"""

from __future__ import annotations

import math
from enum import Enum

import numpy as np

from curionav_cli.constants import STEP_LENGTH, TURN_ANGLE
from curionav_cli.geometry import wrapped
from curionav_cli.records import Pose
from curionav_cli.robot.interface import Base
from curionav_cli.robot.localiser import Localiser
from curionav_cli.robot.occupancy import Occupancy
from curionav_cli.robot.planner import Plan, plan

TICKS = 3  # of one move: it can be cancelled between them
TURNS = np.arange(-17, 19)  # headings that are tried, in steps of 10 degrees from the present one
IN_VIEW = 3  # steps to either side that lie in the depth camera's view
AHEAD = np.array([0.2, 0.4])  # metres along a heading at which the cost to go is read
TURN_COST = 0.01  # metres that a turn of 10 degrees must save
REPLAN_AFTER, STALLED_AFTER = 20, 45  # moves until the next plan; moves without progress
PROGRESS = 0.2  # metres of cost to go
NEAR, FACING = 0.12, math.radians(6.0)  # metres and radians: the goal is reached within these
NEARBY, NEARBY_AFTER = 0.4, 8  # metres that suffice after so many moves without progress
CLEARINGS, CLEAR_RADII = 3, (0.4, 0.6, 1.0)  # how often, and how many metres around, the map is cleared
BACK_OFF = 0.12  # metres back after a bump


class NavStatus(Enum):
    """The state of a navigation goal."""

    driving = "driving"
    arrived = "arrived"
    blocked = "blocked"
    timed_out = "timed_out"


class Navigator:
    """Drives the base to a pose. radius: of the robot, metres; seconds: duration of one move; metres: driven so far.

    ticks: in how many parts a move is made.
    """

    def __init__(self, base: Base, localiser: Localiser, occupancy: Occupancy, radius: float, seconds: float,
                 ticks: int = TICKS):
        self.base, self.localiser, self.map = base, localiser, occupancy
        self.radius, self.seconds, self.ticks = radius, seconds, ticks
        self.metres = 0.0

    def set_goal(self, goal: Pose) -> None:
        """Start towards a new goal, in the robot's frame."""
        self.goal, self.status = goal, NavStatus.driving  # the nearest open place: self.plan.goal
        self._ticks_left = 0  # ticks of the present move
        self._turn_side = 0  # of the turns since the last move ahead, so that it does not turn back and forth
        self._clearings, self._stalled = 0, 0
        self._replan()
        self._best_cost = self._cost()
        pose = self.localiser.pose
        metres = self._best_cost if math.isfinite(self._best_cost) else math.hypot(goal.x - pose.x, goal.y - pose.y)
        self._time_left = 20.0 + 8.0 * metres

    def tick(self) -> NavStatus:
        """Drive a part of a move, choosing a new move where the last one is done; returns the status."""
        if self._ticks_left == 0:
            self._choose_move()
        if self.status is NavStatus.driving:
            self._move()
        return self.status

    def _move(self) -> None:
        distance, turn = self._command
        reading = self.base.drive(distance / self.ticks, turn / self.ticks, self.seconds / self.ticks)
        self.metres += abs(distance) / self.ticks
        self._time_left -= self.seconds / self.ticks
        self._ticks_left -= 1
        bumped = reading.bump is not None and distance > 0.0
        done = self._ticks_left == 0 or bumped
        scan = self.base.scan() if done else None
        self.localiser.update(reading, scan)
        if scan is not None:
            self.map.integrate_scan(self.localiser.pose, scan)
        if bumped:
            self._back_off(str(reading.bump))

    def _back_off(self, side: str) -> None:
        """Mark what was bumped into on the map, and drive back a little."""
        pose = self.localiser.pose
        angle = pose.yaw + {"left": 0.7, "centre": 0.0, "right": -0.7}[side]
        reach = self.radius + 0.5 * self.map.cell
        self.map.mark_occupied(pose.x + reach * math.cos(angle), pose.y + reach * math.sin(angle))
        self._start(-BACK_OFF, 0.0)
        self._until_replan = 0

    def _start(self, distance: float, turn: float) -> None:
        self._command, self._ticks_left = (distance, turn), self.ticks

    def _choose_move(self) -> None:
        """Start the next move, or set the final status."""
        pose = self.localiser.pose
        remaining = math.hypot(self.plan.goal[0] - pose.x, self.plan.goal[1] - pose.y)
        if self._time_left < 0.0:
            self.status = NavStatus.timed_out
        elif remaining < NEAR or (remaining < NEARBY and self._stalled > NEARBY_AFTER):
            self._align(wrapped(self.goal.yaw - pose.yaw))
        elif self._check_progress():
            self._drive_towards(pose, remaining)

    def _align(self, error: float) -> None:
        if abs(error) < FACING:
            self.status = NavStatus.arrived
        else:
            self._start(0.0, max(-TURN_ANGLE, min(TURN_ANGLE, error)))

    def _check_progress(self) -> bool:
        """Replan where that is due; False where navigation ends blocked."""
        self._until_replan -= 1
        if self._until_replan < 0:
            self._replan()
        cost = self._cost()
        self._stalled += 1
        if cost < self._best_cost - PROGRESS:
            self._best_cost, self._stalled = cost, 0
        if not math.isfinite(cost) or self._stalled > STALLED_AFTER:
            return self._clear_map()
        return True

    def _clear_map(self) -> bool:
        """Clear the map around the robot, which may be wrong; False after CLEARINGS times."""
        if self._clearings >= CLEARINGS:
            self.status = NavStatus.blocked
            return False
        pose = self.localiser.pose
        self.map.clear(pose.x, pose.y, CLEAR_RADII[self._clearings])
        self._clearings, self._stalled = self._clearings + 1, 0
        self.map.insert(pose, self.base.scan())
        self._replan()
        self._best_cost = self._cost()
        return True

    def _drive_towards(self, pose: Pose, remaining: float) -> None:
        """Start one move towards the goal, around what depth shows."""
        turn = self._best_heading(pose, remaining)
        if turn is None:
            self._until_replan, self._stalled = 0, self._stalled + STALLED_AFTER // 3
            self._start(0.0, TURN_ANGLE)
        elif turn:
            self._turn_side = 1 if turn > 0 else -1
            self._start(0.0, self._turn_side * TURN_ANGLE)
        else:
            self._turn_side = 0
            self._start(min(STEP_LENGTH, remaining), 0.0)

    def _best_heading(self, pose: Pose, remaining: float) -> int | None:
        """The best heading in steps of 10 degrees to the left of the present one; None where none is open."""
        yaw = pose.yaw + TURNS * TURN_ANGLE
        reach = np.minimum(AHEAD, remaining)[:, None]
        cost = self.plan.at(pose.x + reach * np.cos(yaw), pose.y + reach * np.sin(yaw)).max(axis=0)
        cost = cost + TURN_COST * np.abs(TURNS)
        seen = np.abs(TURNS) <= IN_VIEW
        free = self._free(TURNS[seen] * TURN_ANGLE, min(STEP_LENGTH, remaining))
        cost[seen] = np.where(free, cost[seen], np.inf)
        cost[self._turn_side * TURNS < 0] = np.inf
        best = int(np.argmin(cost))
        return int(TURNS[best]) if math.isfinite(cost[best]) else None

    def _free(self, heading: np.ndarray, distance: float) -> np.ndarray:
        """(H,) bool: does depth show a free corridor along each heading (H,), radians from the present one?"""
        view = self.base.depth()
        at = view.bearing - heading[:, None]  # (H, A)
        ahead, aside = view.range * np.cos(at), view.range * np.sin(at)
        return ~((np.abs(aside) < self.radius) & (ahead > 0.0) & (ahead < distance + self.radius + 0.03)).any(axis=1)

    def _replan(self) -> None:
        self.plan: Plan = plan(self.map, self.goal.x, self.goal.y, self.localiser.pose[:2])
        self._until_replan = REPLAN_AFTER

    def _cost(self) -> float:
        return float(self.plan.at(self.localiser.pose.x, self.localiser.pose.y))
