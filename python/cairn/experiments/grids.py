"""The maps that planning is measured on: drawn by a seed, the same on every machine.

A map is square. `bool` arrays are True where free, at unit cost; `uint8` arrays are weights 1..255,
0 blocked; a `Terrain` is planned with the energy of a P3-AT, up and down.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from cairn import _brain, terrain


@dataclass(frozen=True)
class Terrain:
    """Heights and roughness, (rows, cols) float32, and the side of a cell [m]."""

    elevation: npt.NDArray[np.float32]
    roughness: npt.NDArray[np.float32]
    cell_size_m: float

    MODEL: ClassVar[Literal["p3at_energy"]] = "p3at_energy"

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, cols)."""
        rows, cols = self.elevation.shape
        return rows, cols


Cells = npt.NDArray[Any]
Map = Cells | Terrain
SMALLEST = 8  # cells a side: below this some kinds have no room for what they are


@dataclass(frozen=True)
class MapClass:
    """A kind of map.

    Attributes:
        name: as given to `cairn bench plan --classes`.
        summary: what it is, in a line.
        draw: (cells a side, seed) to a map.
        aim_ns: the aim at 4096², one thread, field and policy out [ns per cell].
    """

    name: str
    summary: str
    draw: Callable[[int, int], Map]
    aim_ns: float | None


def open_ground(size: int, seed: int) -> Map:
    """Nothing stands anywhere."""
    return np.ones((size, size), bool)


def random_obstacles(share: float) -> Callable[[int, int], Map]:
    """Each cell is blocked with the same chance, whatever its neighbours are."""

    def draw(size: int, seed: int) -> Map:
        return np.random.default_rng(seed).random((size, size), np.float32) >= share

    return draw


def caves(size: int, seed: int) -> Map:
    """Caves by a cellular automaton: 43 % rock, five times smoothed by the rule of five in nine."""
    rock = np.zeros((size + 2, size + 2), np.uint8)
    rock[1:-1, 1:-1] = np.random.default_rng(seed).random((size, size), np.float32) < 0.43
    for _ in range(5):
        rock[0], rock[-1], rock[:, 0], rock[:, -1] = 1, 1, 1, 1  # rock all around
        beside = rock[:, :-2] + rock[:, 1:-1] + rock[:, 2:]
        rock[1:-1, 1:-1] = beside[:-2] + beside[1:-1] + beside[2:] >= 5
    return rock[1:-1, 1:-1] == 0


def maze(corridor: int) -> Callable[[int, int], Cells]:
    """A perfect maze, corridors of so many cells between walls of one."""

    def draw(size: int, seed: int) -> Cells:
        free = _brain.perfect_maze(size, size, corridor, seed)
        # Too small for a single room: an empty one.
        return np.ones((size, size), bool) if free is None else free

    return draw


def smooth_weights(size: int, seed: int) -> Map:
    """Weights 1..255 that change slowly: noise of 128, 64 and 32 cells a wave."""
    noise = np.zeros((size, size), np.float32)
    for part, (cells, amplitude) in enumerate([(128, 1.0), (64, 0.5), (32, 0.25)]):
        noise += amplitude * _waves(size, cells, seed * 3 + part)
    low, high = float(np.min(noise)), float(np.max(noise))
    return (1.5 + 254 * (noise - low) / (high - low or 1.0)).astype(np.uint8)


