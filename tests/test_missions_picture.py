import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

import cairn
from cairn.missions import Scenario, run
from cairn.missions.result import Transition
from cairn.view.picture import draw_plan, draw_run

ROOM = {
    "name": "drawn",
    "map": "room",
    "robot": "kinematic",
    "timeout_s": 3.0,
    "start": {"place": "start"},
    "goals": [{"place": "goal"}],
}


def size_of(path):
    with Image.open(path) as image:
        return image.size


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"boxes": [{"x_m": 5.0, "y_m": 3.0, "length_m": 0.5, "width_m": 0.3, "yaw_rad": 0.5}]},
        {"map": "none", "world": {"map": "room"}},
        {"goals": [{"explore_s": 2.0}]},
        {"pose": "truth", "events": [{"do": "shove", "at_s": 1.0, "dy_m": 0.5}]},
        {
            "start": None,
            "robots": [
                {"name": "a", "start": {"place": "start"}},
                {"name": "b", "start": {"place": "corner"}},
            ],
        },
    ],
)
def test_every_kind_of_run_can_be_drawn(tmp_path, changes):
    result = run(Scenario.model_validate(ROOM | changes))
    width, height = size_of(draw_run(result, tmp_path / "run.png"))
    assert width > 1000
    assert height > 600


def test_a_picture_of_one_result_is_always_the_same(tmp_path):
    result = run(Scenario.model_validate(ROOM))
    one, other = (draw_run(result, tmp_path / f"{n}.png").read_bytes() for n in (1, 2))
    assert one == other


@pytest.mark.parametrize("shape", [(1, 1), (1, 30), (30, 1), (12, 20)])
@pytest.mark.parametrize("yaw", [0.0, 0.6])
def test_a_plan_can_be_drawn_on_a_map_of_any_shape(tmp_path, shape, yaw):
    world = cairn.World(np.zeros(shape, np.uint8), 0.5, origin=(3.0, -2.0, yaw), name="yard")
    goal = tuple(world.point_of((0, 0)))
    field = cairn.plan(world, goal)
    start = tuple(world.point_of((shape[0] - 1, shape[1] - 1)))
    path = draw_plan(
        world, field.cost_to_go, goal, tmp_path / "plan.png", start=start, way=field.path(start)
    )
    assert min(size_of(path)) > 300


def test_a_plan_that_nothing_reaches_can_be_drawn(tmp_path):
    cells = np.zeros((5, 5), np.uint8)
    cells[:, 2] = 1
    world = cairn.World(cells, name="cut")
    field = cairn.plan(world, (0.5, 0.5))
    path = draw_plan(world, field.cost_to_go, (0.5, 0.5), tmp_path / "p.png", start=(4.5, 0.5))
    assert min(size_of(path)) > 300


def long_run(changes):
    """A run with that many changes of mode, far apart, each with a long sentence."""
    result = run(Scenario.model_validate(ROOM))
    sentence = (
        "Stop: something the plan did not know at (24.98, 4.62) m stands 0.07 m from it. " * 4
    )
    result.robots[0].transitions = [
        Transition(
            3.1 * k, "path_tracking", "stop", "arrived", "arrived", sentence, (1.0 + 0.1 * k, 1.0)
        )
        for k in range(changes)
    ]
    return result


def drawn_texts(monkeypatch, result, path):
    """The texts of a picture as drawn, with where each begins and ends on the page."""
    pages = []
    monkeypatch.setattr(Figure, "savefig", lambda page, *_, **__: pages.append(page))
    draw_run(result, path)
    page = pages[0]
    page.canvas.draw()
    texts = [text for axes in page.axes for text in axes.texts] + page.texts
    boxes = [(text.get_text(), text.get_window_extent()) for text in texts if text.get_text()]
    return page, boxes


@pytest.mark.parametrize("changes", [1, 13, 60])
def test_no_line_of_the_legend_runs_into_another_or_off_the_page(monkeypatch, tmp_path, changes):
    page, boxes = drawn_texts(monkeypatch, long_run(changes), tmp_path / "run.png")
    map_bottom = page.axes[0].get_window_extent().y0
    below = [box for _, box in boxes if box.y1 < map_bottom]
    assert len(below) > 2 * min(changes, 20)
    for number, box in enumerate(below):
        assert box.x0 > 0
        assert box.x1 < page.bbox.width
        assert box.y0 > 0
        assert not any(box.shrunk(0.99, 0.9).overlaps(other) for other in below[:number])


def test_of_many_changes_the_first_and_the_last_few_are_told(monkeypatch, tmp_path):
    _, boxes = drawn_texts(monkeypatch, long_run(60), tmp_path / "run.png")
    texts = [text for text, _ in boxes]
    assert {"1", "10", "51", "60", "40 more in summary.json"} <= set(texts)
    assert not {"11", "50"} & set(texts)


def test_what_was_touched_is_marked_where_it_was(monkeypatch, tmp_path):
    result = long_run(1)
    result.robots[0].contacts = [{"time_s": 1.0, "name": "crate $1"}]
    _, boxes = drawn_texts(monkeypatch, result, tmp_path / "run.png")
    assert "touched crate $1" in [text for text, _ in boxes]


def test_the_sentence_of_a_result_stays_on_the_page(monkeypatch, tmp_path):
    result = long_run(1)
    result.unmet = [
        "expected something that takes a very long sentence to say, for $1 or \\$_2"
    ] * 5
    page, boxes = drawn_texts(monkeypatch, result, tmp_path / "run.png")
    assert max(box.x1 for _, box in boxes) < page.bbox.width
