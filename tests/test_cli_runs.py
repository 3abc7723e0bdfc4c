import json

import numpy as np
import pytest

import cairn
from cairn.missions import Scenario, run, run_many, shipped
from cairn.record import open_run
from cairn.shipped import folder

QUICK = (folder("scenarios") / "quick.toml").read_text()


def without_wall(record):
    return {key: value for key, value in record.items() if key != "wall"}


def test_a_run_that_reaches_is_exit_code_0_and_leaves_its_record_and_picture(command, tmp_path):
    code, said, _ = command("run", "quick", "--json")
    record = json.loads(said)
    assert code == record["summary"]["exit_code"] == 0
    assert record["summary"]["reached"] is True
    assert record["summary"]["arrival_error_m"] <= 0.3
    assert json.loads((tmp_path / "runs/quick/summary.json").read_text()) == record
    assert (tmp_path / "runs/quick/picture.png").stat().st_size > 10_000


def test_a_recorded_run_has_one_decision_per_tick(command, tmp_path):
    code, _, _ = command("run", "quick", "--record", tmp_path / "mine", "--no-picture")
    ticks = list(open_run(tmp_path / "mine").ticks())
    summary = json.loads((tmp_path / "mine/summary.json").read_text())["summary"]
    assert code == 0
    assert len(ticks) == round(summary["time_s"] * 10) + 1
    assert {"mode", "reason", "sentence"} <= set(ticks[-1]["decision"])


def test_two_records_of_one_seed_are_equal_wall_times_aside():
    scenario = Scenario.load("quick")
    one, other = (without_wall(run(scenario, seed=5).to_dict()) for _ in range(2))
    assert json.dumps(one) == json.dumps(other)


def test_runs_in_other_processes_give_the_same_records():
    here = without_wall(run(Scenario.load("quick"), seed=2).to_dict())
    there = dict(run_many(["quick"], [1, 2], workers=2))
    assert without_wall(there[("quick", 2)]) == here


def test_a_goal_in_a_wall_is_refused_with_exit_code_3(command, tmp_path):
    wall = QUICK.replace('place = "goal"', "x_m = 3.25\ny_m = 0.5")
    (tmp_path / "wall.toml").write_text(wall)
    code, said, _ = command("run", tmp_path / "wall.toml", "--json", "--no-picture")
    summary = json.loads(said)["summary"]
    assert code == 3
    assert "refused" in summary["sentence"]


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('place = "goal"', 'place = "moon"', "ScenarioPlaceUnknown"),
        ('map = "room"', 'map = "moon"', "MapNotFound"),
        ('pose = "odometry"', 'pose = "odometry"\nprofile = "moon"', "ProfileNotFound"),
        (
            'map = "room"\nrobot = "kinematic"\npose = "odometry"',
            'map = "none"\nworld = { map = "room" }\npose = "localised"',
            "PoseSourceUnavailable",
        ),
        ('pose = "odometry"', 'pose = "odometry"\nnavigator = { speed = 1 }', "ScenarioInvalid"),
        ('place = "start"', "x_m = 3.2\ny_m = 0.5", "StandsInObstacle"),
    ],
)
def test_what_does_not_exist_is_exit_code_2_with_its_name(command, tmp_path, old, new, complaint):
    (tmp_path / "mission.toml").write_text(QUICK.replace(old, new, 1))
    code, _, complaints = command("run", tmp_path / "mission.toml")
    assert code == 2
    assert complaint in complaints


def test_a_folder_that_cannot_be_written_is_exit_code_2(command, tmp_path):
    (tmp_path / "taken").write_text("a file")
    code, _, complaints = command("run", "quick", "--record", tmp_path / "taken")
    assert code == 2
    assert "taken" in complaints


def test_a_map_beside_the_scenario_is_found_from_anywhere(command, tmp_path):
    folder = tmp_path / "mission"
    folder.mkdir()
    np.save(folder / "yard.npy", np.ones((12, 12), dtype=bool))
    text = QUICK.replace('map = "room"', 'map = "yard.npy"')
    text = text.replace('place = "start"', "x_m = 3.0\ny_m = 3.0")
    text = text.replace('place = "goal"', "x_m = 9.0\ny_m = 9.0")
    (folder / "mission.toml").write_text(text)
    code, said, _ = command("run", folder / "mission.toml", "--json", "--no-picture")
    assert code == 0, said


