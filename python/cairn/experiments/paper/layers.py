"""The layered planner as it runs: equation (4), Figs. 3 and 4 [Maalouf06 §3.2]."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from cairn.experiments.paper.cases import CASES, parsed
from cairn.experiments.parallel import Profile, layered_graph
from cairn.graphs import LayeredResult, grid_graph, plan_layered

LAYERS = range(1, 9)
LEVELS_BEYOND = range(13)
# Five layers on a small map, so that every vector link of Fig. 3 can be told apart.
MAP = """
. . . . . . .
. # . . . # .
. . G . . . .
. . # . . . .
. . . # . . .
"""
LEVELS = 6


def printed(layers: int, levels: int) -> int:
    """Equation (4) as printed: V for K layers and N levels, N >= K."""
    k, n = layers, levels
    return 3 * n * k - 2 * n - 3 * k * k + k + 3 * k * (k - 1) // 2 + 3


def equation_4(seed: int, advance: Callable[[str], None]) -> dict[str, Any]:
    """Count the operations of graphs with K layers run to N levels; run the maps of Fig. 12 too."""
    rows = []
    for layers in LAYERS:
        advance(f"K = {layers}")
        graph = layered_graph(Profile("counted", layers, 3), seed)
        for levels in (layers + beyond for beyond in LEVELS_BEYOND):
            result = plan_layered(
                *graph, 0, engine="levelled", max_levels=levels, early_stop=False,
                record_sequence=True,
            )  # fmt: skip
            assert result.sequence is not None
            rows.append(
                {
                    "layers": layers,
                    "levels": levels,
                    "counted": len(result.sequence),
                    "printed": printed(layers, levels),
                }
            )
    advance("maps of Fig. 12")
    maps = [_stopped(case.name, case.text) for case in CASES]
    return {
        "summary": {
            "graphs": len(rows),
            "printed_minus_counted": sorted({row["printed"] - row["counted"] for row in rows}),
            "least_saved_by_stopping": min(
                1 - one["operations"] / one["operations_bound"] for one in maps
            ),
        },
        "counts": rows,
        "maps": maps,
    }


def _stopped(name: str, text: str) -> dict[str, Any]:
    """What a map takes until nothing changes [Maalouf06 §3.4], against the worst case."""
    free, _, goal = parsed(text)
    node = goal[0] * free.shape[1] + goal[1]
    result = plan_layered(*grid_graph(free, steps="100/141"), node, engine="levelled")
    return {
        "name": name,
        "layers": result.layers,
        "widest_layer": result.widest_layer,
        "levels": result.levels,
        "levels_bound": result.max_levels,
        "operations": result.operations,
        "operations_bound": result.operations_worst_case,
    }


def graph_of_layers() -> dict[str, Any]:
    """Run the levelled engine on a small map; say what Figs. 3 and 4 draw.

    Returns:
        `layer` of every cell (rows, cols), -1 where there is no way; `operations` [(level, i, j)]
        in the order they ran, j = 0 the goal; `links` [(i, j, count)], how many links of the map
        each vector link stands for.
    """
    free, goal = _small_map()
    rows, cols = free.shape
    indptr, indices, costs = grid_graph(free, steps="100/141")
    result = plan_layered(
        indptr, indices, costs, goal[0] * cols + goal[1], engine="levelled", max_levels=LEVELS,
        early_stop=False, record_sequence=True,
    )  # fmt: skip
    assert result.sequence is not None
    return {
        "summary": {
            "layers": result.layers,
            "levels": result.levels,
            "operations": result.operations,
            "operations_equation_4": printed(result.layers, result.levels),
            "nodes": int((result.layer > 0).sum()),
        },
        "layer": result.layer.reshape(rows, cols).tolist(),
        "goal": list(goal),
        "operations": [list(operation) for operation in result.sequence],
        "links": _links(indptr, indices, result),
    }


def _small_map() -> tuple[np.ndarray, tuple[int, int]]:
    lines = [line.split() for line in MAP.strip().splitlines()][::-1]  # row 0 has the lowest y
    cells = np.array(lines)
    row, col = (int(i) for i in np.argwhere(cells == "G")[0])
    return cells != "#", (row, col)


def _links(indptr: np.ndarray, indices: np.ndarray, result: LayeredResult) -> list[list[int]]:
    """Count the links from every layer to every other; links out of the goal are unused."""
    starts = np.repeat(result.layer, np.diff(indptr))
    ends = result.layer[indices]
    used = (starts > 0) & (ends >= 0)
    pairs, counts = np.unique(np.stack([starts[used], ends[used]]), axis=1, return_counts=True)
    return [[int(i), int(j), int(n)] for (i, j), n in zip(pairs.T, counts, strict=True)]
