import builtins
import math

import numpy as np
import pytest

import cairn
from cairn.robots import MujocoP3AT, MujocoWorld, RobotSpec, Scene, Twist
from cairn.robots.mujoco_p3at import measured_effective_track_m
from robot_contract import EXACT, NOWHERE, P3AT, TICK_S, RobotContract, drive, room


class TestMujocoP3AT(RobotContract):
    def make(self, scene, start=(0.0, 0.0, 0.0), **options):
        return MujocoP3AT(P3AT, scene, start, **options)


@pytest.mark.parametrize("twist", [(0.0, 0.3), (0.0, 2.0), (0.3, 0.3), (0.6, 0.3)])
def test_turning_slips_as_the_profiles_effective_track_says(twist):
    measured = measured_effective_track_m(P3AT, Twist(*twist), 4.0)
    assert measured == pytest.approx(P3AT.drive.effective_track_m, rel=0.03)


def test_the_slip_factor_is_near_arias():
    assert 1.4 < measured_effective_track_m(P3AT, seconds=4.0) / P3AT.physics.track_m < 1.6


def test_straight_line_odometry_errs_by_less_than_a_hundredth():
    robot = MujocoP3AT(P3AT, NOWHERE, (0.0, 0.0, 0.0), noise=EXACT)
    readings = drive(robot, (0.6, 0.0), 12.0) + drive(robot, (0.0, 0.0), 3.0)
    travelled = sum(r.wheels_m[0] + r.wheels_m[1] for r in readings) / 2
    assert travelled == pytest.approx(robot.truth.x, rel=0.01)
    assert abs(robot.truth.y) < 0.01


def test_dead_reckoning_by_encoders_and_gyroscope_holds_over_thirty_metres_of_bends():
    """With noise: encoders for travel, gyroscope for turns, no map; drift under 3 % of the way."""
    robot = MujocoP3AT(P3AT, NOWHERE, (0.0, 0.0, 0.0), seed=11)
    legs = [((0.5, 0.0), 12.0), ((0.2, 0.5), 3.0), ((0.5, 0.0), 10.0), ((0.0, -0.6), 2.5)]
    x = y = heading = way = 0.0
    for twist, seconds in legs * 3:
        for reading in drive(robot, twist, seconds):
            step = sum(reading.wheels_m) / 2
            turn = reading.gyro_radps * TICK_S
            x += step * math.cos(heading + turn / 2)
            y += step * math.sin(heading + turn / 2)
            heading += turn
            way += abs(step)
    assert way > 30
    assert math.dist((x, y), robot.truth[:2]) < 0.03 * way


def test_two_robots_see_and_touch_each_other_by_name():
    world = MujocoWorld(
        NOWHERE,
        [
            RobotSpec(P3AT, (0.0, 0.0, 0.0), noise=EXACT, name="left"),
            RobotSpec(P3AT, (2.0, 0.0, math.pi), noise=EXACT, name="right"),
        ],
    )
    left, right = world.robots
    assert left.clearance_m == pytest.approx(2.0 - 0.626, abs=2e-3)
    assert left.sense().ranges_m[3] == pytest.approx(2.0 - 0.313 - 0.245, abs=0.02)
    left.command(Twist(0.3, 0.0))
    left.advance(0.1)
    assert world.time_s == 0.0
    right.advance(0.1)
    assert world.time_s == pytest.approx(0.1)
    for _ in range(60):
        world.advance(0.1)
    assert [c.name for c in left.contacts] == ["right"]
    assert [c.name for c in right.contacts] == ["left"]


def test_robots_may_not_start_in_each_other():
    with pytest.raises(cairn.errors.StandsInObstacle):
        MujocoWorld(NOWHERE, [RobotSpec(P3AT, (0.0, 0.0, 0.0)), RobotSpec(P3AT, (0.4, 0.0, 0.0))])


def test_a_corner_of_the_chassis_touching_in_a_turn_is_a_contact():
    robot = MujocoP3AT(P3AT, room(), (0.0, 3.72, 0.0), noise=EXACT)
    drive(robot, (0.0, 0.5), 3.0)
    assert [c.name for c in robot.contacts] == ["wall"]


def test_a_step_that_is_no_multiple_of_the_physics_step_is_refused():
    with pytest.raises(cairn.errors.StepOutOfRange):
        MujocoP3AT(P3AT, NOWHERE, (0.0, 0.0, 0.0)).advance(0.033)


def test_without_mujoco_the_error_names_the_extra(monkeypatch):
    real = builtins.__import__

    def without(name, *args, **kwargs):
        if name == "mujoco":
            raise ImportError(name)
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(cairn.errors.SimulationNotInstalled, match=r"cairn-nav\[sim\]"):
        MujocoP3AT(P3AT, NOWHERE, (0.0, 0.0, 0.0))


def test_a_profile_without_physics_is_refused_by_the_table():
    text = P3AT.text[: P3AT.text.index("[physics]")]
    with pytest.raises(cairn.errors.ProfileTableMissing, match=r"\[physics\]"):
        MujocoP3AT(cairn.Profile(text), Scene(), (0.0, 0.0, 0.0), noise=EXACT)


def test_rays_of_the_physics_meet_what_the_rectangles_say():
    from cairn.robots import rectangles as rect

    robot = MujocoP3AT(P3AT, room(), (0.7, -0.4, 0.3), noise=EXACT)
    angles = np.linspace(-math.pi, math.pi, 97)
    directions = np.column_stack([np.cos(angles), np.sin(angles)])
    origin = np.array([0.7, -0.4])
    distance, cosine = robot._cast(origin, directions)
    expected = rect.cast(np.tile(origin, (97, 1)), directions, robot.world.stage.rectangles)
    near = expected[0] < robot._ranges.reach_m
    assert distance[near] == pytest.approx(expected[0][near], abs=1e-9)
    assert cosine[near] == pytest.approx(expected[1][near], abs=1e-9)
