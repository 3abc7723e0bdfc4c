"""Office missions of the navigation benchmark: drawn fairly, judged rightly."""

import math
from itertools import pairwise

import numpy as np
import pytest

import cairn
from cairn.experiments.nav import bench, office

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


def test_a_way_past_everything_is_possible_until_boxes_shut_the_robot_in():
    scenario = office.office_mission(1)
    assert office.is_possible(scenario, time_s=300.0)
    start = scenario.start
    ring = [
        {
            "x_m": start.x_m + 0.7 * math.cos(angle),
            "y_m": start.y_m + 0.7 * math.sin(angle),
            "length_m": 0.2,
            "width_m": 0.7,
            "yaw_rad": angle,
            "from_s": 10.0,
        }
        for angle in np.arange(8) * math.pi / 4
    ]
    data = scenario.model_dump()
    data["boxes"] = [*data["boxes"], *ring]
    shut_in = cairn.missions.Scenario.model_validate(data)
    assert not office.is_possible(shut_in, time_s=20.0)
    assert office.is_possible(shut_in, time_s=5.0)


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
    occupancy = np.zeros((60, 120), np.uint8)
    occupancy[:20] = occupancy[40:] = 1  # a corridor of 1 m along x, from y = 1 m to 2 m
    occupancy[:, :4] = occupancy[:, -4:] = 1
    corridor = cairn.World(occupancy, resolution_m=0.05)
    monkeypatch.setattr(cairn.maps, "load", lambda _: corridor)
    scenario = cairn.missions.Scenario.model_validate(
        {
            "name": "corridor",
            "map": "office",
            "start": {"x_m": 1.0, "y_m": 1.5},
            "goals": [{"x_m": 5.0, "y_m": 1.5}],
            "boxes": [{"x_m": 3.0, "y_m": 1.15, "length_m": 0.4, "width_m": 0.3}],
        }
    )
    assert office.widest_way_m(scenario, 0.0) == pytest.approx(0.7, abs=0.11)
    data = scenario.model_dump()
    data["boxes"][0]["width_m"] = 2.0
    shut = cairn.missions.Scenario.model_validate(data)
    assert office.widest_way_m(shut, 0.0) == 0.0
    assert not office.is_possible(shut, 0.0)
