"""What users and outside checks call, as the documents promise it."""

import json
import math
import os
import sys
from pathlib import Path

import numpy as np
import pytest

import cairn

MOVES = np.array([(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)])
ROOT2 = math.sqrt(2)

# 4 × 6 cells; the first line of text is the top of an image, or row 0 of a MovingAI file.
TEXT = ["......", ".@@@..", ".....@", "......"]
GRID = np.array([[c == "." for c in line] for line in TEXT])


def octile(path):
    """(straight, diagonal) steps of a path of cells."""
    steps = np.abs(np.diff(path, axis=0))
    assert (steps.max(axis=1) == 1).all()
    diagonal = int((steps.sum(axis=1) == 2).sum())
    return len(steps) - diagonal, diagonal


@pytest.fixture
def map_server(tmp_path):
    shades = np.where(GRID, 254, 0)
    shades[0, 5] = 205  # unknown
    body = "\n".join(" ".join(map(str, row)) for row in shades)
    (tmp_path / "office.pgm").write_text(f"P2\n6 4\n255\n{body}\n")
    (tmp_path / "office.yaml").write_text(
        "image: office.pgm\nresolution: 0.5\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    return tmp_path / "office.yaml"


def test_every_kind_of_map_is_loaded_row_0_lowest_y(tmp_path, map_server):
    world = cairn.maps.load(map_server)
    kinds = np.where(GRID, 0, 1)
    kinds[0, 5] = 2
    np.testing.assert_array_equal(world.occupancy, kinds[::-1])
    assert (world.resolution_m, world.origin) == (0.5, (-1.0, 2.0, 0.0))

    (tmp_path / "arena.map").write_text("type octile\nheight 4\nwidth 6\nmap\n" + "\n".join(TEXT))
    world = cairn.maps.load(tmp_path / "arena.map")
    np.testing.assert_array_equal(world.occupancy, ~GRID)
    assert (world.resolution_m, world.origin) == (1.0, (0.0, 0.0, 0.0))

    np.save(tmp_path / "free.npy", GRID)
    np.testing.assert_array_equal(cairn.maps.load(tmp_path / "free.npy").occupancy, ~GRID)
    np.save(tmp_path / "costs.npy", np.where(GRID, 2.0, np.inf))
    world = cairn.maps.load(tmp_path / "costs.npy")
    np.testing.assert_array_equal(world.costs, np.where(GRID, 2.0, np.inf))

    (tmp_path / "hall.map").write_text(
        "2D-Map\nLineMinPos: 0 0\nLineMaxPos: 2000 0\nNumLines: 1\nResolution: 50\n"
        'Cairn: Goal 1000 500 90.0 "" ICON "desk"\nLINES\n0 0 2000 0\nDATA\n'
    )
    world = cairn.maps.load(tmp_path / "hall.map")
    assert world.occupancy[world.cell_of((1.0, 0.0))] == 1
    assert world.goals["desk"][:2] == (1.0, 0.5)


def test_a_plan_on_a_map_server_world_is_in_metres_and_does_not_enter_the_unknown(map_server):
    world = cairn.maps.load(map_server)
    field = cairn.plan(world, goal=(-0.75, 2.25))
    assert field.cost_to_go.dtype == np.float64
    assert field.cost_to_go[0, 0] == 0.0
    assert field.cost_to_go[0, 1] == 0.5
    assert field.cost_to_go[1, 1] == pytest.approx(0.5 * ROOT2, rel=1e-6)
    assert np.isinf(field.cost_to_go[(2, 1), (1, 5)]).all()
    assert np.isinf(field.cost_to_go[3, 5])
    assert field.native.dtype == np.uint32
    assert field.native is field.native
    assert field.next_node.dtype == np.int8
    assert field.next_node[0, 0] == -1
    assert field.next_node[3, 5] == -1
    assert field.next_node[1, 1] == 5
    path = field.path((1.25, 3.75))
    assert path.ndim == 2
    assert path.shape[1] == 2
    assert path.dtype == np.float64
    assert path[0].tolist() == [1.25, 3.75]
    assert path[-1].tolist() == [-0.75, 2.25]
    assert field.path((1.75, 3.75)) is None  # unknown
    assert field.path((-0.25, 3.25)) is None  # a wall
    assert cairn.plan(world, goal=[(-0.75, 2.25), (1.25, 3.75)]).cost_to_go[3, 4] == 0.0
    assert np.isfinite(cairn.plan(world, goal=(-0.75, 2.25), unknown="free").cost_to_go[3, 5])


def test_a_grid_of_numpy_is_planned_in_cells():
    field = cairn.plan_grid(GRID, goal=(0, 0), corner_cutting=False, precision=None, threads=None)
    assert field.native.dtype == np.uint32
    assert field.native[0, 1] == 985
    straight, diagonal = octile(field.path((3, 3)))
    assert field.native[3, 3] == 985 * straight + 1393 * diagonal
    assert field.cost_to_go[3, 3] == pytest.approx(straight + diagonal * ROOT2, rel=1e-6)
    row, col = 3, 3
    while (code := field.next_node[row, col]) >= 0:
        drop = field.native[row, col]
        row, col = np.add((row, col), MOVES[code])
        assert drop - field.native[row, col] == (1393 if code % 2 else 985)
    assert (row, col) == (0, 0)

    costs = np.where(GRID, 2.0, np.inf)
    costs[3, 3] = 4.0
    field = cairn.plan_grid(costs, goal=(3, 2))
    assert field.native.dtype == np.float32
    assert field.cost_to_go[3, 3] == 3.0
    assert cairn.plan_grid(costs, goal=(3, 2), precision="f64").native.dtype == np.float64
    assert cairn.plan_grid(GRID, goal=[(0, 0), (3, 5)]).cost_to_go[3, 5] == 0.0


def test_corner_cutting_looks_at_neither_side_cell():
    cut = np.array([[True, False], [False, True]])
    assert np.isinf(cairn.plan_grid(cut, goal=(0, 0)).cost_to_go[1, 1])
    field = cairn.plan_grid(cut, goal=(0, 0), corner_cutting=True)
    assert field.cost_to_go[1, 1] == pytest.approx(ROOT2, rel=1e-6)


def test_next_node_ties_go_to_the_lowest_code():
    field = cairn.plan_grid(np.ones((3, 4), bool), goal=[(1, 3), (1, 1), (0, 0), (2, 0)])
    assert field.next_node[1, 2] == 0  # right and left are equally near
    assert field.next_node[1, 0] == 0  # right, down and up


def test_a_graph_is_planned_along_its_links():
    field = cairn.plan_graph([0, 2, 3, 3, 3], [1, 2, 2], [1.0, 5.0, 1.5], goal=2)
    assert field.cost_to_go.tolist() == [2.5, 1.5, 0.0, math.inf]
    assert field.next_node.dtype == np.int64
    assert field.next_node.tolist() == [1, 2, -1, -1]
    assert field.path(0).tolist() == [0, 1, 2]
    assert field.path(3) is None


@pytest.mark.parametrize(
    ("goal", "error"),
    [
        ((99.0, 99.0), cairn.errors.GoalOutsideMap),
        ((math.nan, 0.0), cairn.errors.GoalOutsideMap),
        ((-0.25, 3.25), cairn.errors.GoalBlocked),
        ((1.75, 3.75), cairn.errors.GoalBlocked),
    ],
)
def test_goals_that_cannot_be_are_refused_by_name(map_server, goal, error):
    with pytest.raises(error) as caught:
        cairn.plan(cairn.maps.load(map_server), goal=goal)
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize("bad", [math.nan, -1.0, 0.0])
def test_costs_that_cannot_be_are_refused_by_name_with_their_cell(bad):
    costs = np.ones((3, 3))
    costs[1, 2] = bad
    with pytest.raises(ValueError, match="1, 2") as caught:
        cairn.plan_grid(costs, goal=(0, 0))
    assert (caught.value.row, caught.value.col) == (1, 2)


def test_a_navigator_takes_what_was_measured_and_gives_a_twist():
    profile = cairn.Profile.load("p3at")
    quiet = np.full(len(profile.sonars), np.inf)
    nav = cairn.Navigator(profile, world=None)
    nav.set_goal((2.0, 0.0))
    for _ in range(20):
        decision = nav.step(quiet, (0.0, 0.0), 0.0, 0.1, world_from_robot=(0.0, 0.0, 0.0))
    v, w = decision.twist
    assert decision.twist.linear_mps == v > 0.0
    assert abs(w) < 0.2
    assert decision.mode in ("stop", "path_planning", "path_tracking", "obstacle_avoidance")
    assert decision.to_dict()["mode"] == decision.mode
    decision = cairn.Navigator(profile).step(quiet, (0.0, 0.0), None, 0.1)  # its own estimate
    assert decision.twist == (0.0, 0.0)


def test_the_plan_command_writes_the_field_and_a_picture(command, map_server, tmp_path):
    code, said, _ = command(
        "plan", map_server, "--goal", "-0.75,2.25", "--start", "1.25,3.75",
        "--out", "field.npy", "--picture", "p.png",
    )  # fmt: skip
    assert code == 0
    assert "path of" in said
    expected = cairn.plan(cairn.maps.load(map_server), goal=(-0.75, 2.25)).cost_to_go
    np.testing.assert_array_equal(np.load(tmp_path / "field.npy"), expected)
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")
    code, _, complaint = command("plan", map_server, "--goal", "9,9")
    assert (code, "GoalOutsideMap" in complaint) == (2, True)
    assert command("plan", map_server, "--goal", "-0.75,2.25", "--start", "1.75,3.75")[0] == 3


def test_a_run_leaves_its_summary_in_the_folder_of_its_name_or_the_one_given(command, tmp_path):
    code, said, _ = command("run", "quick", "--seed", 3, "--json")
    record = json.loads(said)
    assert code == 0
    assert record["summary"]["seed"] == 3
    assert json.loads((tmp_path / "runs/quick/summary.json").read_text()) == record
    scenario = Path(cairn.__file__).parent / "data/scenarios/quick.toml"
    code, said, _ = command("run", scenario, "--seed", 3, "--record", "mine", "--json")
    again = json.loads((tmp_path / "mine/summary.json").read_text())
    assert again == json.loads(said)
    assert {**again, "wall": 0} == {**record, "wall": 0}


def test_without_the_physics_engine_its_extra_is_named(command, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    code, _, complaint = command("run", "office")
    assert code == 2
    assert 'pip install "cairn-nav[sim]"' in complaint
    code, said, _ = command("doctor")
    assert code == 0
    assert 'pip install "cairn-nav[sim]"' in said


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize(
    "scen", sorted(Path(os.environ.get("CAIRN_MOVINGAI", "nowhere")).glob("*.scen")), ids=str
)
def test_published_lengths_are_met_by_counting_steps(scen):
    """Every query of the MovingAI files in the folder that CAIRN_MOVINGAI names."""
    world = cairn.maps.load(scen.with_suffix(""))
    for query in cairn.maps.load_scen(scen):
        field = cairn.plan_grid(world.free(), goal=query.goal)
        straight, diagonal = octile(field.path(query.start))
        # Some files give two decimals.
        assert straight + diagonal * ROOT2 == pytest.approx(query.optimal_length, abs=0.00501)
