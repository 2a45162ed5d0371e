"""The estimated pose: an EKF fed with odometry, gyro, scans and the dock.

Its frame is the scene's, because the pose of the dock is given in it.
"""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np

from curionav_cli.records import Pose
from curionav_cli.robot.ekf import BIAS, GYRO_SCALE, SCALE, STATES, Ekf, relative_motion
from curionav_cli.robot.measurements import Reading, Scan
from curionav_cli.robot.ndt_matcher import NdtMap
from curionav_cli.robot.settings import Filter, Gyro, Localisation, Odometry, Turtlebot

SPEED, RATE = 0.42, 0.3  # m/s and rad/s: sd of a move over which a sensor was silent
ANYWHERE = 10.0  # metres: sd of a position before the dock is used
# Starts of scan matching with an uncertain pose, and when lost: metres ahead and aside, and radians.
UNCERTAIN, LOST = ((-0.2, -0.1, 0.0, 0.1, 0.2),), ((-0.4, -0.2, 0.0, 0.2, 0.4), (-0.3, 0.0, 0.3), (-0.2, 0.0, 0.2))
INSERT_SD = 0.08  # metres; a scan is inserted into the map only where the sd of its position is below
# Driven share of the distance that the wheels rolled, and its sd: when the bumper gets pressed, when it already was.
TOUCHED, PUSHED = (0.3, 0.35), (0.0, 0.1)


class Errors(Protocol):
    """The errors of a robot's sensors, as the estimate reckons with them; localisation: what else it uses."""

    @property
    def localisation(self) -> Localisation:
        """What the LiDAR adds."""

    @property
    def odometry(self) -> Odometry:
        """Wheel encoders."""

    @property
    def gyro(self) -> Gyro:
        """The gyro."""

    @property
    def filter(self) -> Filter:
        """The filter's own settings."""


