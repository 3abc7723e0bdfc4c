"""A field that is updated equals the field planned anew, to the bit, policy included.

Sequences of changes of every kind on maps of every kind and odd sizes: some repaired whatever it
takes, some with the default share of work, some solved anew, some while an older array is held.
"""

import numpy as np
import pytest

import cairn
from test_plan_edges import ARITHMETICS, ENGINES, INF, MAPS, SIZES, random_costs

GIVE_UP = {"repaired": {"give_up": INF}, "default": {}, "anew": {"give_up": 0.0}}


# ---- changes: the cells, row by row, and what they cost from now on ---


def some(rng, costs, chosen):
    cells = np.argwhere(chosen)
    if not len(cells):
        cells = np.argwhere(np.ones_like(chosen))
    return cells[rng.integers(0, len(cells), int(rng.integers(1, 9)))]


def fall(rng, costs, goals):
    cells = some(rng, costs, np.isfinite(costs))
    return cells, costs[tuple(cells.T)] * rng.choice([0.25, 0.5, 0.75])


def rise(rng, costs, goals):
    cells = some(rng, costs, np.isfinite(costs))
    return cells, costs[tuple(cells.T)] * rng.choice([1.25, 2.0, 8.0])


def both(rng, costs, goals):
    cells = some(rng, costs, np.isfinite(costs))
    return cells, costs[tuple(cells.T)] * rng.choice([0.5, 2.0], len(cells))


def block(rng, costs, goals):
    return some(rng, costs, np.isfinite(costs)), INF


def free(rng, costs, goals):
    return some(rng, costs, np.isinf(costs)), 1.0


def swap(rng, costs, goals):
    """What was free is blocked and the other way round, in one go."""
    cells = np.concatenate(
        [some(rng, costs, np.isfinite(costs)), some(rng, costs, np.isinf(costs))]
    )
    return cells, np.where(np.isinf(costs[tuple(cells.T)]), 1.0, INF)


def box(rng, costs, goals):
    """A block of cells, wall or ground; it may cover the map."""
    top, left = (int(rng.integers(0, size)) for size in costs.shape)
    height, width = rng.integers(1, [int(rng.choice([3, 8, 70]))] * 2 + np.array([1, 1]))
    inside = np.zeros(costs.shape, bool)
    inside[top : top + height, left : left + width] = True
    return np.argwhere(inside), rng.choice([INF, 1.0, 3.0])


def wall(rng, costs, goals):
    """A whole row or column, often on a border of tiles; open or shut."""
    lines = np.zeros(costs.shape, bool)
    row = int(rng.choice([rng.integers(costs.shape[0]), min(63, costs.shape[0] - 1)]))
    col = int(rng.choice([rng.integers(costs.shape[1]), min(64, costs.shape[1] - 1)]))
    if rng.random() < 0.5:
        lines[row] = True
    else:
        lines[:, col] = True
    return np.argwhere(lines), rng.choice([INF, 1.0])


def door(rng, costs, goals):
    """One cell, wall or ground the other way round, twice in the same change."""
    cell = np.argwhere(np.ones_like(costs))[rng.integers(costs.size)]
    return np.array([cell, cell]), [7.0, 1.0 if np.isinf(costs[tuple(cell)]) else INF]


def beside_a_goal(rng, costs, goals):
    row, col = goals[rng.integers(len(goals))]
    near = np.zeros(costs.shape, bool)
    near[max(0, row - 2) : row + 3, max(0, col - 2) : col + 3] = True
    cells = some(rng, costs, near)
    return cells, rng.choice([INF, 0.5, 1.0, 4.0], len(cells))


def corners_of_tiles(rng, costs, goals):
    row, col = np.indices(costs.shape) % 64
    cells = some(rng, costs, np.isin(row, [0, 63]) & np.isin(col, [0, 63]))
    return cells, rng.choice([INF, 0.5, 1.0, 4.0], len(cells))


def nothing(rng, costs, goals):
    cells = some(rng, costs, np.ones_like(costs, bool))
    return cells, costs[tuple(cells.T)]


