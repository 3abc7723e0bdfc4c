"""Three maps of the kinds of Fig. 12, planned by dynamic programming and by A* [Maalouf06 §7].

The figure's own maps are not to be had in numbers: these are ours, of the same three kinds.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import cairn
from cairn.graphs import grid_graph, plan_layered

Cell = tuple[int, int]
STRAIGHT, DIAGONAL = 100, 141  # the paper's 1 and 1.41, in hundredths


@dataclass(frozen=True)
class Case:
    """A map drawn in text, the topmost row first: `#` blocked, `S` start, `G` goal."""

    name: str
    text: str


OPEN = """
........................
.S......................
........................
.....###........##......
.....###........##......
.....###................
..............#####.....
...##.........#####.....
...##...................
...##......####.........
...........####.........
...........####.....##..
....................##..
..####..............##..
..####.......##.........
.............##.........
.......##...............
.......##............G..
........................
........................
"""
HARDER = """
........................
.S..........#...........
............#...........
.....########...........
.....#......#....#######
.....#......#..........#
.....#..#####..........#
.....#..#..............#
........#......####....#
######..#......#.......#
.....#..########.......#
.....#.................#
.....#########..########
.............#..........
..........#..#..........
..........#..######..###
..........#..........#..
....#######..........#..
....#.......##########G.
....#...................
"""
LABYRINTH = """
#########################
#S....#.....#.....#.....#
#.###.#.###.#.###.#.###.#
#...#...#.#...#...#...#.#
###.#####.#####.#####.#.#
#...#.......#.....#...#.#
#.###.#####.#.###.#.###.#
#.#...#.....#...#.#.#...#
#.#.###.#######.#.#.#.###
#.#.#...#.......#...#...#
#.#.#.###.#############.#
#...#...#.#.....#.......#
#######.#.#.###.#.#####.#
#.......#...#...#.#...#.#
#.###########.###.#.#.#.#
#.#.........#.#...#.#...#
#.#.#######.#.#.###.#####
#...#.....#...#...#....G#
#########################
"""
CASES = (
    Case("open obstacles", OPEN),
    Case("harder obstacles", HARDER),
    Case("labyrinth", LABYRINTH),
)


def parsed(text: str) -> tuple[npt.NDArray[np.bool_], Cell, Cell]:
    """Return (free, start, goal) of a map in text; row 0 is its lowest line."""
    cells = np.array([list(line) for line in text.split()])[::-1]
    (start,), (goal,) = (np.argwhere(cells == mark) for mark in "SG")
    return cells != "#", (int(start[0]), int(start[1])), (int(goal[0]), int(goal[1]))


def measure(advance: Callable[[str], None]) -> dict[str, Any]:
    """Plan every case by every engine and by A*.

    Returns:
        For every case `free`, `start`, `goal`, `path` (cells), `layer` of every
        cell (-1: no way), and `costs` in hundredths by planner.
    """
    cases = []
    for case in CASES:
        advance(case.name)
        cases.append({"name": case.name, **_case(case)})
    return {
        "summary": {
            one["name"]: {
                "cost": one["costs"]["A*"] / 100,
                "all_equal": len(set(one["costs"].values())) == 1,
                "layers": one["layers"],
                "levels": one["levels"],
                "visited_by_a_star": one["visited_by_a_star"],
                "cells": one["cells"],
            }
            for one in cases
        },
        "cases": cases,
    }


def _case(case: Case) -> dict[str, Any]:
    free, start, goal = parsed(case.text)
    cols = free.shape[1]
    graph = grid_graph(free, steps="100/141")
    at, to = start[0] * cols + start[1], goal[0] * cols + goal[1]
    costs: dict[str, int] = {}
    levelled = plan_layered(*graph, to, engine="levelled")
    costs["layered, levelled"] = int(levelled.native[at])
    costs["layered, in place"] = int(plan_layered(*graph, to, engine="in_place").native[at])
    costs["layered, phased"] = int(plan_layered(*graph, to, engine="phased").native[at])
    field = cairn.plan_grid(free, goal, steps="100/141")
    costs["Cairn's solver"] = int(field.native[start])
    cost, visited = a_star(free, start, goal)
    costs["A*"] = cost
    nodes = levelled.path(at)
    assert nodes is not None
    path = [[int(node) // cols, int(node) % cols] for node in nodes]
    return {
        "free": free.tolist(),
        "start": list(start),
        "goal": list(goal),
        "layer": levelled.layer.reshape(free.shape).tolist(),
        "path": path,
        "path_cost": _cost(path),
        "costs": costs,
        "layers": levelled.layers,
        "levels": levelled.levels,
        "visited_by_a_star": visited,
        "cells": int(free.sum()),
    }


def _cost(path: list[list[int]]) -> int:
    """Add up the steps of a path, in hundredths."""
    steps = np.abs(np.diff(np.array(path), axis=0)).sum(axis=1)
    return int(np.where(steps == 1, STRAIGHT, DIAGONAL).sum())


def a_star(free: npt.NDArray[np.bool_], start: Cell, goal: Cell) -> tuple[int, int]:
    """Return (cost in hundredths, cells visited) of the best way by A* [Hart68]; -1: no way.

    Written apart from the library's planners, to hold against them. The octile distance never
    overestimates; a diagonal needs both cells beside it free.
    """

    def least(cell: Cell) -> int:
        far, near = sorted((abs(cell[0] - goal[0]), abs(cell[1] - goal[1])), reverse=True)
        return DIAGONAL * near + STRAIGHT * (far - near)

    best = {start: 0}
    done: set[Cell] = set()
    waiting = [(least(start), start)]
    while waiting:
        _, cell = heapq.heappop(waiting)
        if cell in done:
            continue
        done.add(cell)
        if cell == goal:
            return best[cell], len(done)
        for row, col in ((0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)):
            other = (cell[0] + row, cell[1] + col)
            beside = (cell[0] + row, cell[1]), (cell[0], cell[1] + col), other
            if not all(_is_free(free, one) for one in beside):
                continue
            cost = best[cell] + (DIAGONAL if row and col else STRAIGHT)
            if cost < best.get(other, math.inf):
                best[other] = cost
                heapq.heappush(waiting, (cost + least(other), other))
    return -1, len(done)


def _is_free(free: npt.NDArray[np.bool_], cell: Cell) -> bool:
    rows, cols = free.shape
    return 0 <= cell[0] < rows and 0 <= cell[1] < cols and bool(free[cell])
