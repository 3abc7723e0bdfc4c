import itertools

import numpy as np
import pytest
from matplotlib.figure import Figure
from typer.testing import CliRunner

import cairn
from cairn.cli import app
from cairn.experiments.paper import arcs, cases, layers, machine, rules
from cairn.experiments.reproduce import ALL, NOT_MADE
from cairn.navigator import transitions

PAPER = ("eq4", "fig3", "fig4", "fig5", "fig7", "table1", "fig8", "fig10", "fig11", "fig12")
NAMED = {*(f"fig{n}" for n in range(1, 17)), "table1", "eq4"}


def quiet(name):
    pass


@pytest.fixture(scope="module")
def records():
    return {name: ALL[name]().measure(1, quiet) for name in PAPER}


def texts_of(monkeypatch, name, record, folder):
    """Every text of the pictures a reproduction draws."""
    pages = []
    monkeypatch.setattr(Figure, "savefig", lambda page, *_, **__: pages.append(page))
    ALL[name]().draw(record, folder)
    found = []
    for page in pages:
        found += [text.get_text() for text in page.texts]
        found += [text.get_text() for axes in page.axes for text in axes.texts]
        page.canvas.draw()
        for text in [*page.texts, *(t for axes in page.axes for t in axes.texts)]:
            if text.get_text():
                box = text.get_window_extent()
                assert box.x0 >= 0, text
                assert box.x1 <= page.bbox.width, text
        titles = [axes._left_title for axes in page.axes] + [axes.title for axes in page.axes]
        for title in (one for one in titles if one.get_text()):
            box = title.get_window_extent()
            assert not any(box.overlaps(text.get_window_extent()) for text in page.texts)
    return found


def test_every_figure_and_table_of_the_paper_is_made_or_it_is_said_why_not():
    assert set(ALL) - {"parallel"} | set(NOT_MADE) == NAMED
    assert not set(ALL) & set(NOT_MADE)
    told = CliRunner().invoke(app, ["reproduce", "--list"]).stdout
    assert all(name in told for name in NAMED)


@pytest.mark.parametrize("name", PAPER)
def test_a_reproduction_counts_its_steps_and_tells_tables_and_a_caption(name, records):
    reproduction, steps = ALL[name](), []
    record = reproduction.measure(1, steps.append) if name != "eq4" else records[name]
    assert name == "eq4" or len(steps) == reproduction.steps()
    for table in reproduction.tables(record):
        assert table.rows
        assert all(len(row) == len(table.columns) for row in table.rows)
    caption = reproduction.caption(record)
    assert "Maalouf06" in caption.source
    assert caption.made_from
    assert caption.agrees
    assert caption.differs  # no figure of ours is the paper's own in everything
    assert not any("NOT" in one for one in (*caption.agrees, *caption.differs))


@pytest.mark.parametrize("name", PAPER)
def test_pictures_are_drawn_with_every_text_on_the_page(name, records, monkeypatch, tmp_path):
    assert any(texts_of(monkeypatch, name, records[name], tmp_path))


def test_equation_4_as_printed_counts_one_operation_more_than_run(records):
    assert records["eq4"]["summary"]["printed_minus_counted"] == [1]
    assert layers.printed(4, 6) == 37  # by hand: 3·24 − 12 − 48 + 4 + 18 + 3


def test_the_solution_graph_links_layers_next_to_each_other_on_levels_above(records):
    record = records["fig3"]
    most = record["summary"]["layers"]
    drawn = {tuple(operation) for operation in record["operations"]}
    wanted = {(1, 1, 0)} | {
        (level, i, j)
        for level in range(2, record["summary"]["levels"] + 1)
        for i in range(1, min(level, most) + 1)
        for j in (i - 1, i, i + 1)
        if 1 <= j <= min(level - 1, most)
    }
    assert drawn == wanted
    assert len(drawn) == len(record["operations"])


def test_vector_links_stand_for_every_link_of_the_map_but_those_out_of_the_goal(records):
    record = records["fig4"]
    free = np.array(record["layer"]) >= 0
    indptr, _, _ = cairn.grid_graph(free)
    goal = record["goal"][0] * free.shape[1] + record["goal"][1]
    out_of_goal = int(indptr[goal + 1] - indptr[goal])
    assert sum(count for _, _, count in record["links"]) == indptr[-1] - out_of_goal
    assert {abs(i - j) for i, j, _ in record["links"]} <= {0, 1}


