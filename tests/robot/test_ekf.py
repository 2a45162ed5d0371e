"""The filter: its Jacobians against finite differences, its updates against what they must do."""

import numpy as np
import pytest

from curionav_cli.robot.ekf import (
    BIAS,
    GYRO_SCALE,
    SCALE,
    YAW,
    Ekf,
    chi_square_bound,
    motion_jacobians,
    motion_model,
    relative_motion,
    relative_motion_jacobian,
)

MEAN = np.array([1.2, -0.7, 0.9, 0.01, 0.03, -0.02])
LONG = np.concatenate([MEAN, [0.8, -0.5, 0.3]])


def slope(function, at, step=1e-6):
    """Central differences of a vector function: (m, n)."""
    nudges = step * np.eye(len(at))
    return np.stack([(function(at + nudge) - function(at - nudge)) / (2 * step) for nudge in nudges], axis=1)


@pytest.mark.parametrize("mean", [MEAN, LONG], ids=["own", "with a cloned pose"])
@pytest.mark.parametrize(("wheel", "gyro", "seconds"), [(0.25, 0.0, 0.6), (0.0, -0.17, 0.6), (-0.1, 0.3, 0.1)])
def test_the_jacobians_of_a_move_are_its_derivatives(mean, wheel, gyro, seconds):
    by_state, by_noise = motion_jacobians(mean, wheel, gyro, seconds)
    assert by_state == pytest.approx(slope(lambda m: motion_model(m, wheel, gyro, seconds), mean), abs=1e-8)
    distance = wheel / (1 + mean[SCALE])

    def noisy(noise):  # distance and turn of the robot itself, and the bias after the move
        after = motion_model(mean, (distance + noise[0]) * (1 + mean[SCALE]), gyro + noise[1] * (1 + mean[GYRO_SCALE]),
                             seconds)
        after[BIAS] += noise[2]
        return after
    assert by_noise == pytest.approx(slope(noisy, np.zeros(3)), abs=1e-8)


def test_the_jacobian_of_a_scan_to_scan_motion_is_its_derivative():
    assert relative_motion_jacobian(LONG) == pytest.approx(slope(relative_motion, LONG), abs=1e-8)


def test_a_wrong_jacobian_would_be_seen():
    by_state, _ = motion_jacobians(MEAN, 0.25, 0.1, 0.6)
    by_state[0, BIAS] = 0.0  # as if the heading did not depend on the bias half way through the move
    assert by_state != pytest.approx(slope(lambda m: motion_model(m, 0.25, 0.1, 0.6), MEAN), abs=1e-8)


def test_the_bound_of_the_gate_is_the_chi_square_quantile():
    assert chi_square_bound(0.997, 3) == pytest.approx(13.931, abs=1e-3)  # tables of the chi-square distribution
    assert chi_square_bound(0.95, 2) == pytest.approx(5.991, abs=1e-3)


def start(sd=(0.1, 0.1, 0.05, 1e-4, 0.01, 0.003), mean=MEAN):
    return Ekf(mean, np.diag(np.square(sd)))


def test_an_update_of_a_pose_is_the_weighted_mean():
    ekf = Ekf(np.zeros(6), np.diag([0.04, 0.04, 0.01, 1e-6, 1e-4, 1e-5]))
    assert ekf.update_pose(np.array([0.3, -0.3, 0.2]), np.diag([0.04, 0.01, 0.03]))
    assert ekf.mean[:3] == pytest.approx([0.15, -0.24, 0.05])
    assert np.diag(ekf.covariance)[:3] == pytest.approx([0.02, 0.008, 0.0075])


