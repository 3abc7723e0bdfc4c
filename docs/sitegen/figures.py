"""The figures of the concept pages, drawn by the code that the pages are about."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cairn
from cairn.experiments.reproduce import ALL

# Reproductions of the paper's figures that the pages show; made with seed 1.
REPRODUCED = ("fig3", "fig4", "fig7", "fig9", "fig10", "fig11", "fig12")
SEED = 1


def draw(folder: Path) -> Iterator[Path]:
    """Draw into `folder` what is not there yet, and give every picture's path."""
    yield _plan(folder / "plan.png")
    for name in REPRODUCED:
        picture = folder / name / f"{name}.png"
        if not picture.exists():
            reproduction = ALL[name]()
            record = reproduction.measure(SEED, lambda _: None)
            picture.parent.mkdir(parents=True, exist_ok=True)
            reproduction.draw(record, picture.parent)
        yield picture


def _plan(path: Path) -> Path:
    """The field of the office to the canteen, and the way from the farthest named place."""
    if not path.exists():
        from cairn.view.picture import draw_plan

        world = cairn.maps.load("office")
        room = cairn.costmap(world, cairn.Profile.load("p3at"))
        places = {name: (float(at[0]), float(at[1])) for name, at in world.goals.items()}
        goal = places["canteen"]
        field = cairn.plan(room, goal=goal)
        costs = {at: field.cost_to_go[world.cell_of(at)] for at in places.values()}
        start = max(places.values(), key=lambda at: (costs[at] < float("inf"), costs[at]))
        path.parent.mkdir(parents=True, exist_ok=True)
        draw_plan(world, field.cost_to_go, goal, path, start=start, way=field.path(start))
    return path
