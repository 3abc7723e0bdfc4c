"""Fields of 4096 x 4096 cells, of every kind of map, against our plain heap, to the bit."""

import numpy as np
import pytest

from cairn import _brain
from cairn.experiments.grids import CLASSES, Terrain, as_costs

SIZE = 4096


@pytest.mark.slow
@pytest.mark.parametrize("corner_cutting", [False, True], ids=["strict", "cutting"])
@pytest.mark.parametrize("name", [name for name in CLASSES if "terrain" not in name])
def test_the_field_of_a_large_map_equals_dijkstra_to_the_bit(name, corner_cutting):
    drawn = CLASSES[name].draw(SIZE, 3)
    assert not isinstance(drawn, Terrain)
    cells = drawn if drawn.dtype == bool else as_costs(drawn)
    enterable = cells if cells.dtype == bool else np.isfinite(cells)
    row, col = (int(i) for i in np.argwhere(enterable)[np.count_nonzero(enterable) // 2])
    heap = _brain.TimedSolver("heap", cells, [(row, col)], corner_cutting, 1)
    heap.run()
    for threads in (1, 2):
        cairn = _brain.TimedSolver("cairn", cells, [(row, col)], corner_cutting, threads)
        cairn.run()
        np.testing.assert_array_equal(cairn.native(), heap.native())
        np.testing.assert_array_equal(cairn.next_node(), heap.next_node())
