"""An extended Kalman filter of a step robot: predict by what wheels and gyro measured, update by what else is known.

States: x, y (m), yaw (rad), gyro bias (rad/s), wheel scale and gyro scale (1 = all of it too much), so that errors
which stay are estimated and not called noise. (Without the last, turns of 180 degrees at once made it too sure: its
normalised error squared was 4.8 and not 3.) `remember` adds the pose of now as three more, which never move, so that
a measured motion since then can be weighed against it exactly. Updates are in Joseph's form.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from scipy.special import gammaincinv

from curionav_cli.geometry import wrapped

X, Y, YAW, BIAS, SCALE, GYRO_SCALE = range(STATES := 6)
CLONED = np.array([X, Y, YAW, BIAS, SCALE, GYRO_SCALE, X, Y, YAW])
X0, Y0, YAW0 = range(STATES, 9)  # the remembered pose


class Ekf:
    """mean (6,) or (9,), covariance square. rejected: updates in a row that the gate refused."""

    def __init__(self, mean: np.ndarray, covariance: np.ndarray):
        self.mean, self.covariance = np.array(mean, np.float64), np.array(covariance, np.float64)
        self.rejected = 0

    def predict(self, wheel: float, gyro: float, seconds: float, variance: tuple[float, float, float]) -> None:
        """One move. variance: of the distance (m^2), of the turn (rad^2), of the bias's walk meanwhile."""
        jacobian, noise = motion_jacobians(self.mean, wheel, gyro, seconds)
        self.mean = motion_model(self.mean, wheel, gyro, seconds)
        self.covariance = jacobian @ self.covariance @ jacobian.T + (noise * variance) @ noise.T

    def update(self, residual: np.ndarray, jacobian: np.ndarray, variance: np.ndarray,
               gate: float | None = None) -> bool:
        """A measurement (m,) minus what was expected of it, its Jacobian (m, n) and its covariance (m, m).

        gate: the share of good measurements to let in. False where it was refused, or was not finite.
        """
        if not np.isfinite(residual).all():
            return False
        cross = self.covariance @ jacobian.T
        weight = np.linalg.inv(jacobian @ cross + variance)
        gain = cross @ weight
        if gate is not None and residual @ weight @ residual > limit(gate, len(residual)):
            self.rejected += 1
            return False
        self.rejected = 0
        self.mean = self.mean + gain @ residual
        self.mean[YAW] = wrapped(self.mean[YAW])
        keep = np.eye(len(self.mean)) - gain @ jacobian
        joseph = keep @ self.covariance @ keep.T + gain @ variance @ gain.T
        self.covariance = 0.5 * (joseph + joseph.T)
        return True

    def update_pose(self, pose: np.ndarray, variance: np.ndarray, gate: float | None = None) -> bool:
        """It stands at pose (3,), to a covariance of (3, 3): the dock, or a match on the map."""
        residual = pose - self.mean[:3]
        residual[YAW] = wrapped(residual[YAW])
        return self.update(residual, np.eye(3, len(self.mean)), variance, gate)

    def update_rate(self, rate: float, variance: float) -> bool:
        """It stands still, and the gyro says `rate` rad/s: the bias."""
        jacobian = np.zeros((1, len(self.mean)))
        jacobian[0, BIAS] = 1.0
        return self.update(np.array([rate - self.mean[BIAS]]), jacobian, np.array([[variance]]))

    def update_motion(self, motion: np.ndarray, variance: np.ndarray, gate: float | None = None) -> bool:
        """It moved by (3,), forward, left and turn as seen from the remembered pose."""
        residual = motion - motion_since(self.mean)
        residual[YAW] = wrapped(residual[YAW])
        return self.update(residual, since_jacobian(self.mean), variance, gate)

    def clone_pose(self) -> None:
        """Keep the pose of now in mind, and forget the one before."""
        self.mean, self.covariance = self.mean[CLONED], self.covariance[CLONED][:, CLONED]

    def spread_since(self) -> float:
        """The variance (m^2) of the position as seen from the remembered pose, both directions together."""
        jacobian = since_jacobian(self.mean)[:2]
        return float(np.trace(jacobian @ self.covariance @ jacobian.T))

    def forget(self) -> None:
        """There is no remembered pose."""
        self.mean, self.covariance = self.mean[:STATES], self.covariance[:STATES, :STATES]

    @property
    def has_clone(self) -> bool:
        return len(self.mean) > STATES

    def renew(self, state: int, sd: float) -> None:
        """A state has become another one, of which only the standard deviation is known."""
        self.mean[state] = 0.0
        self.covariance[state], self.covariance[:, state] = 0.0, 0.0
        self.covariance[state, state] = sd**2

    def slip(self, distance: float) -> None:
        """The wheels rolled up to so many metres that were not driven, in the direction of the heading."""
        way = np.zeros(len(self.mean))
        way[[X, Y]] = distance * math.cos(self.mean[YAW]), distance * math.sin(self.mean[YAW])
        self.covariance += np.outer(way, way)

    def inflate(self, position: float, yaw: float) -> None:
        """Trust the pose less by so many metres and radians."""
        self.covariance[[X, Y, YAW], [X, Y, YAW]] += np.square([position, position, yaw])


