"""What whoever watches a run may ask of it; obeyed between two ticks."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DriveTo:
    """Drive there [m, world frame]; a goal under way is replaced."""

    x_m: float
    y_m: float
    robot: int = 0


@dataclass(frozen=True)
class Explore:
    """See what is unknown, for so long."""

    for_s: float = 600.0
    robot: int = 0


@dataclass(frozen=True)
class CallOff:
    """End the task; the robot brakes to rest."""

    robot: int = 0


@dataclass(frozen=True)
class StopNow:
    """Press every robot's emergency stop, and call off all tasks."""


@dataclass(frozen=True)
class PutBox:
    """Put a box down [m, rad, world frame]."""

    x_m: float
    y_m: float
    length_m: float = 0.5
    width_m: float = 0.5
    heading: float = 0.0


@dataclass(frozen=True)
class TakeBox:
    """Take a box away that was put down."""

    name: str


@dataclass(frozen=True)
class Carry:
    """Lift a robot and set it down there [m, rad, world frame]; nobody tells its navigator."""

    x_m: float
    y_m: float
    heading: float | None = None
    robot: int = 0


@dataclass(frozen=True)
class Begin:
    """Begin anew: the first robot stands at another pose and knows it; None: where it did."""

    start: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class Pause:
    """Let time stand still, or go on."""

    on: bool = True


@dataclass(frozen=True)
class Step:
    """Pause, and let so many ticks pass."""

    ticks: int = 1


@dataclass(frozen=True)
class Speed:
    """So many simulated seconds per second; inf: as many as there can be."""

    factor: float


@dataclass(frozen=True)
class Show:
    """Whose map and field the snapshots carry."""

    robot: int


@dataclass(frozen=True)
class End:
    """End the run."""


Command = (
    DriveTo | Explore | CallOff | StopNow | PutBox | TakeBox | Carry | Begin | Pause | Step | Speed
    | Show | End
)  # fmt: skip
