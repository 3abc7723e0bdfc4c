"""Up a mountain and down again are two different plans: a real elevation model, planned both ways.

    python examples/plan_over_terrain.py [PICTURE.png]

The terrain is the fault near Jacksboro, Tennessee, that comes with matplotlib.
"""

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import cbook
from numpy.typing import NDArray

import cairn
from cairn import terrain
from cairn.view.relief import Way, draw_relief

EARTH_RADIUS_M = 6_371_009.0
VALLEY, RIDGE = (194, 91), (43, 167)  # (row, col)


def jacksboro() -> tuple[NDArray[np.float64], float]:
    """Heights [m] on square cells, row 0 in the south, and the side of a cell [m]."""
    found: Any = cbook.get_sample_data("jacksboro_fault_dem.npz")
    with found as dem:
        heights = dem["elevation"][::-1].astype(float)  # the file begins in the north
        latitude = math.radians(float(dem["ymin"] + dem["ymax"]) / 2)
        south_north_m = math.radians(float(dem["dy"])) * EARTH_RADIUS_M
        west_east_m = math.radians(float(dem["dx"])) * EARTH_RADIUS_M * math.cos(latitude)
    given = np.arange(heights.shape[1]) * west_east_m
    wanted = np.arange(0.0, given[-1], south_north_m)
    return np.array([np.interp(wanted, given, row) for row in heights]), south_north_m


def main(picture: Path | None = None) -> tuple[float, float]:
    """Plan up and down with the energy of a P3-AT, and tell what each takes [J]."""
    heights, cell_size = jacksboro()
    model = terrain.P3ATEnergy()
    to_ridge = cairn.plan_terrain(heights, cell_size, RIDGE, model)
    to_valley = cairn.plan_terrain(heights, cell_size, VALLEY, model)
    up, down = to_ridge.path(VALLEY), to_valley.path(RIDGE)
    assert up is not None
    assert down is not None

    def told(way: NDArray[np.int64], name: str) -> str:
        """What a way takes; back along it, a way is priced anew."""
        there = terrain.path_cost(heights, cell_size, way, model)
        back = terrain.path_cost(heights, cell_size, way[::-1], model)
        return f"{name}: {there / 3600:.0f} Wh ({back / 3600:.0f} Wh if driven the other way)"

    names = told(up, "up"), told(down, "down")
    print("\n".join(names))
    if picture is not None:
        draw_relief(
            heights,
            cell_size,
            picture,
            ways=[Way(up, names[0]), Way(down, names[1])],
            cost_to_go=to_ridge.cost_to_go / 3600,
            cost_name="energy to the ridge [Wh]",
            title="A P3-AT between valley and ridge, by least energy",
        )
    return float(to_ridge.cost_to_go[VALLEY]), float(to_valley.cost_to_go[RIDGE])


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
