import pytest

from cairn.missions import Change, Scenario, changes_of_mode, coverage, run_many, shipped
from cairn.missions.coverage import NEVER_PERCEIVED
from cairn.navigator import transitions

STOP, PLAN, TRACK, AVOID = "stop", "path_planning", "path_tracking", "obstacle_avoidance"

# Every way from one mode to another [Maalouf06 Fig. 11], each to be reached with physics.
CHANGES = [
    (STOP, "ready_to_plan", PLAN),
    (STOP, "ready_to_avoid", AVOID),
    (PLAN, "cancelled", STOP),
    (PLAN, "new_task", STOP),
    (PLAN, "plan_found", TRACK),
    (PLAN, "goal_unattainable", STOP),
    (TRACK, "cancelled", STOP),
    (TRACK, "new_task", STOP),
    (TRACK, "arrived", STOP),
    (TRACK, "obstacle_ahead", AVOID),
    (TRACK, "all_waypoints_blocked", STOP),
    (TRACK, "region_visited_twice", STOP),
    (TRACK, "local_minimum", STOP),
    (TRACK, "stalled", AVOID),
    (AVOID, "cancelled", STOP),
    (AVOID, "new_task", STOP),
    (AVOID, "arrived", STOP),
    (AVOID, "all_waypoints_blocked", STOP),
    (AVOID, "way_clear", TRACK),
    (AVOID, "region_visited_twice", STOP),
    (AVOID, "local_minimum", STOP),
]


def test_the_list_names_every_change_of_mode_of_the_strategy_that_can_be_perceived():
    table = {(mode, event, after) for mode, event, after, _ in transitions() if after != mode}
    impossible = {row for row in table if row[:2] in NEVER_PERCEIVED}
    assert {row[:2] for row in impossible} == NEVER_PERCEIVED
    assert set(CHANGES) == table - impossible
    assert set(CHANGES) == set(changes_of_mode())


def test_coverage_counts_each_transition_in_its_scenario():
    seen = [{"from": STOP, "event": "ready_to_plan", "to": PLAN}] * 2
    counts = coverage({"office": [{"robots": [{"transitions": seen}]}] * 3, "room": []})
    assert counts.pop(Change(STOP, "ready_to_plan", PLAN)) == {"office": 6}
    assert not any(counts.values())


@pytest.fixture(scope="module")
def reached():
    """Where each change of mode is reached: every shipped scenario with physics, two seeds."""
    names = [name for name in shipped() if Scenario.load(name).robot == "mujoco"]
    records = {name: [] for name in names}
    for (name, _), record in run_many(names, [1, 2]):
        assert not isinstance(record, Exception), record
        records[name].append(record)
    return coverage(records)


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("change", CHANGES, ids="-".join)
def test_every_change_of_mode_is_reached_with_physics(reached, change):
    assert reached[Change(*change)]
