import math

import numpy as np
import pytest

import cairn
from cairn import errors
from cairn.avoidance import Cvm, FieldGuide, Moving

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


# ---- guided by a field ---------------------------------------------------------------------

JACKAL = cairn.Profile.load("jackal")
GAP_LEFT = np.column_stack([np.full(60, 2.0), np.linspace(-2.6, 0.3, 60)])


class Wrapped:
    """A guide written in Python that says what another one does."""

    def __init__(self, guide):
        self.guide = guide

    def to_go(self, point_in_robot):
        return self.guide.to_go(point_in_robot)

    def price(self, point_in_robot):
        return self.guide.price(point_in_robot)


def lidar_cvm():
    return Cvm(JACKAL, **cairn.Navigator.default_config()["lidar"]["avoidance"])


def test_guided_by_a_field_it_bends_towards_the_gap_and_not_towards_the_goal():
    guide = FieldGuide(JACKAL, GAP_LEFT, (0.0, 0.0, 0.0), (4.0, -0.5))
    assert guide.has_way
    choice = lidar_cvm().choose_guided((1.0, 0.0), guide, GAP_LEFT, 4.0, 0.05)
    assert choice.why == {"kind": "best_arc"}
    assert choice.twist[0] > 0.5
    assert choice.twist[1] > 0.2


def test_a_guide_written_in_python_is_asked_the_same_and_answers_the_same_choice():
    guide = FieldGuide(JACKAL, GAP_LEFT, (0.3, 0.1, 0.2), (4.0, -0.5))
    here = GAP_LEFT - [0.3, 0.1]
    turn = np.array([[math.cos(0.2), -math.sin(0.2)], [math.sin(0.2), math.cos(0.2)]])
    moving = [Moving((1.5, 1.0), 0.3, (0.0, -0.6))]
    for things in ((), moving):
        one, other = (
            lidar_cvm().choose_guided(
                (0.8, 0.1), each, here @ turn, 4.0, 0.05, pending=(0.9, 0.1), moving=things
            )
            for each in (guide, Wrapped(guide))
        )
        assert one.record == other.record
        assert one.why["kind"] == ("giving_way" if things else "best_arc")


def test_a_field_counts_seconds_at_its_open_speed_where_nothing_stands():
    guide = FieldGuide(JACKAL, np.empty((0, 2)), (1.0, 2.0, math.pi / 2), (1.0, 6.0), open_mps=1.6)
    seconds, direction = guide.to_go((0.0, 0.0))
    # By cells of 5 cm: within one of them.
    assert seconds == pytest.approx(4.0 / 1.6, abs=0.05 / 1.6)
    assert direction == pytest.approx(0.0, abs=0.05)
    assert guide.price((1.0, 0.0)) == pytest.approx(1 / 1.6)


def test_walled_in_on_all_sides_a_field_has_no_way():
    angles = np.linspace(0, 2 * math.pi, 200)
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    assert not FieldGuide(JACKAL, ring, (0.0, 0.0, 0.0), (4.0, 0.0)).has_way


def test_what_a_guide_raises_comes_through():
    class Broken(Wrapped):
        def price(self, point_in_robot):
            raise LookupError("no such place")

    guide = FieldGuide(JACKAL, GAP_LEFT, (0.0, 0.0, 0.0), (4.0, 0.0))
    with pytest.raises(LookupError, match="no such place"):
        lidar_cvm().choose_guided((0.5, 0.0), Broken(guide), GAP_LEFT, 4.0)
    with pytest.raises(AttributeError):
        lidar_cvm().choose_guided((0.5, 0.0), object(), GAP_LEFT, 4.0)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"points": [[1.0, math.inf]]}, "points"),
        ({"points": [[1.0, 2.0, 3.0]]}, "points.shape"),
        ({"robot": (0.0, math.nan, 0.0)}, "robot"),
        ({"goal": (1e300, 0.0)}, "goal"),
        ({"resolution_m": 0.0}, "resolution_m"),
    ],
)
def test_a_field_that_cannot_be_solved_is_refused_by_name(change, named):
    given = {"points": GAP_LEFT, "robot": (0.0, 0.0, 0.0), "goal": (4.0, 0.0), **change}
    resolution = {"resolution_m": given.pop("resolution_m")} if "resolution_m" in given else {}
    with pytest.raises(errors.AvoidanceInputInvalid) as refused:
        FieldGuide(JACKAL, *given.values(), **resolution)
    assert refused.value.what == named


def test_a_moving_thing_that_is_nan_is_refused():
    guide = FieldGuide(JACKAL, GAP_LEFT, (0.0, 0.0, 0.0), (4.0, 0.0))
    with pytest.raises(errors.AvoidanceInputInvalid, match="moving"):
        lidar_cvm().choose_guided(
            (0.5, 0.0), guide, GAP_LEFT, 4.0, moving=[Moving((math.nan, 0.0), 0.3, (0.0, 0.0))]
        )


class Ahead:
    """A guide to whom everything is open, and the goal far ahead."""

    def to_go(self, point):
        return (50.0 - point[0]) / 2.0, 0.0

    def price(self, point):
        return 0.5


def test_beside_what_moves_nothing_is_driven_that_was_not_judged_beside_it():
    judged = 0
    for speed in np.arange(0.0, 2.01, 0.2):
        for gap in np.arange(0.4, 0.6, 0.05):
            wall = np.column_stack([np.full(200, 0.229 + gap), np.linspace(-3.0, 3.0, 200)])
            moving = [Moving((-2.5, 1.0), 0.4, (0.3, 0.0))]
            choice = lidar_cvm().choose_guided(
                (speed, 1.0), Ahead(), wall, 10.0, 0.05, pending=(speed, 1.0), moving=moving
            )
            kind = choice.why["kind"]
            assert kind in {"giving_way", "leaving_obstacle", "braking"}, (speed, gap)
            judged += kind == "giving_way"
    assert judged > 4