CHANGES = [
    fall,
    rise,
    both,
    block,
    free,
    swap,
    box,
    wall,
    door,
    beside_a_goal,
    corners_of_tiles,
    nothing,
]


class Drive:
    """A field, what it was planned on, and how."""

    def __init__(self, seed, engine, arithmetic, shape, draw):
        self.rng = rng = np.random.default_rng(seed)
        self.number, _, options = ARITHMETICS[arithmetic]
        self.options = {**options, "corner_cutting": bool(rng.integers(2))}
        is_free = draw(rng, shape)
        is_free.flat[rng.integers(is_free.size)] = True
        self.costs = np.where(is_free, random_costs(rng, shape, arithmetic), INF)
        self.costs = self.costs.astype(self.number or float)
        cells = np.argwhere(is_free)
        chosen = rng.integers(0, len(cells), int(rng.choice([1, 1, 3])))
        self.goals = [tuple(cell) for cell in cells[chosen].tolist()]
        self.field = self.anew(**ENGINES[engine])

    def given(self, costs):
        return costs if self.number else np.isfinite(costs)

    def anew(self, **engine):
        return cairn.plan_grid(self.given(self.costs), self.goals, **self.options, **engine)

    def change(self, kind, share):
        """Change, update, and compare with what is planned anew; the result of the update."""
        cells, values = kind(self.rng, self.costs, self.goals)
        values = np.broadcast_to(np.asarray(values, self.costs.dtype), len(cells)).copy()
        values[(cells[:, None] == np.array(self.goals)).all(axis=2).any(axis=1)] = 1.0
        if self.number is None:
            values[np.isfinite(values)] = 1.0
        before = self.costs.copy()
        for cell, value in zip(cells, values, strict=True):
            self.costs[tuple(cell)] = value
        held = self.field.native, self.field.next_node, self.field.cost_to_go
        copies = [array.copy() for array in held]
        if self.rng.random() < 0.6:
            del held, copies
        update = self.field.update(cells, self.given(values), **GIVE_UP[share])
        expected = self.anew()
        assert self.field.native.dtype == expected.native.dtype
        np.testing.assert_array_equal(self.field.native, expected.native)
        np.testing.assert_array_equal(self.field.next_node, expected.next_node)
        if len(np.unique(cells, axis=0)) == len(cells):
            assert update.changed == (before != self.costs).sum()
        if "held" in locals():
            for array, copy in zip(held, copies, strict=True):
                np.testing.assert_array_equal(array, copy)
            np.testing.assert_array_equal(self.field.cost_to_go, expected.cost_to_go)
        return update


def drive_on(seed, engine, arithmetic, shape, draw, changes, share):
    drive = Drive(seed, engine, arithmetic, shape, draw)
    updates = []
    for _ in range(changes):
        kind = CHANGES[drive.rng.integers(len(CHANGES))]
        updates.append(drive.change(kind, share))
    start = tuple(np.argwhere(np.isfinite(drive.field.cost_to_go))[-1])
    for any_angle in (False, True):
        found = drive.field.path(start, any_angle=any_angle)
        np.testing.assert_array_equal(found, drive.anew().path(start, any_angle=any_angle))
    return updates


@pytest.mark.parametrize("share", GIVE_UP)
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("draw", MAPS, ids=lambda draw: draw.__name__)
def test_an_updated_field_equals_one_planned_anew(draw, arithmetic, share):
    rng = np.random.default_rng(len(arithmetic) + len(share))
    for seed in range(2):
        shape = tuple(int(rng.choice([*SIZES, 97, 130, 150])) for _ in range(2))
        engine = list(ENGINES)[rng.integers(len(ENGINES))]
        updates = drive_on(seed, engine, arithmetic, shape, draw, 12, share)
        if share == "repaired":
            assert not any(update.anew for update in updates)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_thousands_of_sequences_of_changes_end_as_planned_anew(arithmetic, engine):
    rng = np.random.default_rng(19)
    for seed in range(150):
        shape = tuple(int(rng.choice([*SIZES, rng.integers(1, 300)])) for _ in range(2))
        draw = MAPS[rng.integers(len(MAPS))]
        share = list(GIVE_UP)[rng.integers(2)]
        drive_on(seed, engine, arithmetic, shape, draw, 25, share)


