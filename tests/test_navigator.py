import itertools
import json
import math

import numpy as np
import pytest

import cairn
from cairn import errors
from cairn.navigator import transitions
from cairn.robots import KinematicRobot, Scene

P3AT = cairn.Profile.load("p3at")
START = (1.0, 1.0, 0.0)
SILENT = np.full(P3AT.range_count, np.inf)


def two_rooms(door=True) -> cairn.World:
    """8 m x 4 m; a wall at x = 4 m with a door of 1.2 m in its middle."""
    occupancy = np.zeros((80, 160), np.uint8)
    occupancy[:3] = occupancy[-3:] = 1
    occupancy[:, :3] = occupancy[:, -3:] = 1
    occupancy[:, 78:82] = 1
    if door:
        occupancy[28:52, 78:82] = 0
    return cairn.World(occupancy, resolution_m=0.05)


class Drive:
    """A kinematic robot in the loop with a navigator, its pose given by truth."""

    def __init__(self, world, scene=None, given="same", start=START, config=None, truth=True):
        noise = P3AT.noise.scaled(0.0)
        self.robot = KinematicRobot(P3AT, scene or Scene.from_world(world), start, noise=noise)
        known = world if given == "same" else given
        self.nav = cairn.Navigator(P3AT, known, start=start, config=config)
        self.truth = truth
        self.decisions = []

    def tick(self):
        seen = self.robot.sense()
        pose = self.robot.truth if self.truth else None
        decision = self.nav.step(seen.ranges_m, seen.wheels_m, seen.gyro_radps, 0.1, pose)
        self.robot.command(decision.twist)
        self.robot.advance(0.1)
        self.decisions.append(decision)
        return decision

    def until(self, done, seconds=90.0):
        for _ in range(round(seconds * 10)):
            decision = self.tick()
            if done(decision):
                return decision
        raise AssertionError(f"not within {seconds} s; last: {self.decisions[-1]!r}")

    def modes(self):
        changes = [self.decisions[0].mode]
        for decision in self.decisions:
            if decision.mode != changes[-1]:
                changes.append(decision.mode)
        return changes


def ended(decision):
    return decision.goal_status in ("reached", "refused", "cancelled")


def at_rest(decision):
    return decision.mode == "stop" and decision.twist == (0.0, 0.0)


def test_a_goal_in_the_next_room_is_planned_tracked_and_reached():
    drive = Drive(two_rooms())
    drive.nav.set_goal((7.0, 3.0))
    drive.until(ended)
    drive.until(at_rest)
    assert drive.modes() == ["stop", "path_planning", "path_tracking", "stop"]
    assert drive.decisions[-1].goal_status == "reached"
    assert math.dist(drive.robot.truth[:2], (7.0, 3.0)) < 0.15
    assert drive.robot.contacts == []
    assert drive.nav.plan_count == 1


def test_the_path_leads_from_the_robot_to_the_exact_goal_and_the_field_falls_along_it():
    drive = Drive(two_rooms())
    drive.nav.set_goal((7.0, 3.0))
    drive.until(lambda d: d.mode == "path_tracking")
    path = drive.nav.path
    assert path is not None
    assert tuple(path[-1]) == (7.0, 3.0)
    assert math.dist(path[0], START[:2]) < 1e-9
    values = [drive.nav.field.cost_to_go_at(x, y) for x, y in path[1:]]
    assert all(a > b for a, b in itertools.pairwise(values))


def test_a_tracking_record_names_inputs_memberships_rules_and_command():
    drive = Drive(two_rooms())
    drive.nav.set_goal((7.0, 3.0))
    record = drive.until(lambda d: d.mode == "path_tracking" and d.twist[0] > 0.2).to_dict()
    tracking = record["tracking"]
    for key in ("C", "dR", "dtheta", "Vc", "alpha1", "alpha2", "look_ahead", "tracker", "caps"):
        assert key in tracking
    assert sum(tracking["tracker"]["strengths"]) > 0 if "strengths" in tracking["tracker"] else True
    assert record["cost_to_go"] > 0
    assert record["way"]["blocked"] is None


