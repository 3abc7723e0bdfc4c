"""A run that is watched and steered: in its own thread, at its own pace."""

import math
import threading

import numpy as np
import pytest

from cairn import errors
from cairn.missions import Scenario, run
from cairn.missions.live import SPARES, Live, with_nothing_to_do
from cairn.missions.scenario import RobotEntry, Start, WorldEntry
from cairn.missions.setting import way_left_m
from cairn.view.console import commands as ask
from cairn.view.console.shapes import scan_points

QUICK = Scenario.load("quick")
ROOM = with_nothing_to_do(QUICK)


def a_live(scenario=ROOM, **options):
    return Live(scenario, **{"speed": math.inf, "open_end": True, **options}).start()


def until(live, holds, patience=3000):
    """The first snapshot for which `holds`."""
    number = 0
    for _ in range(patience):
        snapshot = live.newer(number, 10.0)
        assert snapshot is not None, "the run stands still"
        if holds(snapshot):
            return snapshot
        number = snapshot.number
    raise AssertionError("never came")


def after(live, snapshot, seconds):
    return until(live, lambda s: s.time_s >= snapshot.time_s + seconds)


def _stands(live):
    """Wait until all steps asked for are done."""
    time_s = None
    while (snapshot := live.newer(0, 10.0)).time_s != time_s:
        time_s = snapshot.time_s
        live.newer(snapshot.number, 0.2)


def ended(goals):
    return lambda snapshot: len(snapshot.robots[0].goals) == goals


def test_what_a_paused_robot_sees_and_believes_is_of_where_it_is_drawn():
    """By lidar at well over 1 m/s: a tick ahead would be visible."""
    lidar = with_nothing_to_do(Scenario.load("lidar"))
    changes = {"world": WorldEntry(map="room"), "start": QUICK.start, "noise": 0.0}
    lidar = lidar.model_copy(update=changes)
    live = a_live(lidar, speed=20.0)
    live.do(ask.DriveTo(7.0, 5.0))
    until(live, lambda s: s.robots[0].decision["twist"]["linear_mps"] > 1.0)
    live.do(ask.Pause())
    snapshot = until(live, lambda s: s.paused)
    _stands(live)
    robot = live.newer(snapshot.number - 1, 10.0).robots[0]
    assert robot.decision["twist"]["linear_mps"] > 0.5
    assert math.dist(robot.truth[:2], robot.estimate[:2]) < 0.03
    points = scan_points(robot.body, robot.ranges_m, robot.truth)
    world = snapshot.world
    rows, cols = np.nonzero(world.values == 1)
    walls = (np.column_stack([cols, rows]) + 0.5) * world.resolution_m + world.origin[:2]
    away = np.abs(points[::10, None] - walls).max(axis=2).min(axis=1)
    assert len(points) > 500
    assert away.max() < 0.51 * world.resolution_m + 1e-6
    live.end()


def test_the_way_left_goes_by_the_nearest_point_of_a_plan_and_on_to_the_goal():
    plan = np.array([(0.0, 0.0), (10.0, 0.0), (10.0, 4.0)])
    assert way_left_m(plan, (6.0, 1.0, 0.0), (10.0, 4.0)) == pytest.approx(1 + 4 + 4)
    assert way_left_m(plan, (10.0, 3.0, 0.0), (13.0, 4.0)) == pytest.approx(1 + 3)
    assert way_left_m(None, (0.0, 0.0, 0.0), (3.0, 4.0)) == pytest.approx(5)


# ---- the loop does not wait ----------------------------------------------------------------------


def test_a_run_that_is_watched_is_the_run_that_is_not():
    live = Live(QUICK, speed=math.inf).start()
    number = 0
    while not live.ended:
        snapshot = live.newer(number, 1.0)
        number = snapshot.number if snapshot else number
    live.wait()
    watched, alone = live.results[0].to_dict(), run(QUICK).to_dict()
    del watched["wall"], alone["wall"]
    assert number > 2
    assert watched == alone


def test_a_view_that_sleeps_over_its_first_snapshot_does_not_hold_up_the_run():
    live, asleep = Live(QUICK, speed=math.inf), threading.Event()
    woken = threading.Event()

    def view():
        live.newer(0, 10.0)
        asleep.set()
        woken.wait()

    viewer = threading.Thread(target=view)
    viewer.start()
    live.start()
    asleep.wait()
    assert live.wait(60.0)
    assert not woken.is_set()
    woken.set()
    viewer.join()
    # The first moment, the end, and one for each time somebody asked: nobody else pays for a view.
    assert live.snapshot().number <= 3
    assert live.results[0].reached


