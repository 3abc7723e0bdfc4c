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


# ---- missions ------------------------------------------------------------------------------------


class ScenarioNotFound(CairnError):
    """There is no scenario file at that path, and no shipped scenario of that name."""

    name: str


class ScenarioInvalid(CairnError):
    """A scenario file is not TOML, or not a scenario."""

    path: str
    line: int | None
    key: str
    reason: str


class ScenarioPlaceUnknown(CairnError):
    """A scenario names a place that its world does not have."""

    place: str
    known: list[str]


class PoseSourceUnavailable(CairnError):
    """A scenario asks for a source of the pose that the navigator does not have."""

    pose: str


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


# ---- planning ------------------------------------------------------------------------------------


class EmptyGrid(CairnError):
    """The grid has no cell."""

    rows: int
    cols: int


class LayerValueInvalid(CairnError):
    """A layer of a cost map holds a negative number or NaN."""

    layer: str


class GridTooLarge(CairnError):
    """More cells than a 32-bit index can name."""

    cells: int
    most: int


class GridNotPlannable(CairnError):
    """A grid is not two-dimensional, or not of bool or real numbers."""

    shape: tuple[int, ...]
    dtype: str


class UnknownPlanOption(CairnError):
    """An option of the planner has none of its possible values."""

    option: str
    value: Any
    choices: tuple[Any, ...]


class CellNotWhole(CairnError):
    """A row, column or node is not a whole number."""

    value: Any


class GoalMalformed(CairnError):
    """A goal is neither a pair of numbers nor a sequence of such."""

    value: Any


class NoGoal(CairnError):
    """No goal was given."""


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


class CellCostNan(CairnError):
    """A cell cost is not a number."""

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


# ---- avoidance -----------------------------------------------------------------------------------


class AvoidanceValueOutOfRange(CairnError):
    """A setting of the curvature velocity method is outside its range."""

    key: str
    value: float
    least: float
    most: float


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


class SimulationNotInstalled(CairnError):
    """The physics engine is an extra that is not installed."""


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


class NoThreads(CairnError):
    """Zero threads were asked for."""


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


# ---- navigating ----------------------------------------------------------------------------------


class RangeCountWrong(CairnError):
    """The array of ranges has another length than the profile has sensors."""

    given: int
    expected: int


class AvoidanceWeightsNotOne(CairnError):
    """The weights of equation (7) do not sum to one."""

    speed_weight: float
    distance_weight: float
    heading_weight: float


class AvoidanceObstacleNotFinite(CairnError):
    """An obstacle has a coordinate that is not a finite number."""

    index: int


class RangeNegative(CairnError):
    """A range is negative."""

    index: int
    value: float


class TimeStepInvalid(CairnError):
    """A tick's duration is not a finite number greater than 0."""

    dt_s: float


class MeasurementNotFinite(CairnError):
    """A measurement or pose is NaN or infinite."""

    what: str
    value: float


class GoalNotFinite(CairnError):
    """A goal's coordinate is NaN or infinite."""

    x_m: float
    y_m: float


class AvoidanceInputInvalid(CairnError):
    """Twist, goal or tick given to the avoidance is not a usable number."""

    what: str
    value: float
    wanted: str


# ---- fuzzy systems and tracking ------------------------------------------------------------------


class FuzzyNameUnknown(CairnError):
    """A rule names an input, set, output or singleton that the system does not have."""

    kind: str
    name: str
    place: str
    known: str


class FuzzySetNotRising(CairnError):
    """Breakpoints of a set do not rise, or are not finite."""

    input: str
    set: str
    breakpoints: list[float]


class FuzzyRangeNotRising(CairnError):
    """The range of an input is empty or not finite."""

    input: str
    low: float
    high: float


class FuzzyNumberInvalid(CairnError):
    """A singleton is not finite, or a weight not a finite number above 0."""

    place: str
    value: float
    more: str


class FuzzySystemEmpty(CairnError):
    """There are no inputs, outputs, sets, singletons or rules where there must be some."""

    missing: str


class FuzzyRuleRepeated(CairnError):
    """One rule stands there twice."""

    rule: str


class FuzzyRulesLeaveGap(CairnError):
    """Inside the declared ranges there is a place where no rule fires for an output."""

    output: str
    place: str


class FuzzySystemTooLarge(CairnError):
    """Too many inputs and sets to check that rules leave no gap."""

    corners: int
    most: int


class FuzzyInputNotFinite(CairnError):
    """An input of a fuzzy system was not given a finite number."""

    input: str
    value: float


class FuzzyInputsMismatch(CairnError):
    """The inputs given are not those that the system has."""

    given: int
    known: str


class ControllerUnreadable(CairnError):
    """The text of a controller or a fuzzy system is not TOML, or has keys that do not belong."""

    reason: str


class ControllerNotFound(CairnError):
    """There is no controller of this name, nor a file."""

    controller: str
    known: list[str]


class ControllerMismatch(CairnError):
    """A fuzzy system of the controller lacks the inputs and outputs that tracking needs."""

    system: str
    kind: str
    found: str
    needed: str


class ControllerInvalid(CairnError):
    """A fuzzy system of the controller is wrong in itself."""

    system: str
    cause: object


class PathEmpty(CairnError):
    """A path has no points."""


class PathPointNotFinite(CairnError):
    """A point of a path is not a pair of finite numbers."""

    index: int
    x: float
    y: float


class TrackValueOutOfRange(CairnError):
    """A number of the tracker's or the waypoints' configuration cannot be used."""

    key: str
    value: float
    must_be: str


class MeasurementNotFinite(CairnError):
    """A pose, a twist or a duration is not a finite number."""

    quantity: str
    value: float
    more: str


class PathShapeWrong(CairnError):
    """A path is not an array of (x, y) rows."""

    shape: tuple[int, ...]


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


class NavigatorSettingInvalid(CairnError):
    """A setting of the navigator is not usable."""

    key: str
    value: float


class ControllerNotFound(CairnError):
    """A fuzzy controller is neither a file nor shipped under that name."""

    controller: str
    known: list[str]


# ---- mapping, odometry, matching -----------------------------------------------------------------


class MappingValueOutOfRange(CairnError):
    """A setting of the map cannot be."""

    key: str
    value: float
    least: float
    most: float


class MappingPoseNotFinite(CairnError):
    """The pose given with the readings holds NaN or infinity."""

    x_m: float
    y_m: float
    heading_rad: float


class MappingRangeCount(CairnError):
    """The array of ranges does not have one reading for each sensor of the profile."""

    given: int
    expected: int


class MappingRangeNegative(CairnError):
    """A range is below zero."""

    index: int
    range_m: float


class MappingTooLarge(CairnError):
    """The map would grow beyond what the settings allow."""

    rows: int
    cols: int
    most: int


class RaysShapeMismatch(CairnError):
    """Points, directions and ranges of a ray cast are not (n, 2), (n,) and positive."""

    what: str
    shape: tuple[int, ...]


class OdometryValueOutOfRange(CairnError):
    """A setting of the odometry, or a tick's length, cannot be."""

    key: str
    value: float
    least: float


class OdometryInputNotFinite(CairnError):
    """A measurement given to the odometry is NaN or infinite."""

    name: str
    value: float


class MatchingValueOutOfRange(CairnError):
    """A setting of the map matcher cannot be."""

    key: str
    value: float
    least: float


class MatchingRangeCount(CairnError):
    """The array of ranges is shorter than the profile's list of sonars."""

    given: int
    expected: int