def test_parameters_of_the_controller_are_as_the_paper_defines_them(records):
    assert records["fig5"]["summary"]["most_off_by_hand"] < 1e-12


def test_table_1_is_answered_as_printed(records):
    cells = records["table1"]["cells"]
    assert [cell["fired"] for cell in cells] == [cell["printed"] for cell in cells]
    assert len(cells) == 9
    assert all(cell["strength"] == 1.0 for cell in cells)
    printed = np.array([rules.TABLE_1[row] for row in rules.ROWS])
    assert printed[:, 2].tolist() == ["cVeryHigh"] * 3
    assert (printed == "cModerate").sum() == 1


def test_sets_cover_every_input_wholly(records):
    for name in ("fig7", "fig8"):
        for told in records[name]["inputs"].values():
            total = np.sum(list(told["sets"].values()), axis=0)
            np.testing.assert_allclose(total, 1.0, atol=1e-12)
            assert all(np.max(grades) == 1.0 for grades in told["sets"].values())


def test_free_lengths_are_those_of_arcs_followed_in_small_steps(records):
    record = records["fig10"]
    for one, marched in zip(record["intervals"], record["marched_m"], strict=True):
        assert one["distance_m"] <= marched + 2 * arcs.MARCH_STEP_M
        assert marched - one["distance_m"] < 0.01
    edges = [(one["curvature_lo"], one["curvature_hi"]) for one in record["intervals"]]
    assert all(before[1] == after[0] for before, after in itertools.pairwise(edges))


def test_tangent_curvatures_part_arcs_that_hit_from_arcs_that_pass():
    radius = 0.45
    for x, y in arcs.OBSTACLES:
        low, high, _ = arcs.tangent_estimate(x, y, radius)
        way = np.linspace(0.0, 4.0, 8001)
        for curvature, hits in ((low - 0.01, False), (low + 0.01, True), (high - 0.01, True),
                                (high + 0.01, False)):  # fmt: skip
            nearest = np.hypot(*(arcs.along(curvature, way) - (x, y)).T).min()
            assert (nearest < radius) == hits


def test_the_state_machine_has_exactly_the_rows_of_the_transition_table(records):
    record = records["fig11"]
    drawn = [
        (arrow["from"], row["event"], arrow["to"], row["reason"])
        for arrow in record["arrows"]
        for row in arrow["rows"]
    ]
    kept = [
        (mode, row["event"], mode, row["reason"])
        for mode, rows in record["stays"].items()
        for row in rows
    ]
    assert sorted(drawn + kept) == sorted(transitions())
    assert all(before != after for before, _, after, _ in drawn)
    (table,) = ALL["fig11"]().tables(record)
    assert table.rows == transitions()


def test_every_change_of_mode_is_a_line_of_the_picture(records, monkeypatch, tmp_path):
    record = records["fig11"]
    texts = texts_of(monkeypatch, "fig11", record, tmp_path)
    lines = [line.removeprefix("· ") for text in texts for line in text.splitlines()]
    for arrow in record["arrows"]:
        for row in arrow["rows"]:
            line = row["event"].replace("_", " ")
            if row["reason"] != row["event"]:
                line += f" ({row['reason'].replace('_', ' ')})"
            assert line in lines
            lines.remove(line)


def test_the_arrows_are_those_the_paper_tells(records):
    assert {(a["from"], a["to"]) for a in records["fig11"]["arrows"]} == set(machine.TOLD)


def test_dynamic_programming_and_a_star_cost_the_same_on_every_case(records):
    for case in records["fig12"]["cases"]:
        assert set(case["costs"].values()) == {case["path_cost"]}


@pytest.mark.parametrize("seed", range(8))
def test_a_star_costs_what_the_solver_does_on_random_maps(seed):
    rng = np.random.default_rng(seed)
    free = rng.random((17, 23)) > 0.3
    start, goal = (2, 3), (14, 20)
    free[start] = free[goal] = True
    field = cairn.plan_grid(free, goal, steps="100/141")
    cost, _ = cases.a_star(free, start, goal)
    way = field.path(start)
    assert cost == (-1 if way is None else int(field.native[start]))


def test_a_caption_stays_beside_the_picture(tmp_path):
    done = CliRunner().invoke(app, ["reproduce", "table1", "fig11", "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    for name in ("table1", "fig11"):
        text = (tmp_path / name / "caption.md").read_text(encoding="utf-8")
        assert text.startswith("# ")
        assert "Agrees:" in text
        assert "Differs:" in text
        assert (tmp_path / name / f"{name}.png").exists()
