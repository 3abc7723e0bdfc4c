"""A run comes out of its log again: the same commands from the same inputs, to the bit."""

import json

import numpy as np
import pytest

import cairn
from cairn.missions import Scenario, run
from cairn.navigator import Navigator
from cairn.record import Recorder, open_run, replay


def recorded(folder, name, timeout_s):
    scenario = Scenario.load(name)
    short = {"robot": "kinematic", "timeout_s": min(timeout_s, scenario.timeout_s)}
    scenario = scenario.model_copy(update=short)
    with Recorder(folder) as recorder:
        run(scenario, observers=[recorder])
    return open_run(folder)


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    return recorded(tmp_path_factory.mktemp("quick"), "quick", 60)


@pytest.mark.parametrize(
    ("name", "timeout_s"),
    [("crate", 25), ("no_map", 15), ("two_robots", 20), ("explore", 12), ("second_thoughts", 20)],
)
def test_a_run_replays_to_the_bit(tmp_path, name, timeout_s):
    made = recorded(tmp_path, name, timeout_s)
    played = replay(made)
    assert played.is_same, played.differences
    assert sum(played.ticks.values()) == len(list(made.ticks()))


def test_a_lost_robot_that_searches_the_map_replays_to_the_bit(tmp_path):
    assert replay(recorded(tmp_path, "lost", 8)).is_same


def test_a_run_cut_off_replays_as_far_as_it_goes(quick, tmp_path):
    whole = quick.path.read_bytes()
    (tmp_path / "run.mcap").write_bytes(whole[: len(whole) // 2])
    played = replay(open_run(tmp_path))
    assert played.is_same
    assert 10 < played.ticks["robot"] < len(list(quick.ticks()))


def test_a_changed_controller_is_found_at_its_first_tick_and_in_its_rules(quick):
    def changed(name, recipe):
        text = recipe["controller"].replace("braking_share = 0.9", "braking_share = 0.4")
        return Navigator.from_recipe({**recipe, "controller": text}, quick.map(name))

    (found,) = replay(quick, make=changed).differences
    assert found.key.startswith("tracking.")
    assert found.is_command or replay(quick, make=changed).command_from
    before = [tick["time_s"] for tick in quick.ticks() if tick["time_s"] < found.time_s]
    assert len(before) > 20


def test_a_changed_setting_is_found(quick):
    def changed(name, recipe):
        config = {**(recipe["config"] or {}), "arrival_m": 0.5}
        return Navigator.from_recipe({**recipe, "config": config}, quick.map(name))

    (found,) = replay(quick, make=changed).differences
    assert found.robot == "robot"
    assert found.logged != found.replayed


def test_one_bit_of_one_reading_is_enough_to_be_found(tmp_path):
    nav = cairn.Navigator("p3at", cairn.maps.load("room"), start=(1.0, 1.0, 0.0))
    with Recorder(tmp_path) as recorder:
        recorder.follow({"mine": nav})
        nav.set_goal((3.0, 1.0))
        for _ in range(20):
            nav.step(np.full(16, np.inf), (0.01, 0.01), 0.0, 0.1)
    made = open_run(tmp_path)

    class Nudged(Navigator):
        def step(self, ranges, wheels, gyro, dt_s, world_from_robot=None):
            left, right = wheels
            return super().step(
                ranges, (np.nextafter(left, 1), right), gyro, dt_s, world_from_robot
            )

    (found,) = replay(
        made, make=lambda name, recipe: Nudged.from_recipe(recipe, made.map(name))
    ).differences
    assert (found.tick, found.key.split(".")[0]) == (0, "pose")


def test_replay_says_same_or_where_it_differs(command, quick, tmp_path):
    code, said, _ = command("replay", quick.path.parent)
    assert code == 0
    assert "the same to the bit" in said
    text = (cairn.shipped.folder("controllers") / "p3at.toml").read_text()
    (tmp_path / "mine.toml").write_text(text.replace("braking_share = 0.9", "braking_share = 0.4"))
    code, said, _ = command(
        "replay", quick.path.parent, "--controller", tmp_path / "mine.toml", "--json"
    )
    record = json.loads(said)
    assert code == 3
    assert record["summary"]["same"] is False
    assert record["differences"][0]["key"].startswith("tracking.")