def test_who_comes_late_gets_the_newest_moment():
    live = Live(QUICK, speed=math.inf).start()
    assert live.wait(60.0)
    snapshot = live.snapshot()
    assert snapshot.over == live.results[0].sentence
    assert snapshot.time_s == live.results[0].time_s


def test_a_snapshot_shares_nothing_with_the_run():
    live = a_live()
    live.do(ask.DriveTo(4.0, 3.0))
    before = until(live, lambda s: s.robots[0].driven_m > 0.2)
    state = before.robots[0]
    kept = [each.copy() for each in (state.path, state.trail, state.ranges_m, before.grid.values)]
    after(live, before, 1.0)
    live.end()
    now = (state.path, state.trail, state.ranges_m, before.grid.values)
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(kept, now, strict=True))
    assert set(state.decision) >= {"mode", "sentence", "tracking", "avoidance", "twist"}


def test_what_breaks_the_run_is_raised_where_it_is_waited_for():
    def broken(tick):
        raise OSError("disk full")

    live = Live(QUICK, speed=math.inf, observers=lambda run: [broken]).start()
    with pytest.raises(OSError, match="disk full"):
        live.wait(60.0)


def test_a_run_that_people_hindered_can_be_run_again_from_its_record():
    live = Live(QUICK, speed=math.inf, paused=True).start()
    for command in (
        ask.Step(31),
        ask.PutBox(4.0, 2.6, 0.4, 0.7, 0.5),
        ask.Step(40),
        ask.Carry(2.0, 1.2, 0.3),
        ask.Step(30),
        ask.TakeBox("dropped 1"),
        ask.Step(5),
        ask.DriveTo(4.0, 3.0),
        ask.Pause(False),
    ):
        live.do(command)
        until(live, lambda s: s.paused or s.over, patience=100)
        if isinstance(command, ask.Step):
            _stands(live)
    assert live.wait(60.0)
    (result,) = live.results
    assert [type(event).__name__ for event in result.scenario.events] == ["Shove", "NewGoal"]
    watched, again = result.to_dict(), run(result.scenario).to_dict()
    for record in (watched, again):
        del record["wall"], record["config_hash"]
    assert watched == again


# ---- commands ------------------------------------------------------------------------------------


def test_a_goal_given_is_driven_to_and_a_second_one_replaces_it():
    live = a_live()
    live.do(ask.DriveTo(4.0, 3.0))
    until(live, lambda s: s.robots[0].driven_m > 0.3)
    live.do(ask.DriveTo(2.0, 2.5))
    last = until(live, ended(2))
    assert [goal["outcome"] for goal in last.robots[0].goals] == ["replaced", "reached"]
    assert math.dist(last.robots[0].truth[:2], (2.0, 2.5)) < 0.3
    result = live.end()
    assert result.exit_code == 0
    assert result.robots[0].goals[1].error_m < 0.3


def test_a_goal_that_cannot_be_reached_is_refused_in_words_and_ends_with_code_3():
    live = a_live()
    live.do(ask.DriveTo(400.0, 3.0))
    told = until(live, lambda s: s.notes).notes[-1]
    assert told.wrong
    assert "outside the map" in told.text
    assert live.end().exit_code == 3


def test_a_goal_left_behind_at_the_end_is_not_reached():
    live = a_live()
    live.do(ask.DriveTo(4.0, 3.0))
    until(live, lambda s: s.robots[0].driven_m > 0.3)
    result = live.end()
    assert [goal.outcome for goal in result.robots[0].goals] == ["abandoned"]
    assert result.exit_code == 3


def test_a_goal_may_take_as_long_as_the_scenario_and_no_longer():
    live = a_live(ROOM.model_copy(update={"timeout_s": 2.0}))
    live.do(ask.DriveTo(4.0, 3.0))
    last = until(live, ended(1))
    assert last.robots[0].goals[0]["outcome"] == "timed_out"
    assert live.end().exit_code == 3


def test_a_run_without_goals_is_no_failure():
    live = a_live()
    until(live, lambda s: s.time_s > 1.0)
    result = live.end()
    assert (result.exit_code, result.sentence) == (0, "no goal was given.")


def test_a_box_put_on_the_way_is_a_body_that_the_robot_goes_around():
    live = a_live()
    live.do(ask.DriveTo(4.6, 2.5))
    live.do(ask.PutBox(2.9, 2.5, 0.5, 0.5))
    box = until(live, lambda s: s.boxes).boxes[0]
    assert (box.x, box.y, box.name) == (2.9, 2.5, "dropped 1")
    result_of = until(live, ended(1)).robots[0]
    assert result_of.goals[0]["outcome"] == "reached"
    # It went around: never nearer to the box's middle than half the box and half its own width.
    away = np.hypot(*(result_of.trail - (2.9, 2.5)).T).min()
    assert away > 0.25 + result_of.body.width_m / 2
    live.do(ask.TakeBox("dropped 1"))
    until(live, lambda s: not s.boxes)
    assert live.end().contacts == 0