def test_a_record_is_strict_json_and_says_everything_twice_the_same():
    def run():
        drive = Drive(two_rooms(), truth=False)
        drive.nav.set_goal((7.0, 3.0))
        drive.until(ended)
        return [decision.to_json() for decision in drive.decisions]

    first = run()
    assert first == run()
    for line in first:
        json.loads(line, parse_constant=lambda what: pytest.fail(f"{what} in the record"))


def test_with_its_own_odometry_it_arrives_too():
    drive = Drive(two_rooms(), truth=False)
    drive.nav.set_goal((7.0, 3.0))
    assert drive.until(ended).goal_status == "reached"
    assert math.dist(drive.robot.truth[:2], (7.0, 3.0)) < 0.3


def test_a_goal_behind_a_closed_wall_is_refused_with_the_reason():
    drive = Drive(two_rooms(door=False))
    drive.nav.set_goal((7.0, 3.0))
    last = drive.until(ended)
    assert last.goal_status == "refused"
    assert last.to_dict()["status"]["refusal"]["code"] == "no_path"
    assert "no path" in last.sentence
    assert last.mode == "stop"


@pytest.mark.parametrize(
    ("goal", "code"),
    [
        ((4.0, 0.5), "goal_blocked"),
        ((7.75, 3.0), "goal_blocked"),
        ((20.0, 3.0), "goal_outside_map"),
    ],
)
def test_a_goal_that_cannot_be_occupied_is_refused_and_not_moved(goal, code):
    drive = Drive(two_rooms())
    drive.nav.set_goal(goal)
    last = drive.until(ended)
    assert last.to_dict()["status"]["refusal"]["code"] == code
    assert drive.robot.truth[:2] == pytest.approx(START[:2], abs=1e-6)


def test_after_a_refusal_the_next_goal_is_taken():
    drive = Drive(two_rooms())
    drive.nav.set_goal((4.0, 0.5))
    assert drive.until(ended).goal_status == "refused"
    drive.nav.set_goal((7.0, 3.0))
    drive.tick()
    assert drive.until(ended).goal_status == "reached"


def test_cancel_brakes_to_rest_and_forgets_the_goal():
    drive = Drive(two_rooms())
    drive.nav.set_goal((7.0, 3.0))
    drive.until(lambda d: d.twist[0] > 0.3)
    drive.nav.cancel()
    assert drive.tick().goal_status == "cancelled"
    drive.until(at_rest, seconds=5)
    for _ in range(20):
        assert drive.tick().mode == "stop"


def test_a_cancel_holds_though_the_pose_is_lost_in_the_same_tick():
    def carried_off():
        drive = Drive(two_rooms(), truth=False, config={"localise": True})
        drive.nav.set_goal((7.0, 3.0))
        drive.until(lambda d: d.twist[0] > 0.3)
        drive.robot.shove(1.0, 1.2)
        return drive

    def is_lost(decision):
        return decision.to_dict()["localisation"]["state"] == "searching"

    drive = carried_off()
    before = len(drive.decisions)
    drive.until(is_lost)
    ticks = len(drive.decisions) - before - 1
    again = carried_off()
    for _ in range(ticks):
        assert not is_lost(again.tick())
    again.nav.cancel()
    assert is_lost(again.tick())
    assert again.decisions[-1].goal_status == "cancelled"
    assert all(again.tick().mode == "stop" for _ in range(50))


def test_a_new_goal_while_moving_is_planned_only_at_rest():
    drive = Drive(two_rooms())
    drive.nav.set_goal((7.0, 3.0))
    drive.until(lambda d: d.twist[0] > 0.3)
    drive.nav.set_goal((1.0, 3.0))
    assert drive.tick().reason == "new_task_while_moving"
    planned = drive.until(lambda d: d.mode == "path_planning", seconds=5)
    assert abs(planned.to_dict()["measured"]["linear_mps"]) < 0.02
    drive.until(ended)
    assert math.dist(drive.robot.truth[:2], (1.0, 3.0)) < 0.15


