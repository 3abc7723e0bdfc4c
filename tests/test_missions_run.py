import dataclasses
import json
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest

from cairn import Profile, World, errors
from cairn.missions import Scenario, run
from cairn.missions.scenario import WorldEntry
from cairn.missions.setting import Agent, Setting, point_of, start_pose
from cairn.record import write_summary
from cairn.robots import KinematicRobot, Scene


class Twist(NamedTuple):
    linear_mps: float
    angular_radps: float


@dataclass
class Decision:
    twist: Twist
    mode: str
    event: str
    reason: str
    sentence: str
    pose: tuple[float, float, float]
    goal_status: str

    def to_dict(self):
        return {"mode": self.mode, "least": math.inf}


@dataclass
class StraightNavigator:
    """Turns to the goal and drives straight at it, by the true pose; refuses goals at x < 0."""

    stop_short_m: float = 0.1
    path: np.ndarray | None = None
    plan_count: int = 0
    goal: tuple[float, float] | None = None
    exploring: bool = False
    given: list = dataclasses.field(default_factory=list)

    @property
    def field(self):
        return None if self.goal is None else f"field to {self.goal}"

    def set_goal(self, goal, field=None):
        self.goal, self.plan_count = goal, self.plan_count + (field is None)
        self.given.append(field)

    def explore(self):
        self.exploring = True

    def cancel(self):
        self.goal, self.exploring = None, False

    def step(self, ranges, wheels, gyro, dt_s, world_from_robot=None):
        pose = world_from_robot
        if self.goal is None:
            return Decision(
                Twist(0.0, 0.0), "stop", "nothing", "idle", "nothing to do", pose, "none"
            )
        if self.goal[0] < 0:
            return Decision(
                Twist(0.0, 0.0),
                "stop",
                "goal_unattainable",
                "no_way",
                "no way there",
                pose,
                "refused",
            )
        self.path = np.array([pose[:2], self.goal])
        dx, dy = self.goal[0] - pose[0], self.goal[1] - pose[1]
        if math.hypot(dx, dy) < self.stop_short_m:
            return Decision(
                Twist(0.0, 0.0), "stop", "arrived", "arrived", "arrived", pose, "reached"
            )
        turn = math.remainder(math.atan2(dy, dx) - pose[2], math.tau)
        speed = 0.0 if abs(turn) > 0.3 else min(0.5, math.hypot(dx, dy))
        return Decision(
            Twist(speed, 1.5 * turn), "path_tracking", "nothing", "go", "on its way", pose, "active"
        )


def room() -> World:
    occupancy = np.zeros((100, 120), dtype=np.uint8)
    occupancy[[0, -1]] = 1
    occupancy[:, [0, -1]] = 1
    places = {"west": (1.0, 2.5, 0.0), "east": (4.5, 2.5)}
    return World(occupancy, resolution_m=0.05, name="room", goals=places)


def in_room(navigator=StraightNavigator, world=None):
    world = world or room()

    def setting(scenario, seed):
        profile = Profile.load("p3at")
        scene = Scene.from_world(world, [])
        agents = [
            Agent(
                entry.name,
                KinematicRobot(profile, scene, start_pose(entry.start, world), seed=seed),
                navigator(),
                [*scenario.goals, *entry.goals],
            )
            for entry in scenario.starts
        ]
        return Setting(world, world, agents)

    return setting


def mission(**changes) -> Scenario:
    base = {
        "name": "cross",
        "map": "room",
        "robot": "kinematic",
        "pose": "truth",
        "timeout_s": 60.0,
        "start": {"place": "west"},
        "goals": [{"place": "east"}],
    }
    return Scenario.model_validate(base | changes)


def test_a_robot_that_arrives_by_truth_has_reached_its_goal():
    result = run(mission(), setting=in_room())
    summary = result.summary()
    assert (summary["reached"], summary["exit_code"], summary["contacts"]) == (True, 0, 0)
    assert summary["arrival_error_m"] < 0.15
    assert 3.3 < summary["path_length_m"] < 3.7
    assert "east" in summary["sentence"]


def test_two_runs_of_one_seed_are_equal_wall_times_aside():
    records = [run(mission(), seed=3, setting=in_room()).to_dict() for _ in range(2)]
    for record in records:
        del record["wall"]
    assert json.dumps(records[0]) == json.dumps(records[1])


def test_another_seed_is_another_run():
    turning = mission(goals=[{"x_m": 3.0, "y_m": 4.0}])
    paths = [run(turning, seed=s, setting=in_room()).robots[0].trace.truth for s in (1, 2)]
    assert paths[0] != paths[1]


def test_a_robot_that_only_believes_it_has_arrived_has_missed_its_goal():
    result = run(mission(), setting=in_room(lambda: StraightNavigator(stop_short_m=1.0)))
    assert result.robots[0].goals[0].outcome == "missed"
    assert result.exit_code == 3
    assert "by truth" in result.sentence


