import json
import math
import runpy
from pathlib import Path

import numpy as np
import pytest

import cairn
from cairn import _brain, terrain
from plan_oracles import MOVES, check_pointers, joined, lowest_codes, textbook_cost_to_go
from terrain_oracles import P3AT, TOBLER, relaxed, roughness, terrain_links

KINDS = {"p3at_energy": P3AT, "p3at_time": P3AT, "tobler": TOBLER}
MODELS = {
    "p3at_energy": terrain.P3ATEnergy,
    "p3at_time": terrain.P3ATTime,
    "tobler": terrain.Tobler,
}
ONLY_ENERGY = {"drive_efficiency", "hotel_power_w"}


def model_of(kind, parameters):
    if kind == "p3at_time":
        parameters = {k: v for k, v in parameters.items() if k not in ONLY_ENERGY}
    return MODELS[kind](**parameters)


def next_cells(next_node):
    offsets = np.array([down * next_node.shape[1] + right for down, right in MOVES] + [0])
    cells = np.arange(next_node.size).reshape(next_node.shape) + offsets[next_node]
    return np.where(next_node >= 0, cells, -1).ravel()


def fractal(rng, rows, cols, height, steepness=2.0):
    """Heights whose spectrum falls with a power of the frequency."""
    f = np.hypot(*np.meshgrid(np.fft.fftfreq(cols), np.fft.fftfreq(rows)))
    f[0, 0] = 1.0
    noise = np.fft.fft2(rng.standard_normal((rows, cols)))
    surface = np.fft.ifft2(noise / f**steepness).real
    return height * (surface - surface.min()) / max(np.ptp(surface), 1e-9)


def random_parameters(rng, kind):
    """Defaults, or others that matter: heavy, weak, slow on rough ground, one-way limits."""
    p = dict(KINDS[kind])
    if rng.random() < 0.6:
        p["max_climb_rad"] = float(rng.choice([0.1, 0.3, 0.8, math.pi / 2]))
        p["max_descent_rad"] = float(rng.choice([0.15, 0.5, 1.2, math.pi / 2]))
        p["max_roll_rad"] = float(rng.choice([0.1, 0.3, math.pi / 2]))
        p["max_roughness"] = float(rng.choice([0.05, 0.2, math.inf]))
    if kind == "tobler":
        p["off_path"] = bool(rng.random() < 0.5)
    elif rng.random() < 0.5:
        p["payload_kg"] = float(rng.random() * 12)
        p["drive_power_w"] = float(5 + 40 * rng.random())
        p["rolling_resistance"] = float(rng.choice([0.0, 0.01, 0.2]))
        p["roughness_slowdown"] = float(rng.choice([0.0, 3.0]))
    return p


def random_terrain(rng):
    """(elevation, cell size, roughness or None, goals): odd sizes, cliffs, holes, steps."""
    rows, cols = (int(n) for n in rng.integers(1, 10, 2))
    size = float(rng.choice([0.1, 0.5, 10.0, 92.5]))
    if rng.random() < 0.3:
        elevation = rng.integers(0, 3, (rows, cols)) * size * 0.2  # ties
    else:
        elevation = fractal(rng, rows, cols, size * rng.choice([0.0, 0.5, 2.0, 6.0]))
    if rng.random() < 0.5:
        elevation = elevation + 1234.5
    elevation[rng.random((rows, cols)) < rng.choice([0.0, 0.15, 0.4])] = np.nan
    rough = None
    if rng.random() < 0.4:
        rough = rng.random((rows, cols)) * 0.3
        rough[rng.random((rows, cols)) < 0.1] = np.nan
    return elevation, size, rough