def test_a_new_goal_begins_with_nothing_of_the_old_one_s_way():
    drive = Drive(two_rooms())
    drive.nav.set_goal((2.5, 1.0))
    drive.until(ended)
    assert len(drive.nav.waypoints) > 0
    drive.nav.set_goal((1.0, 3.0))
    assert (len(drive.nav.waypoints), drive.nav.path) == (0, None)
    assert drive.tick().to_dict()["waypoint_index"] is None


def test_knocked_off_its_path_the_robot_walks_the_field_anew_without_a_plan():
    drive = Drive(two_rooms())
    drive.nav.set_goal((7.0, 2.0))
    drive.until(lambda d: d.twist[0] > 0.3)
    drive.robot.shove(0.0, 0.9)
    drive.until(ended)
    assert any(decision.to_dict()["rewalked"] for decision in drive.decisions)
    assert drive.decisions[-1].goal_status == "reached"
    assert drive.nav.plan_count == 1


def test_a_shared_field_saves_the_second_robot_its_plan():
    first = Drive(two_rooms())
    first.nav.set_goal((7.0, 2.0))
    first.until(lambda d: d.mode == "path_tracking")
    second = Drive(two_rooms(), start=(1.0, 3.0, 0.0))
    second.nav.set_goal((7.0, 2.0), field=first.nav.field)
    assert second.until(ended).goal_status == "reached"
    assert (first.nav.plan_count, second.nav.plan_count) == (1, 0)


def test_a_shared_field_does_not_make_a_robot_forget_what_it_saw():
    world = two_rooms()
    scene = Scene.from_world(world.with_boxes([[2.1, 2.0, 0.4, 0.6]]))
    drive = Drive(world, scene, start=(0.8, 2.0, 0.0))
    drive.nav.set_goal((3.3, 2.0))
    assert drive.until(ended).goal_status == "reached"
    elsewhere = Drive(world, start=(1.0, 3.0, 0.0))
    elsewhere.nav.set_goal((0.8, 2.0))
    elsewhere.until(lambda d: d.mode == "path_tracking")
    drive.nav.set_goal((0.8, 2.0), field=elsewhere.nav.field)
    drive.until(lambda d: d.mode == "path_tracking")
    assert drive.nav.plan_count == 1
    way = np.vstack([drive.robot.truth[:2], drive.nav.waypoints])
    along = np.concatenate([np.linspace(a, b, 20) for a, b in itertools.pairwise(way)])
    outside = np.maximum(abs(along - (2.1, 2.0)) - (0.2, 0.3), 0)
    assert np.hypot(*outside.T).min() > 0.2


def test_an_unmapped_box_on_the_path_is_driven_around_without_contact():
    world = two_rooms()
    scene = Scene.from_world(world.with_boxes([[2.4, 2.05, 0.4, 0.4]]))
    drive = Drive(world, scene, start=(0.8, 2.0, 0.0))
    drive.nav.set_goal((7.0, 2.0))
    assert drive.until(ended).goal_status == "reached"
    assert any(decision.recovery for decision in drive.decisions)
    assert drive.nav.plan_count == 1
    assert drive.robot.contacts == []


def test_without_a_map_it_heads_for_the_goal_at_once_and_maps_on_the_way():
    drive = Drive(two_rooms(), given=None, start=(1.0, 2.0, 0.0))
    drive.nav.set_goal((3.0, 2.0))
    assert drive.until(ended).goal_status == "reached"
    assert drive.modes()[:2] == ["stop", "obstacle_avoidance"]
    seen = drive.nav.map()
    assert (seen.occupancy == 1).sum() > 50
    assert (seen.occupancy == 0).sum() > 1000


def test_a_map_without_a_known_pose_is_as_no_map():
    nav = cairn.Navigator(P3AT, two_rooms())
    nav.set_goal((3.0, 2.0))
    modes = [nav.step(SILENT, (0, 0), None, 0.1).mode for _ in range(3)]
    assert modes == ["stop", "obstacle_avoidance", "obstacle_avoidance"]


