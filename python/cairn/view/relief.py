"""Pictures of plans over terrain: a shaded relief, a field on it, ways with their profiles."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LightSource
from matplotlib.figure import Figure
from numpy.typing import NDArray

from cairn.view.style import INK, PALE, PAPER

WAY_COLOURS = ["#d1495b", "#1c6dd0", "#0b7a75", "#c8862b"]
DPI = 110  # relief compresses badly
WIDTH_IN, MARGIN_IN, PROFILE_IN, BAR_IN = 9.0, 0.7, 1.5, 1.0


@dataclass(frozen=True)
class Way:
    """One way over the terrain: its cells (n, 2), and what to call it."""

    cells: NDArray[np.int64]
    name: str


def draw_relief(
    elevation: NDArray[np.floating],
    cell_size: float,
    path: Path,
    *,
    ways: list[Way],
    cost_to_go: NDArray[np.float64] | None = None,
    cost_name: str = "cost to go",
    title: str = "",
) -> Path:
    """Draw ways on a shaded relief, row 0 at the bottom, and how high they run below it.

    Args:
        elevation: (rows, cols) [m], NaN where there is no data.
        cell_size: side of the square cells [m].
        path: the picture to write.
        ways: over its cells; none is fine.
        cost_to_go: of the field whose contours are drawn, (rows, cols), inf where there is no way.
        cost_name: what it is, with its unit.
        title: one line above.

    Returns:
        `path`.
    """
    rows, cols = elevation.shape
    unit, shown = ("km", 1000.0) if max(rows, cols) * cell_size >= 3000.0 else ("m", 1.0)
    side = cell_size / shown
    map_in = WIDTH_IN - MARGIN_IN - BAR_IN
    tall_in = min(max(map_in * rows / cols, 1.5), 9.0)
    below_in = MARGIN_IN + (PROFILE_IN + MARGIN_IN if ways else 0.0)
    height_in = below_in + tall_in + 0.5
    figure = Figure(figsize=(WIDTH_IN, height_in), facecolor=PAPER)
    FigureCanvasAgg(figure)

    def box(left: float, low: float, wide: float, tall: float) -> Axes:
        return figure.add_axes(
            (left / WIDTH_IN, low / height_in, wide / WIDTH_IN, tall / height_in)
        )

    axes = box(MARGIN_IN, below_in, map_in, tall_in)
    extent = (0.0, cols * side, 0.0, rows * side)
    _draw_heights(axes, elevation, cell_size, extent)
    if cost_to_go is not None:
        _draw_contours(figure, axes, cost_to_go, side, cost_name)
    for way, colour in zip(ways, _colours(ways), strict=True):
        row, col = way.cells.T
        x, y = (col + 0.5) * side, (row + 0.5) * side
        axes.plot(x, y, color=PAPER, lw=3.6, zorder=4, solid_capstyle="round")
        axes.plot(x, y, color=colour, lw=2.0, zorder=5, solid_capstyle="round", label=way.name)
        axes.plot(x[0], y[0], "o", ms=7, mfc=PAPER, mec=colour, mew=2.0, zorder=6)
        axes.plot(x[-1], y[-1], "*", ms=15, mfc=colour, mec=PAPER, mew=1.0, zorder=7)
    if ways:
        axes.legend(loc="upper right", fontsize=9, framealpha=0.9, edgecolor="none")
        _draw_profiles(box(MARGIN_IN, MARGIN_IN, map_in, PROFILE_IN), elevation, side, ways, unit)
    axes.set_xlabel(f"x [{unit}]", color=INK)
    axes.set_ylabel(f"y [{unit}]", color=INK)
    axes.set_title(title, loc="left", color=INK, fontsize=12, parse_math=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=DPI, facecolor=PAPER)
    return path


def _colours(ways: list[Way]) -> list[str]:
    return [WAY_COLOURS[i % len(WAY_COLOURS)] for i in range(len(ways))]


def _draw_heights(
    axes: Axes,
    elevation: NDArray[np.floating],
    cell_size: float,
    extent: tuple[float, float, float, float],
) -> None:
    known = np.isfinite(elevation)
    filled = np.where(known, elevation, np.median(elevation[known]) if known.any() else 0.0)
    shade = np.full(elevation.shape, 0.7)
    if min(elevation.shape) > 1 and np.ptp(filled) > 0:
        # Row 0 is the lowest y: turned over, so that light comes from the upper left.
        light = LightSource(azdeg=315, altdeg=40)
        shade = light.hillshade(filled[::-1], vert_exag=1.5, dx=cell_size, dy=cell_size)[::-1]
    picture = np.stack([0.35 + 0.6 * shade] * 3, axis=-1)
    picture[~known] = (0.93, 0.87, 0.87)
    axes.imshow(np.clip(picture, 0.0, 1.0), origin="lower", extent=extent, interpolation="nearest")


def _draw_contours(
    figure: Figure, axes: Axes, cost_to_go: NDArray[np.float64], side: float, name: str
) -> None:
    finite = np.where(np.isfinite(cost_to_go), cost_to_go, np.nan)
    if not np.isfinite(finite).any() or np.nanmax(finite) <= 0.0:
        return
    rows, cols = finite.shape
    top = float(np.nanmax(finite))
    image = axes.imshow(
        finite, origin="lower", extent=(0.0, cols * side, 0.0, rows * side), cmap="YlGnBu_r",
        alpha=0.42, zorder=2, vmin=0.0, vmax=top, interpolation="nearest",
    )  # fmt: skip
    if min(rows, cols) > 1:
        x, y = (np.arange(cols) + 0.5) * side, (np.arange(rows) + 0.5) * side
        levels = np.linspace(0.0, top, 22)[1:-1]
        axes.contour(x, y, finite, levels=levels, colors=PAPER, linewidths=0.7, zorder=3)
    place = axes.get_position()
    bar = figure.colorbar(
        image, cax=figure.add_axes((place.x1 + 0.015, place.y0, 0.018, place.height))
    )
    bar.set_label(name, color=INK)
    bar.outline.set_visible(False)  # type: ignore[operator]


def _draw_profiles(
    axes: Axes, elevation: NDArray[np.floating], side: float, ways: list[Way], unit: str
) -> None:
    for way, colour in zip(ways, _colours(ways), strict=True):
        row, col = way.cells.T
        steps = np.hypot(np.diff(row), np.diff(col)) * side
        along = np.concatenate([[0.0], np.cumsum(steps)])
        axes.plot(along, elevation[row, col], color=colour, lw=1.8)
    axes.set_xlabel(f"along the way [{unit}]", color=INK)
    axes.set_ylabel("height [m]", color=INK)
    axes.grid(color=PALE, alpha=0.3, lw=0.6)
    for edge in ("top", "right"):
        axes.spines[edge].set_visible(False)