@lru_cache
def limit(share: float, dimensions: int) -> float:
    """The squared Mahalanobis distance below which `share` of the good measurements lie."""
    return 2.0 * float(gammaincinv(dimensions / 2.0, share))


def motion_model(mean: np.ndarray, wheel: float, gyro: float, seconds: float) -> np.ndarray:
    """The states after an arc whose chord points half way between the headings before and after."""
    distance, turn = wheel / (1.0 + mean[SCALE]), (gyro - mean[BIAS] * seconds) / (1.0 + mean[GYRO_SCALE])
    heading = mean[YAW] + 0.5 * turn
    after = mean.copy()
    after[X] += distance * math.cos(heading)
    after[Y] += distance * math.sin(heading)
    after[YAW] = wrapped(mean[YAW] + turn)
    return after


def motion_jacobians(mean: np.ndarray, wheel: float, gyro: float, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Of `moved` by the states (n, n), and by distance, turn and bias (n, 3)."""
    shorter, narrower = 1.0 / (1.0 + mean[SCALE]), 1.0 / (1.0 + mean[GYRO_SCALE])
    distance, turn = wheel * shorter, (gyro - mean[BIAS] * seconds) * narrower
    ahead, aside = math.cos(mean[YAW] + 0.5 * turn), math.sin(mean[YAW] + 0.5 * turn)
    by_bias, by_scale = -seconds * narrower, -turn * narrower  # of the turn
    jacobian, noise = np.eye(len(mean)), np.zeros((len(mean), 3))
    jacobian[YAW, BIAS], jacobian[YAW, GYRO_SCALE] = by_bias, by_scale
    for axis, along, across in ((X, ahead, -distance * aside), (Y, aside, distance * ahead)):
        half = 0.5 * across
        jacobian[axis, YAW:STATES] = across, half * by_bias, -distance * shorter * along, half * by_scale
    noise[X], noise[Y] = (ahead, -0.5 * distance * aside, 0.0), (aside, 0.5 * distance * ahead, 0.0)
    noise[YAW, 1] = noise[BIAS, 2] = 1.0
    return jacobian, noise


def motion_since(mean: np.ndarray) -> np.ndarray:
    """Forward, left and turn (3,) from the remembered pose to that of now."""
    dx, dy, cosine, sine = mean[X] - mean[X0], mean[Y] - mean[Y0], math.cos(mean[YAW0]), math.sin(mean[YAW0])
    return np.array([cosine * dx + sine * dy, cosine * dy - sine * dx, wrapped(mean[YAW] - mean[YAW0])])


def since_jacobian(mean: np.ndarray) -> np.ndarray:
    """Of `motion_since` by the states: (3, 9)."""
    forward, left, _ = motion_since(mean)
    cosine, sine = math.cos(mean[YAW0]), math.sin(mean[YAW0])
    jacobian = np.zeros((3, 9))
    jacobian[0, :2], jacobian[0, X0:] = (cosine, sine), (-cosine, -sine, left)
    jacobian[1, :2], jacobian[1, X0:] = (-sine, cosine), (sine, -cosine, -forward)
    jacobian[2, YAW], jacobian[2, YAW0] = 1.0, -1.0
    return jacobian
