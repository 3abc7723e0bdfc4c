"""Benchmarks: their maps are what they say, their contenders agree, their command tells."""

import json
import math
import sys

import numpy as np
import pytest

import cairn
from cairn import _brain
from cairn.experiments import bench_plan, bench_report, memory
from cairn.experiments.bench_graph import GRAPHS
from cairn.experiments.contenders import OURS, PEERS, InRust, Peer, Refused, Task, compare, ours
from cairn.experiments.grids import CLASSES, Terrain, as_costs
from plan_oracles import Case, grid_links, mean_price, scipy_cost_to_go

# ---- maps ---


@pytest.mark.parametrize("name", CLASSES)
def test_a_map_follows_from_its_seed(name):
    draw = CLASSES[name].draw
    for size in (8, 61, 200):
        first, again, other = (
            each.elevation if isinstance(each, Terrain) else each
            for each in (draw(size, 3), draw(size, 3), draw(size, 4))
        )
        assert first.shape == (size, size)
        np.testing.assert_array_equal(first, again)
        assert name in ("open", "maze-16") or size == 8 or not np.array_equal(first, other)


@pytest.mark.parametrize("percent", [10, 20, 40])
def test_random_obstacles_block_the_share_in_their_name(percent):
    grid = CLASSES[f"random-{percent}"].draw(512, 1)
    assert abs((~grid).mean() - percent / 100) < 4 * math.sqrt(0.25 / grid.size)


