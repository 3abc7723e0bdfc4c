import numpy as np
import pytest

import cairn


def test_a_path_runs_from_the_start_to_the_goal_with_both_ends():
    field = cairn.plan_grid(np.ones((5, 7), bool), (2, 3))
    assert field.path((0, 0)).tolist() == [[0, 0], [0, 1], [1, 2], [2, 3]]


def test_a_goal_outside_the_grid_is_refused_by_name_with_its_place():
    with pytest.raises(cairn.errors.GoalOutsideGrid) as caught:
        cairn.plan_grid(np.ones((2, 2), bool), (-1, 0))
    assert (caught.value.row, caught.value.col) == (-1, 0)
