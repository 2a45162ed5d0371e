"""Extended Kalman filter: odometry and gyro prediction; dock, scan-match and zero-rate updates.

States: x, y (m), yaw (rad), gyro bias (rad/s), errors of wheel scale and gyro scale (shares), so that systematic errors
are estimated and not treated as noise. Without the gyro scale the filter was overconfident after turns of 180 degrees
(normalised estimation error squared 4.8, expected 3). `clone_pose` appends a copy of the pose as three static states,
so that each motion measured since then is used exactly once (stochastic cloning, Roumeliotis and Burdick 2002). Updates
are in Joseph form.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from scipy.special import gammaincinv

from curionav_cli.geometry import wrapped

X, Y, YAW, BIAS, SCALE, GYRO_SCALE = range(STATES := 6)
CLONED = np.array([X, Y, YAW, BIAS, SCALE, GYRO_SCALE, X, Y, YAW])
X0, Y0, YAW0 = range(STATES, 9)  # the cloned pose


class Ekf:
    """An extended Kalman filter: mean (6,), or (9,) with a cloned pose, covariance (6, 6) or (9, 9).

    The module's docstring has the states' order and units. rejected: measurements rejected in a row.
    """

    def __init__(self, mean: np.ndarray, covariance: np.ndarray):
        self.mean, self.covariance = np.array(mean, np.float64), np.array(covariance, np.float64)
        self.rejected = 0

    def predict(self, wheel: float, gyro: float, seconds: float, variance: tuple[float, float, float]) -> None:
        """Predict one move. wheel: metres; gyro: radians; variance: of distance (m^2), turn (rad^2), bias walk."""
        jacobian, noise = motion_jacobians(self.mean, wheel, gyro, seconds)
        self.mean = motion_model(self.mean, wheel, gyro, seconds)
        self.covariance = jacobian @ self.covariance @ jacobian.T + (noise * variance) @ noise.T

    def update(self, residual: np.ndarray, jacobian: np.ndarray, variance: np.ndarray,
               gate: float | None = None) -> bool:
        """Update by a residual (m,), measurement minus prediction, its Jacobian (m, n) and covariance (m, m).

        gate: the share of good measurements to accept. Returns False for a rejected measurement or one that is not
        finite.
        """
        if not np.isfinite(residual).all():
            return False
        cross = self.covariance @ jacobian.T
        weight = np.linalg.inv(jacobian @ cross + variance)
        gain = cross @ weight
        if gate is not None and residual @ weight @ residual > chi_square_bound(gate, len(residual)):
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
        """Update by a measured pose (3,) with covariance (3, 3)."""
        residual = pose - self.mean[:3]
        residual[YAW] = wrapped(residual[YAW])
        return self.update(residual, np.eye(3, len(self.mean)), variance, gate)

    def update_zero_rate(self, rate: float, variance: float) -> bool:
        """Update the bias by a gyro rate (rad/s) measured at rest, with its variance."""
        jacobian = np.zeros((1, len(self.mean)))
        jacobian[0, BIAS] = 1.0
        return self.update(np.array([rate - self.mean[BIAS]]), jacobian, np.array([[variance]]))

    def update_motion(self, motion: np.ndarray, variance: np.ndarray, gate: float | None = None) -> bool:
        """Update by a motion (3,), forward, left and turn in the frame of the cloned pose, with covariance (3, 3)."""
        residual = motion - relative_motion(self.mean)
        residual[YAW] = wrapped(residual[YAW])
        return self.update(residual, relative_motion_jacobian(self.mean), variance, gate)

    def clone_pose(self) -> None:
        """Append a copy of the present pose to the state, replacing the previous one."""
        self.mean, self.covariance = self.mean[CLONED], self.covariance[CLONED][:, CLONED]

    def relative_position_variance(self) -> float:
        """The variance (m^2) of the position relative to the cloned pose, summed over both axes."""
        jacobian = relative_motion_jacobian(self.mean)[:2]
        return float(np.trace(jacobian @ self.covariance @ jacobian.T))

    def drop_clone(self) -> None:
        """Marginalise the cloned pose out."""
        self.mean, self.covariance = self.mean[:STATES], self.covariance[:STATES, :STATES]

    @property
    def has_clone(self) -> bool:
        """True after `clone_pose`."""
        return len(self.mean) > STATES

    def reset_state(self, state: int, sd: float) -> None:
        """Restart a state from a prior: mean 0, standard deviation `sd`, no correlation."""
        self.mean[state] = 0.0
        self.covariance[state], self.covariance[:, state] = 0.0, 0.0
        self.covariance[state, state] = sd**2

    def add_slip(self, distance: float) -> None:
        """Add the uncertainty of `distance` metres of wheel slip along the heading."""
        way = np.zeros(len(self.mean))
        way[[X, Y]] = distance * math.cos(self.mean[YAW]), distance * math.sin(self.mean[YAW])
        self.covariance += np.outer(way, way)

    def inflate(self, position: float, yaw: float) -> None:
        """Add variance to the pose: sd in metres and radians."""
        self.covariance[[X, Y, YAW], [X, Y, YAW]] += np.square([position, position, yaw])


@lru_cache
def chi_square_bound(share: float, dimensions: int) -> float:
    """The quantile `share` of the chi-square distribution: a bound on squared Mahalanobis distances."""
    return 2.0 * float(gammaincinv(dimensions / 2.0, share))


def motion_model(mean: np.ndarray, wheel: float, gyro: float, seconds: float) -> np.ndarray:
    """The state after one move: an arc whose chord points half way between the headings before and after."""
    distance, turn = wheel / (1.0 + mean[SCALE]), (gyro - mean[BIAS] * seconds) / (1.0 + mean[GYRO_SCALE])
    heading = mean[YAW] + 0.5 * turn
    after = mean.copy()
    after[X] += distance * math.cos(heading)
    after[Y] += distance * math.sin(heading)
    after[YAW] = wrapped(mean[YAW] + turn)
    return after


def motion_jacobians(mean: np.ndarray, wheel: float, gyro: float, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """The Jacobians of `motion_model` by the state (n, n), and by distance, turn and bias (n, 3)."""
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


def relative_motion(mean: np.ndarray) -> np.ndarray:
    """Forward, left and turn (3,) from the cloned pose to the present one."""
    dx, dy, cosine, sine = mean[X] - mean[X0], mean[Y] - mean[Y0], math.cos(mean[YAW0]), math.sin(mean[YAW0])
    return np.array([cosine * dx + sine * dy, cosine * dy - sine * dx, wrapped(mean[YAW] - mean[YAW0])])


def relative_motion_jacobian(mean: np.ndarray) -> np.ndarray:
    """The Jacobian of `relative_motion` by the state: (3, 9)."""
    forward, left, _ = relative_motion(mean)
    cosine, sine = math.cos(mean[YAW0]), math.sin(mean[YAW0])
    jacobian = np.zeros((3, 9))
    jacobian[0, :2], jacobian[0, X0:] = (cosine, sine), (-cosine, -sine, left)
    jacobian[1, :2], jacobian[1, X0:] = (-sine, cosine), (sine, -cosine, -forward)
    jacobian[2, YAW], jacobian[2, YAW0] = 1.0, -1.0
    return jacobian
