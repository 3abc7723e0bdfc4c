"""What can be wrong with grids, graphs, goals and starts."""

from typing import Any

from cairn.errors.base import CairnError

# ---- goals, starts and options -------------------------------------------------------------------


class NoGoal(CairnError):
    """No goal was given."""


class GoalMalformed(CairnError):
    """A goal is neither a pair of numbers nor a sequence of such."""

    value: Any


class StartMalformed(CairnError):
    """A start is no pair of numbers."""

    value: Any


class CellNotWhole(CairnError):
    """A row, column or node is not a whole number of 64 bits."""

    value: Any


class GoalOutsideGrid(CairnError):
    """A goal cell is not in the grid."""

    row: int
    col: int
    rows: int
    cols: int


class GoalOutsideMap(CairnError):
    """A goal point is not on the map."""

    x_m: float
    y_m: float
    rows: int
    cols: int
    resolution_m: float


class GoalBlocked(CairnError):
    """A goal lies in a cell that cannot be entered."""

    row: int
    col: int


class StartOutsideGrid(CairnError):
    """A start cell is not in the grid."""

    row: int
    col: int
    rows: int
    cols: int


class StartOutsideMap(CairnError):
    """A start point is not on the map."""

    x_m: float
    y_m: float
    rows: int
    cols: int
    resolution_m: float


class UnknownPlanOption(CairnError):
    """An option of the planner has none of its possible values."""

    option: str
    value: Any
    choices: tuple[Any, ...]


class AnyAngleNotPriced(CairnError):
    """A field of costs per move has no cost for a segment at any other angle."""


class NoThreads(CairnError):
    """Zero threads were asked for."""


class CellOutsideGrid(CairnError):
    """A cell to be changed is not in the grid."""

    row: int
    col: int
    rows: int
    cols: int


class CellsMalformed(CairnError):
    """Cells are no array of pairs of whole numbers."""

    value: Any


class UpdateCostsMalformed(CairnError):
    """New costs are no bools or real numbers, one for each cell."""

    shape: tuple[int, ...]
    dtype: str


class UpdateLengthMismatch(CairnError):
    """There are not as many new costs as cells to be changed."""

    cells: int
    costs: int


class FieldNotUpdatable(CairnError):
    """A field cannot take the change asked for."""

    reason: str


class SimdNotAvailable(CairnError):
    """Instructions were asked for that this processor does not have."""

    simd: str
    widest: str


# ---- grids ---------------------------------------------------------------------------------------


class EmptyGrid(CairnError):
    """The grid has no cell."""

    rows: int
    cols: int


class GridTooLarge(CairnError):
    """More cells than a 32-bit index can name."""

    cells: int
    most: int


class GridNotPlannable(CairnError):
    """A grid is not two-dimensional, not of bool or real numbers, or has masked cells."""

    shape: tuple[int, ...]
    dtype: str


class WorldNotPlannable(CairnError):
    """What was given as a world lacks something that planning on it needs."""

    kind: str
    attribute: str


class CellCostNan(CairnError):
    """A cell cost is not a number."""

    row: int
    col: int
    value: float


class CellCostNegative(CairnError):
    """A cell cost is below zero."""

    row: int
    col: int
    value: float


class CellCostZero(CairnError):
    """A cell cost is zero."""

    row: int
    col: int
    value: float


class CellCostBeyondPrecision(CairnError):
    """A finite cell cost would become zero or infinite in single precision."""

    row: int
    col: int
    value: float


class LinkCostAbsorbed(CairnError):
    """A link is so cheap beside the cost-to-go that adding it changes nothing."""

    row: int
    col: int
    cost_to_go: float
    precision: str


class CostToGoOverflow(CairnError):
    """A cost-to-go is larger than the number type can hold."""

    row: int
    col: int
    precision: str


# ---- terrain and weights -------------------------------------------------------------------------


class CellSizeOutOfRange(CairnError):
    """The cell size of a terrain is not usable."""

    value: Any
    least: float
    most: float


class TerrainValueOutOfRange(CairnError):
    """A parameter of a terrain model is not usable."""

    key: str
    value: float
    least: float
    most: float


class TerrainModelUnknown(CairnError):
    """What was given as a terrain model is neither one nor the name of one."""

    value: Any
    choices: tuple[str, ...]


class ElevationInfinite(CairnError):
    """An elevation is infinite, in single precision."""

    row: int
    col: int
    value: float


class RoughnessShape(CairnError):
    """Roughness and elevation differ in shape."""

    rows: int
    cols: int
    elevation_rows: int
    elevation_cols: int


class RoughnessOutOfRange(CairnError):
    """A roughness is negative or infinite."""

    row: int
    col: int
    value: float


class PathMalformed(CairnError):
    """A path to be priced is no sequence of (row, col)."""

    value: Any


class PathWithoutCells(CairnError):
    """A path to be priced has no cell."""


class PathOutsideGrid(CairnError):
    """A cell of a path is not in the grid."""

    index: int
    row: int
    col: int
    rows: int
    cols: int


class PathBroken(CairnError):
    """A cell of a path is no neighbour of the one before."""

    index: int
    row: int
    col: int
    next_row: int
    next_col: int


class WeightsNotPlannable(CairnError):
    """Weights of moves are not an array (8, rows, cols) of real numbers."""

    shape: tuple[int, ...]
    dtype: str


class WeightCount(CairnError):
    """There are not eight weights for every cell."""

    weights: int
    rows: int
    cols: int


class WeightNan(CairnError):
    """The weight of a move is not a number."""

    row: int
    col: int
    code: int
    value: float


class WeightNegative(CairnError):
    """The weight of a move is below zero."""

    row: int
    col: int
    code: int
    value: float


class WeightZero(CairnError):
    """The weight of a move is zero."""

    row: int
    col: int
    code: int
    value: float


class WeightBeyondPrecision(CairnError):
    """The weight of a move does not fit float32, or uint32 for integers."""

    row: int
    col: int
    code: int
    value: float


# ---- graphs --------------------------------------------------------------------------------------


class IndptrEnds(CairnError):
    """A graph's `indptr` does not run from 0 to the number of links."""

    first: int
    last: int
    links: int


class IndptrFalls(CairnError):
    """A graph's `indptr` falls."""

    node: int
    begin: int
    end: int


class LinkCostCount(CairnError):
    """There is not one cost for every link."""

    costs: int
    links: int


class NodeOutOfRange(CairnError):
    """A link leads from or to a node that does not exist."""

    link: int
    node: int
    nodes: int


class GraphTooLarge(CairnError):
    """More nodes or links than a 32-bit index can name."""

    nodes: int
    links: int
    most: int


class GraphNotPlannable(CairnError):
    """Graph arrays are not one-dimensional, or not of the right number types."""

    array: str
    shape: tuple[int, ...]
    dtype: str


class LinkCostNan(CairnError):
    """A link cost is not a number."""

    link: int
    source_node: int
    target_node: int
    value: float


class LinkCostNegative(CairnError):
    """A link cost is below zero."""

    link: int
    source_node: int
    target_node: int
    value: float


class GraphCostOverflow(CairnError):
    """The longest way through a graph may not fit into the cost type."""

    links: int
    dearest: float
    precision: str


class GoalNotANode(CairnError):
    """A goal is not a node of the graph."""

    node: int
    nodes: int


class StartNotANode(CairnError):
    """A start is not a node of the graph."""

    node: int
    nodes: int


class NoLevels(CairnError):
    """The layered solution graph was given no level."""
