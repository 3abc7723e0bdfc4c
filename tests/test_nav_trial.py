"""A trial of the navigation benchmark: when it begins, how it ends, and that it repeats."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cairn import errors
from cairn.experiments.nav import bench, trial
from cairn.experiments.nav.generator import generated
from cairn.experiments.nav.movers import Mover
from cairn.experiments.nav.worlds import NavWorld
from cairn.robots.robot import Pose
from cairn.view.trials import draw_trial

OPEN = NavWorld(
    "open", np.zeros((0, 3)), np.zeros((0, 5)), Pose(1.0, 2.0, math.pi / 2), (1.0, 12.0), 10.0
)
WALLED = replace(OPEN, name="walled", boxes=np.array([[1.0, 7.0, 0.0, 4.0, 0.2]]))


def ahead(task):
    """Half a metre a second straight on, reached gently."""
    return lambda seen: (min(0.5, 0.5 * seen.time_s), 0.0)


def still(task):
    """Never moves."""
    return lambda seen: (0.0, 0.0)


def round_and_round(task):
    """Drives in circles."""
    return lambda seen: (0.5, 1.0)


def fails_to_begin(task):
    """Cannot be made."""
    raise RuntimeError("no such robot")


def fails_later(task):
    """Fails after a while."""

    def step(seen):
        if seen.time_s > 0.5:
            raise RuntimeError("lost")
        return 0.1, 0.0

    return step


def commands_nonsense(task):
    """Commands what is no number."""
    return lambda seen: (math.nan, 0.0)


def remembers(task):
    """Keeps what it is told."""

    class Stack:
        path = np.array([[0.0, 0.0], [1.0, 0.0]])
        seen = ()

        def __call__(self, seen):
            self.seen = (*self.seen, seen)
            return 0.5, 0.0

        def notes(self):
            times = [round(each.time_s, 3) for each in self.seen[:3]]
            return {"goal": list(task.goal), "times": times, "seed": task.seed}

    return Stack()


remembers.period_s = 0.1


def hasty(task):
    """Asks for a period that no robot here has."""
    return still(task)


hasty.period_s = 0.004


def drive(stack, world, **options):
    return trial.drive(f"test_nav_trial:{stack.__name__}", world, 0, 1, **options)


def test_the_clock_starts_after_a_decimetre_and_stops_within_the_tolerance_of_the_goal():
    done = drive(ahead, OPEN)
    assert done.outcome == "success"
    assert math.hypot(done.end.x - 1.0, done.end.y - 12.0) == pytest.approx(1.0, abs=0.003)
    # From 0.1 m on: with the ramp of one second, 8.9 m at half a metre a second are 17.6 s and a
    # little, the robot not being at full speed at once.
    began = math.sqrt(2 * 0.1 / 0.5)
    exact_s = 1.0 + (9.0 - 0.25) / 0.5 - began
    assert done.time_s == pytest.approx(exact_s, abs=0.1)
    assert done.score == pytest.approx(5.0 / done.time_s)
    assert done.score_old_cap == pytest.approx(min(5.0 / done.time_s, 0.25))
    assert done.path_length_m == pytest.approx(9.0, abs=0.01)


def test_a_touch_ends_a_trial_with_what_was_touched_and_no_score():
    done = drive(ahead, WALLED)
    assert (done.outcome, done.reason, done.score) == ("collision", "touched box 0", 0.0)
    assert done.end.y + 0.458 / 2 == pytest.approx(6.9, abs=0.003)


def test_a_robot_that_never_starts_or_never_arrives_runs_out_of_time():
    done = drive(still, OPEN)
    assert (done.outcome, done.time_s) == ("timeout", 0.0)
    assert "did not start" in done.reason
    done = drive(round_and_round, replace(OPEN, timeout_s=3.0))
    assert done.outcome == "timeout"
    assert done.time_s == pytest.approx(3.0, abs=0.006)


@pytest.mark.parametrize(
    ("stack", "told"),
    [(fails_to_begin, "no such robot"), (fails_later, "lost"), (commands_nonsense, "finite")],
)
def test_a_stack_that_fails_ends_its_trial_with_the_reason(stack, told):
    done = drive(stack, OPEN)
    assert (done.outcome, done.score) == ("error", 0.0)
    assert told in done.reason


def test_a_stack_is_told_the_goal_ahead_of_it_and_is_asked_every_period():
    done = drive(remembers, OPEN)
    assert done.notes["goal"] == pytest.approx([10.0, 0.0])
    assert done.notes["times"] == [0.0, 0.1, 0.2]
    assert done.notes["seed"] == trial.seed_of(1, "open", 0, 0)


def test_a_period_that_the_simulation_has_not_is_refused():
    with pytest.raises(errors.StackPeriodInvalid) as caught:
        drive(hasty, OPEN)
    assert caught.value.period_s == 0.004


def test_what_moves_onto_the_robot_is_a_collision():
    frames = np.array([[0.0, -15.0, 2.0], [30.0, 15.0, 2.0]])  # 1 m/s along x, over the start
    world = replace(OPEN, movers=(Mover("m", 0.5, 30.0, frames),))
    trials = [trial.drive("test_nav_trial:still", world, n, 1) for n in range(6)]
    assert {each.outcome for each in trials} == {"collision"}
    assert {each.reason for each in trials if each.outcome == "collision"} == {"touched moving 0"}


def test_a_hit_right_at_a_jump_is_nobodys_fault_and_the_trial_is_repeated(monkeypatch):
    # It waits far away, jumps onto the place where the robot stands, and is soon gone again.
    frames = np.array([[0.0, 1.0, 2.0], [0.05, 1.0, 2.0], [0.06, 60.0, 2.0], [20.0, 60.0, 2.0]])
    world = replace(OPEN, movers=(Mover("jumper", 0.5, 20.0, frames),))
    monkeypatch.setattr(trial, "ATTEMPTS", 3)
    done = drive(still, world)
    assert done.attempts == 3
    kept = drive(still, replace(world, movers=(Mover("m", 0.5, 100.0, frames * [1, 60, 1]),)))
    assert kept.attempts == 1


def test_trials_are_the_same_whatever_else_is_run_and_differ_from_one_another():
    worlds = [generated(n) for n in range(2)]
    worlds = [replace(world, timeout_s=3.0) for world in worlds]
    settings = bench.Settings("cvm", worlds, trials=2, processes=1, seed=4)
    record = bench.run(settings)
    again = bench.run(bench.Settings("cvm", worlds[1:], trials=2, processes=1, seed=4))
    ours = [t for t in record["trials"] if t["world"] == "generated_1"]
    assert again["trials"] == ours
    assert ours[0]["end"] != ours[1]["end"]
    assert {k: v for k, v in record.items() if k != "wall"}.keys() >= {"summary", "worlds"}


def test_two_processes_give_the_record_of_one():
    worlds = [replace(OPEN, name=f"open_{n}", timeout_s=2.0) for n in range(2)]
    records = [
        bench.run(bench.Settings("cvm", worlds, trials=1, processes=n, seed=2)) for n in (1, 2)
    ]
    for record in records:
        del record["wall"]
    assert records[0] == records[1]


@pytest.mark.parametrize(
    ("key", "value"), [("robot", "tank"), ("trials", 0), ("processes", 0), ("seed", -1)]
)
def test_a_setting_that_cannot_be_is_refused_by_name(key, value):
    with pytest.raises(errors.NavBenchValueOutOfRange) as caught:
        bench.Settings("cvm", [OPEN], **{key: value}).check()
    assert (caught.value.key, caught.value.value) == (key, value)


@pytest.mark.parametrize("robot", ["jackal", "p3at"])
def test_a_trial_is_drawn_with_its_world_and_its_way(tmp_path, robot):
    world = replace(WALLED, circles=np.array([[0.0, 4.0, 0.1]]))
    done = drive(remembers, world, robot=robot, trace=True)
    assert done.trace is not None
    assert done.trace.path is not None
    path = draw_trial(done, world, robot, "remembers", tmp_path / "trial.png")
    assert path.stat().st_size > 10_000


@pytest.mark.parametrize("stack", ["cairn", "cvm", "dynamic-window"])
def test_every_built_in_stack_crosses_open_ground(stack):
    done = trial.drive(stack, OPEN, 0, 1)
    assert done.outcome == "success", done.reason
