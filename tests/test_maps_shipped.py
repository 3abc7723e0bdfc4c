"""The worlds that come with Cairn: drawn by the script, fit for the robot, with ways around."""

import runpy
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt, label
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

import cairn

P3AT = (0.626, 0.505)
REPOSITORY = Path(__file__).parent.parent
DOORS = tomllib.loads(
    cairn.maps.shipped_path("office").with_suffix(".goals.toml").read_text(encoding="utf-8")
)["doors"]


def route(world, start, goal):
    """Cheapest way over the cost map by SciPy's Dijkstra, (n, 2) metres, None if there is none."""
    costs = cairn.costmap(world, P3AT).costs.astype(float)
    rows, cols = costs.shape
    index = np.arange(costs.size).reshape(costs.shape)
    links = []
    for dr, dc in ((0, 1), (1, 0), (1, 1), (1, -1)):
        a = np.s_[: rows - dr, max(0, -dc) : cols - max(0, dc)]
        b = np.s_[dr:, max(0, dc) : cols + min(0, dc)]
        cost = (costs[a] + costs[b]) / 2 * np.hypot(dr, dc) * world.resolution_m
        keep = np.isfinite(cost)
        links.append((cost[keep], index[a][keep], index[b][keep]))
    data, tail, head = (np.concatenate(parts) for parts in zip(*links, strict=True))
    graph = coo_array((data, (tail, head)), shape=(costs.size, costs.size)).tocsr()
    source, target = index[world.cell_of(start)], index[world.cell_of(goal)]
    distance, before = dijkstra(graph, directed=False, indices=source, return_predecessors=True)
    if np.isinf(distance[target]):
        return None
    walk = [target]
    while walk[-1] != source:
        walk.append(before[walk[-1]])
    return world.point_of(np.stack(np.unravel_index(walk[::-1], costs.shape), axis=-1))


def length(path):
    return np.hypot(*np.diff(path, axis=0).T).sum()


def doors_on(path):
    """Names of the office's doors that the path goes through, in its order."""
    passed = []
    for name, door in DOORS.items():
        gap = np.hypot(*(path - (door["x"], door["y"])).T)
        if gap.min() < 0.4:
            passed.append((gap.argmin(), name))
    return [name for _, name in sorted(passed)]


def close(world, *doors):
    boxes = [[DOORS[name]["x"], DOORS[name]["y"], 1.2, 1.2] for name in doors]
    return world.with_boxes(boxes)


@pytest.fixture(scope="module")
def office():
    return cairn.maps.load("office")


def test_the_drawing_script_draws_the_shipped_worlds(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["draw_worlds.py", str(tmp_path)])
    runpy.run_path(str(REPOSITORY / "examples" / "draw_worlds.py"), run_name="__main__")
    for name in cairn.maps.shipped():
        shipped = cairn.maps.shipped_path(name)
        drawn = cairn.maps.load(tmp_path / shipped.name)
        world = cairn.maps.load(name)
        assert (drawn.occupancy == world.occupancy).all()
        for file in shipped.parent.glob(f"{name}.*"):
            if file.suffix != ".png":
                assert (tmp_path / file.name).read_bytes() == file.read_bytes()


@pytest.mark.parametrize("name", cairn.maps.shipped())
def test_every_place_has_room_to_turn_and_a_way_to_every_other(name):
    world = cairn.maps.load(name)
    assert len(world.goals) >= 4
    costs = cairn.costmap(world, P3AT).costs
    clearance = distance_transform_edt(world.occupancy != 1) * world.resolution_m
    connected, _ = label(np.isfinite(costs))
    first = connected[world.cell_of(next(iter(world.goals.values())))]
    for place, at in world.goals.items():
        assert clearance[world.cell_of(at)] >= 0.6, place
        assert np.isfinite(costs[world.cell_of(at)]), place
        assert connected[world.cell_of(at)] == first, place


def test_the_office_is_worthy_of_a_building(office):
    assert office.size_m[0] >= 32
    assert office.size_m[1] >= 22
    assert office.resolution_m == 0.05
    assert len(DOORS) >= 20


def test_every_door_of_the_office_is_one_metre_wide_to_the_cell(office):
    for name, door in DOORS.items():
        row, col = office.cell_of((door["x"], door["y"]))
        line = office.occupancy[row] if door["heading"] == 0 else None
        across = office.occupancy[:, col] if door["heading"] == 0 else office.occupancy[row]
        at = row if door["heading"] == 0 else col
        free = across == 0
        low = at - np.argmin(free[at::-1]) + 1
        high = at + np.argmin(free[at:])
        assert high - low == 20, name
        assert line is None or line[col] == 0


def test_a_long_route_leads_through_four_doors_and_each_passage_closed_leaves_another(office):
    start, goal = office.goals["reception"], office.goals["director"]
    path = route(office, start, goal)
    assert doors_on(path) == [
        "reception",
        "fire door west",
        "fire door north",
        "secretary",
        "director",
    ]
    assert length(path) >= 30
    for passage in ("fire door west", "fire door north"):
        around = route(close(office, passage), start, goal)
        assert passage not in doors_on(around)
        assert len(doors_on(around)) >= 4
        assert length(around) >= 30
    assert route(close(office, "director"), start, goal) is None


def test_routes_are_centred_in_doors_and_keep_from_walls(office):
    path = route(office, office.goals["reception"], office.goals["director"])
    surface = cairn.distance_to_occupied(office.occupancy == 1, 0.05, surface=True)
    clearance = np.array([surface[office.cell_of(point)] for point in path])
    assert clearance.min() >= 0.45
    for name in doors_on(path):
        door = DOORS[name]
        assert np.hypot(*(path - (door["x"], door["y"])).T).min() <= 0.08, name


def test_the_labyrinth_has_one_way_and_it_is_long():
    world = cairn.maps.load("labyrinth")
    path = route(world, world.goals["start"], world.goals["goal"])
    assert length(path) > 25
    middle = path[len(path) // 2]
    blocked = world.with_boxes([*middle, 1.6, 1.6])
    assert route(blocked, world.goals["start"], world.goals["goal"]) is None


def test_the_straight_way_across_the_dead_end_is_shut_and_there_are_two_around_it():
    world = cairn.maps.load("dead_end")
    start, goal = (np.array(world.goals[name][:2]) for name in ("start", "goal"))
    straight = start + np.linspace(0, 1, 500)[:, None] * (goal - start)
    assert any(world.occupancy[world.cell_of(point)] == 1 for point in straight)
    for side in ("north", "south"):
        x, y = world.goals[side][:2]
        assert route(world.with_boxes([x, y, 0.5, 3.4]), start, goal) is not None