@pytest.mark.parametrize("corner_cutting", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_field_policy_and_allowed_moves_equal_an_independent_dijkstra_to_the_bit(
    kind, corner_cutting
):
    rng = np.random.default_rng(11)
    cases, codes, fields, made = [], [], [], 0
    while made < 150:  # 900 terrains in all
        elevation, size, rough = random_terrain(rng)
        p = random_parameters(rng, kind)
        model = model_of(kind, p)
        case, code, masks = terrain_links(elevation, size, kind, p, [], rough, corner_cutting)
        options = {"roughness": rough, "corner_cutting": corner_cutting}
        allowed = terrain.allowed_moves(elevation, size, model, **options)
        np.testing.assert_array_equal(allowed, masks)
        known = roughness(elevation.astype(np.float32), size) if rough is None else rough
        usable = ~np.isnan(elevation) & (known.astype(np.float32) <= np.float32(p["max_roughness"]))
        if not usable.any():
            continue
        made += 1
        places = np.argwhere(usable)
        chosen = rng.choice(len(places), min(len(places), int(rng.integers(1, 4))), replace=False)
        goals = [tuple(map(int, places[i])) for i in chosen]
        case.goals = [row * elevation.shape[1] + col for row, col in goals]
        cases.append(case)
        codes.append(code)
        fields.append(cairn.plan_terrain(elevation, size, goals, model, **options))
    truth = textbook_cost_to_go(joined(cases), np.float32).astype(np.float32)
    ends = np.cumsum([case.nodes for case in cases])[:-1]
    for case, code, field, values in zip(cases, codes, fields, np.split(truth, ends), strict=True):
        assert field.native.dtype == np.float32
        np.testing.assert_array_equal(field.native.ravel(), values)
        np.testing.assert_array_equal(field.cost_to_go.ravel(), values.astype(float))
        np.testing.assert_array_equal(field.next_node.ravel(), lowest_codes(case, code, values))
        check_pointers(case, values, next_cells(field.next_node))


@pytest.mark.parametrize("kind", KINDS)
def test_a_large_rough_terrain_is_the_least_fixed_point(kind):
    rng = np.random.default_rng(12)
    elevation = fractal(rng, 97, 131, 120.0, 1.8)
    elevation[rng.random(elevation.shape) < 0.05] = np.nan
    elevation[60, 40] = 50.0
    field = cairn.plan_terrain(elevation, 10.0, (60, 40), kind)
    case, codes, _ = terrain_links(elevation, 10.0, kind, KINDS[kind], [(60, 40)])
    values = relaxed(case, np.float32)
    np.testing.assert_array_equal(field.native.ravel(), values)
    np.testing.assert_array_equal(field.next_node.ravel(), lowest_codes(case, codes, values))


@pytest.mark.parametrize("kind", KINDS)
def test_a_path_costs_what_the_field_says_where_it_starts(kind):
    rng = np.random.default_rng(13)
    elevation = fractal(rng, 41, 37, 30.0)
    field = cairn.plan_terrain(elevation, 5.0, (20, 18), kind)
    starts = [s for s in np.ndindex(*elevation.shape) if np.isfinite(field.cost_to_go[s])][::40]
    assert len(starts) > 5
    for start in starts:
        path = field.path(start)
        assert terrain.path_cost(elevation, 5.0, path, kind) == field.cost_to_go[start]


def test_the_way_up_costs_more_than_the_way_down():
    ramp = np.linspace(0.0, 9.0, 31)[None, :].repeat(7, axis=0)
    for model in ("p3at_energy", "p3at_time", "tobler"):
        up = cairn.plan_terrain(ramp, 1.0, (3, 30), model).cost_to_go[3, 0]
        down = cairn.plan_terrain(ramp, 1.0, (3, 0), model).cost_to_go[3, 30]
        assert up > 1.2 * down, model


def test_limits_apply_to_each_way_of_its_own():
    step = np.array([[0.0, 0.0, 0.5, 0.5]])
    down_only = terrain.P3ATEnergy(max_descent_rad=1.0)
    field = cairn.plan_terrain(step, 1.0, (0, 0), down_only)
    assert np.isfinite(field.cost_to_go).all()
    field = cairn.plan_terrain(step, 1.0, (0, 3), down_only)
    np.testing.assert_array_equal(np.isfinite(field.cost_to_go), [[False, False, True, True]])
    moves = terrain.allowed_moves(step, 1.0, down_only)
    assert moves.tolist() == [[0b1, 0b10000, 0b10001, 0b10000]]


def test_a_slope_is_driven_up_and_down_but_not_across_beyond_the_roll_limit():
    slope = 0.3 * np.arange(9.0)[:, None].repeat(9, axis=1)  # rises with the row
    model = terrain.P3ATTime(max_roll_rad=math.atan(0.29))
    moves = terrain.allowed_moves(slope, 1.0, model)
    inside = moves[1:-1, 1:-1]
    assert (inside & 0b00010001 == 0).all()
    assert (inside & 0b11101110 == 0b11101110).all()
    assert terrain.allowed_moves(slope, 1.0, terrain.P3ATTime(max_roll_rad=0.3)).min() > 0


@pytest.mark.parametrize("cut", [False, True])
def test_a_diagonal_passes_beside_a_hole_only_if_corners_may_be_cut(cut):
    flat = np.zeros((2, 2))
    flat[0, 1] = np.nan
    field = cairn.plan_terrain(flat, 1.0, (0, 0), "tobler", corner_cutting=cut)
    diagonal = terrain.link_cost(0.0, 1.0, "tobler", diagonal=True)
    straight = terrain.link_cost(0.0, 1.0, "tobler")
    assert field.native[1, 1] == (diagonal if cut else straight + straight)
    assert np.isinf(field.cost_to_go[0, 1])


def test_toblers_walker_goes_5_km_per_h_on_the_level_and_6_where_it_falls_by_5_per_cent():
    run = 100.0
    kmh = lambda rise, model="tobler": 3.6 * run / terrain.link_cost(rise, run, model)  # noqa: E731
    assert kmh(0.0) == pytest.approx(5.0367, abs=1e-4)
    assert kmh(-5.0) == pytest.approx(6.0, rel=1e-6)
    slopes = np.linspace(-100.0, 100.0, 401)
    assert kmh(slopes).max() <= 6.0 * (1 + 1e-6)
    exact = 6.0 * np.exp(-3.5 * np.abs(slopes / run + 0.05))
    np.testing.assert_allclose(kmh(slopes), exact, rtol=1e-6)
    np.testing.assert_allclose(kmh(slopes, "tobler_off_path"), 0.6 * exact, rtol=1e-6)
    # Published with the function: slope [deg], pace [s/m].
    for degrees, pace in [(-30, 3.80), (-10, 0.93), (0, 0.71), (10, 1.32), (30, 5.39)]:
        rise = run * math.tan(math.radians(degrees))
        assert terrain.link_cost(rise, run, "tobler") / run == pytest.approx(pace, abs=0.0051)


def test_a_p3at_on_the_level_up_and_down_takes_what_a_person_would_work_out():
    energy = lambda rise, **p: terrain.link_cost(rise, 10.0, terrain.P3ATEnergy(**p))  # noqa: E731
    time = lambda rise, **p: terrain.link_cost(rise, 10.0, terrain.P3ATTime(**p))  # noqa: E731
    weight = 12 * 9.80665
    assert time(0.0) == pytest.approx(10 / 0.7)
    assert energy(0.0) == pytest.approx(30 * 10 / 0.7 + weight * 0.08 * 10 / 0.5)
    work = weight * (3.0 + 0.8)
    assert time(3.0) == pytest.approx(work / 20)
    assert energy(3.0) == pytest.approx(30 * work / 20 + work / 0.5)
    assert energy(-3.0) == pytest.approx(30 * math.hypot(10, 3) / 0.7)  # the brakes hold it
    assert energy(0.0, payload_kg=12.0) == pytest.approx(30 * 10 / 0.7 + 2 * weight * 0.8 / 0.5)


def test_below_the_slope_where_it_must_brake_a_p3at_works_there_and_back_as_on_the_level():
    strong = terrain.P3ATEnergy(drive_power_w=1e6, hotel_power_w=1e-6)
    rises = np.linspace(0.0, 0.79, 50)
    there_and_back = terrain.link_cost(rises, 10.0, strong) + terrain.link_cost(
        -rises, 10.0, strong
    )
    level = 2 * terrain.link_cost(0.0, 10.0, strong)
    np.testing.assert_allclose(there_and_back, level, rtol=1e-5)
    steep = terrain.link_cost(1.5, 10.0, strong) + terrain.link_cost(-1.5, 10.0, strong)
    assert steep == pytest.approx(level * (1.5 + 0.8) / (2 * 0.8), rel=1e-5)


@pytest.mark.parametrize("kind", ["p3at_energy", "p3at_time"])
@pytest.mark.parametrize("diagonal", [False, True])
def test_costs_grow_with_climb_payload_and_roughness_and_stay_above_zero(kind, diagonal):
    model = MODELS[kind]
    rises = np.linspace(-50.0, 50.0, 2001)
    costs = terrain.link_cost(rises, 10.0, model(), diagonal=diagonal)
    assert (costs > 0).all()
    assert (np.diff(costs[rises >= 0]) >= 0).all()
    assert (costs[rises > 0] >= costs[rises < 0][::-1]).all()
    loaded = terrain.link_cost(rises, 10.0, model(payload_kg=6.0), diagonal=diagonal)
    assert (loaded >= costs).all()
    rough = terrain.link_cost(rises, 10.0, model(), diagonal=diagonal, roughness=0.1)
    assert (rough > costs).all()
    rougher = terrain.link_cost(rises, 10.0, model(), diagonal=diagonal, roughness=0.2)
    assert (rougher > rough).all()


def test_a_flat_terrain_is_a_plan_in_metres_times_a_price():
    flat = np.full((23, 31), 250.0)
    field = cairn.plan_terrain(flat, 4.0, (11, 15), "p3at_energy")
    per_metre = terrain.link_cost(0.0, 4.0, "p3at_energy") / 4.0
    metres = cairn.plan_grid(np.ones((23, 31)), (11, 15), precision="f64").cost_to_go * 4.0
    np.testing.assert_allclose(field.cost_to_go, metres * per_metre, rtol=1e-5)


def test_roughness_is_nought_on_every_plane_and_tells_how_far_a_cell_sticks_out():
    row, col = np.mgrid[0:9, 0:12]
    plane = 3.0 + 0.25 * row - 0.5 * col
    assert (terrain.roughness(plane, 2.0) == 0).all()
    bump = np.zeros((5, 5))
    bump[2, 2] = 0.1
    assert terrain.roughness(bump, 1.0)[2, 2] == pytest.approx(0.1)
    assert terrain.roughness(bump, 0.5)[2, 2] == pytest.approx(0.2)
    bump[2, 3] = np.nan
    rough = terrain.roughness(bump, 1.0)
    assert np.isnan(rough[2, 3])
    assert rough[2, 2] == pytest.approx(0.1)
    rng = np.random.default_rng(14)
    for _ in range(100):
        elevation, size, _ = random_terrain(rng)
        expected = roughness(elevation.astype(np.float32), size)
        np.testing.assert_array_equal(terrain.roughness(elevation, size), expected)


def test_rough_ground_is_gone_around_or_shut():
    flat, rough = np.zeros((9, 9)), np.zeros((9, 9))
    rough[1:8, 4] = 0.9
    field = cairn.plan_terrain(flat, 1.0, (4, 8), "p3at_time", roughness=rough)
    assert not (rough[tuple(field.path((4, 0)).T)] > 0).any()
    rough[:, 4] = 0.9
    field = cairn.plan_terrain(flat, 1.0, (4, 8), "p3at_time", roughness=rough)
    assert np.isfinite(field.cost_to_go[4, 0])
    for shut in (terrain.P3ATTime(max_roughness=0.4), terrain.Tobler(max_roughness=0.4)):
        field = cairn.plan_terrain(flat, 1.0, (4, 8), shut, roughness=rough)
        assert np.isinf(field.cost_to_go[:, :5]).all()


def test_masked_heights_are_no_data_and_whole_numbers_are_metres():
    heights = np.arange(12).reshape(3, 4) % 2
    masked = np.ma.array(heights, mask=heights == 99)
    masked[1, 1] = np.ma.masked
    holes = heights.astype(float)
    holes[1, 1] = np.nan
    a = cairn.plan_terrain(masked, 10.0, (0, 0), "tobler").native
    b = cairn.plan_terrain(holes, 10.0, (0, 0), "tobler").native
    np.testing.assert_array_equal(a, b)
    assert np.isinf(a[1, 1])


@pytest.mark.parametrize("simd", _brain.simd_levels())
def test_instructions_and_a_start_change_what_is_solved_not_how(simd):
    rng = np.random.default_rng(15)
    elevation = fractal(rng, 70, 131, 60.0, 1.8)
    whole = cairn.plan_terrain(elevation, 5.0, (60, 40), "p3at_time")
    same = cairn.plan_terrain(elevation, 5.0, (60, 40), "p3at_time", simd=simd)
    np.testing.assert_array_equal(same.native, whole.native)
    start = (7, 100)
    field = cairn.plan_terrain(elevation, 5.0, (60, 40), "p3at_time", simd=simd, start=start)
    kept = whole.native <= whole.native[start]
    np.testing.assert_array_equal(field.native, np.where(kept, whole.native, np.inf))
    np.testing.assert_array_equal(field.next_node, np.where(kept, whole.next_node, -1))


def test_several_goals_are_the_least_of_each_and_threads_change_nothing():
    elevation = fractal(np.random.default_rng(15), 30, 40, 15.0)
    goals = [(3, 4), (25, 35)]
    both = cairn.plan_terrain(elevation, 5.0, goals, "p3at_energy")
    each = [cairn.plan_terrain(elevation, 5.0, goal, "p3at_energy").native for goal in goals]
    np.testing.assert_array_equal(both.native, np.minimum(*each))
    for threads in (1, 2, 7):
        again = cairn.plan_terrain(elevation, 5.0, goals, "p3at_energy", threads=threads)
        np.testing.assert_array_equal(both.native, again.native)
        np.testing.assert_array_equal(both.next_node, again.next_node)


def test_a_path_over_terrain_is_not_straightened():
    field = cairn.plan_terrain(np.zeros((3, 4)), 1.0, (0, 0), "tobler")
    with pytest.raises(cairn.errors.AnyAngleNotPriced):
        field.path((2, 3), any_angle=True)
    assert len(field.path((2, 3), any_angle=False)) == 4


def test_models_by_name_are_those_with_defaults():
    elevation = fractal(np.random.default_rng(16), 12, 9, 5.0)
    named = {
        "p3at_energy": terrain.P3ATEnergy(),
        "p3at_time": terrain.P3ATTime(),
        "tobler": terrain.Tobler(),
        "tobler_off_path": terrain.Tobler(off_path=True),
    }
    for name, model in named.items():
        a = cairn.plan_terrain(elevation, 5.0, (0, 0), name).native
        b = cairn.plan_terrain(elevation, 5.0, (0, 0), model).native
        np.testing.assert_array_equal(a, b)
    assert {name: model.unit for name, model in named.items()} == {
        "p3at_energy": "J", "p3at_time": "s", "tobler": "s", "tobler_off_path": "s",
    }  # fmt: skip
    for model, defaults in [(terrain.P3ATEnergy(), P3AT), (terrain.Tobler(), TOBLER)]:
        assert vars(model) == pytest.approx(defaults)
    with pytest.raises(AttributeError):
        terrain.Tobler().off_path = True
    assert terrain.P3ATTime(payload_kg=np.float32(2.5)) == terrain.P3ATTime(payload_kg=2.5)


# ---- refusals ------------------------------------------------------------------------------------

FLAT = np.zeros((3, 4))


def with_value(value, at=(1, 2), shape=(3, 4)):
    grid = np.zeros(shape)
    grid[at] = value
    return grid


@pytest.mark.parametrize(
    ("change", "error", "fields"),
    [
        ({"elevation": with_value(np.inf)}, "ElevationInfinite", {"row": 1, "col": 2}),
        ({"elevation": with_value(-np.inf)}, "ElevationInfinite", {"value": -np.inf}),
        ({"elevation": with_value(1e39)}, "ElevationInfinite", {"row": 1}),
        ({"elevation": np.zeros(5)}, "GridNotPlannable", {"shape": (5,)}),
        ({"elevation": FLAT > 0}, "GridNotPlannable", {"dtype": "bool"}),
        ({"elevation": [[1.0], [1.0, 2.0]]}, "GridNotPlannable", {}),
        ({"elevation": np.zeros((0, 4))}, "EmptyGrid", {"rows": 0, "cols": 4}),
        ({"elevation": np.zeros((4, 0))}, "EmptyGrid", {"rows": 4, "cols": 0}),
        ({"elevation": np.full((3, 4), np.nan)}, "GoalBlocked", {"row": 0, "col": 0}),
        ({"cell_size": 0.0}, "CellSizeOutOfRange", {"value": 0.0}),
        ({"cell_size": -1.0}, "CellSizeOutOfRange", {"value": -1.0}),
        ({"cell_size": math.nan}, "CellSizeOutOfRange", {}),
        ({"cell_size": math.inf}, "CellSizeOutOfRange", {"value": math.inf}),
        ({"cell_size": "ten"}, "CellSizeOutOfRange", {"value": "ten"}),
        ({"goal": (3, 0)}, "GoalOutsideGrid", {"row": 3, "rows": 3}),
        ({"goal": (-1, 0)}, "GoalOutsideGrid", {"row": -1}),
        ({"goal": (0.5, 0)}, "CellNotWhole", {"value": 0.5}),
        ({"goal": 7}, "GoalMalformed", {"value": 7}),
        ({"goal": []}, "NoGoal", {}),
        ({"elevation": with_value(np.nan), "goal": (1, 2)}, "GoalBlocked", {"row": 1, "col": 2}),
        ({"roughness": with_value(np.nan), "goal": (1, 2)}, "GoalBlocked", {"row": 1, "col": 2}),
        ({"roughness": np.zeros((4, 3))}, "RoughnessShape", {"rows": 4, "elevation_rows": 3}),
        ({"roughness": with_value(-0.1)}, "RoughnessOutOfRange", {"row": 1, "col": 2}),
        ({"roughness": with_value(np.inf)}, "RoughnessOutOfRange", {"value": np.inf}),
        ({"roughness": np.zeros(3)}, "GridNotPlannable", {"shape": (3,)}),
        ({"model": "p3dx"}, "TerrainModelUnknown", {"value": "p3dx"}),
        ({"model": None}, "TerrainModelUnknown", {"value": None}),
        ({"model": terrain.Tobler}, "TerrainModelUnknown", {}),
        ({"threads": 0}, "NoThreads", {}),
        ({"threads": -1}, "UnknownPlanOption", {"option": "threads"}),
        ({"simd": "sse9"}, "UnknownPlanOption", {"option": "simd"}),
        ({"start": (0, 99)}, "StartOutsideGrid", {"col": 99}),
        ({"start": 5}, "StartMalformed", {"value": 5}),
        ({"corner_cutting": 1}, "UnknownPlanOption", {"option": "corner_cutting"}),
    ],
)
def test_what_cannot_be_planned_on_is_refused_by_name(change, error, fields):
    given = {"elevation": FLAT, "cell_size": 1.0, "goal": (0, 0), "model": "p3at_energy", **change}
    with pytest.raises(getattr(cairn.errors, error)) as caught:
        cairn.plan_terrain(**given)
    assert isinstance(caught.value, ValueError)
    assert {name: getattr(caught.value, name) for name in fields} == fields


@pytest.mark.parametrize("model", [terrain.P3ATEnergy, terrain.P3ATTime, terrain.Tobler])
def test_every_parameter_of_a_model_has_its_range(model):
    for name, value in vars(model()).items():
        if name == "off_path":
            continue
        for bad in (math.nan, -1.0, -math.inf, 1e300 if name != "max_roughness" else -1e-9):
            with pytest.raises(cairn.errors.TerrainValueOutOfRange) as caught:
                model(**{name: bad})
            assert caught.value.key == name
            assert not caught.value.least <= bad <= caught.value.most
        with pytest.raises(cairn.errors.SettingsInvalid):
            model(**{name: "fast"})
        assert getattr(model(**{name: value}), name) == value
    with pytest.raises(TypeError):
        model(colour="red")


def test_costs_that_vanish_beside_the_cost_to_go_are_refused_not_gone_round_in_circles():
    cliff = np.array([[0.0, 0.0, 8.0, 8.0, 8.0]])
    walker = terrain.Tobler(max_climb_rad=math.pi / 2, max_descent_rad=math.pi / 2)
    with pytest.raises(cairn.errors.LinkCostAbsorbed):
        cairn.plan_terrain(cliff, 1.0, (0, 0), walker)
    sheer = np.array([[0.0, 3e38, 0.0]])
    free = {"max_climb_rad": math.pi / 2, "max_descent_rad": math.pi / 2}
    with pytest.raises(cairn.errors.CostToGoOverflow):
        cairn.plan_terrain(sheer, 1e6, (0, 0), terrain.P3ATEnergy(**free))


@pytest.mark.parametrize(
    ("path", "error", "fields"),
    [
        ([], "PathWithoutCells", {}),
        (None, "PathMalformed", {"value": None}),
        ([1, 2], "PathMalformed", {}),
        ([(0, 0), (0, 0.5)], "CellNotWhole", {"value": 0.5}),
        ([(0, 0), (0, 4)], "PathOutsideGrid", {"index": 1, "col": 4, "cols": 4}),
        ([(-1, 0)], "PathOutsideGrid", {"index": 0, "row": -1}),
        ([(0, 0), (0, 2)], "PathBroken", {"index": 0, "next_col": 2}),
        ([(0, 0), (1, 1), (1, 1)], "PathBroken", {"index": 1, "row": 1}),
    ],
)
def test_what_is_no_path_is_refused_by_name(path, error, fields):
    with pytest.raises(getattr(cairn.errors, error)) as caught:
        terrain.path_cost(FLAT, 1.0, path, "tobler")
    assert {name: getattr(caught.value, name) for name in fields} == fields


def test_a_path_over_a_move_that_is_not_allowed_costs_infinitely_much():
    assert (
        terrain.path_cost(with_value(np.nan), 1.0, [(1, 1), (1, 2), (1, 3)], "tobler") == math.inf
    )
    assert terrain.path_cost(with_value(5.0), 1.0, [(1, 1), (1, 2)], "p3at_time") == math.inf
    assert terrain.path_cost(FLAT, 1.0, [(1, 1)], "tobler") == 0.0


# ---- the command line and the pictures -----------------------------------------------------------


@pytest.fixture
def hills(tmp_path):
    elevation = fractal(np.random.default_rng(17), 24, 36, 20.0)
    elevation[:, 30] = np.nan
    np.save(tmp_path / "hills.npy", elevation)
    return elevation


def test_the_plan_command_plans_over_terrain_in_metres(command, hills, tmp_path):
    code, said, _ = command(
        "plan", "hills.npy", "--terrain", "p3at_energy", "--cell-size", 5, "--goal", "22,61",
        "--start", "101,3", "--out", "field.npy", "--picture", "p.png", "--json",
    )  # fmt: skip
    assert code == 0
    record = json.loads(said)
    field = cairn.plan_terrain(hills, 5.0, (12, 4), "p3at_energy")
    assert record["summary"]["cost"] == pytest.approx(field.cost_to_go[0, 20], abs=1e-6)
    assert record["summary"]["unit"] == "J"
    assert record["path_m"][0] == [102.5, 2.5]
    np.testing.assert_array_equal(np.load(tmp_path / "field.npy"), field.cost_to_go)
    assert (tmp_path / "p.png").stat().st_size > 10_000
    code, said, _ = command(
        "plan", "hills.npy", "--terrain", "tobler", "--cell-size", 5, "--goal", "22,61",
        "--start", "170,3",
    )  # fmt: skip
    assert (code, "no way" in said) == (3, True)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--terrain", "tobler"], "--cell-size"),
        (["--cell-size", "5"], "--terrain"),
        (["--terrain", "walk", "--cell-size", "5"], "TerrainModelUnknown"),
        (["--terrain", "tobler", "--cell-size", "0"], "CellSizeOutOfRange"),
        (["--terrain", "tobler", "--cell-size", "0.01"], "off the map"),
        (["--terrain", "tobler", "--cell-size", "5", "--robot", "p3at"], "--robot"),
        (["--terrain", "tobler", "--cell-size", "5", "--start", "x"], "X,Y"),
    ],
)
def test_wrong_usage_over_terrain_is_exit_code_2(command, hills, arguments, complaint):
    code, _, complaints = command("plan", "hills.npy", "--goal", "22,61", *arguments)
    assert (code, complaint in complaints) == (2, True), complaints