def test_a_change_that_is_refused_leaves_the_field_as_it_was():
    costs = np.ones((70, 80), np.float32)
    field = cairn.plan_grid(costs, (3, 4))
    native, next_node = field.native.copy(), field.next_node.copy()
    for cells, values, error in [
        ([(70, 0)], [2.0], "CellOutsideGrid"),
        ([(5, 5), (-1, 0)], [2.0, 2.0], "CellOutsideGrid"),
        ([(5, 5)], [2.0, 3.0], "UpdateLengthMismatch"),
        ([(6, 6), (3, 4)], [2.0, INF], "GoalBlocked"),
        ([(6, 6), (5, 5)], [2.0, np.nan], "CellCostNan"),
        ([(6, 6), (5, 5)], [2.0, -1.0], "CellCostNegative"),
        ([(6, 6), (5, 5)], [2.0, 0.0], "CellCostZero"),
        ([(6, 6), (5, 5)], [2.0, 1e300], "CellCostBeyondPrecision"),
        ([(5, 5)], [1e-30], None),
    ]:
        if error is None:
            continue
        with pytest.raises(getattr(cairn.errors, error)):
            field.update(cells, values)
        np.testing.assert_array_equal(field.native, native)
        np.testing.assert_array_equal(field.next_node, next_node)
    field.update([(6, 6)], [1.0])
    np.testing.assert_array_equal(field.native, native)


@pytest.mark.parametrize("share", GIVE_UP)
def test_costs_that_no_field_can_hold_are_refused_after_a_change_as_before_it(share):
    strip = np.full((1, 8), INF, np.float32)
    strip[0, :4] = 1.0
    for values, error in [
        ([1e9, 1e9, 1.0, 1.0], "LinkCostAbsorbed"),
        ([3e38, 1.0, 3e38, 1.0], "CostToGoOverflow"),
    ]:
        field = cairn.plan_grid(strip, (0, 0))
        native, next_node = field.native.copy(), field.next_node.copy()
        cells = [(0, col) for col in range(1, 5)]
        with pytest.raises(getattr(cairn.errors, error)):
            field.update(cells, values, **GIVE_UP[share])
        np.testing.assert_array_equal(field.native, native)
        np.testing.assert_array_equal(field.next_node, next_node)
        field.update(cells, 2.0)
        strip_then = strip.copy()
        strip_then[0, 1:5] = 2.0
        expected = cairn.plan_grid(strip_then, (0, 0))
        np.testing.assert_array_equal(field.native, expected.native)


def test_a_field_of_a_world_is_updated_too():
    occupancy = np.zeros((40, 60), np.uint8)
    world = cairn.World(occupancy, 0.5)
    field = cairn.plan(world, (1.0, 1.0))
    before = field.path((25.0, 15.0))
    cells = [(row, 20) for row in range(30)]
    field.update(cells, np.zeros(30, bool))
    occupancy[:30, 20] = 1
    expected = cairn.plan(cairn.World(occupancy, 0.5), (1.0, 1.0))
    np.testing.assert_array_equal(field.cost_to_go, expected.cost_to_go)
    for any_angle in (False, True):
        after = field.path((25.0, 15.0), any_angle=any_angle)
        np.testing.assert_array_equal(after, expected.path((25.0, 15.0), any_angle=any_angle))
    assert len(after) != len(before)


def test_a_local_change_is_local_work():
    rng = np.random.default_rng(13)
    field = cairn.plan_grid(rng.integers(1, 200, (700, 900)).astype(np.float32), (350, 450))
    for cell in rng.integers(0, [700, 900], (20, 2)):
        for cost in (400.0, 0.5, 20.0):
            update = field.update([cell], [cost])
            assert not update.anew
            assert update.visits < 154 // 2  # tiles of 64 by 64
