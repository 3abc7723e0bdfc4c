"""Pictures of the fuzzy modules: sets of every input, numbers of every output, and Table 1."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.patches import Rectangle

from cairn.view.style import INK, PALE, PAPER, RED, SERIES, TEAL, calm, grid_of, label, page, save

SYMBOLS = {
    "alpha1": "α₁: turn at the next waypoint [rad]",
    "alpha2": "α₂: turn at the one after it [rad]",
    "C": "C: look-ahead curvature",
    "dR": "dR: distance to the next waypoint [m]",
    "dtheta": "dθ: its bearing, left positive [rad]",
    "Vc": "Vc: current speed [m/s]",
    "V": "V: speed [m/s]",
    "omega": "ω: turn rate [rad/s]",
}
CELLS = {
    "NoCurvature": "#e3f0ee",
    "cModerate": "#f6ead2",
    "cHigh": "#efc9a0",
    "cVeryHigh": "#e39a93",
}


def draw_sets(record: dict[str, Any], title: str, subtitle: str, path: Path) -> Path:
    """Draw `experiments.paper.rules.sets_of` of one module, after Figs. 7 and 8."""
    inputs, outputs = record["inputs"], record["outputs"]
    count = len(inputs) + len(outputs)
    columns = 3 if count <= 3 else 2
    rows = -(-count // columns)
    figure, room = page((12.5, 1.3 + 2.9 * rows), title, subtitle)
    room = (*room[:3], room[3] - 0.75 / figure.get_figheight())  # for names above the uppermost row
    places = [
        axes for row in grid_of(figure, room, rows, columns, hspace=0.75, wspace=0.16)
        for axes in row
    ]  # fmt: skip
    for axes, (name, told) in zip(places, inputs.items(), strict=False):
        _draw_input(axes, name, told)
    for axes, (name, numbers) in zip(places[len(inputs) :], outputs.items(), strict=False):
        _draw_output(axes, name, numbers)
    for axes in places[count:]:
        axes.set_axis_off()
    return save(figure, path)


def _draw_input(axes: Any, name: str, told: dict[str, Any]) -> None:
    values = np.asarray(told["values"])
    tilt = 0 if len(told["sets"]) < 5 else 58
    peaks = []
    for number, (one, grades) in enumerate(told["sets"].items()):
        colour = SERIES[number % len(SERIES)]
        axes.plot(values, grades, color=colour, lw=1.7)
        axes.fill_between(values, grades, color=colour, alpha=0.08)
        top = values[np.asarray(grades) >= np.max(grades) - 1e-9]
        peaks.append((one, colour, float(top[0]), float(top[-1])))
    low, high = _part_worth_showing(values, peaks)
    for one, colour, first, last in peaks:
        at = (max(first, low) + min(last, high)) / 2
        axes.text(at, 1.07, one, color=colour, fontsize=8.2, rotation=tilt, va="bottom",
                  ha="left" if tilt else "center", rotation_mode="anchor")  # fmt: skip
    axes.set_xlim(low, high)
    axes.set_ylim(0, 1.05)
    label(axes, SYMBOLS.get(name, name), "membership")


def _part_worth_showing(values: np.ndarray, peaks: list[Any]) -> tuple[float, float]:
    """Leave out what of the outermost plateaus is longer than the rest."""
    inner = [peak for one in peaks for peak in one[2:]][1:-1]
    if not inner:
        return float(values[0]), float(values[-1])
    margin = 0.25 * (inner[-1] - inner[0])
    return (
        float(max(values[0], inner[0] - margin)),
        float(min(values[-1], inner[-1] + margin)),
    )


def _draw_output(axes: Any, name: str, numbers: dict[str, float]) -> None:
    values = list(numbers.values())
    axes.vlines(values, 0, 1, color=TEAL, lw=1.6 if len(values) < 10 else 1.0)
    axes.plot(values, np.ones(len(values)), "o", color=TEAL, ms=4 if len(values) < 10 else 2.5)
    if len(values) < 10:
        for one, value in numbers.items():
            axes.text(value, 1.06, f"{one}\n{value:g}", fontsize=7.8, ha="center", va="bottom",
                      color=INK)  # fmt: skip
        axes.margins(x=0.12)
    else:
        axes.text(0.0, 1.06, f"{len(values)} singletons, from {min(values):g} to {max(values):g}",
                  transform=axes.transAxes, fontsize=8.5, color=PALE, va="bottom")  # fmt: skip
    axes.set_ylim(0, 1.05)
    axes.set_yticks([0, 1])
    label(axes, SYMBOLS.get(name, name), "")


def draw_table_1(record: dict[str, Any], path: Path) -> Path:
    """Draw `experiments.paper.rules.table_1`: the rules as printed and as fired, and C(α₁, α₂)."""
    told = record["summary"]
    figure, room = page(
        (12.5, 5.2), "Table 1: inference rules for the look-ahead curvature",
        f"left: what the controller answers where one rule alone holds; {told['equal']} of "
        f"{told['rules']} rules as printed; right: C between them",
    )  # fmt: skip
    left, bottom, width, height = room
    axes = figure.add_axes((left, bottom + 0.08 * height, 0.52 * width, 0.86 * height))
    axes.set_axis_off()
    rows = list(dict.fromkeys(cell["alpha2"] for cell in record["cells"]))
    columns = list(dict.fromkeys(cell["alpha1"] for cell in record["cells"]))
    for cell in record["cells"]:
        x, y = columns.index(cell["alpha1"]), len(rows) - 1 - rows.index(cell["alpha2"])
        same = cell["fired"] == cell["printed"]
        axes.add_patch(Rectangle((x, y), 0.97, 0.94, facecolor=CELLS.get(cell["fired"], PAPER),
                                 edgecolor="none" if same else RED, lw=2.5))  # fmt: skip
        axes.text(x + 0.485, y + 0.6, cell["fired"], ha="center", va="center", fontsize=11.5,
                  color=INK, weight="bold")  # fmt: skip
        under = "as printed" if same else f"printed: {cell['printed']}"
        axes.text(x + 0.485, y + 0.28, f"C = {cell['C']:g}, {under}", ha="center", va="center",
                  fontsize=9, color=INK)  # fmt: skip
    for x, name in enumerate(columns):
        axes.text(x + 0.485, len(rows) + 0.08, name, ha="center", fontsize=10.5, color=INK)
    for y, name in enumerate(reversed(rows)):
        axes.text(-0.06, y + 0.47, name, ha="right", va="center", fontsize=10.5, color=INK)
    axes.text(-0.06, len(rows) + 0.08, "α₂ \\ α₁", ha="right", fontsize=10.5, color=PALE)
    axes.set_xlim(-0.72, len(columns))
    axes.set_ylim(-0.05, len(rows) + 0.3)
    beside = calm(figure.add_axes((left + 0.6 * width, bottom + 0.1 * height, 0.34 * width,
                                   0.84 * height)))  # fmt: skip
    angles, surface = np.asarray(record["angles_rad"]), np.asarray(record["surface"])
    drawn = beside.contourf(
        angles, angles, np.clip(surface, 0, 5 - 1e-9), levels=np.linspace(0, 5, 21), cmap="YlOrRd"
    )
    figure.colorbar(drawn, ax=beside, ticks=range(6)).set_label("C", color=INK)
    label(beside, SYMBOLS["alpha1"], SYMBOLS["alpha2"])
    return save(figure, path)
