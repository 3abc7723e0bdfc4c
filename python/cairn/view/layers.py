"""Pictures of the layered planner: operations counted, the layered solution graph, three maps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.patches import Circle, FancyArrowPatch, Rectangle

from cairn.view.style import (
    AMBER,
    BLUE,
    INK,
    OCCUPIED,
    PALE,
    PAPER,
    RED,
    SERIES,
    TEAL,
    grid_of,
    label,
    page,
    save,
)

GOAL = "#f3d27a"


def draw_counts(record: dict[str, Any], path: Path) -> Path:
    """Draw `experiments.paper.layers.equation_4`: (4) against operations that really ran."""
    figure, room = page(
        (12.0, 5.4), "Equation (4): number of DP operations V",
        "lines: as printed; dots: counted on graphs of just K layers run to N levels, none stopped "
        "early; right: what stopping saves",
    )  # fmt: skip
    ((left, right),) = grid_of(figure, room, 1, 2, wspace=0.3, width_ratios=(3, 2))
    counts = record["counts"]
    for number, layers in enumerate(sorted({row["layers"] for row in counts})):
        rows = [row for row in counts if row["layers"] == layers]
        levels = [row["levels"] for row in rows]
        colour = SERIES[number % len(SERIES)]
        left.plot(levels, [row["printed"] for row in rows], color=colour, lw=1.2)
        left.plot(levels, [row["counted"] for row in rows], "o", ms=3.5, color=colour)
        left.annotate(f"K = {layers}", (levels[-1], rows[-1]["printed"]), xytext=(5, -3),
                      textcoords="offset points", fontsize=8.5, color=colour)  # fmt: skip
    label(left, "levels N", "DP operations V")
    left.margins(x=0.1)
    names = [one["name"] for one in record["maps"]][::-1]
    done = [one["operations"] for one in record["maps"]][::-1]
    bound = [one["operations_bound"] for one in record["maps"]][::-1]
    right.barh(names, bound, color="#e4e7ea", height=0.55)
    right.barh(names, done, color=TEAL, height=0.55)
    right.set_xscale("log")
    right.grid(axis="y", visible=False)
    for row, (one, most) in enumerate(zip(done, bound, strict=True)):
        right.text(one * 0.85, row, f"{one:,}", ha="right", va="center", fontsize=9, color=PAPER)
        right.text(most * 0.85, row, f"{most:,}", ha="right", va="center", fontsize=9, color=INK)
    right.set_xlim(left=50)
    label(right, "DP operations: until nothing changed (teal), of K·M levels (grey)")
    return save(figure, path)


def draw_solution_graph(record: dict[str, Any], path: Path) -> Path:
    """Draw `experiments.paper.layers.graph_of_layers`: the layered solution graph, after Fig. 3."""
    told = record["summary"]
    figure, room = page(
        (12.0, 7.6), "Fig. 3: layered solution graph",
        f"{told['layers']} layers of the map at the left, {told['levels']} levels; every arrow is "
        f"one DP(i, j) that ran, numbered in the order they ran: {told['operations']} of them, "
        f"(4) prints {told['operations_equation_4']}",
    )  # fmt: skip
    left, bottom, width, height = room
    _draw_small_map(figure.add_axes((left, bottom + 0.12 * height, 0.34 * width, 0.7 * height)),
                    record)  # fmt: skip
    axes = figure.add_axes((left + 0.38 * width, bottom, 0.62 * width, height))
    axes.set_axis_off()
    operations = record["operations"]
    levels, layers = told["levels"], told["layers"]
    places = {(0, 0): (1.0, 0.0)}
    places |= {
        (level, i): (i, -level) for level in range(1, levels + 1) for i in range(1, layers + 1)
    }
    kinds = {-1: TEAL, 0: PALE, 1: AMBER}
    for number, (level, i, j) in enumerate(operations, start=1):
        start, end = places[(level, i)], places[(level - 1, j)]
        colour = kinds[j - i] if j else BLUE
        axes.add_patch(FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=10, lw=1.3,
                                       color=colour, shrinkA=13, shrinkB=13, zorder=1))  # fmt: skip
        share = 0.36
        x, y = (a + share * (b - a) for a, b in zip(start, end, strict=True))
        axes.text(x, y, str(number), fontsize=6.8, color=INK, ha="center", va="center", zorder=2,
                  bbox={"boxstyle": "round,pad=0.12", "fc": PAPER, "ec": "none"})  # fmt: skip
    shown = {(level, i) for level, i, _ in operations}
    for level, i in [(0, 0), *sorted(shown)]:
        _bubble(axes, places[(level, i)], "G" if i == 0 else str(i), layers, i)
    for level in range(1, levels + 1):
        axes.text(0.35, -level, f"level {level}", ha="right", va="center", fontsize=9, color=PALE)
    for offset, (text, colour) in enumerate(
        (("to the layer below", TEAL), ("within a layer", PALE), ("to the layer above", AMBER))
    ):
        axes.text(0.42 + offset * 1.45, -levels - 0.62, "→ " + text, color=colour, fontsize=9.5)
    axes.set_xlim(-0.5, layers + 0.6)
    axes.set_ylim(-levels - 0.8, 0.4)
    return save(figure, path)


def draw_vector_links(record: dict[str, Any], path: Path) -> Path:
    """Draw `experiments.paper.layers.graph_of_layers`: layers and vector links, after Fig. 4."""
    told = record["summary"]
    figure, room = page(
        (12.0, 5.2), "Fig. 4: layers and vector links",
        "every arrow stands for as many links of the map as its number says; one cost and one "
        "pointer per node are kept",
    )  # fmt: skip
    left, bottom, width, height = room
    _draw_small_map(figure.add_axes((left, bottom, 0.34 * width, 0.92 * height)), record)
    axes = figure.add_axes((left + 0.37 * width, bottom, 0.63 * width, height))
    axes.set_axis_off()
    layers = told["layers"]
    for i, j, count in record["links"]:
        if i == j:
            axes.add_patch(FancyArrowPatch(
                (i - 0.11, 0.12), (i + 0.11, 0.12), connectionstyle="arc3,rad=-2.2",
                arrowstyle="-|>", mutation_scale=11, lw=1.4, color=PALE, shrinkA=3, shrinkB=3,
            ))  # fmt: skip
            at, colour = (float(i), 0.50), INK
        else:
            bend, colour = (0.35, BLUE if j == 0 else TEAL) if j < i else (0.35, AMBER)
            axes.add_patch(FancyArrowPatch(
                (i, 0), (j, 0), connectionstyle=f"arc3,rad={bend}", arrowstyle="-|>",
                mutation_scale=12, lw=1.6, color=colour, shrinkA=22, shrinkB=22,
            ))  # fmt: skip
            at = ((i + j) / 2, 0.27 if j < i else -0.27)
        axes.text(*at, str(count), fontsize=9.5, color=colour, ha="center", va="center",
                  bbox={"boxstyle": "round,pad=0.15", "fc": PAPER, "ec": "none"})  # fmt: skip
    sizes = np.array(record["layer"])
    for i in range(layers + 1):
        _bubble(axes, (i, 0.0), "G" if i == 0 else f"L{i}", layers, i, size=0.16)
        nodes = int((sizes == i).sum())
        if i:
            axes.text(
                i,
                -0.42,
                f"{nodes} node{'s' if nodes != 1 else ''}",
                ha="center",
                fontsize=9,
                color=PALE,
            )
    for row, (text, colour) in enumerate(
        (("falling: the only links of classical dynamic programming", TEAL),
         ("within a layer", PALE), ("rising", AMBER))
    ):  # fmt: skip
        axes.text(-0.2, -0.72 - 0.15 * row, "→ " + text, color=colour, fontsize=9.5)
    axes.set_xlim(-0.35, layers + 0.35)
    axes.set_ylim(-1.1, 0.75)
    axes.set_aspect("equal")
    return save(figure, path)


def draw_cases(record: dict[str, Any], path: Path) -> Path:
    """Draw `experiments.paper.cases.measure`: three maps and their best paths, after Fig. 12."""
    figure, room = page(
        (13.0, 4.9), "Fig. 12: three test cases in a 2-D environment",
        "steps of 1 and 1.41; the path by dynamic programming; shaded: the layers of the cells, "
        "from the goal; maps of our own, of the paper's three kinds",
    )  # fmt: skip
    room = (room[0], room[1], room[2], room[3] - 0.5 / figure.get_figheight())  # for the titles
    (row,) = grid_of(figure, room, 1, 3, wspace=0.06)
    for axes, case in zip(row, record["cases"], strict=True):
        free = np.array(case["free"])
        layer = np.array(case["layer"])
        axes.imshow(np.where(free, np.nan, 1.0), origin="lower", cmap=ListedColormap(["#b9bec6"]))
        axes.imshow(np.ma.masked_less(layer, 0), origin="lower", cmap="BuGn_r", alpha=0.55)
        rows, cols = free.shape
        axes.set_xticks(np.arange(-0.5, cols), minor=True)
        axes.set_yticks(np.arange(-0.5, rows), minor=True)
        axes.set_anchor("N")
        axes.grid(visible=False)
        axes.grid(which="minor", color=PAPER, lw=0.5, alpha=1.0)
        axes.tick_params(which="both", length=0, labelbottom=False, labelleft=False)
        axes.spines[:].set_visible(False)
        way = np.array(case["path"])
        axes.plot(way[:, 1], way[:, 0], color=RED, lw=2.0, solid_capstyle="round")
        for place in (case["start"], case["goal"]):
            axes.plot(place[1], place[0], "x", color=INK, ms=9, mew=2.4)
        same = len(set(case["costs"].values())) == 1
        axes.set_title(
            f"{case['name']}: cost {case['path_cost'] / 100:.2f}\n"
            f"{case['layers']} layers, {case['levels']} levels; "
            + ("A* and all engines equal" if same else "ENGINES DIFFER"),
            fontsize=10, color=INK, loc="left",
        )  # fmt: skip
    return save(figure, path)


def _draw_small_map(axes: Any, record: dict[str, Any]) -> None:
    layer = np.array(record["layer"])
    most = record["summary"]["layers"]
    for (row, col), value in np.ndenumerate(layer):
        colour = OCCUPIED if value < 0 else _shade(int(value), most)
        axes.add_patch(Rectangle((col, row), 1, 1, facecolor=colour, edgecolor=PAPER, lw=1.5))
        if value >= 0:
            axes.text(col + 0.5, row + 0.5, "G" if value == 0 else str(value), ha="center",
                      va="center", fontsize=11, color=INK,
                      weight="bold" if value == 0 else "normal")  # fmt: skip
    axes.set_xlim(0, layer.shape[1])
    axes.set_ylim(0, layer.shape[0])
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title("cells by their layer: least number of links to G", fontsize=9.5, color=PALE)


def _bubble(
    axes: Any, at: tuple[float, float], text: str, layers: int, layer: int, size: float = 0.17
) -> None:
    axes.add_patch(Circle(at, size, facecolor=_shade(layer, layers), edgecolor=INK, lw=1.1,
                          zorder=3))  # fmt: skip
    axes.text(*at, text, ha="center", va="center", fontsize=10, color=INK, zorder=4)


def _shade(layer: int, layers: int) -> Any:
    """Colour of a layer: the goal's own, then paler with every layer."""
    if layer == 0:
        return GOAL
    share = 0.85 - 0.7 * (layer - 1) / max(layers - 1, 1)
    teal = np.array([0.043, 0.478, 0.459])
    return tuple(1 - (1 - teal) * share * 0.75)
