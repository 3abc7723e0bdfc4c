"""The robots of the navigation benchmark move and sense as its rules say."""

import math

import numpy as np
import pytest

from cairn import Profile
from cairn.experiments.nav import jackal
from cairn.experiments.nav.jackal import Jackal
from cairn.experiments.nav.rover import SonarRover
from cairn.experiments.nav.simulated import STEP_S
from cairn.experiments.nav.worlds import NavWorld
from cairn.robots.robot import Pose, wrap_angle

PERIOD_S = 0.05
NOTHING = np.zeros((0, 3))
FAR = NavWorld("far", np.array([[0.0, 60.0, 0.1]]), np.zeros((0, 5)), Pose(0, 0, 0), (10, 0), 10.0)
HALL = NavWorld(
    "hall",
    np.array([[2.0, 0.0, 0.075]]),
    np.array([[0.0, 3.0, 0.0, 20.0, 0.2], [0.0, -3.0, 0.0, 20.0, 0.2]]),
    Pose(0.0, 0.0, 0.0),
    (10.0, 0.0),
    10.0,
)
PROFILE, ROVER = Profile.load("jackal"), Profile.load("p3at")


def driven(robot, commands, period_s=PERIOD_S):
    """Truth (n, 3) at every step of commands held for one period each."""
    poses = []
    for command in commands:
        robot.command(*command)
        poses.append(robot.advance(period_s).poses)
    return np.vstack(poses)


def speeds(poses):
    return np.hypot(*np.diff(poses[:, :2], axis=0).T) / STEP_S


@pytest.mark.parametrize("seed", range(5))
def test_a_command_takes_effect_a_period_and_twenty_to_forty_milliseconds_late(seed):
    robot = Jackal(PROFILE, FAR, PERIOD_S, seed)
    robot.observe()
    moved = speeds(driven(robot, [(1.0, 0.0)] * 10)) > 0
    first_s = (int(moved.argmax()) + 1) * STEP_S
    assert PERIOD_S + 0.02 - 1e-9 <= first_s <= PERIOD_S + 0.04 + STEP_S + 1e-9


def test_the_body_never_accelerates_harder_than_its_tyres_grip():
    robot = Jackal(PROFILE, FAR, PERIOD_S, 3)
    random = np.random.default_rng(1)
    commands = [tuple(random.uniform((-2, -4), (2, 4))) for _ in range(60) for _ in range(3)]
    poses = driven(robot, commands)
    velocity = np.diff(poses[:, :2], axis=0) / STEP_S
    acceleration = np.hypot(*np.diff(velocity, axis=0).T) / STEP_S
    assert acceleration.max() <= jackal.GRIP_MPS2 * (1 + 1e-6)
    assert speeds(poses).max() <= 2.0 + 1e-9


def test_stopping_from_full_speed_takes_at_least_what_five_metres_per_second_squared_allow():
    robot = Jackal(PROFILE, FAR, PERIOD_S, 1)
    driven(robot, [(5.0, 0.0)] * 40)  # more than it can
    before = robot.truth.x
    poses = driven(robot, [(0.0, 0.0)] * 30)
    assert speeds(poses)[0] == pytest.approx(2.0)
    assert speeds(poses)[-1] == 0.0
    late_m = 2.0 * (PERIOD_S + 0.03)
    assert robot.truth.x - before == pytest.approx(2.0**2 / (2 * 5.0) + late_m, abs=0.06)


@pytest.mark.parametrize("seed", range(8))
def test_the_true_turn_is_the_wheels_turn_times_a_gain_that_odometry_does_not_know(seed):
    robot = Jackal(PROFILE, FAR, PERIOD_S, seed)
    low, high = jackal.YAW_GAIN
    assert low <= robot.yaw_gain <= high
    poses = driven(robot, [(0.5, 0.8)] * 40)
    turned = float(np.diff(np.unwrap(poses[:, 2]))[100:].sum())
    seconds = (len(poses) - 101) * STEP_S
    assert turned / seconds == pytest.approx(0.8 * robot.yaw_gain, rel=1e-6)
    seen = robot.observe()
    assert seen.twist == pytest.approx((0.5, 0.8))
    assert seen.gyro_radps is None


def test_a_turn_within_grip_is_driven_and_in_a_sharper_one_the_robot_slides():
    def turning(linear, angular):
        """Speed and the angle from heading to course, once all is steady."""
        robot = Jackal(PROFILE, FAR, PERIOD_S, 1)
        poses = driven(robot, [(linear, angular)] * 60)
        dx, dy = np.diff(poses[-2:, :2], axis=0)[0]
        middle = poses[-1, 2] - robot.yaw_gain * angular * STEP_S / 2
        return speeds(poses)[-1], abs(wrap_angle(math.atan2(dy, dx) - middle)), robot.yaw_gain

    speed, aslant, _ = turning(1.0, 2.0)
    assert (speed, aslant) == pytest.approx((1.0, 0.0), abs=0.02)
    speed, aslant, gain = turning(2.0, 4.0)  # 8 m/s² across
    assert speed * gain * 4.0 == pytest.approx(jackal.GRIP_MPS2, rel=0.02)
    assert aslant > 0.5


def test_odometry_without_turning_is_where_the_robot_is():
    robot = Jackal(PROFILE, FAR, PERIOD_S, 1)
    driven(robot, [(0.2, 0.0)] * 20 + [(0.4, 0.0)] * 20 + [(0.0, 0.0)] * 20)
    assert robot.observe().odometry == pytest.approx(robot.truth, abs=0.02)


