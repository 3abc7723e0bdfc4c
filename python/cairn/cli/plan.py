"""`cairn plan`: the field of a map to a goal, as a file, a path or a picture."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

import cairn
from cairn import maps
from cairn.cli.completion import names_of
from cairn.cli.progress import busy
from cairn.cli.root import app, console, print_json
from cairn.missions.result import EXIT_NOT_REACHED, tidy


@app.command()
def plan(
    map_: Annotated[
        str,
        typer.Argument(
            metavar="MAP",
            help=f"A map file, or the name of a shipped one: {', '.join(maps.shipped())}.",
            autocompletion=names_of("maps"),
        ),
    ],
    goal: Annotated[str, typer.Option(help="X,Y in metres, or the name of a place of the map.")],
    start: Annotated[str | None, typer.Option(help="The same; with it the path is found.")] = None,
    out: Annotated[
        Path | None, typer.Option(help="Write the cost-to-go of every cell here, as .npy.")
    ] = None,
    robot: Annotated[
        str | None,
        typer.Option(
            help="Profile of the robot to keep clear of things, p3at say; by default a point.",
            autocompletion=names_of("profiles"),
        ),
    ] = None,
    any_angle: Annotated[
        bool, typer.Option("--any-angle", help="Go straight wherever that costs no more.")
    ] = False,
    terrain: Annotated[
        str | None,
        typer.Option(
            help="MAP is a .npy of heights in metres; prices: p3at_energy, p3at_time, tobler."
        ),
    ] = None,
    cell_size: Annotated[
        float | None, typer.Option(help="Side of a cell of a terrain in metres.")
    ] = None,
    picture: Annotated[
        Path | None, typer.Option(help="Draw contours of the field and the path here, as .png.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, nothing else.")] = False,
) -> None:
    """Plan to a goal: one field for all starts. Code 3 if there is no way from the start."""
    if out is not None and out.suffix != ".npy":
        raise typer.BadParameter(f"{out}: only .npy is written", param_hint="--out")
    if picture is not None and picture.suffix != ".png":
        raise typer.BadParameter(f"{picture}: only .png is drawn", param_hint="--picture")
    if terrain is not None:
        from cairn.cli.plan_terrain import plan_terrain

        if robot is not None or any_angle:
            raise typer.BadParameter(
                "neither goes with --terrain", param_hint="--robot, --any-angle"
            )
        return plan_terrain(map_, terrain, cell_size, goal, start, out, picture, as_json)
    if cell_size is not None:
        raise typer.BadParameter("only for --terrain", param_hint="--cell-size")
    with busy(f"reading {map_}"):
        world = maps.load(map_)
    goal_m = _point(goal, world, "--goal")
    start_m = None if start is None else _point(start, world, "--start")
    began = time.perf_counter()
    with busy(f"planning on {world.name}"):
        priced = world if robot is None else cairn.costmap(world, cairn.Profile.load(robot))
        field = cairn.plan(priced, goal=goal_m)
        cost_to_go = field.cost_to_go
    took = time.perf_counter() - began
    path = None if start_m is None else field.path(start_m, any_angle=any_angle)
    if out is not None:
        np.save(out, cost_to_go)
    if picture is not None:
        from cairn.view.picture import draw_plan

        with busy("drawing"):
            draw_plan(world, cost_to_go, goal_m, picture, start=start_m, way=path)
    length_m = None if path is None else float(np.hypot(*np.diff(path, axis=0).T).sum())
    reachable = int(np.isfinite(cost_to_go).sum())
    summary = {
        "map": world.name,
        "goal_m": goal_m,
        "start_m": start_m,
        "reached": None if start_m is None else path is not None,
        "path_length_m": length_m,
        "cells": int(cost_to_go.size),
        "reachable_cells": reachable,
    }
    if as_json:
        record = {"summary": tidy(summary), "path_m": tidy(path), "wall": {"plan_s": took}}
        print_json(record)
    else:
        console.print(
            f"{reachable} of {cost_to_go.size} cells reach the goal; planned in {1e3 * took:.0f} ms"
        )
        if path is not None:
            console.print(f"path of {length_m:.2f} m through {len(path)} points")
        elif start_m is not None:
            console.print(f"no way from ({start_m[0]:.2f}, {start_m[1]:.2f}) m to the goal")
    if start_m is not None and path is None:
        raise typer.Exit(EXIT_NOT_REACHED)


def _point(text: str, world: cairn.World, option: str) -> tuple[float, float]:
    if text in world.goals:
        place = world.goals[text]
        return (float(place[0]), float(place[1]))
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        places = ", ".join(sorted(world.goals)) or "none"
        raise typer.BadParameter(
            f"`{text}` is neither X,Y in metres nor a place of the map ({places})",
            param_hint=option,
        )
    return (x, y)