def test_several_seeds_print_one_row_each(command):
    code, said, _ = command("run", "quick", "--seeds", 2, "--json")
    assert code == 0
    record = json.loads(said)
    assert [row["seed"] for row in record["summary"]["quick"]] == [1, 2]
    reached = {row["event"]: row["reached"] for row in record["transitions"] if row["reached"]}
    assert reached["plan_found"] == {"quick": 2}


def test_all_scenarios_are_followed_by_where_each_transition_was_reached(command, monkeypatch):
    record = run(Scenario.load("quick")).to_dict()
    monkeypatch.setattr("cairn.cli.run.shipped", lambda: ["quick", "two"])
    monkeypatch.setattr("cairn.cli.run.Scenario.load", lambda name: name)
    runs = [((name, seed), record) for name in ("quick", "two") for seed in (1, 2)]
    monkeypatch.setattr("cairn.cli.run.run_many", lambda *_: runs)
    code, said, _ = command("scenarios", "--seeds", 2)
    rows = {tuple(line.split()[:3]): line.split()[3:] for line in said.splitlines() if line}
    assert code == 0
    assert rows["path_planning", "plan_found", "path_tracking"] == ["quick,", "two"]
    assert rows["path_tracking", "local_minimum", "stop"] == ["not", "reached"]


def test_every_shipped_scenario_reads_and_names_places_that_exist():
    from cairn.missions.setting import load_map, point_of, start_pose

    for name in shipped():
        scenario = Scenario.load(name)
        assert scenario.name == name
        world = load_map(scenario.world.map if scenario.world else scenario.map, scenario.folder)
        for robot in scenario.starts:
            start_pose(robot.start, world)
        for goal in scenario.goals:
            assert goal.explore_s or world.contains(point_of(goal, world))


def test_the_scenarios_are_listed(command):
    code, said, _ = command("scenarios", "--json")
    assert code == 0
    assert list(json.loads(said)["summary"]) == shipped()


def test_a_plan_is_written_drawn_and_measured(command, tmp_path):
    code, said, _ = command(
        "plan", "room", "--goal", "goal", "--start", "1.0,1.0", "--json",
        "--out", tmp_path / "field.npy", "--picture", tmp_path / "plan.png",
    )  # fmt: skip
    world = cairn.maps.load("room")
    record = json.loads(said)
    assert code == 0
    field = np.load(tmp_path / "field.npy")
    assert field.shape == world.shape
    assert field[world.cell_of(world.goals["goal"])] == 0.0
    assert record["summary"]["path_length_m"] == pytest.approx(
        field[world.cell_of((1.0, 1.0))], abs=0.1
    )
    assert (tmp_path / "plan.png").stat().st_size > 10_000


def test_no_way_from_the_start_is_exit_code_3(command, tmp_path):
    cut = np.ones((5, 5), dtype=bool)
    cut[:, 2] = False
    np.save(tmp_path / "cut.npy", cut)
    code, said, _ = command("plan", tmp_path / "cut.npy", "--goal", "4.5,2.5", "--start", "0.5,2.5")
    assert code == 3
    assert "no way" in said


@pytest.mark.parametrize("goal", ["here", "1", "1,2,3", "nan,1", ""])
def test_a_goal_that_is_no_point_is_exit_code_2(command, goal):
    code, _, complaints = command("plan", "room", "--goal", goal)
    assert code == 2
    assert "--goal" in complaints


@pytest.mark.parametrize(
    ("goal", "complaint"), [("99,99", "GoalOutsideMap"), ("3.25,0.5", "GoalBlocked")]
)
def test_a_goal_where_none_can_be_is_exit_code_2_with_its_name(command, goal, complaint):
    code, _, complaints = command("plan", "room", "--goal", goal)
    assert (code, complaint in complaints) == (2, True)


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_every_scenario_goes_as_expected_with_ten_seeds(command, capsys):
    code, table, complaints = command("scenarios", "--seeds", 10)
    with capsys.disabled():
        print(f"\n{table}{complaints}")
    assert code == 0