def test_a_terrain_that_is_not_there_or_is_no_array_of_heights_is_refused_by_name(
    command, tmp_path
):
    np.save(tmp_path / "free.npy", np.ones((3, 3), bool))
    np.save(tmp_path / "none.npy", np.ones((0, 3)))
    given = ["--terrain", "tobler", "--cell-size", 1, "--goal", "0,0"]
    for name, error in [
        ("nowhere.npy", "MapNotFound"), ("free.npy", "MapLineInvalid"), ("none.npy", "MapEmpty"),
    ]:  # fmt: skip
        code, _, complaints = command("plan", name, *given)
        assert (code, error in complaints) == (2, True)


def test_the_example_goes_up_one_way_and_down_another(tmp_path, capsys):
    example = runpy.run_path(str(Path(__file__).parent.parent / "examples/plan_over_terrain.py"))
    up, down = example["main"](tmp_path / "terrain.png")
    assert up > 1.1 * down
    assert "if driven the other way" in capsys.readouterr().out
    assert (tmp_path / "terrain.png").stat().st_size > 100_000


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (40, 7)])
def test_a_relief_of_any_shape_is_drawn(tmp_path, shape):
    from cairn.view.relief import Way, draw_relief

    elevation = np.zeros(shape)
    field = cairn.plan_terrain(elevation, 1.0, (0, 0), "tobler")
    way = Way(field.path((shape[0] - 1, shape[1] - 1)), "there")
    drawn = draw_relief(elevation, 1.0, tmp_path / "p.png", ways=[way], cost_to_go=field.cost_to_go)
    assert drawn.stat().st_size > 3_000
    draw_relief(np.full(shape, np.nan), 1.0, tmp_path / "q.png", ways=[])
