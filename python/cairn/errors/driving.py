"""What can be wrong with profiles, robots, controllers, readings and missions."""

from typing import Any

from cairn.errors.base import CairnError

# ---- profiles ------------------------------------------------------------------------------------


class ProfileNotFound(CairnError):
    """Neither a shipped profile nor a file."""

    profile: str
    known: list[str]


class ProfileKeyUnknown(CairnError):
    """A table of a robot profile has a key that nobody reads."""

    profile: str
    key: str
    known: list[str]


class ProfileKeyMissing(CairnError):
    """A table of a robot profile lacks a key."""

    profile: str
    key: str


class ProfileUnreadable(CairnError):
    """The text of a profile is not TOML, or its keys are not those of a profile."""

    reason: str


class ProfileTableMissing(CairnError):
    """A simulation was asked of a profile without the table that describes it."""

    profile: str
    table: str


class ProfileValueOutOfRange(CairnError):
    """A number in a robot profile is not what physics allows."""

    profile: str
    key: str
    value: float
    least: float


# ---- robots and scenes ---------------------------------------------------------------------------


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


class FloorOutOfRange(CairnError):
    """How much more a robot slips on a floor is not a positive finite number."""

    track_scale: float


class CommandNotFinite(CairnError):
    """A commanded speed is NaN or infinite."""

    linear_mps: float
    angular_radps: float


class SimulationNotInstalled(CairnError):
    """The physics engine is an extra that is not installed."""


class StageFull(CairnError):
    """As many boxes stand as may be put down during a run."""

    box: str
    spares: int


class ConsoleNotInstalled(CairnError):
    """The console in the browser is an extra that is not installed."""


class ConsoleAddressUnusable(CairnError):
    """The console cannot listen on the address that it was told."""

    host: str
    port: int


class TunerNotInstalled(CairnError):
    """The optimiser that tunes controllers is an extra that is not installed."""


# ---- fuzzy systems -------------------------------------------------------------------------------


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


# ---- controllers and paths -----------------------------------------------------------------------


class ControllerNotFound(CairnError):
    """A fuzzy controller is neither a file nor shipped under that name."""

    controller: str
    known: list[str]


class ControllerUnreadable(CairnError):
    """The text of a controller or a fuzzy system is not TOML, or has keys that do not belong."""

    reason: str


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


class PathShapeWrong(CairnError):
    """A path is not an array of (x, y) rows."""

    shape: tuple[int, ...]


class TrackValueOutOfRange(CairnError):
    """A number of the tracker's or the waypoints' configuration cannot be used."""

    key: str
    value: float
    must_be: str


# ---- avoidance -----------------------------------------------------------------------------------


class AvoidanceValueOutOfRange(CairnError):
    """A setting of the curvature velocity method is outside its range."""

    key: str
    value: float
    least: float
    most: float


class AvoidanceWeightsNotOne(CairnError):
    """The weights of equation (7) do not sum to one."""

    speed_weight: float
    distance_weight: float
    heading_weight: float


class AvoidanceObstacleNotFinite(CairnError):
    """An obstacle has a coordinate that is not a finite number."""

    index: int
    x_m: float
    y_m: float


class AvoidanceInputInvalid(CairnError):
    """Twist, goal or tick given to the avoidance is not a usable number."""

    what: str
    value: float
    wanted: str


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


class LocaliseValueOutOfRange(CairnError):
    """A setting of the localisation cannot be."""

    key: str
    value: float
    least: float
    most: float


class LocaliseMapEmpty(CairnError):
    """Nothing stands on the map: there is nothing to recognise."""

    cells: int


class LocaliseNoRoom(CairnError):
    """The robot fits nowhere on the map."""

    radius_m: float


class LocaliseNoSensor(CairnError):
    """The profile has neither sonars nor a lidar to recognise a place with."""

    profile: str


class LocaliseRangeCount(CairnError):
    """There is not one range for each sensor."""

    given: int
    expected: int


class LocaliseInputNotFinite(CairnError):
    """A pose, a motion or a spread is no finite number, or a spread is negative."""

    name: str
    value: float


class SpinTestRefused(CairnError):
    """A spin test cannot be done as asked, or the robot does not turn."""

    reason: str


# ---- navigating ----------------------------------------------------------------------------------


class SettingsInvalid(CairnError):
    """Settings of a part have a key that does not belong, or a value of the wrong type."""

    part: str
    reason: str


class NavigatorSettingInvalid(CairnError):
    """A setting of the navigator is not usable."""

    key: str
    value: float


class NavigatorValueOutOfRange(CairnError):
    """A setting of the navigator is outside its range."""

    key: str
    value: float
    least: float
    most: float


class RangeCountWrong(CairnError):
    """The array of ranges has another length than the profile has sensors."""

    given: int
    expected: int


class GroundShapeWrong(CairnError):
    """Costs of the ground are not one for each cell of the map."""

    given: int
    expected: int


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


class TransitionMissing(CairnError):
    """A table of the strategy has no row for an event in a mode."""

    mode: str
    event: str


class TransitionAmbiguous(CairnError):
    """A table of the strategy has several rows for an event in a mode."""

    mode: str
    event: str


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


# ---- the benchmark of navigation -----------------------------------------------------------------


class NavWorldInvalid(CairnError):
    """A file is not a world of the navigation benchmark."""

    path: str
    key: str
    reason: str


class NavWorldsMissing(CairnError):
    """A folder holds no world, or not all of those asked for."""

    folder: str
    missing: list[int]


class StackNotFound(CairnError):
    """There is no navigation stack of that name, or no such callable."""

    name: str
    reason: str


class StackPeriodInvalid(CairnError):
    """A stack asks for a control period that the simulated robot does not offer."""

    name: str
    period_s: float


class NavBenchValueOutOfRange(CairnError):
    """A setting of the navigation benchmark is not usable."""

    key: str
    value: Any


# ---- logs ----------------------------------------------------------------------------------------


class LogUnwritable(CairnError):
    """The log of a run cannot be written, or no longer."""

    path: str
    reason: str


class RecordedRobotUnknown(CairnError):
    """A log was told of a robot that it does not record."""

    number: int
    robots: int


class LogUnreadable(CairnError):
    """There is no log of a run, or what is there is none."""

    path: str
    reason: str


class LogNotReplayable(CairnError):
    """An input was used that is not in the log."""

    path: str
    reason: str


class TickNotRecorded(CairnError):
    """A log has no tick at that time."""

    path: str
    time_s: float


class RobotUnknown(CairnError):
    """A run has no robot of that name."""

    robot: str
    known: list[str]
