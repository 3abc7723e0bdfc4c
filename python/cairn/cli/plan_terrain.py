"""`cairn plan --terrain`: the field of an elevation model to a goal."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Any, cast

import numpy as np
import typer

import cairn
from cairn.cli.progress import busy
from cairn.cli.root import console, print_json
from cairn.maps.arrays import load_elevation
from cairn.missions.result import EXIT_NOT_REACHED, tidy
from cairn.terrain import ModelName, model_of


def plan_terrain(
    map_: str,
    name: str,
    cell_size: float | None,
    goal: str,
    start: str | None,
    out: Path | None,
    picture: Path | None,
    as_json: bool,
) -> None:
    """Plan over the heights in a `.npy` file; cell (0, 0) begins at (0, 0) m."""
    if cell_size is None:
        raise typer.BadParameter("--terrain needs the side of a cell", param_hint="--cell-size")
    model = model_of(cast(ModelName, name))
    elevation = load_elevation(map_)
    goal_cell = _cell(goal, cell_size, elevation.shape, "--goal")
    began = time.perf_counter()
    with busy(f"planning over {Path(map_).name}"):
        field = cairn.plan_terrain(elevation, cell_size, goal_cell, model)
        cost_to_go = field.cost_to_go
    took = time.perf_counter() - began
    start_cell = None if start is None else _cell(start, cell_size, elevation.shape, "--start")
    path = None if start_cell is None else field.path(start_cell)
    cost = None if start_cell is None or path is None else float(cost_to_go[start_cell])
    if out is not None:
        np.save(out, cost_to_go)
    if picture is not None:
        from cairn.view.relief import Way, draw_relief

        ways = [] if path is None or cost is None else [Way(path, _amount(cost, model.unit))]
        draw_relief(
            elevation.astype(float), cell_size, picture, ways=ways, cost_to_go=cost_to_go,
            cost_name=f"cost to go [{model.unit}]", title=f"{Path(map_).stem}, {name}",
        )  # fmt: skip
    reachable = int(np.isfinite(cost_to_go).sum())
    summary = {
        "map": Path(map_).stem,
        "terrain": name,
        "goal_cell": goal_cell,
        "start_cell": start_cell,
        "reached": None if start is None else path is not None,
        "cost": cost,
        "unit": model.unit,
        "cells": int(cost_to_go.size),
        "reachable_cells": reachable,
    }
    if as_json:
        way: Any = None if path is None else (path[:, ::-1] + 0.5) * cell_size
        record = {"summary": tidy(summary), "path_m": tidy(way), "wall": {"plan_s": took}}
        print_json(record)
    else:
        console.print(
            f"{reachable} of {cost_to_go.size} cells reach the goal; planned in {1e3 * took:.0f} ms"
        )
        if path is not None and cost is not None:
            console.print(f"{_amount(cost, model.unit)} through {len(path)} cells")
        elif start is not None:
            console.print(f"no way from ({start}) m to the goal")
    if start is not None and path is None:
        raise typer.Exit(EXIT_NOT_REACHED)


def _amount(cost: float, unit: str) -> str:
    return f"{cost / 1000:.4g} kJ" if unit == "J" else f"{cost:.4g} s"


def _cell(text: str, cell_size: float, shape: tuple[int, ...], option: str) -> tuple[int, int]:
    """(row, col) of a point X,Y in metres; the planner refuses what is off the grid."""
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        raise typer.BadParameter(f"`{text}` is not X,Y in metres", param_hint=option)
    if not (math.isfinite(cell_size) and cell_size > 0.0):
        return (0, 0)  # the planner says what is wrong with it
    rows, cols = shape
    row, col = math.floor(y / cell_size), math.floor(x / cell_size)
    if not (0 <= row < rows and 0 <= col < cols):
        width, height = cols * cell_size, rows * cell_size
        raise typer.BadParameter(
            f"({x:g}, {y:g}) m is off the map of {width:g} x {height:g} m", param_hint=option
        )
    return (row, col)
