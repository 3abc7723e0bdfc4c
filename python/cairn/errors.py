"""Every way that input can be wrong: one class per cause, the offending values as attributes.

Errors of the brain arrive as the class of the same name. All are `ValueError`s, so code that does
not care which one it was can catch that.
"""

from typing import Any


class CairnError(ValueError):
    """Something given to Cairn was wrong; the message says what, where, and what would be right."""

    def __init__(self, message: str, **fields: Any) -> None:
        super().__init__(message)
        for name, value in fields.items():
            setattr(self, name, value)


# ---- profiles ------------------------------------------------------------------------------------


class ProfileValueOutOfRange(CairnError):
    """A number in a robot profile is not what physics allows."""

    profile: str
    key: str
    value: float
    least: float


# ---- worlds --------------------------------------------------------------------------------------


class WorldShapeInvalid(CairnError):
    """An array of a world is not (rows, cols) with a cell at least, or not like the others."""

    what: str
    shape: tuple[int, ...]


class WorldCellInvalid(CairnError):
    """A cell of a world holds what no cell can hold."""

    what: str
    row: int
    col: int
    value: float


class WorldValueOutOfRange(CairnError):
    """The resolution, origin or footprint is not usable."""

    key: str
    value: Any


class WorldGoalInvalid(CairnError):
    """A goal of a world is not two or three finite numbers."""

    goal: str
    value: Any


class PointOutsideWorld(CairnError):
    """No cell of the world holds the point."""

    x: float
    y: float
    extent: tuple[float, float, float, float]


class CostmapValueOutOfRange(CairnError):
    """A weight, margin or speed of a cost map is not usable."""

    key: str
    value: float
    rule: str


class LayerShapeMismatch(CairnError):
    """A layer of a cost map has not one value for every cell."""

    layer: str
    values: int
    rows: int
    cols: int


class LayerValueInvalid(CairnError):
    """A layer of a cost map holds a negative number or NaN."""

    layer: str
    row: int
    col: int
    value: float


class ProfileKeyUnknown(CairnError):
    """A table of a robot profile has a key that nobody reads."""

    profile: str
    key: str
    known: list[str]


class ProfileKeyMissing(CairnError):
    """A table of a robot profile lacks a key."""

    profile: str
    key: str


class ProfileNotFound(CairnError):
    """Neither a shipped profile nor a file."""

    profile: str
    known: list[str]


class ProfileTableMissing(CairnError):
    """A simulation was asked of a profile without the table that describes it."""

    profile: str
    table: str


# ---- robots --------------------------------------------------------------------------------------


class NoiseFactorOutOfRange(CairnError):
    """Noise cannot be scaled by this."""

    factor: float


class StandsInObstacle(CairnError):
    """A robot was put where something already stands."""

    x_m: float
    y_m: float
    heading_rad: float
    obstacle: str


class BoxOutOfRange(CairnError):
    """A box of a scene has sizes, a place or times that no box can have."""

    box: str
    key: str
    value: object


class StepOutOfRange(CairnError):
    """A robot cannot be advanced by this time."""

    dt_s: float


class CommandNotFinite(CairnError):
    """A commanded speed is NaN or infinite."""

    linear_mps: float
    angular_radps: float