def test_a_refused_goal_says_why_and_the_next_one_is_taken():
    goals = [{"x_m": -3.0, "y_m": 0.0}, {"place": "east"}]
    result = run(mission(goals=goals), setting=in_room())
    assert [goal.outcome for goal in result.robots[0].goals] == ["refused", "reached"]
    assert result.robots[0].goals[0].sentence == "refused (-3.00, 0.00) m: no way there"
    assert result.exit_code == 3


def test_a_refusal_the_scenario_expects_is_no_failure():
    goals = [{"x_m": -3.0, "y_m": 0.0, "expect": "refused"}, {"place": "east"}]
    result = run(mission(goals=goals), setting=in_room())
    assert result.exit_code == 0
    assert result.sentence.startswith("refused (-3.00, 0.00) m as expected; reached east, 0.")


def test_a_goal_expected_to_be_refused_but_reached_is_a_failure():
    goals = [{"place": "east", "expect": "refused"}]
    assert run(mission(goals=goals), setting=in_room()).exit_code == 3


def test_out_of_time_says_how_far_it_was():
    result = run(mission(timeout_s=2.0), setting=in_room())
    assert result.robots[0].goals[0].outcome == "timed_out"
    assert "short" in result.sentence
    assert result.exit_code == 3


def test_touching_something_is_exit_code_4_whatever_else_happened():
    goals = [{"x_m": 5.9, "y_m": 2.5}]
    result = run(mission(goals=goals, timeout_s=20.0), setting=in_room())
    assert result.exit_code == 4
    assert result.robots[0].contacts[0]["name"] == "wall"
    assert result.robots[0].least_clearance_m == 0.0


def test_a_shove_moves_the_robot_and_does_not_count_as_driving():
    shove = {"do": "shove", "at_distance_m": 1.0, "dy_m": 1.0}
    result = run(mission(events=[shove]), setting=in_room())
    trace = np.array(result.robots[0].trace.truth)
    assert np.hypot(*np.diff(trace[:, :2], axis=0).T).max() > 0.9
    assert result.reached
    assert result.robots[0].path_length_m < 4.2


def test_a_new_goal_on_the_way_replaces_the_old_one():
    event = {"do": "new_goal", "at_s": 3.0, "x_m": 3.0, "y_m": 4.0}
    goals = run(mission(events=[event]), setting=in_room()).robots[0].goals
    assert [goal.outcome for goal in goals] == ["replaced", "reached"]
    assert goals[1].goal == (3.0, 4.0)


def test_a_cancelled_goal_stops_the_robot_and_the_next_is_taken():
    goals = [{"place": "east"}, {"x_m": 2.0, "y_m": 3.5}]
    event = {"do": "cancel", "at_s": 2.0}
    result = run(mission(goals=goals, events=[event]), setting=in_room())
    assert [goal.outcome for goal in result.robots[0].goals] == ["cancelled", "reached"]


def test_exploring_lasts_as_long_as_asked_and_then_the_goal_is_taken():
    result = run(mission(goals=[{"explore_s": 4.0}, {"place": "east"}]), setting=in_room())
    first, second = result.robots[0].goals
    assert (first.outcome, second.outcome) == ("explored", "reached")
    assert 4.0 <= first.ended_s <= 4.5


def test_every_transition_is_kept_with_its_event_and_reason():
    transitions = run(mission(), setting=in_room()).robots[0].transitions
    assert [(t.before, t.event, t.after, t.reason) for t in transitions] == [
        ("path_tracking", "arrived", "stop", "arrived")
    ]
    assert transitions[0].to_dict()["event"] == "arrived"


def test_an_emergency_stop_holds_the_robot_while_its_navigator_drives_on():
    event = {"do": "emergency_stop", "at_s": 3.0, "for_s": 5.0}
    result = run(mission(events=[event]), setting=in_room())
    trace = result.robots[0].trace
    pressed = [i for i, t in enumerate(trace.time_s) if 3.2 <= t <= 8.0]
    assert len({trace.truth[i] for i in pressed}) == 1
    assert all(trace.mode[i] == "path_tracking" for i in pressed)
    assert result.reached


def test_an_event_waits_until_the_robot_has_been_in_a_mode_for_a_time():
    event = {"do": "new_goal", "x_m": 2.0, "y_m": 2.5}
    event |= {"when_mode": "path_tracking", "mode_for_s": 2.0}
    goal = run(mission(events=[event]), setting=in_room()).robots[0].goals[0]
    assert (goal.outcome, goal.ended_s) == ("replaced", 2.0)


def test_an_event_happens_only_when_all_that_it_names_holds():
    event = {"do": "cancel", "when_mode": "path_tracking", "at_s": 4.0, "at_distance_m": 1.0}
    result = run(mission(events=[event]), setting=in_room())
    goal = result.robots[0].goals[0]
    assert goal.outcome == "cancelled"
    assert goal.ended_s > 4.0
    assert goal.path_length_m > 1.0


