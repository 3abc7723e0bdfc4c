"""The shape of the way: straight where the robot fits and it costs no more."""

import itertools
import math

import numpy as np
import pytest

import cairn
from test_navigator import P3AT, Drive
from test_navigator_keeping import causes, hall, through_shut_door

OUTLINE = (P3AT.footprint.length_m + 0.1, P3AT.footprint.width_m + 0.1)  # and clearance_m


def path_of(drive):
    assert drive.nav.path is not None
    return np.array(drive.nav.path)


def walked(world, start, goal, **config):
    """The navigator's path right after planning, (n, 2) [m]."""
    drive = Drive(world, start=start, config=config)
    drive.nav.set_goal(goal)
    drive.until(lambda d: d.mode == "path_tracking")
    return path_of(drive)


def cost(world, path):
    """∫ cost ds along a polyline, by steps of a millimetre."""
    costs = cairn.costmap(world, OUTLINE).costs
    assert costs is not None
    total = 0.0
    for a, b in itertools.pairwise(path):
        length = float(np.hypot(*(b - a)))
        for t in (np.arange(n := max(1, math.ceil(length / 1e-3))) + 0.5) / n:
            total += costs[world.cell_of(tuple(a + t * (b - a)))] * length / n
    return total


def test_across_an_empty_hall_the_way_is_one_straight_line():
    path = walked(cairn.World(hall(), resolution_m=0.05), (1.0, 1.5, 0.0), (6.0, 2.3))
    assert path.tolist() == [[1.0, 1.5], [6.0, 2.3]]


@pytest.mark.parametrize("seed", range(3))
def test_an_any_angle_way_through_the_office_costs_no_more_than_the_octile_one(seed):
    world = cairn.maps.load("office")
    places = sorted(world.goals)
    first, last = np.random.default_rng(seed).choice(len(places), 2, replace=False)
    start, goal = world.goals[places[first]][:2], world.goals[places[last]][:2]
    straight = walked(world, (*start, 0.0), goal)
    octile = walked(world, (*start, 0.0), goal, path_shape="octile")
    assert cost(world, straight) <= cost(world, octile) * (1 + 1e-3)  # of the sum's own steps
    assert len(straight) < len(octile) / 5
    assert np.hypot(*np.diff(octile[1:-1], axis=0).T).max() < 0.05 * math.sqrt(2) + 1e-9


def test_the_way_walked_anew_is_the_any_angle_path_of_the_repaired_field():
    drive = through_shut_door()
    drive.until(lambda d: any(code == "way_shut" for code in causes(drive)))
    path = path_of(drive)
    field = cairn.plan(cairn.costmap(drive.nav.map(), OUTLINE), (7.0, 1.5))
    anew = field.path(tuple(path[0]), any_angle=True)
    assert anew is not None
    assert len(path) > 4
    assert np.array_equal(path, anew)
