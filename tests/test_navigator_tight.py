"""Tight places, things that come and go, and what only an echo tells."""

import math

import numpy as np
import pytest

import cairn
from cairn.missions.result import Recovered
from cairn.missions.traps import traps
from cairn.robots import Box, Scene
from test_navigator import Drive, at_rest, ended
from test_navigator_keeping import causes, hall


def corridor(width_m=1.2, length_m=10.0):
    """Along x, its middle at y = 2 m."""
    occupancy = hall(length_m, 4.0)
    low, high = (round((2.0 + side * width_m / 2) / 0.05) for side in (-1, 1))
    occupancy[:low] = occupancy[high:] = 1
    return cairn.World(occupancy, resolution_m=0.05)


def wall_with_gap(gap_m, at_x=4.0):
    """8 m x 4 m; a wall 0.6 m thick across it with one gap, its middle at y = 2 m."""
    occupancy = hall()
    low, high = (round((2.0 + side * gap_m / 2) / 0.05) for side in (-1, 1))
    x = round(at_x / 0.05)
    occupancy[:low, x : x + 12] = occupancy[high:, x : x + 12] = 1
    return cairn.World(occupancy, resolution_m=0.05)


@pytest.mark.parametrize(
    ("x", "y", "degrees"),
    [(3.62, 2.0, 16), (3.62, 1.93, -14), (3.55, 2.05, 25), (3.6, 2.0, 180), (3.3, 1.8, 60)],
)
def test_a_gap_just_wider_than_the_robot_is_passed_from_a_slant(x, y, degrees):
    world = wall_with_gap(0.7)
    start = (x, y, math.radians(degrees))
    drive = Drive(world, start=start)
    drive.nav.set_goal((6.5, 2.0))
    assert drive.until(ended, seconds=60).goal_status == "reached"
    assert drive.robot.contacts == []


def test_what_shuts_the_only_way_for_a_while_is_outwaited_and_not_refused():
    world = corridor()
    crate = Box(5.0, 2.0, 0.4, 1.0, name="cart", from_s=3.0, until_s=18.0)
    drive = Drive(world, Scene.from_world(world, [crate]), start=(1.5, 2.0, 0.0))
    drive.nav.set_goal((9.0, 2.0))
    assert drive.until(ended).goal_status == "reached"
    assert drive.robot.contacts == []


def test_what_shuts_the_only_way_for_good_is_refused_at_rest_in_front_of_it():
    world = corridor()
    crate = Box(5.0, 2.0, 0.4, 1.0, name="cart")
    drive = Drive(world, Scene.from_world(world, [crate]), start=(1.5, 2.0, 0.0))
    drive.nav.set_goal((9.0, 2.0))
    refused = drive.until(ended, seconds=120)
    assert refused.goal_status == "refused"
    assert "no path" in refused.sentence
    drive.until(at_rest)
    assert drive.robot.contacts == []
    # It went and looked: what it refuses for, it has seen from near.
    assert max(d.pose.x for d in drive.decisions) > 3.5


def test_the_ghost_of_a_thing_that_left_shuts_no_way():
    """A prior map with a way, a map that holds phantoms: doubted, gone and looked at, passed."""
    world = corridor()
    cart = Box(3.2, 2.0, 0.4, 1.0, name="cart", until_s=6.0)
    drive = Drive(world, Scene.from_world(world, [cart]), start=(1.2, 2.0, 0.0))
    drive.nav.set_goal((9.0, 2.0))
    assert drive.until(ended).goal_status == "reached"
    assert drive.robot.contacts == []


@pytest.mark.parametrize("degrees", [0, 20, 45, 70])
@pytest.mark.parametrize("offset_m", [-0.15, 0.1])
def test_a_box_put_before_a_fast_robot_is_not_touched_however_it_is_turned(degrees, offset_m):
    world = corridor(1.8)
    box = Box(6.0, 2.0 + offset_m, 0.5, 0.25, math.radians(degrees), "box", appears_within_m=1.9)
    drive = Drive(world, Scene.from_world(world, [box]), start=(1.5, 2.0, 0.0))
    drive.nav.set_goal((9.0, 2.0))
    drive.until(ended, seconds=120)
    assert drive.robot.contacts == []


def test_a_robot_whose_motors_are_off_is_not_taken_for_wedged():
    drive = Drive(cairn.World(hall(), resolution_m=0.05), start=(1.0, 2.0, 0.0))
    drive.nav.set_goal((7.0, 2.0))
    drive.until(lambda d: d.pose.x > 3.0)
    drive.robot.emergency_stop(6.0)
    assert drive.until(ended).goal_status == "reached"
    assert "wedged" not in causes(drive)


def test_a_trap_lasts_from_the_first_time_without_gain_until_half_a_metre_away():
    time_s = np.arange(0.0, 30.0, 0.1)
    x = np.clip(time_s - 12.0, 0.0, None)
    truth = [(float(p), 0.0, 0.0) for p in x]
    stuck = [
        Recovered(10.0, "no_gain", "plan_anew", {"seconds": 8.0}),
        Recovered(11.0, "wedged", "manoeuvre", {"seconds": 2.0, "legs": 2}),
        Recovered(20.0, "way_shut", "walk_anew", {}),
    ]
    (trap,) = traps(stuck, list(time_s), truth)
    assert (trap.time_s, trap.cause, trap.left) == (2.0, "no_gain", True)
    assert trap.seconds == pytest.approx(10.5, abs=0.11)
    (kept,) = traps([Recovered(29.0, "circling", "plan_anew", {})], list(time_s), [truth[0]] * 300)
    assert not kept.left
