"""Driving by lidar where no map is given: in worlds of the benchmark's own generator."""

import math

import numpy as np
import pytest

import cairn
from cairn import errors
from cairn.experiments.nav import trial
from cairn.experiments.nav.generator import generated

JACKAL = cairn.Profile.load("jackal")


def still(navigator, ranges):
    return navigator.step(ranges, (0.0, 0.0), None, 0.05)


def open_place():
    return np.full(JACKAL.range_count, math.inf)


@pytest.mark.parametrize("number", [2, 7, 11])
def test_worlds_never_seen_are_crossed_without_a_touch_at_a_metre_a_second(number):
    run = trial.drive("cairn", generated(number), 0, 1)
    assert run.outcome == "success", run.to_dict()
    assert run.score > 0.45


def test_a_goal_is_driven_to_at_once_and_the_field_says_how_long_it_takes():
    navigator = cairn.Navigator(JACKAL, start=(0.0, 0.0, 0.0))
    navigator.set_goal((6.0, 0.0))
    for _ in range(6):
        decision = still(navigator, open_place())
    record = decision.to_dict()
    assert decision.mode == "obstacle_avoidance"
    assert decision.twist[0] > 0
    assert record["avoidance"]["why"]["kind"] == "best_arc"
    assert 6.0 / 2.0 < record["avoidance"]["guided"]["to_go_s"] < 6.0


def test_a_wall_ahead_with_a_gap_to_the_left_is_left_of_in_the_direction_of_the_field():
    lidar = JACKAL.lidar
    angles = lidar.first_rad + lidar.step_rad * np.arange(lidar.beams)
    ranges = np.full(lidar.beams, math.inf)
    ahead = np.abs(angles) < 1.2
    ranges[ahead] = 2.0 / np.cos(angles[ahead])
    y = ranges * np.sin(angles)
    ranges[ahead & (y > 1.0)] = math.inf
    navigator = cairn.Navigator(JACKAL, start=(0.0, 0.0, 0.0))
    navigator.set_goal((6.0, 0.0))
    for _ in range(3):
        decision = still(navigator, ranges)
    record = decision.to_dict()["avoidance"]
    assert record["goal_bearing_rad"] > 0.2
    assert len(navigator.lidar_points) > 20


def test_two_navigators_of_the_same_inputs_decide_the_same_bits():
    def decisions():
        navigator = cairn.Navigator(JACKAL, start=(0.0, 0.0, 0.0))
        navigator.set_goal((6.0, 1.0))
        ranges = open_place()
        ranges[300:330] = 1.5
        return [still(navigator, ranges).to_json() for _ in range(5)]

    assert decisions() == decisions()


def test_an_unknown_setting_of_the_lidar_is_refused_by_name():
    with pytest.raises(errors.SettingsInvalid, match="fiield"):
        cairn.Navigator(JACKAL, config={"lidar": {"fiield": {}}})


def test_a_setting_of_the_guided_method_out_of_range_is_refused():
    with pytest.raises(errors.AvoidanceValueOutOfRange, match="horizon_m"):
        cairn.Navigator(JACKAL, config={"lidar": {"avoidance": {"horizon_m": -1.0}}})