def test_wheel_travel_between_observations_sums_to_the_odometry():
    robot = Jackal(PROFILE, FAR, PERIOD_S, 1)
    random = np.random.default_rng(2)
    left = right = 0.0
    for _ in range(50):
        robot.command(*random.uniform((0, -1), (1, 1)))
        robot.advance(PERIOD_S)
        seen = robot.observe()
        left, right = left + seen.wheels_m[0], right + seen.wheels_m[1]
    turned = wrap_angle((right - left) / PROFILE.drive.effective_track_m)
    assert turned == pytest.approx(robot.odometry.heading, abs=1e-9)


def test_the_lidar_measures_a_hall_by_hand_and_is_blind_behind():
    robot = Jackal(PROFILE, HALL, PERIOD_S, 1)
    ranges = robot.observe().ranges_m
    assert len(ranges) == 720
    angles = -0.75 * math.pi + 1.5 * math.pi / 719 * np.arange(720)
    walls = np.abs(2.9 / np.sin(angles))
    aside = (np.abs(angles) > 0.1) & (np.abs(np.cos(angles) / np.sin(angles)) * 2.9 < 9.9)
    np.testing.assert_allclose(ranges[aside], walls[aside], atol=6e-3)
    assert np.std(ranges[aside] - walls[aside]) == pytest.approx(jackal.SCAN_SIGMA_M, rel=0.25)
    ahead = int(np.abs(angles).argmin())
    assert ranges[ahead] == pytest.approx(2.0 - 0.075 - 0.055, abs=6e-3)
    assert np.abs(angles).max() == pytest.approx(math.radians(135))


def test_a_scan_is_at_most_twenty_milliseconds_old_and_says_where_it_was_taken():
    robot = Jackal(PROFILE, HALL, PERIOD_S, 1)
    driven(robot, [(0.05 * n, 0.0) for n in range(1, 18)])  # gently: no wheel spins
    seen = robot.observe()
    assert 0 < seen.odometry.x - seen.scan_pose.x <= 0.02 + 1e-9
    ahead = seen.ranges_m[359:361].mean()
    assert ahead + 0.055 + seen.scan_pose.x == pytest.approx(2.0 - 0.075, abs=0.03)


def test_one_seed_gives_one_robot_and_another_seed_another():
    def ways(seed):
        robot = Jackal(PROFILE, HALL, PERIOD_S, seed)
        poses = driven(robot, [(0.5, 0.5)] * 5)
        return poses, robot.observe().ranges_m

    np.testing.assert_array_equal(ways(4)[0], ways(4)[0])
    np.testing.assert_array_equal(ways(4)[1], ways(4)[1])
    assert not np.array_equal(ways(4)[0], ways(5)[0])


def test_contact_is_seen_when_the_front_of_the_outline_reaches_a_post():
    robot = Jackal(PROFILE, HALL, PERIOD_S, 1)
    while True:
        robot.command(0.5, 0.0)
        motion = robot.advance(PERIOD_S)
        if motion.touch is not None:
            break
    assert (motion.touch.what, motion.touch.which) == ("circle", 0)
    front = motion.poses[motion.touch.step, 0] + 0.458 / 2
    assert 0 <= front - (2.0 - 0.075) <= 0.5 * STEP_S


# ---- the sonar robot ---------------------------------------------------------------------


def test_sonars_hear_a_post_ahead_and_walls_to_both_sides():
    ranges = np.median([SonarRover(ROVER, HALL, 0.1, s).observe().ranges_m for s in range(9)], 0)
    assert len(ranges) == 16
    for number in (3, 4):  # 10° to both sides of straight ahead
        sonar = ROVER.sonars[number].pose
        true = math.hypot(2.0 - sonar.x, sonar.y) - 0.075
        assert ranges[number] == pytest.approx(true, abs=0.03)
    for number, side in ((0, 1), (7, -1), (8, -1), (15, 1)):
        assert ranges[number] == pytest.approx(2.9 - side * ROVER.sonars[number].pose.y, abs=0.06)


def test_a_sonar_hears_a_thin_post_anywhere_in_its_cone_and_none_outside():
    sonar = ROVER.sonars[3]
    cone = sonar.beam_rad / 2
    for offset, heard in ((0.0, True), (0.9, True), (-0.9, True), (1.2, False), (-1.2, False)):
        angle = sonar.pose.heading + offset * cone
        at = (sonar.pose.x + 4 * math.cos(angle), sonar.pose.y + 4 * math.sin(angle), 0.075)
        world = NavWorld("post", np.array([at]), np.zeros((0, 5)), Pose(0, 0, 0), (10.0, 0.0), 10.0)
        measured = SonarRover(ROVER, world, 0.1, 1).observe().ranges_m[3]
        assert math.isfinite(measured) == heard
        assert not heard or measured == pytest.approx(4 - 0.075, abs=0.2)


def test_the_rover_keeps_its_firmware_ramp_and_knows_its_turn_by_gyroscope():
    robot = SonarRover(ROVER, FAR, 0.1, 2)
    robot.observe()
    poses = driven(robot, [(0.6, 0.3)] * 30, period_s=0.1)
    assert speeds(poses).max() == pytest.approx(0.6, abs=1e-3)
    rise = np.diff(speeds(poses)) / STEP_S
    assert rise.max() <= ROVER.limits.linear_mps2 * 1.001
    turned = float(np.unwrap(poses[:, 2])[-1])
    assert robot.observe().gyro_radps * 3.0 == pytest.approx(turned, abs=0.05)
