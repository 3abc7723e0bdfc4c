import numpy as np
import pytest
from PIL import Image

import cairn
from cairn.missions import Scenario, run
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