NOT_MEASURED = np.full(P3AT.range_count, np.nan)


@pytest.mark.parametrize("localise", [False, True])
def test_what_was_seen_before_the_pose_was_told_is_not_on_the_given_map(localise):
    world = two_rooms()
    nav = cairn.Navigator(P3AT, world, config={"localise": localise})
    nav.set_goal((3.0, 2.0))
    for _ in range(30):
        nav.step(np.full(P3AT.range_count, 1.0), (0.0, 0.0), 0.0, 0.1)
    assert nav.map().occupancy.shape != world.occupancy.shape
    nav.step(NOT_MEASURED, (0.0, 0.0), 0.0, 0.1, START)
    assert np.array_equal(nav.map().occupancy == 1, world.occupancy == 1)


def test_a_goal_given_before_the_pose_is_planned_on_the_map_once_the_pose_is_told():
    drive = Drive(two_rooms())
    drive.nav = cairn.Navigator(P3AT, two_rooms())
    drive.nav.set_goal((7.0, 1.0))
    drive.truth = False
    for _ in range(10):
        drive.tick()
    drive.truth = True
    decision = drive.until(ended)
    assert decision.goal_status == "reached"
    assert "path_tracking" in drive.modes()


def test_a_map_that_is_met_before_the_pose_keeps_a_shared_field():
    world = two_rooms()
    first = Drive(world)
    first.nav.set_goal((7.0, 1.0))
    first.until(lambda decision: decision.mode == "path_tracking")
    second = cairn.Navigator(P3AT, world)
    second.set_goal((7.0, 1.0), field=first.nav.field)
    for _ in range(5):
        decision = second.step(NOT_MEASURED, (0.0, 0.0), 0.0, 0.1, START)
    assert (decision.mode, second.plan_count) == ("path_tracking", 0)


def test_where_a_lost_robot_looks_around_an_echo_from_afar_marks_nothing():
    for range_m, marks in ((2.5, False), (1.5, True)):
        nav = cairn.Navigator(P3AT, two_rooms(), config={"localise": True})
        for _ in range(20):
            nav.step(np.full(P3AT.range_count, range_m), (0.0, 0.0), 0.0, 0.1)
        assert (nav.map().occupancy == 1).any() == marks


@pytest.mark.parametrize("far", [(5.1e5, 5.4e6), (-1e300, 1e300)])
def test_a_goal_farther_than_a_map_may_reach_is_refused_and_does_no_harm(far):
    nav = cairn.Navigator(P3AT, start=START, config={"trap": {"patience_s": 1.0}})
    nav.set_goal(far)
    hemmed_in = np.full(P3AT.range_count, 0.3)
    for _ in range(600):
        decision = nav.step(hemmed_in, (0.0, 0.0), 0.0, 0.1)
        if ended(decision):
            break
    assert decision.to_dict()["status"]["refusal"] == {"code": "goal_outside_map"}


def test_cancelling_what_has_ended_changes_nothing():
    nav = cairn.Navigator(P3AT, two_rooms(door=False), start=START, config={"doubts": 0})
    nav.set_goal((7.0, 1.0))
    status = {nav.step(SILENT, (0, 0), 0.0, 0.1, START).goal_status for _ in range(100)}
    assert "refused" in status
    nav.cancel()
    assert nav.step(SILENT, (0, 0), 0.0, 0.1, START).goal_status == "refused"
    idle = cairn.Navigator(P3AT, start=START)
    idle.cancel()
    assert idle.step(SILENT, (0, 0), 0.0, 0.1).goal_status == "idle"


