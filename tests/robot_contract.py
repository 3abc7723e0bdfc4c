"""Laws of every simulated robot. A test class gives `make(scene, start, **options)`.

Robots under this contract have the P3-AT's profile.
"""

import math
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import cairn
from cairn import errors
from cairn.robots import Box, Scene, Twist

P3AT = cairn.Profile.load("p3at")
EXACT = P3AT.noise.scaled(0.0)
TICK_S = 0.1
NOWHERE = Scene()


def room(length_m=10.0, width_m=8.0, boxes=()):
    """A walled room about the origin, cells of 0.1 m."""
    rows, cols = round(width_m / 0.1) + 2, round(length_m / 0.1) + 2
    occupancy = np.zeros((rows, cols), dtype=np.uint8)
    occupancy[[0, -1], :] = 1
    occupancy[:, [0, -1]] = 1
    origin = (-length_m / 2 - 0.1, -width_m / 2 - 0.1, 0.0)
    world = SimpleNamespace(occupancy=occupancy, resolution_m=0.1, origin=origin)
    return Scene.from_world(world, boxes)


def drive(robot, twist, seconds):
    """Command every tick; return the readings of every tick."""
    readings = []
    for _ in range(round(seconds / TICK_S)):
        robot.command(twist)
        robot.advance(TICK_S)
        readings.append(robot.sense())
    return readings