class Localiser:
    """The estimate of a pose and its covariance.

    lost: too many scans in a row were rejected, and none was accepted since. slips: how often scans disagreed with the
    wheels. stale: how many measurements came late or twice and were not used.
    """

    def __init__(self, profile: Errors, pose: Pose):
        self.profile = profile
        self.filter = Ekf(np.array([*pose, 0.0, 0.0, 0.0]), np.zeros((STATES, STATES)))
        self.lost, self.slips, self.stale = False, 0, 0
        self.time, self._scanned, self._bumped = -math.inf, -math.inf, False
        self.leave_dock(pose)

    @property
    def pose(self) -> Pose:
        """The estimated pose: x, y in metres, yaw in radians."""
        return Pose(*self.filter.mean[:3].tolist())

    @property
    def covariance(self) -> np.ndarray:
        """(3, 3) of x, y, yaw."""
        return self.filter.covariance[:3, :3]

    def update(self, reading: Reading, scan: Scan | None = None) -> None:
        """Predict by one move, then update by the scan taken after it."""
        if reading.time <= self.time:
            self.stale += 1
        else:
            self.time = reading.time
            self._predict(reading)
        if scan is not None and self.profile.localisation is not Localisation.none:
            self._use_scan(scan)

    def update_at_rest(self, reading: Reading) -> None:
        """Update the gyro bias while the robot stands still (zero-rate update)."""
        self.time = max(self.time, reading.time)
        variance = self._gyro_noise(reading.seconds) / reading.seconds**2
        self.filter.update_zero_rate(reading.gyro / reading.seconds, variance)

    def update_dock_pose(self, pose: Pose, sd_position: float, sd_yaw: float) -> None:
        """Update by the known pose of the dock, with sd in metres and radians.

        It is never an outlier: the covariance is inflated until the gate accepts it.
        """
        variance = np.diag(np.square([sd_position, sd_position, sd_yaw]))
        while not self.filter.update_pose(np.array(pose), variance, self.profile.filter.gate):
            self._inflate()
        self.lost = False

    def leave_dock(self, pose: Pose) -> None:
        """Start an episode at the dock: the pose comes from the dock alone, the map is empty, and gyro bias and scales
        start from their priors."""
        profile = self.profile
        self.filter.drop_clone()
        self.ndt_map = NdtMap()
        self.filter.inflate(ANYWHERE, math.pi)
        self.update_dock_pose(pose, profile.filter.dock_position, math.radians(profile.filter.dock_yaw))
        self.filter.reset_state(BIAS, math.radians(profile.gyro.bias))
        self.filter.reset_state(SCALE, profile.odometry.scale)
        self.filter.reset_state(GYRO_SCALE, profile.gyro.scale)

    def save(self) -> dict[str, Any]:
        """The state that `load` restores, but for `ndt_map`, which is arrays."""
        return {"mean": self.filter.mean.tolist(), "covariance": self.filter.covariance.tolist(),
                "rejected": self.filter.rejected, "lost": self.lost, "slips": self.slips, "stale": self.stale,
                "bumped": self._bumped, "times": [self.time, self._scanned]}

    def load(self, state: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
        """Restore the state of `save` and the arrays of `ndt_map.save`."""
        self.ndt_map.load(arrays)
        self.filter = Ekf(np.array(state["mean"]), np.array(state["covariance"]))
        self.filter.rejected, (self.time, self._scanned) = state["rejected"], state["times"]
        self.lost, self.slips, self.stale, self._bumped = (state[key] for key in ("lost", "slips", "stale", "bumped"))

    def _predict(self, reading: Reading) -> None:
        profile, seconds = self.profile, reading.seconds
        wheel, gyro = reading.wheel, reading.gyro
        distance, turn = profile.odometry.noise**2 * abs(wheel), self._gyro_noise(seconds)
        if math.isnan(wheel):
            wheel, distance = 0.0, (SPEED * seconds) ** 2
        elif reading.bump is not None:
            share, sd = PUSHED if self._bumped else TOUCHED
            wheel, distance = share * wheel, (sd * wheel) ** 2
        self._bumped = reading.bump is not None
        if math.isnan(gyro):
            gyro, turn = 0.0, (RATE * seconds) ** 2
        walk = math.radians(profile.gyro.walk) ** 2 * seconds
        self.filter.predict(wheel, gyro, seconds, (distance, turn, walk))

    def _gyro_noise(self, seconds: float) -> float:
        return math.radians(self.profile.gyro.noise) ** 2 * seconds

    def _use_scan(self, scan: Scan) -> None:
        if scan.time <= self._scanned or scan.time < self.time:
            self.stale += 1
            return
        self._scanned = scan.time
        if self.profile.localisation is Localisation.scan_to_map:
            self._match_to_map(scan)
        else:
            if scan.shift is not None and self.filter.has_clone:
                self._update_motion(*scan.shift)
            self.filter.clone_pose()

    def _match_to_map(self, scan: Scan) -> None:
        """Match a scan to the map of this episode, whose origin is the cloned pose of its first scan: the error of that
        pose cannot be observed on the map."""
        if not self.filter.has_clone:
            self.filter.clone_pose()
        guess = Pose(*relative_motion(self.filter.mean))
        uncertain = self.filter.relative_position_variance() > INSERT_SD**2
        around = LOST if self.lost else UNCERTAIN if uncertain else ((0.0,),)
        match = self.ndt_map.search(guess, scan, *around)
        assert isinstance(self.profile, Turtlebot)  # no other robot uses scans
        settings = self.profile.scan_to_map
        floor = np.diag(np.square([settings.position, settings.position, math.radians(settings.yaw)]))
        if match and not match.fits:
            self.filter.rejected += 1
            self._check_lost()
            return
        agreed = match is None or self._update_motion(np.array(match.pose), match.variance(settings.noise) + floor)
        if agreed and self.filter.relative_position_variance() < INSERT_SD**2:
            self.ndt_map.insert(Pose(*relative_motion(self.filter.mean)), scan)

    def _update_motion(self, motion: np.ndarray, variance: np.ndarray) -> bool:
        """Update by a motion (3,) since the cloned pose; where the gate rejects it, the wheels slipped."""
        gate = self.profile.filter.gate
        if self.filter.update_motion(motion, variance, gate):
            self.lost = False
            return True
        assert isinstance(self.profile, Turtlebot)
        self.slips += 1
        self.filter.add_slip(SPEED * self.profile.step)
        self.filter.rejected -= 1  # a scan counts once
        agreed = self.filter.update_motion(motion, variance, gate)
        self._check_lost()
        return agreed

    def _check_lost(self) -> None:
        """Inflate the covariance and set `lost` after too many rejections in a row."""
        if self.filter.rejected >= self.profile.filter.patience:
            self._inflate()
            self.lost = True

    def _inflate(self) -> None:
        settings = self.profile.filter
        self.filter.inflate(settings.lost_position, math.radians(settings.lost_yaw))
        self.filter.rejected = 0
