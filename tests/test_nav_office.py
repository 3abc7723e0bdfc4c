"""Office missions of the navigation benchmark: drawn fairly, judged rightly."""

import math
from itertools import pairwise

import numpy as np
import pytest

import cairn
from cairn.experiments.nav import bench, office
from cairn.robots import Box

PROFILE = cairn.Profile.load("p3at")


@pytest.mark.parametrize("number", range(4))
def test_a_mission_begins_and_ends_free_and_its_boxes_stand_away_from_both(number):
    scenario = office.office_mission(number)
    world = cairn.maps.load(scenario.map)
    start, goal = scenario.start, scenario.goals[0]
    ends = [(start.x_m, start.y_m), (goal.x_m, goal.y_m)]
    scene = cairn.robots.Scene.from_world(world)
    for x, y in ends:
        for heading in np.linspace(0, math.pi, 7):
            assert scene.clearance_m((x, y, heading), PROFILE.footprint) > 0
        for box in scenario.boxes:
            assert math.dist((x, y), (box.x_m, box.y_m)) >= office.AWAY_M
    assert math.dist(*ends) > 1.0
    assert len({box.name for box in scenario.boxes}) >= office.BOXES


def test_missions_follow_from_their_number_and_seed():
    one, same, other = (office.office_mission(n, s) for n, s in ((3, 1), (3, 1), (3, 2)))
    assert one == same
    assert one.goals != other.goals


def test_a_trolley_stands_in_one_place_at_a_time_and_moves_at_a_slow_pace():
    steps = [b for b in office.office_mission(0).boxes if b.name == "trolley"]
    assert len(steps) > 3
    for before, after in pairwise(steps):
        assert before.until_s == after.from_s
        moved = math.dist((before.x_m, before.y_m), (after.x_m, after.y_m))
        speed_mps = moved / (after.until_s - after.from_s)
        assert speed_mps == pytest.approx(0.15) or moved == 0
    assert steps[0].from_s == 0


def test_a_way_past_everything_is_there_until_boxes_shut_the_robot_in():
    scenario = office.office_mission(1)
    start = scenario.start
    angles = np.arange(8) * math.pi / 4
    ring = [
        Box(start.x_m + 0.7 * math.cos(a), start.y_m + 0.7 * math.sin(a), 0.2, 0.7, float(a))
        for a in angles
    ]
    width_m = cairn.Profile.load("p3at").footprint.width_m
    assert office.widest_way_m(scenario, []) > width_m
    assert office.widest_way_m(scenario, ring) <= width_m


def corridor_of_a_metre() -> cairn.World:
    """Along x, from y = 1 m to 2 m."""
    occupancy = np.zeros((60, 160), np.uint8)
    occupancy[:20] = occupancy[40:] = 1
    occupancy[:, :4] = occupancy[:, -4:] = 1
    return cairn.World(occupancy, resolution_m=0.05)


def test_a_refusal_is_judged_by_what_really_stands_and_not_by_when_it_was_to_leave(monkeypatch):
    corridor = corridor_of_a_metre()
    monkeypatch.setattr(cairn.maps, "load", lambda _: corridor)
    pushed = [
        {"x_m": x, "y_m": 1.5, "length_m": 0.4, "width_m": 1.9, "name": "trolley",
         "from_s": from_s, "until_s": from_s + 1.0}
        for x, from_s in ((1.7, 0.0), (0.9, 1.0))  # the robot is there: it stays before it for good
    ]  # fmt: skip
    mission = {
        "name": "corridor", "map": "office", "robot": "kinematic", "boxes": pushed,
        "start": {"x_m": 0.8, "y_m": 1.5}, "goals": [{"x_m": 6.0, "y_m": 1.5}],
    }  # fmt: skip
    scenario = cairn.missions.Scenario.model_validate(mission)
    monkeypatch.setattr(office, "office_mission", lambda *_: scenario)
    trial, result = office.drive_office(0, 1, "kinematic")
    assert result is not None
    assert result.robots[0].goals[0].outcome == "refused"
    assert trial.outcome == "success", trial.reason


def test_a_kinematic_mission_is_judged_as_a_trial_and_repeats():
    records = [bench.run_office([2], 1, "kinematic", processes=1) for _ in range(2)]
    for record in records:
        del record["wall"]
    assert records[0] == records[1]
    (trial,) = records[0]["trials"]
    assert trial["outcome"] in ("success", "collision", "timeout")
    assert trial["world"] == "office_2"
    assert records[0]["summary"]["trials"] == 1
    figures = records[0]["office"]
    assert figures["contacts_standing"] <= figures["contacts"] == trial["notes"]["contacts"]
    assert figures["traps"] == len(trial["notes"]["trapped_s"])
    assert figures["transitions_per_minute"] > 0


def test_the_widest_way_is_the_gap_beside_a_box_to_a_cell(monkeypatch):
    corridor = corridor_of_a_metre()
    monkeypatch.setattr(cairn.maps, "load", lambda _: corridor)
    scenario = cairn.missions.Scenario.model_validate(
        {
            "name": "corridor",
            "map": "office",
            "start": {"x_m": 1.0, "y_m": 1.5},
            "goals": [{"x_m": 5.0, "y_m": 1.5}],
        }
    )
    assert office.widest_way_m(scenario, [Box(3.0, 1.15, 0.4, 0.3)]) == pytest.approx(0.7, abs=0.11)
    assert office.widest_way_m(scenario, [Box(3.0, 1.15, 0.4, 2.0)]) == 0.0