def test_more_boxes_than_there_is_room_for_are_refused():
    live = a_live(paused=True)
    for _ in range(SPARES + 1):
        live.do(ask.PutBox(4.0, 3.0, 0.1, 0.1))
    last = until(live, lambda s: s.notes)
    assert last.notes[-1].wrong
    assert len(last.boxes) == SPARES
    assert last.spares_left == 0
    live.end()


def test_a_robot_is_carried_elsewhere_but_not_into_a_wall():
    live = a_live()
    live.do(ask.Carry(4.0, 3.0, math.pi / 2))
    moved = until(live, lambda s: s.robots[0].truth[0] > 3.9)
    assert moved.robots[0].truth == pytest.approx((4.0, 3.0, math.pi / 2), abs=1e-6)
    assert math.dist(moved.robots[0].estimate[:2], (4.0, 3.0)) > 1.0  # nobody told it
    live.do(ask.Carry(0.0, 0.0))
    note = until(live, lambda s: s.notes).notes[-1]
    assert note.wrong
    assert "wall" in note.text
    live.end()


def test_the_stop_button_brings_it_to_rest_at_once_and_calls_everything_off():
    live = a_live()
    live.do(ask.DriveTo(4.0, 3.0))
    moving = until(live, lambda s: s.robots[0].decision["twist"]["linear_mps"] > 0.25)
    live.do(ask.StopNow())
    stopped = until(live, ended(1))
    assert stopped.robots[0].goals[0]["outcome"] == "cancelled"
    assert stopped.time_s - moving.time_s < 2.0
    later = after(live, stopped, 2.0)
    assert math.dist(later.robots[0].truth[:2], stopped.robots[0].truth[:2]) < 0.01
    live.end()


def test_time_stands_still_while_paused_and_steps_are_tenths_of_a_second():
    live = a_live(paused=True)
    assert until(live, lambda s: True).time_s == 0.0
    live.do(ask.Step(3))
    assert until(live, lambda s: s.time_s > 0.25).time_s == pytest.approx(0.3)
    live.do(ask.DriveTo(4.0, 3.0))
    asked = until(live, lambda s: s.robots[0].goal)  # what was asked shows before time goes on
    assert asked.time_s == pytest.approx(0.3)
    live.do(ask.Pause(False))
    until(live, ended(1))
    assert live.end().exit_code == 0


def test_beginning_anew_closes_the_run_and_stands_the_robot_where_it_was_asked():
    live = a_live()
    live.do(ask.DriveTo(4.0, 3.0))
    until(live, ended(1))
    live.do(ask.Begin((4.0, 3.0, 1.0)))
    anew = until(live, lambda s: s.run == 1)
    assert anew.robots[0].truth == pytest.approx((4.0, 3.0, 1.0), abs=1e-3)
    assert anew.robots[0].estimate == pytest.approx((4.0, 3.0, 1.0), abs=1e-3)
    live.do(ask.Begin((0.0, 0.0, 0.0)))  # inside a wall
    refused = until(live, lambda s: s.notes and s.notes[-1].wrong)
    assert refused.run == 1
    live.end()
    assert [len(result.robots[0].goals) for result in live.results] == [1, 0]


def test_a_speed_must_be_above_nothing():
    with pytest.raises(ValueError, match="above 0"):
        Live(ROOM, speed=0.0)
    live = a_live(paused=True)
    live.do(ask.Speed(-1.0))
    assert until(live, lambda s: s.notes).notes[-1].wrong
    live.end()


def test_each_robot_takes_its_own_commands():
    several = ROOM.model_copy(
        update={
            "start": None,
            "robots": tuple(
                RobotEntry(name=name, start=Start(x_m=x, y_m=1.5))
                for name, x in (("left", 1.5), ("right", 4.5))
            ),
        }
    )
    live = a_live(several)
    live.do(ask.DriveTo(4.5, 3.0, robot=1))
    live.do(ask.Show(1))
    last = until(live, lambda s: s.robots[1].goals)
    assert last.robots[1].goals[0]["outcome"] == "reached"
    assert last.robots[0].driven_m < 0.01
    live.do(ask.CallOff(7))
    assert "no robot 7" in until(live, lambda s: s.notes and s.notes[-1].wrong).notes[-1].text
    live.end()


def test_a_scenario_that_does_not_fit_is_refused_before_anything_runs():
    with pytest.raises(errors.CairnError):
        Live(ROOM.model_copy(update={"map": "no such map"}))
