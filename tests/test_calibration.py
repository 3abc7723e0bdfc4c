import math

import numpy as np
import pytest

import cairn
from cairn.calibration import spin_test
from cairn.odometry import Odometry
from cairn.robots import KinematicRobot, Scene

P3AT = cairn.Profile.load("p3at")
TRACK = P3AT.drive.effective_track_m


@pytest.mark.parametrize("seed", range(5))
def test_a_spin_test_finds_the_effective_track_of_a_floor_to_a_percent(seed):
    found = spin_test(KinematicRobot(P3AT, Scene(), (0, 0, 0), seed=seed), rates_radps=(1.0,))
    assert found.truth_m is not None
    assert abs(found.truth_m / TRACK - 1) < 0.12  # the floor is not the profile's
    assert found.effective_track_m == pytest.approx(found.truth_m, rel=0.01)
    assert found.profile_track_m == TRACK
    assert found.correction == pytest.approx(found.effective_track_m / TRACK)


def test_a_spin_test_of_exact_sensors_is_exact():
    exact = P3AT.noise.scaled(0)
    found = spin_test(KinematicRobot(P3AT, Scene(), (0, 0, 0), noise=exact), turns=1.0)
    assert found.effective_track_m == pytest.approx(TRACK, rel=1e-6)
    assert found.sigma_m < 1e-6
    assert found.gyro_bias_radps == pytest.approx(0, abs=1e-9)
    for spin in found.spins:
        assert abs(spin.turned_rad) > 2 * math.pi
        assert spin.crept_m == pytest.approx(0, abs=1e-6)


def test_a_robot_that_does_not_turn_ends_a_spin_test_by_name():
    class Stuck(KinematicRobot):
        def command(self, twist):
            super().command((0.0, 0.0))

    with pytest.raises(cairn.errors.SpinTestRefused):
        spin_test(Stuck(P3AT, Scene(), (0, 0, 0)), turns=0.2, rates_radps=(2.0,), rest_s=1.0)
    with pytest.raises(cairn.errors.SpinTestRefused):
        spin_test(KinematicRobot(P3AT, Scene(), (0, 0, 0)), turns=-1.0)


def test_odometry_learns_slip_and_veer_from_its_gyro_and_keeps_them_when_it_fails():
    learnt, profile = Odometry(P3AT), Odometry(P3AT)
    track, veer = 1.08 * TRACK, 0.01

    def drive(odometry, ticks, gyro):
        """A slalom on a floor of another track, wheels of the two sides not alike."""
        turned = 0.0
        for k in range(ticks):
            turn = 0.08 * math.sin(k / 10)
            by_wheels = (turn - veer * 0.04) * track
            odometry.predict(
                (0.04 - by_wheels / 2, 0.04 + by_wheels / 2), turn / 0.1 if gyro else None, 0.1
            )
            turned += turn
        return turned

    drive(learnt, 400, gyro=True)
    found, sigma = learnt.effective_track_m
    assert found == pytest.approx(track, rel=0.02)
    assert abs(found - track) < 3 * sigma
    assert learnt.veer_radpm == pytest.approx(veer, abs=0.004)
    offs = []
    for odometry in (learnt, profile):
        odometry.set_pose((0.0, 0.0, 0.0))
        turned = drive(odometry, 600, gyro=False)
        offs.append(abs(math.remainder(odometry.pose[2] - turned, math.tau)))
    assert offs[0] < 0.4 * offs[1]


def test_a_map_teaches_the_scale_of_the_wheels():
    from cairn.odometry import MapMatcher
    from test_mapping import corridor, heard

    world = corridor()
    odometry, matcher = Odometry(P3AT, (0.5, 0.0, 0.0)), MapMatcher(world)
    x, way = 0.5, 0.04
    for k in range(600):
        forward = way if (k // 150) % 2 == 0 else -way
        x += forward
        odometry.predict((forward / 1.01, forward / 1.01), 0.0, 0.1)
        matcher.correct(odometry, P3AT, heard(world, (x, 0.0, 0.0)))
    assert odometry.path_scale == pytest.approx(0.01, abs=0.006)
    assert np.hypot(odometry.pose[0] - x, odometry.pose[1]) < 0.05
