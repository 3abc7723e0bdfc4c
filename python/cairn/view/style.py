"""How pictures look: colours, and figures with a title that says what they show."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

INK, PALE, PAPER = "#22303c", "#8a97a3", "#ffffff"
FREE, OCCUPIED, UNKNOWN = "#fbfaf6", "#3d4a57", "#dcdedd"
TEAL, RED, AMBER, BLUE, VIOLET = "#0b7a75", "#d1495b", "#c8862b", "#3f6fb5", "#7c5cbf"
SERIES = (TEAL, AMBER, VIOLET, RED, BLUE, "#5b8c3e", "#b05a9b", "#4f9fc4", "#8b6b4a")
DPI = 160


def page(
    size_in: tuple[float, float], title: str, subtitle: str = ""
) -> tuple[Figure, tuple[float, float, float, float]]:
    """Begin a figure with a heading; return it with the room below (left, bottom, width, "
    "height)."""
    figure = Figure(figsize=size_in, facecolor=PAPER)
    FigureCanvasAgg(figure)
    width, height = size_in
    figure.text(0.3 / width, 1 - 0.36 / height, title, fontsize=14, weight="bold", color=INK)
    if subtitle:
        figure.text(0.3 / width, 1 - 0.62 / height, subtitle, fontsize=9.5, color=PALE,
                    parse_math=False)  # fmt: skip
    head = (0.8 if subtitle else 0.55) / height
    return figure, (0.3 / width, 0.25 / height, 1 - 0.6 / width, 1 - head - 0.25 / height)


def grid_of(
    figure: Figure,
    room: tuple[float, float, float, float],
    rows: int,
    columns: int,
    **spacing: Any,
) -> list[list[Any]]:
    """Lay axes out over the room below a heading."""
    left, bottom, width, height = room
    layout = figure.add_gridspec(
        rows, columns, left=left + 0.04 * width, bottom=bottom + 0.06 * height,
        right=left + width, top=bottom + height, **spacing,
    )  # fmt: skip
    return [[calm(figure.add_subplot(layout[r, c])) for c in range(columns)] for r in range(rows)]


def calm(axes: Any) -> Any:
    """Take the frame and the loud ticks off; returns the axes."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(PALE)
    axes.tick_params(colors=INK, labelsize=8.5)
    axes.grid(color=PALE, alpha=0.22, linewidth=0.6)
    return axes


def label(axes: Any, x: str = "", y: str = "") -> None:
    """Name the two directions."""
    axes.set_xlabel(x, color=INK, fontsize=9)
    axes.set_ylabel(y, color=INK, fontsize=9)


def save(figure: Figure, path: Path) -> Path:
    """Write the picture, its folder made if need be; returns `path`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=DPI, facecolor=PAPER)
    return path


POSE_BY = {"localised": "localisation", "odometry": "odometry", "truth": "truth"}
"""What a scenario's source of the pose is called."""