def test_an_event_in_a_mode_that_never_comes_never_happens():
    event = {"do": "cancel", "when_mode": "obstacle_avoidance"}
    assert run(mission(events=[event]), setting=in_room()).reached


def test_a_goal_waits_as_long_as_asked_before_it_begins():
    goals = [{"x_m": 2.0, "y_m": 2.5}, {"place": "east", "wait_s": 5.0}]
    first, second = run(mission(goals=goals), setting=in_room()).robots[0].goals
    assert second.started_s == pytest.approx(first.ended_s + 5.0, abs=0.11)


def test_the_modes_add_up_to_the_time():
    result = run(mission(), setting=in_room())
    ticks = len(result.robots[0].trace.time_s)
    assert sum(result.robots[0].modes_s.values()) == pytest.approx(0.1 * ticks)


def test_an_expectation_that_is_not_met_is_said_and_is_a_failure():
    expect = {
        "plan_count": 2,
        "modes": ["obstacle_avoidance"],
        "transitions": ["arrived", "local_minimum"],
    }
    result = run(mission(expect=expect), setting=in_room())
    assert result.unmet == [
        "expected 2 plans, made 1",
        "expected a change of mode by local_minimum, there was none",
        "expected the mode obstacle_avoidance, never entered",
    ]
    assert result.exit_code == 3


def test_two_robots_that_meet_have_touched_each_other():
    robots = [
        {"name": "a", "start": {"place": "west"}},
        {"name": "b", "start": {"x_m": 4.5, "y_m": 2.5, "heading_rad": math.pi}},
    ]
    changes = {"start": None, "robots": robots, "goals": [{"x_m": 2.7, "y_m": 2.5}]}
    result = run(mission(**changes), setting=in_room())
    assert result.exit_code == 4
    assert {contact["name"] for r in result.robots for contact in r.contacts} == {"a", "b"}


def test_observers_see_every_tick_with_the_way_left():
    ticks = []
    run(mission(), observers=[ticks.append], setting=in_room())
    left = [tick.distance_to_go_m for tick in ticks if tick.distance_to_go_m is not None]
    assert left[0] == pytest.approx(3.5, abs=0.05)
    assert left[-1] < 0.15


def test_a_record_is_one_summary(tmp_path):
    result = run(mission(), setting=in_room())
    write_summary(result.to_dict(), tmp_path)
    record = json.loads((tmp_path / "summary.json").read_text())
    assert record["summary"]["reached"] is True
    assert set(record) == {
        "summary", "version", "config_hash", "unmet", "robots", "scenario", "wall",
    }  # fmt: skip


def test_an_observer_that_wants_to_know_is_told_what_begins():
    class Told(list):
        def begin(self, scenario, seed, setting):
            self.append((scenario.name, seed, [agent.name for agent in setting.agents]))

        def __call__(self, tick):
            self.append(tick)

    told = Told()
    run(mission(), seed=3, observers=[told], setting=in_room())
    assert told[0] == (mission().name, 3, ["robot"])
    assert len(told) > 2


def test_an_unknown_place_is_refused_with_the_places_there_are():
    from cairn.errors import ScenarioPlaceUnknown
    from cairn.missions.scenario import Goal

    with pytest.raises(ScenarioPlaceUnknown, match="east, west"):
        point_of(Goal(place="north"), room())


def test_robots_that_share_a_goal_share_the_field_of_the_first():
    robots = [
        {"name": "a", "start": {"place": "west"}, "goals": [{"x_m": 1.0, "y_m": 1.0}]},
        {"name": "b", "start": {"x_m": 1.0, "y_m": 4.0}},
    ]
    made = []

    def navigator():
        made.append(StraightNavigator())
        return made[-1]

    changes = {"start": None, "robots": robots, "goals": [{"place": "east"}]}
    result = run(mission(**changes), setting=in_room(navigator))
    assert made[0].given == [None, None]
    assert made[1].given == ["field to (4.5, 2.5)"]
    assert [robot.plan_count for robot in result.robots] == [2, 0]


@pytest.mark.parametrize("known", [True, False], ids=["with its map", "without a map"])
def test_a_lidar_robot_drives_a_mission(known):
    quick = Scenario.load("quick")
    room = {"name": "by lidar", "profile": "jackal", "start": quick.start, "goals": quick.goals}
    if known:
        room |= {"map": "room", "world": None, "pose": "localised"}
    else:
        room |= {"map": "none", "world": WorldEntry(map="room")}
    scenario = Scenario.load("lidar").model_copy(update={**room, "expect": quick.expect})
    result = run(scenario, seed=3)
    (robot,) = result.robots
    assert result.exit_code == 0, result.sentence
    assert robot.drift_max_m < 0.05


def test_a_lidar_robot_without_physics_says_which_table_it_lacks():
    scenario = Scenario.load("lidar").model_copy(update={"robot": "mujoco"})
    with pytest.raises(errors.ProfileTableMissing, match="physics"):
        run(scenario)
