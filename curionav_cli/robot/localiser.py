"""Where the robot believes that it is, from what it sensed. Its frame is the scene's, since the one thing that it
is told is where its dock stands there."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from curionav_cli.records import Pose
from curionav_cli.robot.ekf import BIAS, GYRO_SCALE, SCALE, STATES, Ekf, motion_since
from curionav_cli.robot.measurements import Scan, Sensed
from curionav_cli.robot.ndt_matcher import NdtMap
from curionav_cli.robot.settings import Localisation, Turtlebot

SPEED, RATE = 0.42, 0.3  # m/s and rad/s that a move may have had when a sensor was silent
ANYWHERE = 10.0  # metres
# Where matches are begun from by one that is unsure, and by one that is lost: metres ahead and aside, and radians.
UNSURE, LOST = ((-0.2, -0.1, 0.0, 0.1, 0.2),), ((-0.4, -0.2, 0.0, 0.2, 0.4), (-0.3, 0.0, 0.3), (-0.2, 0.0, 0.2))
BLURRED = 0.08  # metres; a scan is entered into the map where its pose is known better than that
# Of the distance that the wheels rolled when the bumper got pressed, and when it already was: what was driven, and sd.
TOUCHED, PUSHED = (0.3, 0.35), (0.0, 0.1)


class Localiser:
    """pose: estimated. covariance (3, 3): of x, y, yaw. lost: it no longer trusts itself. slips: how often the scans
    did not agree with the wheels. stale: measurements that came late or twice, and were not used."""

    def __init__(self, profile: Turtlebot, pose: Pose):
        self.profile = profile
        self.filter = Ekf(np.array([*pose, 0.0, 0.0, 0.0]), np.zeros((STATES, STATES)))
        self.lost, self.slips, self.stale = False, 0, 0
        self.time, self._scanned, self._bumped = -math.inf, -math.inf, False
        self.depart(pose)

    @property
    def pose(self) -> Pose:
        return Pose(*self.filter.mean[:3].tolist())

    @property
    def covariance(self) -> np.ndarray:
        return self.filter.covariance[:3, :3]

    def update(self, sensed: Sensed, scan: Scan | None = None) -> None:
        """One more move, and what the LiDAR saw after it."""
        if sensed.time <= self.time:
            self.stale += 1
        else:
            self.time = sensed.time
            self._predict(sensed)
        if scan is not None and self.profile.localisation is not Localisation.none:
            self._see(scan)

    def rest(self, sensed: Sensed) -> None:
        """It stood still on its dock: what the gyro says is bias."""
        self.time = max(self.time, sensed.time)
        self.filter.update_rate(sensed.gyro / sensed.seconds, self._gyro_noise(sensed.seconds) / sensed.seconds**2)

    def fix(self, pose: Pose, sd_position: float, sd_yaw: float) -> None:
        """It stands at a known pose, to so many metres and radians: the dock, which cannot be mistaken. Where the
        filter did not think so, it learns that it was too sure."""
        variance = np.diag(np.square([sd_position, sd_position, sd_yaw]))
        while not self.filter.update_pose(np.array(pose), variance, self.profile.filter.gate):
            self._doubt()
        self.lost = False

    def depart(self, pose: Pose) -> None:
        """It leaves the dock, turned round or carried there: of its pose it keeps nothing but where the dock stands;
        the gyro was set to zero there but for a remainder, and the load is another."""
        profile = self.profile
        self.filter.forget()
        self.surfaces = NdtMap()
        self.filter.inflate(ANYWHERE, math.pi)
        self.fix(pose, profile.filter.dock_position, math.radians(profile.filter.dock_yaw))
        self.filter.renew(BIAS, math.radians(profile.gyro.bias))
        self.filter.renew(SCALE, profile.odometry.scale)
        self.filter.renew(GYRO_SCALE, profile.gyro.scale)

    def save(self) -> dict[str, Any]:
        """All that `load` needs, but for the surfaces, which are arrays."""
        return {"mean": self.filter.mean.tolist(), "covariance": self.filter.covariance.tolist(),
                "rejected": self.filter.rejected, "lost": self.lost, "slips": self.slips, "stale": self.stale,
                "bumped": self._bumped, "times": [self.time, self._scanned]}

    def load(self, state: dict[str, Any], surfaces: dict[str, np.ndarray]) -> None:
        self.surfaces.load(surfaces)
        self.filter = Ekf(np.array(state["mean"]), np.array(state["covariance"]))
        self.filter.rejected, (self.time, self._scanned) = state["rejected"], state["times"]
        self.lost, self.slips, self.stale, self._bumped = (state[key] for key in ("lost", "slips", "stale", "bumped"))

    def _predict(self, sensed: Sensed) -> None:
        profile, seconds = self.profile, sensed.seconds
        wheel, gyro = sensed.wheel, sensed.gyro
        distance, turn = profile.odometry.noise**2 * abs(wheel), self._gyro_noise(seconds)
        if math.isnan(wheel):
            wheel, distance = 0.0, (SPEED * seconds) ** 2
        elif sensed.bump is not None:
            share, sd = PUSHED if self._bumped else TOUCHED
            wheel, distance = share * wheel, (sd * wheel) ** 2
        self._bumped = sensed.bump is not None
        if math.isnan(gyro):
            gyro, turn = 0.0, (RATE * seconds) ** 2
        walk = math.radians(profile.gyro.walk) ** 2 * seconds
        self.filter.predict(wheel, gyro, seconds, (distance, turn, walk))

    def _gyro_noise(self, seconds: float) -> float:
        return math.radians(self.profile.gyro.noise) ** 2 * seconds

    def _see(self, scan: Scan) -> None:
        if scan.time <= self._scanned or scan.time < self.time:
            self.stale += 1
            return
        self._scanned = scan.time
        if self.profile.localisation is Localisation.scan_to_map:
            self._lay(scan)
        else:
            if scan.shift is not None and self.filter.has_clone:
                self._weigh(*scan.shift)
            self.filter.clone_pose()

    def _lay(self, scan: Scan) -> None:
        """On the map of this episode, whose origin is the remembered pose of its first scan: what that is off by
        cannot be told from the map."""
        if not self.filter.has_clone:
            self.filter.clone_pose()
        guess = Pose(*motion_since(self.filter.mean))
        blurred = self.filter.spread_since() > BLURRED**2
        around = LOST if self.lost else UNSURE if blurred else ((0.0,),)
        match = self.surfaces.search(guess, scan, *around)
        settings = self.profile.scan_to_map
        floor = np.square([settings.position, settings.position, math.radians(settings.yaw)])
        if match and not match.fits:
            self.filter.rejected += 1
            self._give_up()
            return
        agreed = match is None or self._weigh(np.array(match.pose), match.variance(settings.noise) + np.diag(floor))
        if agreed and self.filter.spread_since() < BLURRED**2:
            self.surfaces.insert(Pose(*motion_since(self.filter.mean)), scan)

    def _weigh(self, motion: np.ndarray, variance: np.ndarray) -> bool:
        """The motion that the scans tell against the one predicted; where they do not agree, the wheels slipped."""
        gate = self.profile.filter.gate
        if self.filter.update_motion(motion, variance, gate):
            self.lost = False
            return True
        self.slips += 1
        self.filter.slip(SPEED * self.profile.step)
        self.filter.rejected -= 1  # a scan counts once
        agreed = self.filter.update_motion(motion, variance, gate)
        self._give_up()
        return agreed

    def _give_up(self) -> None:
        """It is lost when too many scans in a row were refused."""
        if self.filter.rejected >= self.profile.filter.patience:
            self._doubt()
            self.lost = True

    def _doubt(self) -> None:
        settings = self.profile.filter
        self.filter.inflate(settings.lost_position, math.radians(settings.lost_yaw))
        self.filter.rejected = 0
