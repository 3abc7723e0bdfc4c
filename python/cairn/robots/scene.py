"""What truly stands in the world of a simulation: a map's walls, and things no map shows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Protocol

import numpy as np

from cairn import errors
from cairn.profile import Footprint
from cairn.robots import rectangles as rect
from cairn.robots.rectangles import Floats
from cairn.robots.robot import Pose


class Gridded(Protocol):
    """The part of `cairn.World` that a scene is made from."""

    @property
    def occupancy(self) -> Any:
        """uint8 (rows, cols), 1 where something stands."""
        ...

    @property
    def resolution_m(self) -> float:
        """Side of a cell."""
        ...

    @property
    def origin(self) -> Any:
        """Pose (x, y, yaw) of the corner of cell (0, 0) in the world frame."""
        ...


@dataclass(frozen=True)
class Box:
    """Something standing that the map does not show.

    Attributes:
        x, y: centre, world frame [m].
        length_m, width_m: sides along its own x and y axes.
        heading: of its x axis [rad].
        name: as contacts and reports call it.
        height_m: for a physics engine and pictures.
        from_s, until_s: stands from, and until before, these times of the robot's clock.
        appears_within_m: appears for good once a robot's centre is this near to `appears_near`
            (by default its own centre). A box never appears onto a robot: it waits for the place
            to be free.

    Boxes of one name of which each begins when the one before ends are one thing that is moved:
    it stays where it is while it would come nearer than `MOVED_GAP_M` to a robot, and is late then.
    """

    x: float
    y: float
    length_m: float
    width_m: float
    heading: float = 0.0
    name: str = "box"
    height_m: float = 0.6
    from_s: float = 0.0
    until_s: float = math.inf
    appears_within_m: float | None = None
    appears_near: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Check every number."""
        for key in ("x", "y", "heading", "from_s"):
            self._check(key, math.isfinite(getattr(self, key)), "a finite number")
        for key in ("length_m", "width_m", "height_m"):
            value = getattr(self, key)
            self._check(key, math.isfinite(value) and value > 0, "a positive finite number")
        self._check("until_s", self.until_s > self.from_s, "later than from_s")
        near = self.appears_within_m
        self._check("appears_within_m", near is None or near > 0, "a positive number")

    def _check(self, key: str, good: bool, wanted: str) -> None:
        if not good:
            value = getattr(self, key)
            raise errors.BoxOutOfRange(
                f"box `{self.name}`: {key} is {value}, must be {wanted}",
                box=self.name,
                key=key,
                value=value,
            )

    @property
    def rectangle(self) -> Floats:
        """On the ground, (6,); see `cairn.robots.rectangles`."""
        return rect.rectangle(self.x, self.y, self.length_m, self.width_m, self.heading)


@dataclass(frozen=True, eq=False)
class Scene:
    """What stands where, unchanging; `stage()` begins a run in it.

    Attributes:
        walls: rectangles (n, 6) of what the map shows occupied, world frame.
        wall_corners: points (k, 2) where the outline of that bends; sonar echoes from them.
        boxes: what the map does not show.
        wall_height_m: for a physics engine.
        spares: how many boxes at a time may be put down during a run (`Stage.put`).
    """

    walls: Floats = field(default_factory=lambda: np.zeros((0, 6)))
    wall_corners: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    boxes: tuple[Box, ...] = ()
    wall_height_m: float = 1.0
    spares: int = 0

    @classmethod
    def from_world(
        cls, world: Gridded, boxes: Iterable[Box | dict[str, Any]] = (), *, spares: int = 0
    ) -> Scene:
        """The occupied cells of a map as few rectangles, and `boxes` besides.

        Unknown cells are empty. Boxes may be dicts of `Box`'s fields.

        Raises:
            BoxOutOfRange: a box has an unknown key or an impossible number.
        """
        occupied = np.asarray(world.occupancy) == 1
        cell, (x, y, yaw) = float(world.resolution_m), map(float, world.origin)
        c, s = math.cos(yaw), math.sin(yaw)

        def in_world(u: Floats, v: Floats) -> tuple[Floats, Floats]:
            return x + c * u - s * v, y + s * u + c * v

        cells = rect.covering(occupied).astype(np.float64) * cell
        r0, c0, r1, c1 = cells.T
        cx, cy = in_world((c0 + c1) / 2, (r0 + r1) / 2)
        n = len(cells)
        walls = np.column_stack(
            [cx, cy, (c1 - c0) / 2, (r1 - r0) / 2, np.full(n, c), np.full(n, s)]
        )
        points = rect.lattice_corners(occupied).astype(np.float64) * cell
        return cls(
            walls.reshape(-1, 6),
            np.column_stack(in_world(points[:, 1], points[:, 0])).reshape(-1, 2),
            tuple(_as_box(box) for box in boxes),
            spares=spares,
        )

    def stage(self) -> Stage:
        """Begin a run."""
        return Stage(self)

    def clearance_m(self, pose: Sequence[float], footprint: Footprint) -> float:
        """From an outline at (x, y, heading) to walls and all boxes, whenever they stand [m]."""
        everything = np.vstack([self.walls, *(box.rectangle[None] for box in self.boxes)])
        outline = outline_at(Pose(*pose), footprint)
        return float(rect.distances(outline, everything).min(initial=math.inf))