@pytest.mark.parametrize(
    ("setting", "error", "key"),
    [
        ({"waypoints": {"spacing_m": 0.0}}, errors.TrackValueOutOfRange, "spacing_m"),
        ({"waypoints": {"corridor_m": -1.0}}, errors.TrackValueOutOfRange, "corridor_m"),
        ({"costmap": {"soft_margin_m": -1.0}}, errors.CostmapValueOutOfRange, "soft_margin_m"),
    ],
)
def test_a_setting_no_way_can_be_planned_with_is_refused_at_once(setting, error, key):
    for world in (None, two_rooms()):
        with pytest.raises(error) as caught:
            cairn.Navigator(P3AT, world, start=START, config=setting)
        assert caught.value.key == key


def test_a_map_on_which_the_robot_fits_nowhere_is_refused_before_the_drive_not_when_it_is_lost():
    occupancy = np.ones((40, 40), np.uint8)
    occupancy[18:22] = 0
    world = cairn.World(occupancy, resolution_m=0.05)
    for start in (None, START):
        with pytest.raises(errors.LocaliseNoRoom):
            cairn.Navigator(P3AT, world, start=start, config={"localise": True})


def test_without_map_and_pose_it_stands_until_the_gyros_bias_is_learnt_and_says_so():
    nav = cairn.Navigator(P3AT)
    nav.set_goal((30.0, 20.0))
    first = [nav.step(SILENT, (0, 0), 0.002, 0.1) for _ in range(20)]
    assert {decision.mode for decision in first} == {"stop"}
    assert "gyroscope's bias" in first[-1].sentence
    later = [nav.step(SILENT, (0, 0), 0.002, 0.1).mode for _ in range(200)]
    assert later[-1] == "obstacle_avoidance"
    assert abs(nav.pose.heading) < 0.01


def test_forbidden_ground_is_not_crossed_though_nothing_stands_there():
    world = two_rooms()
    costs = np.ones(world.shape, np.float32)
    costs[:, 50:60] = np.inf
    closed = cairn.World(world.occupancy, resolution_m=0.05, costs=costs)
    drive = Drive(world, given=closed)
    drive.nav.set_goal((7.0, 3.0))
    assert drive.until(ended).to_dict()["status"]["refusal"]["code"] == "no_path"
    costs[10:30, 50:60] = 1.0
    drive = Drive(world, given=cairn.World(world.occupancy, resolution_m=0.05, costs=costs))
    drive.nav.set_goal((7.0, 3.0))
    assert drive.until(ended).goal_status == "reached"
    crossing = [d.pose.y for d in drive.decisions if 2.5 < d.pose.x < 3.0]
    assert all(0.5 < y < 1.5 for y in crossing)


def test_a_world_already_priced_for_the_robot_still_lets_it_through_the_door():
    priced = cairn.costmap(two_rooms(), P3AT)
    drive = Drive(two_rooms(), given=priced)
    drive.nav.set_goal((7.0, 3.0))
    assert drive.until(ended).goal_status == "reached"


@pytest.mark.parametrize("goal", [None, (1.0,), [(1.0, 1.0), (2.0, 2.0)], "there"])
def test_a_malformed_goal_is_refused_by_name(goal):
    with pytest.raises(errors.GoalMalformed):
        cairn.Navigator(P3AT).set_goal(goal)


def test_a_start_inside_the_margin_leaves_to_free_space():
    drive = Drive(two_rooms(), start=(0.45, 2.0, math.pi / 2))
    drive.nav.set_goal((3.0, 2.0))
    assert drive.until(ended).goal_status == "reached"
    assert drive.robot.contacts == []


def test_a_start_inside_an_obstacle_of_the_map_is_refused():
    closed = two_rooms()
    nav = cairn.Navigator(P3AT, closed, start=(4.0, 0.5, 0.0))
    nav.set_goal((7.0, 3.0))
    for _ in range(4):
        last = nav.step(SILENT, (0, 0), 0.0, 0.1)
    assert last.to_dict()["status"]["refusal"]["code"] == "start_blocked"


