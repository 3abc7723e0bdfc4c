import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cairn
from cairn.odometry import MapMatcher, Odometry

P3AT = cairn.Profile.load("p3at")
TRACK = P3AT.to_dict()["drive"]["effective_track_m"]


def test_wheels_alone_close_a_circle_exactly():
    odometry = Odometry(P3AT, (1.0, 2.0, 0.5))
    turn = 2 * np.pi / 100
    for _ in range(100):
        odometry.predict((0.05 - turn * TRACK / 2, 0.05 + turn * TRACK / 2), None, 0.1)
    np.testing.assert_allclose(odometry.pose, (1.0, 2.0, 0.5), atol=1e-9)
    assert odometry.path_m == pytest.approx(5.0)
    assert odometry.twist == pytest.approx((0.5, turn / 0.1))


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.tuples(st.floats(-0.07, 0.07), st.floats(-0.07, 0.07), st.none() | st.floats(-2.5, 2.5)),
        min_size=1,
        max_size=60,
    )
)
def test_the_covariance_is_always_one(ticks):
    odometry = Odometry(P3AT)
    for left, right, gyro in ticks:
        odometry.predict((left, right), gyro, 0.1)
    covariance = odometry.covariance
    assert (covariance == covariance.T).all()
    assert np.linalg.eigvalsh(covariance).min() >= -1e-12


def test_the_gyro_holds_the_heading_that_slipping_wheels_lose():
    with_gyro, without = Odometry(P3AT), Odometry(P3AT)
    for _ in range(100):
        wheels = (-0.05 * TRACK / 2 * 1.2, 0.05 * TRACK / 2 * 1.2)
        with_gyro.predict(wheels, 0.5, 0.1)
        without.predict(wheels, None, 0.1)
    off = [abs((o.pose[2] - 5.0 + np.pi) % (2 * np.pi) - np.pi) for o in (with_gyro, without)]
    assert off[0] < 0.15 < 0.9 < off[1]
    assert with_gyro.covariance[2, 2] < without.covariance[2, 2]


def test_measurements_that_are_no_numbers_are_refused_by_name_and_change_nothing():
    odometry = Odometry(P3AT)
    odometry.predict((0.1, 0.1), None, 0.1)
    before = odometry.pose
    for wheels, gyro, name in (
        ((np.nan, 0.0), 0.0, "wheels.left_m"),
        ((0.0, np.inf), 0.0, "wheels.right_m"),
        ((0.0, 0.0), np.nan, "gyro_radps"),
    ):
        with pytest.raises(cairn.errors.OdometryInputNotFinite) as caught:
            odometry.predict(wheels, gyro, 0.1)
        assert caught.value.name == name
    with pytest.raises(cairn.errors.OdometryValueOutOfRange):
        odometry.predict((0.0, 0.0), None, -0.1)
    with pytest.raises(cairn.errors.OdometryInputNotFinite):
        odometry.set_pose((0.0, np.nan, 0.0))
    with pytest.raises(cairn.errors.OdometryValueOutOfRange):
        Odometry(P3AT, config={"start_m": -1.0})
    assert odometry.pose == before


def test_a_matcher_brings_a_robot_back_between_walls_it_knows():
    from test_mapping import corridor, heard

    world = corridor()
    odometry = Odometry(P3AT, (0.5, 0.12, 0.0), config={"start_m": 0.15, "start_rad": 0.02})
    matcher = MapMatcher(world)
    for _ in range(60):
        report = matcher.correct(odometry, P3AT, heard(world, (0.5, 0.0, 0.0)))
        assert np.hypot(*report.correction[:2]) <= 0.01 + 1e-9
    assert report.used >= 4
    assert abs(odometry.pose[1]) < 0.03
    with pytest.raises(cairn.errors.MatchingRangeCount):
        matcher.correct(odometry, P3AT, [1.0, 2.0])
    with pytest.raises(cairn.errors.MatchingValueOutOfRange):
        MapMatcher(world, config={"gate_m": 0.0})


@pytest.mark.parametrize("bias_radps", [-0.002, -0.0005, 0.001, 0.009])
def test_the_gyros_bias_is_learnt_at_short_stops(bias_radps):
    random = np.random.default_rng(1)
    odometry = Odometry(P3AT)
    for _ in range(6):
        for wheels, ticks in ((0.0, 8), (0.04, 20)):
            for _ in range(ticks):
                gyro = bias_radps + 0.0016 * random.standard_normal()
                odometry.predict((wheels, wheels), gyro, 0.1)
    assert odometry.gyro_bias_radps == pytest.approx(
        bias_radps, abs=max(0.0006, 0.1 * abs(bias_radps))
    )


def test_a_box_a_little_before_a_wall_does_not_pull_the_pose():
    from test_mapping import corridor, heard

    world = corridor(2.0)
    cells = world.occupancy.copy()
    cells[11:31, 155:159] = 1  # stands 0.2 m out of the far wall, 1 m wide
    boxed = cairn.World(cells, 0.05, world.origin)
    truth = (4.0, 0.0, 0.0)
    odometry = Odometry(P3AT, truth, config={"start_m": 0.1, "start_rad": 0.02})
    matcher = MapMatcher(world)
    for _ in range(50):
        odometry.predict((0.0, 0.0), 0.0, 0.1)
        matcher.correct(odometry, P3AT, heard(boxed, truth))
    np.testing.assert_allclose(odometry.pose, truth, atol=0.05)
