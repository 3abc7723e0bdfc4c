import math

import numpy as np
import pytest

from cairn.robots import KinematicRobot
from robot_contract import EXACT, NOWHERE, P3AT, TICK_S, RobotContract, drive, room


class TestKinematicRobot(RobotContract):
    def make(self, scene, start=(0.0, 0.0, 0.0), **options):
        return KinematicRobot(P3AT, scene, start, **options)


def test_a_full_circle_at_steady_speeds_has_radius_speed_over_turn_rate():
    robot = KinematicRobot(P3AT, NOWHERE, (0.0, 0.0, 0.0), noise=EXACT)
    drive(robot, (0.4, 0.5), 3.0)
    x, y, heading = robot.truth
    centre = np.array([x - 0.8 * math.sin(heading), y + 0.8 * math.cos(heading)])
    for _ in range(100):
        robot.advance(TICK_S)
        assert math.dist(robot.truth[:2], centre) == pytest.approx(0.8, abs=1e-9)


def test_wheel_errors_drawn_over_many_seeds_have_the_profiles_spread():
    def error(seed):
        robot = KinematicRobot(P3AT, NOWHERE, (0.0, 0.0, 0.0), seed=seed)
        travelled = sum(r.wheels_m[0] for r in drive(robot, (0.7, 0.0), 4.0))
        return travelled / robot.truth.x - 1

    errors = np.array([error(seed) for seed in range(120)])
    metres = 1.8
    expected = math.hypot(
        P3AT.noise.wheel_scale_sigma, P3AT.noise.encoder_sigma_per_sqrt_m / math.sqrt(metres)
    )
    assert abs(errors.mean()) < 4 * expected / math.sqrt(120)
    assert errors.std() == pytest.approx(expected, rel=0.25)


def test_gyroscope_bias_over_many_seeds_has_the_profiles_spread():
    def bias(seed):
        robot = KinematicRobot(P3AT, NOWHERE, (0.0, 0.0, 0.0), seed=seed)
        robot.advance(20.0)
        return robot.sense().gyro_radps

    biases = np.array([bias(seed) for seed in range(100)])
    noise = P3AT.noise
    expected = math.hypot(
        noise.gyro_bias_sigma_radps,
        noise.gyro_density_radps_sqrt_s / math.sqrt(20),
        noise.gyro_drift_radps_per_sqrt_s * math.sqrt(20),
    )
    assert biases.std() == pytest.approx(expected, rel=0.25)


def test_range_noise_has_the_profiles_spread():
    robot = KinematicRobot(P3AT, room(), (0.0, 0.0, 0.0), seed=3)
    left = np.array([robot.sense().ranges_m[0] for _ in range(400)])
    expected = P3AT.noise.sonar_sigma_m + P3AT.noise.sonar_sigma_relative * 3.864
    assert left.mean() == pytest.approx(3.864, abs=4 * expected / 20)
    assert left.std() == pytest.approx(expected, rel=0.15)