@pytest.mark.parametrize("corridor", [1, 4, 16])
def test_mazes_join_all_their_cells_by_one_way(corridor):
    grid = CLASSES[f"maze-{corridor}"].draw(205, 2)
    goal = bench_plan.choose_goal(grid)
    field = cairn.plan_grid(grid, goal)
    assert (np.isfinite(field.cost_to_go) == grid).all()
    rooms = (204 // (corridor + 1)) ** 2
    assert grid.sum() == rooms * corridor**2 + (rooms - 1) * corridor  # a tree of rooms


def test_caves_have_halls_and_rock_and_the_goal_is_in_the_largest():
    grid = CLASSES["caves"].draw(512, 1)
    assert 0.6 < grid.mean() < 0.9
    within = np.lib.stride_tricks.sliding_window_view(grid, (7, 7)).all(axis=(2, 3))
    assert within.mean() > 0.1
    field = cairn.plan_grid(grid, bench_plan.choose_goal(grid))
    assert np.isfinite(field.cost_to_go).sum() > 0.5 * grid.sum()


def test_weights_are_1_to_255_smooth_ones_change_slowly_random_ones_do_not():
    smooth, rough = (CLASSES[f"{kind}-weights"].draw(512, 1) for kind in ("smooth", "random"))
    for weights in (smooth, rough):
        assert (weights.min(), weights.max()) == (1, 255)
    steps = [np.abs(np.diff(weights.astype(int), axis=1)) for weights in (smooth, rough)]
    assert steps[0].max() <= 12
    assert steps[1].mean() > 60
    maze = CLASSES["weighted-maze"].draw(512, 1)
    np.testing.assert_array_equal(maze > 0, CLASSES["maze-4"].draw(512, 1))


@pytest.mark.parametrize(("name", "mean_slope"), [("fractal-terrain", 0.12), ("real-terrain", 0.1)])
def test_terrain_slopes_like_hills_and_most_of_it_reaches_the_goal(name, mean_slope):
    ground = CLASSES[name].draw(300, 1)
    slopes = np.abs(np.diff(ground.elevation, axis=0)) / ground.cell_size_m
    assert slopes.mean() == pytest.approx(mean_slope, rel=0.5)
    assert ground.elevation.flags.c_contiguous
    np.testing.assert_array_equal(
        ground.roughness, cairn.terrain.roughness(ground.elevation, ground.cell_size_m)
    )
    goal = bench_plan.choose_goal(ground)
    field = cairn.plan_terrain(
        ground.elevation, ground.cell_size_m, goal, ground.MODEL, roughness=ground.roughness
    )
    assert np.isfinite(field.native).mean() > 0.9


def test_the_real_terrain_is_the_elevation_model_mirrored_without_a_seam():
    from matplotlib import cbook

    with cbook.get_sample_data("jacksboro_fault_dem.npz") as model:
        tile = model["elevation"]
    drawn = CLASSES["real-terrain"].draw(900, 4).elevation
    assert set(np.unique(drawn)) == set(np.unique(tile).astype(np.float32))
    for axis in (0, 1):
        assert (
            np.abs(np.diff(drawn, axis=axis)).max()
            <= np.abs(np.diff(tile.astype(float), axis=axis)).max()
        )


# ---- contenders ---


def tasks():
    for name, each in CLASSES.items():
        grid = each.draw(53, 5)
        for cutting in (False, True):
            yield name, Task(grid, bench_plan.choose_goal(grid), cutting)


def test_every_contender_gives_the_same_answer_on_every_kind_of_map():
    there = [name for name, peer in PEERS.items() if peer.missing() is None]
    assert "scipy" in there
    for kind, task in tasks():
        mine = OURS["cairn"](task)
        mine.run()
        for name in ours(task) + there:
            try:
                other = OURS[name](task) if name in OURS else PEERS[name].make(task)
            except Refused:
                assert not task.corner_cutting or isinstance(task.grid, Terrain)
                continue
            assert other.run() > 0
            how, differs = compare("cairn", mine, name, other, 1e-5)
            assert differs is None, kind
            assert how == ("within 1e-05" if other.arithmetic != mine.arithmetic else "to the bit")


def test_dial_and_heap_in_whole_weights_equal_scipy_to_the_unit():
    for kind in ("random-weights", "weighted-maze"):
        grid = CLASSES[kind].draw(40, 6)
        task = Task(grid, bench_plan.choose_goal(grid), False)
        costs = as_costs(grid).astype(float)
        tails, heads, codes, _ = grid_links(costs, False, mean_price(np.float64))
        flat = costs.ravel()
        links = (flat[tails] + flat[heads]) * np.array([985, 1393])[codes % 2]
        goal = task.goal[0] * grid.shape[1] + task.goal[1]
        truth = scipy_cost_to_go(Case(grid.size, tails, heads, links, [goal]))
        truth = np.where(np.isinf(truth), 2**32 - 1, truth)
        for solver in ("dial", "heap"):
            contender = InRust(solver, task, whole=True)
            contender.run()
            np.testing.assert_array_equal(contender.values().ravel(), truth)


def test_answers_that_differ_are_told():
    grid = np.ones((9, 9), bool)
    one, other = (InRust("dial", Task(grid, goal, False)) for goal in ((4, 4), (4, 5)))
    one.run()
    other.run()
    assert compare("one", one, "other", other, 1e-5)[1] == "one and other differ in steps"
    walled = grid.copy()
    walled[0] = False
    peer = PEERS["scipy"].make(Task(walled, (4, 4), False))
    peer.run()
    assert "same cells" in compare("one", one, "scipy", peer, 1e-5)[1]
    peer = PEERS["scipy"].make(Task(grid, (4, 5), False))
    peer.run()
    assert "differ by" in compare("one", one, "scipy", peer, 1e-5)[1]


def test_a_solver_asked_for_a_map_it_does_not_take_is_refused_by_name():
    with pytest.raises(cairn.errors.SettingsInvalid, match="no solver `fast`"):
        _brain.TimedSolver("fast", np.ones((3, 3), bool), [(0, 0)], False, 1)
    with pytest.raises(cairn.errors.GoalBlocked):
        _brain.TimedSolver("dial", np.zeros((3, 3), bool), [(0, 0)], False, 1).run()


@pytest.mark.skipif(sys.platform != "linux", reason="the high-water mark is Linux's")
def test_peak_memory_is_at_least_what_comes_out():
    share = memory.peak_share(Task(np.ones((1024, 1024), bool), (5, 5), False))
    assert 0.9 < share < 40


# ---- the command ---


def test_the_command_prints_a_record_with_its_summary_first(command, tmp_path):
    code, said, _ = command(
        "bench", "plan", "--size", "64", "--repeats", "1", "--json", "--no-memory", "--peers",
        "scipy", "--classes", "open,caves,random-weights", "--markdown", "--out", "here",
    )  # fmt: skip
    assert code == 0
    record = json.loads(said)
    assert next(iter(record)) == "summary"
    summary = record["summary"]
    assert summary["cases"] == 6
    assert summary["agree"] is True
    assert summary["geometric_mean_ratio"] > 0
    assert summary["lowest_ratio"] <= summary["geometric_mean_ratio"]
    assert summary["geometric_mean_ratio_by_size"].keys() == {"64"}
    assert summary["geometric_mean_ratio_scipy"] > 0
    assert record["machine"]["cores"] >= 1
    assert record["machine"]["peers"]["scipy"]
    case = record["cases"][0]
    assert (case["class"], case["size"], case["corner_cutting"]) == ("open", 64, False)
    assert case["ratio"] > 0
    assert case["reached"] == 1.0
    for name in ("cairn", "cairn-python", "dial", "dial-wide", "heap", "scipy"):
        timing = case["contenders"][name]
        assert timing["least_ns_per_cell"] <= timing["median_ns_per_cell"]
        assert timing["runs"] == 1
    assert case["contenders"]["dial"]["agrees"] == "to the bit"
    assert json.loads((tmp_path / "here/summary.json").read_text()) == record
    table = (tmp_path / "BENCHMARKS.md").read_text()
    assert "| open | 64² | strict |" in table
    assert table.startswith("# Benchmarks")


def test_a_section_of_benchmarks_is_replaced_and_the_rest_kept(tmp_path):
    path = tmp_path / "BENCHMARKS.md"
    bench_report.written(path, "one", "0.123\n")
    path.write_text(path.read_text() + "\nby hand\n")
    bench_report.written(path, "two", "second\n")
    bench_report.written(path, "one", "third\n")
    text = path.read_text()
    assert "0.123" not in text
    assert text.index("third") < text.index("by hand") < text.index("second")
    assert text.count("<!-- one -->") == text.count("<!-- end of two -->") == 1


def test_a_table_for_people_tells_peers_that_are_missing(command, monkeypatch):
    gone = Peer("nothing", "nothing_at_all", PEERS["scipy"].make, 1.0, 1)
    monkeypatch.setitem(PEERS, "scikit-image", gone)
    code, said, _ = command(
        "bench", "plan", "--size", "16", "--repeats", "2", "--no-memory", "--classes", "maze-1",
        "--peers", "scipy,scikit-image", "--corner-cutting", "allowed",
    )  # fmt: skip
    assert code == 0
    assert "maze-1" in said
    assert "geometric mean" in said
    assert 'pip install "cairn-nav[bench]"' in said


def test_a_peer_too_slow_for_its_budget_is_left_out_and_says_so(command):
    code, said, _ = command(
        "bench", "plan", "--size", "64", "--repeats", "1", "--json", "--no-memory", "--budget",
        "0.0001", "--classes", "open", "--corner-cutting", "forbidden",
    )  # fmt: skip
    assert code == 0
    case = json.loads(said)["cases"][0]
    assert "more than the budget" in case["skipped"]["scipy"]
    assert case["ratio"] > 0


@pytest.mark.parametrize(
    "options",
    [
        ("--classes", "mountains"),
        ("--peers", "magic"),
        ("--size", "64,x"),
        ("--size", "4"),
        ("--corner-cutting", "perhaps"),
        ("--repeats", "0"),
    ],
)
def test_what_cannot_be_measured_is_a_usage_error(command, options):
    code, _, complaint = command("bench", "plan", *options)
    assert code == 2
    assert options[0] in complaint


def test_the_cases_of_a_full_run_are_every_kind_at_both_sizes_and_those_with_aims_at_512():
    cases = bench_plan.cases_of(bench_plan.FULL_SIZES, tuple(CLASSES), (False, True), small=True)
    assert len(cases) == 2 * (2 * len(CLASSES) + 2)
    assert bench_report.number(1.234) == "1.23"
    assert bench_report.number(None) == "–"


# ---- published maps ---

ARENA = ["........", ".@@@@...", ".....@..", "........"]


def movingai(folder, lengths):
    """A map with queries from the lower left to the upper right, of these published lengths."""
    (folder / "arena.map").write_text("type octile\nheight 4\nwidth 8\nmap\n" + "\n".join(ARENA))
    lines = [f"0\tarena.map\t8\t4\t0\t3\t7\t{goal}\t{length}" for goal, length in lengths]
    (folder / "arena.map.scen").write_text("version 1\n" + "\n".join(lines))


def test_published_lengths_are_checked_one_by_one(command, tmp_path):
    movingai(tmp_path, [(3, "7"), (0, "9.41"), (0, "9.41421356")])
    code, said, _ = command("bench", "movingai", tmp_path, "--repeats", "2", "--json")
    assert code == 0
    record = json.loads(said)
    assert record["summary"]["lengths_met"] == record["summary"]["queries"] == 3
    assert record["summary"]["geometric_mean_ratio"] > 0
    assert record["maps"][0]["cairn_ms"]["median"] > 0
    assert json.loads((tmp_path / "runs/bench-movingai/summary.json").read_text()) == record


def test_a_length_that_is_not_met_is_told_and_ends_with_code_3(command, tmp_path):
    movingai(tmp_path, [(3, "7"), (0, "7.5")])
    code, said, _ = command("bench", "movingai", tmp_path)
    assert code == 3
    assert "1 of 2" in said
    assert "published 7.5" in said


def test_a_folder_without_maps_is_a_usage_error(command, tmp_path):
    assert command("bench", "movingai", tmp_path)[0] == 2


# ---- graphs ---


def test_graphs_are_planned_as_scipy_plans_them(command):
    code, said, _ = command("bench", "graph", "--nodes", "3000", "--repeats", "1", "--json")
    assert code == 0
    record = json.loads(said)
    assert record["summary"]["agree"] is True
    assert record["summary"]["geometric_mean_ratio_scipy"] > 0
    assert [each["graph"] for each in record["graphs"]] == list(GRAPHS)
    for each in record["graphs"]:
        assert each["reached"] > 0.5
        assert each["contenders"]["cairn"]["median_ms"] > 0
    code, said, _ = command("bench", "graph", "--nodes", "100", "--repeats", "1", "--markdown")
    assert code == 0
    assert "equal to the bit" in said


@pytest.mark.parametrize("options", [("--graphs", "tree"), ("--nodes", "many")])
def test_a_graph_that_is_not_known_is_a_usage_error(command, options):
    assert command("bench", "graph", *options)[0] == 2


# ---- repair ---


def test_repaired_fields_are_those_solved_anew(command):
    code, said, _ = command("bench", "repair", "--size", "96", "--places", "4", "--json")
    assert code == 0
    record = json.loads(said)
    assert record["summary"]["agree"] is True
    assert record["summary"]["changes"] == 8 * record["summary"]["maps"]
    assert record["maps"][0]["full_ms"]["median"] > 0
    code, said, _ = command(
        "bench", "repair", "--size", "64", "--places", "1", "--classes", "open", "--markdown"
    )
    assert code == 0
    assert "local changes" in said


def test_a_map_that_is_not_repaired_is_a_usage_error(command):
    assert command("bench", "repair", "--classes", "real-terrain")[0] == 2
