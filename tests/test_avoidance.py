import math

import numpy as np
import pytest

import cairn
from cairn import errors
from cairn.avoidance import Cvm

P3AT = cairn.Profile.load("p3at")


def test_an_empty_place_is_driven_straight_at_full_speed():
    choice = Cvm(P3AT).choose((0.7, 0.0), 0.0, math.inf, np.empty((0, 2)))
    assert choice.twist == (0.7, 0.0)
    assert choice.why == {"kind": "best_arc"}


def test_the_intervals_are_disjoint_without_gaps_and_the_blocked_one_is_straight_ahead():
    wall = np.column_stack([np.full(9, 1.5), np.linspace(-0.2, 0.2, 9)])
    intervals = Cvm(P3AT).choose((0.2, 0.0), 0.0, 4.0, wall).intervals
    assert np.all(intervals[1:, 0] == intervals[:-1, 1])
    ahead = intervals[(intervals[:, 0] <= 0) & (intervals[:, 1] >= 0)]
    assert np.all(ahead[:, 2] <= 1.5 - 0.313)
    assert intervals[:, 2].max() == 3.0


def test_the_chosen_candidate_has_the_greatest_weighted_sum_of_its_terms():
    cvm = Cvm(P3AT)
    weights = [cvm.config[f"{name}_weight"] for name in ("speed", "distance", "heading")]
    posts = np.array([[1.2, 0.1], [1.8, -0.7], [0.9, 0.9]])
    record = cvm.choose((0.3, 0.1), 0.2, 5.0, posts).record
    for candidate in record["candidates"]:
        terms = [candidate["speed"], candidate["distance"], candidate["heading"]]
        assert candidate["total"] == pytest.approx(np.dot(weights, terms))
    drivable = [c["total"] for c in record["candidates"] if c["refused"] is None]
    assert record["candidates"][record["chosen"]]["total"] == max(drivable)


def test_facing_a_wall_it_turns_in_place():
    wall = np.column_stack([np.full(80, 0.55), np.linspace(-2, 2, 80)])
    choice = Cvm(P3AT).choose((0.0, 0.0), 0.0, 4.0, wall)
    assert choice.why["kind"] == "turning_in_place"
    assert choice.twist[0] == 0.0
    assert choice.twist[1] != 0.0


def test_nose_to_a_wall_it_backs_out_if_it_may():
    wall = np.column_stack([np.full(60, 0.313 + 0.08), np.linspace(-1.5, 1.5, 60)])
    choice = Cvm(P3AT).choose((0.0, 0.0), 1.5, 3.0, wall)
    assert choice.why["kind"] == "backing_out"
    assert choice.twist[0] < 0
    stays = Cvm(P3AT, back_out=False).choose((0.0, 0.0), 1.5, 3.0, wall)
    assert stays.twist[0] >= 0


def test_an_obstacle_that_is_nan_is_refused_with_its_index():
    with pytest.raises(errors.AvoidanceObstacleNotFinite, match="obstacle 1") as refused:
        Cvm(P3AT).choose((0.0, 0.0), 0.0, 1.0, [[1.0, 0.0], [math.nan, 0.0]])
    assert refused.value.index == 1


def test_weights_that_do_not_sum_to_one_are_refused():
    with pytest.raises(errors.AvoidanceWeightsNotOne):
        Cvm(P3AT, speed_weight=0.9)


def test_an_unknown_setting_is_refused_by_name():
    with pytest.raises(cairn.errors.SettingsInvalid, match="spede_weight"):
        Cvm(P3AT, spede_weight=0.9)


def test_obstacles_of_another_shape_are_refused():
    with pytest.raises(errors.AvoidanceInputInvalid, match="shape"):
        Cvm(P3AT).choose((0.0, 0.0), 0.0, 1.0, np.zeros((3, 3)))