class RobotContract:
    """Subclass, and define `make`."""

    # How far a simulated drive may be from the ideal one.
    speed_tolerance = 0.02

    def make(self, scene, start=(0.0, 0.0, 0.0), **options):
        raise NotImplementedError

    def test_stands_where_it_was_put_and_stays_there(self):
        robot = self.make(NOWHERE, (1.0, 2.0, 0.5))
        before = robot.truth
        for _ in range(10):
            robot.advance(TICK_S)
        assert robot.truth == pytest.approx(before, abs=1e-3)
        assert robot.truth == pytest.approx((1.0, 2.0, 0.5), abs=2e-3)
        assert robot.time_s == pytest.approx(1.0)

    def test_nothing_moves_for_exactly_one_tick_after_a_command(self):
        robot = self.make(NOWHERE, noise=EXACT)
        robot.advance(1.0)
        before = robot.truth
        robot.command(Twist(0.3, 0.0))
        robot.advance(TICK_S)
        assert math.dist(robot.truth[:2], before[:2]) < 1e-4
        robot.advance(TICK_S)
        assert robot.truth.x - before.x == pytest.approx(0.5 * 0.3 * 0.01, rel=0.3)

    def test_speeds_ramp_at_the_profiles_accelerations_up_to_its_limits(self):
        robot = self.make(NOWHERE, noise=EXACT)
        drive(robot, (99.0, 0.0), 1.1)
        assert robot.velocity.linear_mps == pytest.approx(0.3, rel=0.1)
        drive(robot, (99.0, 0.0), 3.0)
        assert robot.velocity.linear_mps == pytest.approx(0.7, rel=self.speed_tolerance)

    def test_encoders_and_gyroscope_without_noise_tell_the_motion(self):
        robot = self.make(NOWHERE, noise=EXACT)
        readings = drive(robot, (0.5, 0.0), 6.0)
        travelled = sum(np.array(r.wheels_m) for r in readings)
        assert travelled == pytest.approx([robot.truth.x] * 2, rel=self.speed_tolerance)
        readings = drive(robot, (0.0, 0.5), 3.0)
        turned = sum(r.gyro_radps * TICK_S for r in readings)
        assert turned == pytest.approx(robot.truth.heading, abs=0.01)
        left, right = readings[-1].wheels_m
        assert (right - left) / P3AT.drive.effective_track_m / TICK_S == pytest.approx(
            0.5, rel=0.02
        )

    def test_turning_left_is_positive_and_backwards_is_negative(self):
        robot = self.make(NOWHERE, noise=EXACT)
        drive(robot, (-0.3, 0.0), 2.0)
        assert robot.truth.x < -0.2
        drive(robot, (0.0, 0.0), 2.0)
        drive(robot, (0.0, 0.4), 2.0)
        assert robot.truth.heading > 0.3

    def test_a_wall_ahead_is_touched_once_named_and_not_passed(self):
        robot = self.make(room(boxes=[Box(2.0, 0.0, 0.5, 2.0, name="crate")]), noise=EXACT)
        drive(robot, (0.5, 0.0), 6.0)
        assert [c.name for c in robot.contacts] == ["crate"]
        assert robot.truth.x == pytest.approx(1.75 - P3AT.footprint.length_m / 2, abs=0.01)
        assert robot.clearance_m < 0.01
        drive(robot, (-0.3, 0.0), 5.0)
        assert robot.clearance_m > 0.05
        assert len(robot.contacts) == 1

    def test_clearance_is_the_distance_from_outline_to_wall(self):
        robot = self.make(room(), noise=EXACT)
        assert robot.clearance_m == pytest.approx(4.0 - P3AT.footprint.width_m / 2, abs=2e-3)
        assert self.make(NOWHERE).clearance_m == math.inf

    def test_sonars_tell_the_hand_computed_distances_in_a_room(self):
        ranges = self.make(room(), noise=EXACT).sense().ranges_m
        assert ranges.shape == (16,)
        # Left side sonar at y 0.136 facing the wall at y 4; right one likewise.
        assert ranges[0] == pytest.approx(4.0 - 0.136, abs=2e-3)
        assert ranges[7] == pytest.approx(4.0 - 0.136, abs=2e-3)
        # The front wall at x 5 is in the cone of sonar 3, whose axis is 10 deg off.
        assert ranges[3] == pytest.approx(5.0 - 0.245, abs=2e-3)
        # The rear ones see the wall at x -5.
        assert ranges[11] == pytest.approx(5.0 - 0.241, abs=2e-3)
        # Sonar 1 looks along 50 deg: the left wall is met at 40 deg to its normal at best 25.
        assert ranges[1] > 4.0

    def test_no_echo_is_infinity(self):
        assert np.isinf(self.make(NOWHERE).sense().ranges_m).all()

    def test_a_box_closer_than_the_least_range_reads_the_least_range(self):
        scene = Scene(boxes=(Box(0.35 + 0.05, 0.0, 0.1, 1.0),))
        robot = self.make(scene, noise=EXACT)
        assert robot.sense().ranges_m[3] == pytest.approx(0.105, abs=2e-3)

    def test_sonars_that_take_turns_read_nan_in_between(self):
        robot = self.make(room(), noise=EXACT, firing="sequenced")
        counts = np.zeros(16)
        for _ in range(16):
            robot.advance(TICK_S)
            counts += ~np.isnan(robot.sense().ranges_m)
        assert (counts == 5).all()

    def test_a_box_appears_at_its_time_and_goes(self):
        box = Box(2.0, 0.0, 0.2, 1.0, from_s=0.5, until_s=1.0)
        robot = self.make(Scene(boxes=(box,)), noise=EXACT)
        seen = []
        for _ in range(15):
            robot.advance(TICK_S)
            seen.append(math.isfinite(robot.sense().ranges_m[3]))
        assert seen == [False] * 5 + [True] * 5 + [False] * 5

    def test_a_box_appears_for_good_once_the_robot_is_near(self):
        box = Box(4.0, 0.0, 0.2, 1.0, appears_within_m=3.0)
        robot = self.make(Scene(boxes=(box,)), noise=EXACT)
        assert robot.clearance_m == math.inf
        drive(robot, (0.5, 0.0), 4.0)
        assert math.isfinite(robot.clearance_m)

    def test_a_box_never_appears_onto_the_robot(self):
        robot = self.make(Scene(boxes=(Box(0.0, 0.0, 0.3, 0.3, from_s=0.5),)), noise=EXACT)
        robot.advance(1.0)
        assert robot.clearance_m == math.inf
        assert not robot.contacts

    def test_a_box_put_down_on_the_way_is_seen_touched_by_name_and_gone_when_taken_away(self):
        robot = self.make(Scene(spares=2), noise=EXACT)
        robot.stage.put(Box(2.0, 0.0, 0.5, 4.0, name="shelf"))
        robot.advance(TICK_S)
        # Its front face stands at x 1.75: sonar 3, 10 deg off at (0.245, 0.02), hears it at once.
        assert robot.sense().ranges_m[3] == pytest.approx(1.75 - 0.245, abs=2e-3)
        assert robot.clearance_m == pytest.approx(1.75 - P3AT.footprint.length_m / 2, abs=2e-3)
        drive(robot, (0.5, 0.0), 6.0)
        assert [c.name for c in robot.contacts] == ["shelf"]
        assert robot.truth.x == pytest.approx(1.75 - P3AT.footprint.length_m / 2, abs=0.01)
        assert robot.stage.take_away("shelf")
        drive(robot, (0.5, 0.0), 4.0)
        assert robot.truth.x > 2.5
        assert np.isinf(robot.sense().ranges_m).all()

    def test_a_box_put_down_onto_the_robot_waits_until_it_has_left(self):
        robot = self.make(Scene(spares=1), noise=EXACT)
        robot.stage.put(Box(0.0, 0.0, 0.3, 0.3, name="bucket"))
        robot.advance(TICK_S)
        assert robot.clearance_m == math.inf
        drive(robot, (0.5, 0.0), 4.0)
        assert robot.clearance_m == pytest.approx(
            robot.truth.x - P3AT.footprint.length_m / 2 - 0.15, abs=5e-3
        )
        assert not robot.contacts

    def test_no_more_boxes_stand_than_there_are_spares_and_a_spare_plays_another_box(self):
        robot = self.make(Scene(spares=1), noise=EXACT)
        robot.stage.put(Box(3.0, 0.0, 0.5, 4.0, name="one"))
        with pytest.raises(errors.StageFull, match="1 boxes stand"):
            robot.stage.put(Box(2.0, 0.0, 0.5, 4.0, name="two"))
        robot.advance(TICK_S)
        robot.stage.take_away("one")
        robot.stage.put(Box(0.0, 2.0, 6.0, 0.2, 0.0, name="two"))
        robot.advance(TICK_S)
        assert robot.clearance_m == pytest.approx(1.9 - P3AT.footprint.width_m / 2, abs=2e-3)
        assert robot.sense().ranges_m[0] == pytest.approx(1.9 - 0.136, abs=2e-3)

    def test_a_shove_moves_it_in_its_own_frame_unseen_by_the_wheels(self):
        robot = self.make(room(), (0.0, 0.0, math.pi / 2), noise=EXACT)
        robot.advance(TICK_S)
        robot.sense()
        robot.shove(0.5, 1.0, 0.25)
        robot.advance(TICK_S)
        assert robot.truth == pytest.approx((-1.0, 0.5, math.pi / 2 + 0.25), abs=2e-3)
        readings = robot.sense()
        assert readings.wheels_m == pytest.approx((0.0, 0.0), abs=1e-3)
        assert readings.gyro_radps * TICK_S == pytest.approx(0.25, abs=2e-3)

    def test_a_shove_into_a_wall_is_refused_and_changes_nothing(self):
        robot = self.make(room(), noise=EXACT)
        before = robot.truth
        with pytest.raises(cairn.errors.StandsInObstacle):
            robot.shove(0.0, 3.9)
        assert robot.truth == before

    def test_an_emergency_stop_brakes_at_once_and_ignores_commands_until_it_is_released(self):
        robot = self.make(NOWHERE, noise=EXACT)
        drive(robot, (0.5, 0.2), 3.0)
        before = robot.truth
        robot.emergency_stop(2.0)
        drive(robot, (0.5, 0.2), 1.0)
        stopped = robot.truth
        assert math.dist(stopped[:2], before[:2]) < 0.06  # by the ramp it would be 0.42 m
        drive(robot, (0.5, 0.2), 1.0)
        assert robot.truth == pytest.approx(stopped, abs=2e-3)
        drive(robot, (0.5, 0.0), 2.0)
        assert math.dist(robot.truth[:2], stopped[:2]) > 0.4

    def test_what_was_commanded_before_an_emergency_stop_is_forgotten(self):
        robot = self.make(NOWHERE, noise=EXACT)
        robot.command((0.5, 0.0))
        robot.emergency_stop(0.5)
        for _ in range(20):
            robot.advance(TICK_S)
        assert robot.truth == pytest.approx((0.0, 0.0, 0.0), abs=2e-3)

    def test_an_emergency_stop_of_no_time_is_refused(self):
        robot = self.make(NOWHERE)
        for for_s in (0.0, -1.0, math.nan, math.inf):
            with pytest.raises(cairn.errors.StepOutOfRange):
                robot.emergency_stop(for_s)

    def test_held_by_something_unseen_its_wheels_spin_and_it_stays(self):
        robot = self.make(NOWHERE, noise=EXACT)
        drive(robot, (0.3, 0.0), 2.0)
        robot.hold(0.4)
        before = robot.truth
        readings = drive(robot, (0.3, 0.0), 2.0)
        assert math.dist(robot.truth[:2], before[:2]) < 0.02
        assert sum(r.wheels_m[0] for r in readings) > 0.4
        assert robot.contacts == []
        assert math.isinf(robot.clearance_m)

    def test_what_holds_a_robot_lets_it_back_and_around(self):
        robot = self.make(NOWHERE, noise=EXACT)
        robot.hold(0.4)
        drive(robot, (-0.2, 0.0), 3.0)
        assert robot.truth.x < -0.3
        for _ in range(4):  # half a metre aside, then past it
            robot.shove(0.0, 0.15)
        drive(robot, (0.4, 0.0), 5.0)
        assert robot.truth.x > 0.3

    def test_a_hold_of_no_width_is_refused(self):
        robot = self.make(NOWHERE)
        for half_width_m in (0.0, -1.0, math.nan, math.inf):
            with pytest.raises(cairn.errors.StepOutOfRange):
                robot.hold(half_width_m)

    def test_on_a_floor_where_it_slips_more_the_robot_turns_less(self):
        turned = []
        for track_scale in (0.9, 1.0, 1.3):
            robot = self.make(NOWHERE, noise=EXACT)
            robot.change_floor(track_scale)
            drive(robot, (0.0, 0.5), 3.0)
            turned.append(robot.truth.heading)
        assert turned[0] > 1.05 * turned[1] > 1.25 * turned[2]
        for track_scale in (0.0, -1.0, math.nan, math.inf):
            with pytest.raises(cairn.errors.FloorOutOfRange):
                robot.change_floor(track_scale)

    def test_a_start_inside_something_is_refused_by_its_name(self):
        with pytest.raises(cairn.errors.StandsInObstacle) as caught:
            self.make(Scene(boxes=(Box(0.3, 0.0, 0.2, 0.2, name="chair"),)))
        assert caught.value.obstacle == "chair"

    def test_nonsense_commands_and_steps_are_refused(self):
        robot = self.make(NOWHERE)
        with pytest.raises(cairn.errors.CommandNotFinite):
            robot.command((math.nan, 0.0))
        for dt_s in (0.0, -0.1, math.nan, math.inf):
            with pytest.raises(cairn.errors.StepOutOfRange):
                robot.advance(dt_s)

    def test_the_same_seed_gives_the_same_bits_and_another_does_not(self):
        def record(seed):
            robot = self.make(room(), seed=seed)
            readings = drive(robot, (0.4, 0.3), 3.0)
            return [(r.ranges_m.tobytes(), r.wheels_m, r.gyro_radps) for r in readings], robot.truth

        assert record(7) == record(7)
        assert record(7)[0] != record(8)[0]

    def test_two_processes_give_the_same_bits(self):
        kind = type(self.make(NOWHERE)).__name__
        program = (
            f"from cairn.robots import {kind}\n"
            "from robot_contract import *\n"
            "scene = Scene(boxes=(Box(2, 1, 1, 1), Box(1.5, 0, 0.2, 0.2, from_s=1.0)))\n"
            f"robot = {kind}(P3AT, scene, (0, 0, 0), seed=5)\n"
            "for reading in drive(robot, (0.4, 0.2), 6.0):\n"
            "    print(reading.ranges_m.tobytes().hex(), reading.wheels_m, reading.gyro_radps)\n"
            "print(robot.truth, robot.contacts)\n"
        )
        runs = [
            subprocess.run(
                [sys.executable, "-c", program],
                capture_output=True,
                text=True,
                check=True,
                cwd=Path(__file__).parent,
            )
            for _ in range(2)
        ]
        assert runs[0].stdout == runs[1].stdout
        assert "Contact" in runs[0].stdout
