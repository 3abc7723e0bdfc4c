"""What the console is shown: one moment of a run, as plain data.

Points are metres, angles radians, all in the world frame unless a name says otherwise. Nothing here
is shared with the run that made it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Pose = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Grid:
    """Values of cells [row, col], row 0 lowest.

    Attributes:
        values: (rows, cols); an occupancy (0 free, 1 occupied, 2 unknown) or costs-to-go.
        resolution_m: side of a cell.
        origin: pose of the corner of cell (0, 0).
        number: another one whenever the values may have changed.
    """

    values: NDArray[Any]
    resolution_m: float
    origin: Pose
    number: int


@dataclass(frozen=True)
class Sonar:
    """Where a sonar sits in the robot frame, and its cone."""

    pose: Pose
    beam_rad: float
    max_range_m: float


@dataclass(frozen=True)
class Lidar:
    """A planar scanner in the robot frame; its ranges follow the sonars'."""

    pose: Pose
    first_rad: float
    step_rad: float


@dataclass(frozen=True)
class Body:
    """What of a robot does not change."""

    length_m: float
    width_m: float
    height_m: float
    sonars: tuple[Sonar, ...]
    lidar: Lidar | None
    linear_mps: float
    angular_radps: float


@dataclass(frozen=True)
class BoxState:
    """A box that no map shows."""

    name: str
    x: float
    y: float
    length_m: float
    width_m: float
    heading: float
    height_m: float
    standing: bool  # False: put down where a robot stands, it waits for the place


@dataclass(frozen=True, eq=False)
class RobotState:
    """One robot at one moment.

    Attributes:
        name: of the robot.
        body: what does not change.
        truth: where it really is.
        estimate: where its navigator believes it is.
        ranges_m: (n,) of the last tick: sonars, then lidar beams; inf no echo, nan not measured.
        decision: `cairn.Decision.to_dict()` of the last tick.
        goal: where it is going, or None.
        to_go_m: along its path, or None.
        clearance_m: from its outline to anything standing, by truth.
        path: (n, 2) the path last walked down the field.
        waypoints: (n, 2) what the tracker follows.
        trail: (n, 2) where it really was, oldest first.
        trail_modes: mode at each point of the trail.
        history: (n, 3) time [s], commanded V [m/s] and ω [rad/s], oldest first.
        told: changes of mode, newest last, as `Transition.to_dict`.
        goals: goals that are over, as `GoalResult.to_dict`.
        driven_m: by truth.
        contacts: how often it touched something.
        plan_count: plans made.
    """

    name: str
    body: Body
    truth: Pose
    estimate: Pose
    ranges_m: Floats
    decision: dict[str, Any]
    goal: tuple[float, float] | None
    to_go_m: float | None
    clearance_m: float
    path: Floats
    waypoints: Floats
    trail: Floats
    trail_modes: tuple[str, ...]
    history: Floats
    told: tuple[dict[str, Any], ...]
    goals: tuple[dict[str, Any], ...]
    driven_m: float
    contacts: int
    plan_count: int


@dataclass(frozen=True)
class Note:
    """Something the console tells once: a command that was refused, the end of a run."""

    number: int
    time_s: float
    text: str
    wrong: bool


@dataclass(frozen=True, eq=False)
class Snapshot:
    """One moment of a run.

    Attributes:
        number: counts up.
        run: counts runs of one console; 0 is the first.
        scenario: its name.
        seed: of the run.
        time_s: simulated.
        paused: whether time stands still.
        speed: simulated seconds wanted per second; inf: as many as there can be.
        pace: simulated seconds per second just now.
        robots: at least one.
        world: what really stands there, boxes apart.
        grid: the map of the robot shown, as it is now.
        costs: its costs-to-go, or None.
        boxes: what no map shows.
        places: named poses of the world.
        spares_left: how many more boxes may be put down.
        notes: newest last.
        over: how it ended, once it has.
    """

    number: int
    run: int
    scenario: str
    seed: int
    time_s: float
    paused: bool
    speed: float
    pace: float
    robots: tuple[RobotState, ...]
    world: Grid
    grid: Grid
    costs: Grid | None
    boxes: tuple[BoxState, ...]
    places: dict[str, tuple[float, ...]] = field(default_factory=dict)
    spares_left: int = 0
    notes: tuple[Note, ...] = ()
    over: str | None = None
