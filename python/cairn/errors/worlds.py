"""What can be wrong with worlds, cost maps and map files."""

from typing import Any

from cairn.errors.base import CairnError

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


# ---- cost maps -----------------------------------------------------------------------------------


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


# ---- circles and boxes ---------------------------------------------------------------------------


class CircleNotUsable(CairnError):
    """A circle has no finite middle, or no positive finite radius."""

    index: int
    x_m: float
    y_m: float
    radius_m: float


class BlockNotUsable(CairnError):
    """A box has no finite pose, or no positive finite sides."""

    index: int
    x_m: float
    y_m: float
    length_m: float
    width_m: float


# ---- map files -----------------------------------------------------------------------------------


class MapError(CairnError):
    """A map file was refused; `path` says which, `line` where in it (from 1; None: all of it)."""

    path: str
    line: int | None


class MapNotFound(MapError):
    """There is no such file."""


class MapFormatUnknown(MapError):
    """The file is of no kind that can be read (or written) here."""


class MapTextInvalid(MapError):
    """What should be text is not: the bytes are not UTF-8."""


class MapYamlInvalid(MapError):
    """A YAML file is not YAML, or not a mapping of keys to values."""


class MapKeyMissing(MapError):
    """A key of the header is missing."""

    key: str


class MapKeyInvalid(MapError):
    """A key of the header has a value that it cannot have."""

    key: str
    value: Any


class MapImageMissing(MapError):
    """The image that a map names is not there."""

    image: str


class MapImageInvalid(MapError):
    """The image of a map cannot be read."""

    image: str


class MapImageTruncated(MapError):
    """The image of a map ends before its last pixel."""

    image: str


class MapEmpty(MapError):
    """The map has no cell."""


class MapTruncated(MapError):
    """The file ends too early."""


class MapCountMismatch(MapError):
    """There is more or less of something than the header says."""

    expected: int
    found: int


class MapCharacterInvalid(MapError):
    """A character stands for no kind of cell."""

    column: int
    character: str


class MapLineInvalid(MapError):
    """A line does not say what it should."""


class MapTooLarge(MapError):
    """The map has more cells at this resolution than can be meant."""

    cells: float


class MapNotRepresentable(MapError):
    """The file format has no room for what this world holds."""