def test_exploring_sees_the_room_and_ends_by_itself():
    occupancy = np.zeros((80, 80), np.uint8)
    occupancy[:3] = occupancy[-3:] = 1
    occupancy[:, :3] = occupancy[:, -3:] = 1
    drive = Drive(cairn.World(occupancy, resolution_m=0.05), given=None, start=(2.0, 2.0, 0.0))
    drive.nav.explore()
    last = drive.until(ended, seconds=240)
    assert last.to_dict()["status"]["refusal"]["code"] == "nothing_left_to_explore"
    seen = drive.nav.map()
    inside = [seen.occupancy[seen.cell_of((x, y))] for x in (1, 2, 3) for y in (1, 2, 3)]
    assert all(cell == 0 for cell in inside)
    assert drive.robot.contacts == []


def test_every_pair_of_mode_and_event_has_one_row_with_a_reason():
    rows = transitions()
    modes = {row[0] for row in rows}
    events = {row[1] for row in rows}
    assert len(modes) == 4
    assert len({row[:2] for row in rows}) == len(rows) == len(modes) * len(events)
    assert all(reason for *_, reason in rows)


@pytest.mark.parametrize(
    ("change", "error", "field"),
    [
        ({"ranges": SILENT[:-1]}, errors.RangeCountWrong, ("given", P3AT.range_count - 1)),
        ({"ranges": np.r_[-0.1, SILENT[1:]]}, errors.RangeNegative, ("index", 0)),
        ({"ranges": SILENT[None, :]}, errors.RangeCountWrong, ("given", P3AT.range_count)),
        ({"wheels": (0.0,)}, errors.MeasurementNotFinite, ("what", "wheels")),
        ({"dt_s": 0.0}, errors.TimeStepInvalid, ("dt_s", 0.0)),
        ({"dt_s": float("nan")}, errors.TimeStepInvalid, None),
        ({"wheels": (float("nan"), 0.0)}, errors.MeasurementNotFinite, None),
        ({"gyro": float("inf")}, errors.MeasurementNotFinite, ("what", "gyro rate")),
        ({"world_from_robot": (0.0, float("nan"), 0.0)}, errors.MeasurementNotFinite, None),
    ],
)
def test_input_that_cannot_be_a_measurement_is_refused_and_changes_nothing(change, error, field):
    nav = cairn.Navigator(P3AT, two_rooms(), start=START)
    good = {"ranges": SILENT, "wheels": (0.0, 0.0), "gyro": 0.0, "dt_s": 0.1}
    nav.step(**good)
    with pytest.raises(error) as caught:
        nav.step(**{**good, **change})
    if field:
        assert getattr(caught.value, field[0]) == field[1]
    assert nav.step(**good).to_dict()["tick"] == 1


def test_a_goal_that_is_no_place_is_refused_by_name():
    nav = cairn.Navigator(P3AT)
    with pytest.raises(errors.GoalNotFinite):
        nav.set_goal((float("nan"), 0.0))


def test_unknown_and_unusable_settings_are_refused_by_name():
    with pytest.raises(ValueError, match="arrival"):
        cairn.Navigator(P3AT, config={"arrivel_m": 0.1})
    with pytest.raises(errors.NavigatorSettingInvalid) as caught:
        cairn.Navigator(P3AT, config={"trap": {"patience_s": -1.0}})
    assert (caught.value.key, caught.value.value) == ("trap.patience_s", -1.0)
    with pytest.raises(errors.ControllerNotFound):
        cairn.Navigator(P3AT, controller="nobody")


def test_ranges_not_measured_say_nothing():
    nav = cairn.Navigator(P3AT, start=START)
    decision = nav.step(np.full(P3AT.range_count, np.nan), (0, 0), None, 0.1)
    assert decision.mode == "stop"
    assert nav.map().occupancy.size == 0 or (nav.map().occupancy == 1).sum() == 0


def test_an_echo_from_afar_marks_nothing_where_no_map_is_given():
    for range_m, marks in ((2.5, False), (1.5, True)):
        nav = cairn.Navigator(P3AT, None, start=START)
        for _ in range(20):
            nav.step(np.full(P3AT.range_count, range_m), (0.0, 0.0), 0.0, 0.1)
        assert (nav.map().occupancy == 1).any() == marks