@pytest.mark.parametrize("yaw", [np.pi - 0.01, -np.pi + 0.01])
def test_a_yaw_across_the_seam_is_near(yaw):
    ekf = start(mean=np.array([0, 0, yaw, 0, 0, 0]))
    ekf.predict(0.25, np.sign(yaw) * 0.03, 0.6, (1e-4, 1e-6, 1e-12))
    assert ekf.mean[YAW] == pytest.approx(-np.sign(yaw) * (np.pi - 0.02), abs=1e-3)
    before = ekf.mean[YAW]
    assert ekf.update_pose(np.array([*ekf.mean[:2], yaw]), np.diag([0.01, 0.01, 1e-6]), gate=0.997)
    assert abs(np.angle(np.exp(1j * (ekf.mean[YAW] - yaw)))) < 0.001 < abs(before - yaw)


def test_an_outlier_is_rejected_by_the_gate_alone():
    far, variance = np.array([9.0, 9.0, 0.0]), 0.01 * np.eye(3)
    gated, open_to_all = start(), start()
    assert not gated.update_pose(far, variance, gate=0.997) and gated.rejected == 1
    assert gated.mean == pytest.approx(MEAN) and open_to_all.update_pose(far, variance)
    assert open_to_all.mean[0] > 4.0


def test_a_measurement_that_is_not_a_number_changes_nothing():
    ekf = start()
    before = ekf.mean.copy(), ekf.covariance.copy()
    assert not ekf.update_pose(np.array([1.0, np.nan, 0.0]), np.eye(3)) and ekf.rejected == 0
    assert not ekf.update_zero_rate(np.inf, 1e-6)
    assert np.array_equal(ekf.mean, before[0]) and np.array_equal(ekf.covariance, before[1])


def test_the_cloned_pose_stays_where_it_was():
    ekf = start()
    ekf.clone_pose()
    assert relative_motion(ekf.mean) == pytest.approx([0, 0, 0])
    ekf.predict(0.25, 0.0, 0.6, (1e-4, 1e-6, 1e-12))
    turn = -0.006 / 0.98
    expected = [0.25 / 1.03 * np.cos(turn / 2), 0.25 / 1.03 * np.sin(turn / 2), turn]
    assert relative_motion(ekf.mean) == pytest.approx(expected, abs=1e-9)
    spread = relative_motion_jacobian(ekf.mean) @ ekf.covariance @ relative_motion_jacobian(ekf.mean).T
    assert spread[0, 0] == pytest.approx(1e-4 + (0.25 / 1.03**2 * 0.01) ** 2, rel=0.02), "that of the clone cancels"
    ekf.clone_pose()
    assert ekf.mean.shape == (9,) and ekf.covariance.shape == (9, 9)


def test_an_exact_motion_corrects_the_scale_of_the_wheels():
    ekf = Ekf(np.zeros(6), np.diag(np.square([0.1, 0.1, 0.1, 1e-9, 0.05, 1e-9])))
    for _ in range(50):
        ekf.clone_pose()
        ekf.predict(0.26, 0.0, 0.6, (1e-6, 1e-8, 1e-14))
        assert ekf.update_motion(np.array([0.25, 0.0, 0.0]), 1e-6 * np.eye(3))
    assert ekf.mean[SCALE] == pytest.approx(0.04, abs=0.002) and ekf.mean[0] == pytest.approx(12.5, abs=0.03)


@pytest.mark.parametrize("steps", [3000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_the_covariance_stays_symmetric_and_positive(steps):
    ekf, rng = start(), np.random.default_rng(0)
    ekf.clone_pose()
    for step in range(steps):
        ekf.predict(0.25, rng.normal(0, 0.2), 0.6, (5e-5, 5e-7, 7e-11))
        ekf.update_motion(relative_motion(ekf.mean), np.diag([1e-4, 1e-4, 2e-5]))
        ekf.clone_pose()
        if step % 500 == 0:
            ekf.update_pose(ekf.mean[:3].copy(), np.diag([1e-4, 1e-4, 3e-4]))
    own = ekf.covariance[:6, :6]
    assert np.abs(own - own.T).max() < 1e-15 and np.linalg.eigvalsh(own).min() > 0.0