def _waves(size: int, cells: int, seed: int) -> npt.NDArray[np.float32]:
    """Draw random heights every so many cells, joined by smooth steps; (size, size), 0..1."""
    knots = np.random.default_rng(seed).random((size // cells + 2,) * 2, np.float32)
    at = np.arange(size, dtype=np.float32) / cells
    knot = at.astype(np.intp)
    t = at - knot
    t = t * t * (3 - 2 * t)
    rows = knots[knot] * (1 - t)[:, None] + knots[knot + 1] * t[:, None]
    return np.asarray(rows[:, knot] * (1 - t) + rows[:, knot + 1] * t, np.float32)


def random_weights(size: int, seed: int) -> Cells:
    """Weights 1..255, each cell's its own."""
    return np.random.default_rng(seed).integers(1, 256, (size, size), np.uint8)


def weighted_maze(size: int, seed: int) -> Cells:
    """A maze with corridors of 4 cells, each cell with a weight 1..255 of its own."""
    return np.where(maze(4)(size, seed), random_weights(size, seed), np.uint8(0))


def fractal_terrain(size: int, seed: int) -> Terrain:
    """Rough hills: a spectrum that falls as f^-2.2, slopes of 12 % in the mean, cells of 1 m."""
    whole = 1 << (size - 1).bit_length()
    rng = np.random.default_rng(seed)
    across = np.fft.rfftfreq(whole, 1 / whole).astype(np.float32)
    down = np.fft.fftfreq(whole, 1 / whole).astype(np.float32)
    frequency = np.hypot(down[:, None], across)
    frequency[0, 0] = 1.0
    noise = rng.standard_normal(frequency.shape, np.float32) + 1j * rng.standard_normal(
        frequency.shape, np.float32
    )
    noise *= frequency**-2.2
    noise[0, 0] = 0.0
    heights = np.fft.irfft2(noise, (whole, whole))[:size, :size].astype(np.float32)
    slope = float(np.abs(np.diff(heights, axis=0)).mean())
    return _terrain(heights * np.float32(0.12 / slope), 1.0)


def real_terrain(size: int, seed: int) -> Terrain:
    """Jacksboro fault, Tennessee: the elevation model that matplotlib ships, at its own resolution.

    344 × 403 heights of 3 arc seconds, taken as cells of 90 m, mirrored side by side until they
    fill the map; the seed says where in this pattern the map begins.
    """
    from matplotlib import cbook

    found: Any = cbook.get_sample_data("jacksboro_fault_dem.npz")
    with found as model:
        tile = model["elevation"].astype(np.float32)
    begin = np.random.default_rng(seed).integers(0, tile.shape)
    rows, cols = (
        _mirrored(int(first), size, count) for first, count in zip(begin, tile.shape, strict=True)
    )
    return _terrain(tile[np.ix_(rows, cols)], 90.0)


def _mirrored(first: int, size: int, count: int) -> npt.NDArray[np.intp]:
    """Indices 0 … count - 1, count - 1 … 0, 0 … from `first` on."""
    at = (first + np.arange(size)) % (2 * count)
    return np.minimum(at, 2 * count - 1 - at)


def _terrain(elevation: npt.NDArray[np.float32], cell_size_m: float) -> Terrain:
    elevation = np.ascontiguousarray(elevation)
    return Terrain(elevation, terrain.roughness(elevation, cell_size_m), cell_size_m)


def as_costs(weights: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    """Weights as `cairn.plan_grid` takes costs: float32, inf blocked."""
    return np.where(weights > 0, weights, np.float32(np.inf)).astype(np.float32, copy=False)


CLASSES = {
    each.name: each
    for each in [
        MapClass("open", "no obstacle", open_ground, 1.0),
        MapClass("random-10", "10 % of cells blocked at random", random_obstacles(0.10), None),
        MapClass("random-20", "20 % of cells blocked at random", random_obstacles(0.20), 2.0),
        MapClass("random-40", "40 % of cells blocked at random", random_obstacles(0.40), None),
        MapClass("caves", "caves of a cellular automaton", caves, 2.0),
        MapClass("maze-1", "perfect maze, corridors of 1 cell", maze(1), 5.0),
        MapClass("maze-4", "perfect maze, corridors of 4 cells", maze(4), 4.0),
        MapClass("maze-16", "perfect maze, corridors of 16 cells", maze(16), 2.5),
        MapClass("smooth-weights", "slowly changing weights 1..255", smooth_weights, 2.0),
        MapClass("random-weights", "random weights 1..255", random_weights, 5.0),
        MapClass("weighted-maze", "maze-4 with random weights 1..255", weighted_maze, 6.0),
        MapClass("fractal-terrain", "rough hills, energy of a P3-AT", fractal_terrain, 5.0),
        MapClass("real-terrain", "Jacksboro fault, energy of a P3-AT", real_terrain, 5.0),
    ]
}

AIM_MS_512 = {"maze-1": 1.4, "random-40": 1.4}
"""Aims for the whole field at 512² [ms]: less than a jump-point search takes for one path."""