MOVED_GAP_M = 0.05
"""Whoever moves a thing does not push it nearer to a robot than this."""


@dataclass
class _Moved:
    """A thing that is moved: its places in order, at which it is (-1: not there yet), its delay."""

    places: list[int]
    at: int = -1
    late_s: float = 0.0
    waits: bool = False


def _chains(boxes: Sequence[Box]) -> list[list[int]]:
    """Boxes of one name of which each begins when the one before ends, two and more."""
    begins = {
        (box.name, round(box.from_s, 6)): i
        for i, box in enumerate(boxes)
        if box.appears_within_m is None
    }
    after = {
        i: begins[box.name, round(box.until_s, 6)]
        for i, box in enumerate(boxes)
        if box.appears_within_m is None and (box.name, round(box.until_s, 6)) in begins
    }
    chains = []
    for first in after.keys() - set(after.values()):
        chain = [first]
        while chain[-1] in after:
            chain.append(after[chain[-1]])
        chains.append(chain)
    return sorted(chains)


class Stage:
    """A scene during a run: which boxes stand now.

    Attributes:
        scene: what it is a run of.
        boxes: the scene's, then those put down since, oldest first.
        standing: of `boxes`, bool (n,).
        gone: of `boxes`, bool (n,): taken away for good.
    """

    def __init__(self, scene: Scene) -> None:
        """Begin at time zero with the boxes that stand from the start."""
        self.scene = scene
        self.boxes = list(scene.boxes)
        self.gone = np.zeros(len(scene.boxes), dtype=bool)
        self._boxes = np.array([b.rectangle for b in scene.boxes]).reshape(-1, 6)
        self._triggered = np.array([b.appears_within_m is None for b in scene.boxes], dtype=bool)
        self.standing = np.zeros(len(scene.boxes), dtype=bool)
        self._moved = [_Moved(chain) for chain in _chains(scene.boxes)]
        self._chained = {i for moved in self._moved for i in moved.places}
        self._assemble()
        self.update(0.0, ())

    def put(self, box: Box) -> None:
        """Put one more box down; it stands from the next `update` on that finds its place free.

        Raises:
            StageFull: the scene's `spares` are all in use.
        """
        if not self.spares_left:
            raise errors.StageFull(
                f"no room for `{box.name}`: {self.scene.spares} boxes stand that were put down "
                "during the run, and no more may; take one away first",
                box=box.name,
                spares=self.scene.spares,
            )
        self.boxes.append(box)
        self._boxes = np.vstack([self._boxes, box.rectangle[None]])
        self._triggered = np.append(self._triggered, box.appears_within_m is None)
        self.standing = np.append(self.standing, False)
        self.gone = np.append(self.gone, False)

    def take_away(self, name: str) -> bool:
        """Take every box of that name away for good; False where there is none."""
        named = np.array([box.name == name for box in self.boxes], dtype=bool) & ~self.gone
        self.gone |= named
        self.standing &= ~named
        self._assemble()
        return bool(named.any())

    @property
    def spares_left(self) -> int:
        """How many more boxes may be put down."""
        return self.scene.spares - int((~self.gone[len(self.scene.boxes) :]).sum())

    def update(self, time_s: float, robots: Sequence[tuple[Pose, Footprint]]) -> bool:
        """Let boxes come and go. True when one did."""
        before = self.standing.copy()
        for moved in self._moved:
            self._move(moved, time_s, robots)
        for i, box in enumerate(self.boxes):
            if self.gone[i] or i in self._chained:
                continue
            if not self._triggered[i]:
                x, y = box.appears_near or (box.x, box.y)
                within = box.appears_within_m or 0.0
                self._triggered[i] = any(math.hypot(p.x - x, p.y - y) <= within for p, _ in robots)
            # A tenth of a microsecond: clocks are sums of steps.
            wanted = self._triggered[i] and box.from_s <= time_s + 1e-7 < box.until_s
            if wanted and not self.standing[i]:
                self.standing[i] = self._is_free(i, 0.0, robots)
            elif not wanted:
                self.standing[i] = False
        changed = bool((before != self.standing).any())
        if changed:
            self._assemble()
        return changed

    def _move(self, moved: _Moved, time_s: float, robots: Sequence[tuple[Pose, Footprint]]) -> None:
        """Move a thing on as far as its time says and robots let it."""
        while moved.at < len(moved.places) and not self.gone[moved.places[0]]:
            now = self.scene.boxes[moved.places[moved.at]] if moved.at >= 0 else None
            due_s = self.scene.boxes[moved.places[0]].from_s if now is None else now.until_s
            if time_s + 1e-7 < due_s + moved.late_s:
                return
            after = moved.at + 1
            last = after == len(moved.places)
            if not last and not self._is_free(moved.places[after], MOVED_GAP_M, robots):
                moved.waits = True
                return
            if moved.waits:
                moved.late_s, moved.waits = time_s - due_s, False
            if now is not None:
                self.standing[moved.places[moved.at]] = False
            if not last:
                self.standing[moved.places[after]] = True
            moved.at = after

    def _is_free(self, i: int, gap_m: float, robots: Sequence[tuple[Pose, Footprint]]) -> bool:
        """Whether box `i` would stand farther than `gap_m` from every robot."""
        place = self._boxes[i : i + 1]
        return all(rect.distances(outline_at(p, f), place)[0] > gap_m for p, f in robots)

    def _assemble(self) -> None:
        boxes = self._boxes[self.standing]
        self.rectangles = np.vstack([self.scene.walls, boxes])
        self.corners = np.vstack([self.scene.wall_corners, rect.corners(boxes).reshape(-1, 2)])
        self._standing_index = np.flatnonzero(self.standing)
        self._reach = np.hypot(self.rectangles[:, 2], self.rectangles[:, 3])

    def name_of(self, index: int) -> str:
        """What row `index` of `rectangles` is called."""
        walls = len(self.scene.walls)
        if index < walls:
            return "wall"
        return self.boxes[self._standing_index[index - walls]].name

    def near(self, x: float, y: float, radius_m: float) -> np.ndarray:
        """Rows of `rectangles` that may reach into a disc."""
        centres = self.rectangles[:, :2]
        gap = np.hypot(centres[:, 0] - x, centres[:, 1] - y) - self._reach
        return np.flatnonzero(gap <= radius_m)

    def clearance_m(self, pose: Pose, footprint: Footprint) -> float:
        """Exact distance from the outline to the nearest thing standing; inf if there is none."""
        return float(
            rect.distances(outline_at(pose, footprint), self.rectangles).min(initial=math.inf)
        )

    def touching(self, pose: Pose, footprint: Footprint) -> str | None:
        """Name of something that the outline overlaps."""
        gaps = rect.distances(outline_at(pose, footprint), self.rectangles)
        hit = np.flatnonzero(gaps <= 0)
        return self.name_of(int(hit[0])) if hit.size else None

    def refuse_if_taken(self, pose: Pose, footprint: Footprint) -> None:
        """Raise `StandsInObstacle` if the outline overlaps anything."""
        name = self.touching(pose, footprint)
        if name is not None:
            raise errors.StandsInObstacle(
                f"a robot at ({pose.x:.3f}, {pose.y:.3f}) m, heading {pose.heading:.3f} rad, "
                f"would stand in `{name}`",
                x_m=pose.x,
                y_m=pose.y,
                heading_rad=pose.heading,
                obstacle=name,
            )


def outline_at(pose: Pose, footprint: Footprint) -> Floats:
    """A robot's outline on the ground, (6,)."""
    return rect.rectangle(pose.x, pose.y, footprint.length_m, footprint.width_m, pose.heading)


def _as_box(box: Box | dict[str, Any]) -> Box:
    if isinstance(box, Box):
        return box
    known = {f.name for f in fields(Box)}
    for key, value in box.items():
        if key not in known:
            raise errors.BoxOutOfRange(
                f"box: unknown key `{key}`; a box has {', '.join(sorted(known))}",
                box=str(box.get("name", "box")),
                key=key,
                value=value,
            )
    return Box(**box)
