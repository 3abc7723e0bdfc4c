"""Types of the compiled brain; the public names are re-exported by `cairn`."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

__version__: str

class Profile:
    """A robot profile, checked: outline, limits, wheels and sensors."""

    def __new__(cls, text: str) -> Self:
        """Read a profile from TOML text."""

    @staticmethod
    def from_toml(text: str) -> Profile:
        """Read a profile from TOML text."""

    def to_dict(self) -> dict[str, Any]:
        """Return the profile as plain dicts and lists, keyed as in the file."""

# ---- grids and cost maps -------------------------------------------------------------------------

def distance_to_occupied(
    occupied: NDArray[np.bool_], resolution_m: float, *, surface: bool
) -> NDArray[np.float32]:
    """Distance from cell centres to the nearest occupied cell's centre, or surface [m]."""

def costmap(
    occupancy: NDArray[np.uint8],
    resolution_m: float,
    footprint: tuple[float, float],
    config: dict[str, Any],
    ground: NDArray[np.float32] | None,
    layers: list[tuple[str, NDArray[np.float32], float]],
) -> NDArray[np.float32]:
    """Cost per metre of every cell for a robot of this outline, inf blocked."""

class GridField:
    """Cost-to-go and next cell of every cell of a grid."""

    @property
    def unit(self) -> float:
        """Native cost of one straight step through cells of unit cost."""

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, cols)."""

    @property
    def goals(self) -> list[tuple[int, int]]:
        """The goal cells."""

    @property
    def prices_segments(self) -> bool:
        """Whether a straight segment has a cost in this field."""

    def native(self) -> NDArray[Any]:
        """Return the solver's own array, not copied, read-only."""

    def next_node(self) -> NDArray[np.int8]:
        """Return codes 0..7 or -1, not copied, read-only."""

    def cost_to_go(self, scale: float) -> NDArray[np.float64]:
        """Return the cost-to-go [cost x cells] times `scale`."""

    def path(self, start: tuple[int, int]) -> NDArray[np.int64] | None:
        """Return the cells from `start` to a goal, or None."""

    def path_in_world(
        self, start: tuple[float, float], goals: list[tuple[float, float]]
    ) -> NDArray[np.float64] | None:
        """Return the way from a point of the world to a goal point, or None."""

    def any_angle_path(self, start: tuple[int, int]) -> NDArray[np.int64] | None:
        """Return the cells that the way turns at when straight wherever that is no dearer."""

    def any_angle_path_in_world(
        self,
        start: tuple[float, float],
        goals: list[tuple[float, float]],
    ) -> NDArray[np.float64] | None:
        """Return the points that the way turns at when straight wherever that is no dearer."""

    def update(
        self,
        cells: NDArray[np.int64],
        costs: NDArray[np.bool_] | NDArray[np.float32] | NDArray[np.float64],
        give_up: float,
    ) -> tuple[bool, int, int, int]:
        """Change costs of cells; (solved anew, cells changed, cells forgotten, visits to tiles)."""

Place = tuple[float, tuple[float, float, float]]
Means = tuple[int | None, str | None, tuple[int, int] | None]

def plan_free(
    free: NDArray[np.bool_],
    goals: list[tuple[int, int]],
    place: Place,
    corner_cutting: bool,
    paper_steps: bool,
    means: Means,
) -> GridField:
    """Plan on a bool grid, True free, in integer steps."""

def plan_terrain(
    elevation: NDArray[np.float32],
    roughness: NDArray[np.float32] | None,
    cell_size_m: float,
    model: dict[str, Any],
    goals: list[tuple[int, int]],
    corner_cutting: bool,
    means: Means,
) -> GridField:
    """Plan on an elevation grid, in the unit of the model."""

def terrain_path_cost(
    elevation: NDArray[np.float32],
    roughness: NDArray[np.float32] | None,
    cell_size_m: float,
    model: dict[str, Any],
    path: list[tuple[int, int]],
    corner_cutting: bool,
) -> float:
    """Cost of a way over terrain, a list of cells."""

def terrain_roughness(elevation: NDArray[np.float32], cell_size_m: float) -> NDArray[np.float32]:
    """Roughness of every cell of an elevation grid."""

def terrain_moves(
    elevation: NDArray[np.float32],
    roughness: NDArray[np.float32] | None,
    cell_size_m: float,
    model: dict[str, Any],
    corner_cutting: bool,
) -> NDArray[np.uint8]:
    """Bit k: the move with code k out of a cell is allowed."""

def terrain_link_costs(
    rises_m: NDArray[np.float32],
    roughness: float,
    cell_size_m: float,
    model: dict[str, Any],
    diagonal: bool,
) -> NDArray[np.float32]:
    """Costs of moves with these rises [m]."""

def terrain_defaults(kind: str) -> dict[str, Any]:
    """Parameters of a model with their defaults."""

def terrain_check(model: dict[str, Any]) -> None:
    """Refuse a model with unusable parameters."""

def plan_weights_f32(
    weights: NDArray[np.float32], goals: list[tuple[int, int]], means: Means
) -> GridField:
    """Plan on a grid with one float32 cost per move, (8, rows, cols)."""

def plan_weights_u32(
    weights: NDArray[np.uint32], goals: list[tuple[int, int]], means: Means
) -> GridField:
    """Plan on a grid with one uint32 cost per move, (8, rows, cols)."""

def plan_costs_f32(
    costs: NDArray[np.float32],
    goals: list[tuple[int, int]],
    place: Place,
    corner_cutting: bool,
    means: Means,
) -> GridField:
    """Plan on a float32 grid of costs."""

def plan_costs_f64(
    costs: NDArray[np.float64],
    goals: list[tuple[int, int]],
    place: Place,
    corner_cutting: bool,
    means: Means,
) -> GridField:
    """Plan on a float64 grid of costs."""

def release_memory() -> None:
    """Give the memory kept from one plan to the next back to the system."""

def simd_levels() -> list[str]:
    """Instruction sets that the solver has code for and this processor has, the widest first."""

def start_cell(point: tuple[float, float], rows: int, cols: int, place: Place) -> tuple[int, int]:
    """Row and column of the cell that holds a point of the world."""

def goal_cells(
    points: list[tuple[float, float]], rows: int, cols: int, place: Place
) -> list[tuple[int, int]]:
    """Row and column of the cells that hold points of the world; refuses points off the map."""

# ---- fuzzy systems and tracking ------------------------------------------------------------------

class FuzzySystem:
    """A checked zero-order Sugeno system."""

    def __new__(cls, text: str) -> Self:
        """Read a system from TOML text."""

    @property
    def input_names(self) -> list[str]: ...
    @property
    def output_names(self) -> list[str]: ...
    def evaluate(self, values: list[float]) -> dict[str, Any]:
        """Outputs, memberships and rule strengths by name; values in order of input names."""

    def outputs(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Output values (n, outputs) for input values (n, inputs)."""

class Tracker:
    """The path tracker."""

    def __new__(cls, text: str, profile: Profile, cruise_mps: float | None = None) -> Self:
        """A tracker from the TOML text of a controller and a robot's limits and latency."""

    def follow(
        self,
        points: NDArray[np.float64],
        spacing_m: float | None,
        corridor_m: float,
        is_clear: Callable[[tuple[float, float], tuple[float, float]], bool] | None,
    ) -> None: ...
    def clear(self) -> None: ...
    @property
    def waypoints(self) -> NDArray[np.float64] | None: ...
    index: int
    def advance_pointer(self, x: float, y: float) -> None: ...
    def step(
        self, pose: tuple[float, float, float], twist: tuple[float, float], dt_s: float
    ) -> dict[str, Any]: ...
    def overridden(self, twist: tuple[float, float]) -> None: ...
    def rehearse(
        self,
        start: tuple[float, float, float],
        tick_s: float,
        latency_s: float,
        turn_share: float,
        most_s: float,
    ) -> NDArray[np.float64]:
        """(n, 8): time; x, y, heading; V, omega; commanded V, omega. Works on a copy."""

    def look_ahead_system(self) -> FuzzySystem: ...
    def tracker_system(self) -> FuzzySystem: ...

def deviations(
    path: NDArray[np.float64], positions: NDArray[np.float64], reach_m: float
) -> NDArray[np.float64]:
    """(n, 2): signed distance to the path, positive left, and the way along it."""

class SharedField:
    """A cost-to-go field laid over the world, to be shared between navigators."""

    def cost_to_go_at(self, x: float, y: float) -> float | None:
        """Cost still to pay from (x, y) [m]: inf where no path leads on, None outside."""

    def cost_to_go(self) -> NDArray[np.float64]:
        """Cost-to-go of every cell (rows, cols), inf where blocked or unreachable."""

    @property
    def resolution_m(self) -> float: ...
    @property
    def origin(self) -> tuple[float, float, float]: ...

class Decision:
    """One tick's record, see `cairn.Decision`."""

    @property
    def twist(self) -> tuple[float, float]: ...
    @property
    def pose(self) -> tuple[float, float, float]: ...
    @property
    def time_s(self) -> float: ...
    @property
    def mode(self) -> str: ...
    @property
    def event(self) -> str: ...
    @property
    def reason(self) -> str: ...
    @property
    def sentence(self) -> str: ...
    @property
    def recovery(self) -> dict[str, Any] | None: ...
    @property
    def goal_status(self) -> str: ...
    def to_dict(self) -> dict[str, Any]: ...

class Navigator:
    """Plans, tracks, avoids and arrives, see `cairn.Navigator`."""

    def __init__(
        self,
        profile: Profile,
        controller_toml: str,
        config: dict[str, Any] | None,
        map: tuple[NDArray[np.uint8], float, tuple[float, float, float]] | None,
        start: tuple[float, float, float] | None,
        ground: NDArray[np.float32] | None,
    ) -> None: ...
    @staticmethod
    def default_config() -> dict[str, Any]: ...
    def set_goal(self, x: float, y: float, field: SharedField | None = None) -> None: ...
    def explore(self) -> None: ...
    def cancel(self) -> None: ...
    def step(
        self,
        ranges: NDArray[np.float64],
        wheels: tuple[float, float],
        gyro: float | None,
        dt_s: float,
        world_from_robot: tuple[float, float, float] | None = None,
    ) -> Decision: ...
    @property
    def pose(self) -> tuple[float, float, float]: ...
    @property
    def mode(self) -> str: ...
    @property
    def path(self) -> NDArray[np.float64]: ...
    @property
    def waypoints(self) -> NDArray[np.float64]: ...
    @property
    def lidar_points(self) -> NDArray[np.float64]: ...
    @property
    def plan_count(self) -> int: ...
    @property
    def field(self) -> SharedField | None: ...
    def map(self) -> tuple[NDArray[np.uint8], float, tuple[float, float, float]]: ...

class Recorder:
    """Writes the log of a run on a thread of its own, see `cairn.record.Recorder`."""

    def __init__(self, path: Path) -> None: ...
    def attach(self, name: str, media_type: str, data: bytes) -> None: ...
    def follow(self, name: str, navigator: Navigator) -> int: ...
    @staticmethod
    def leave(navigator: Navigator) -> None: ...
    def judged(
        self, robot: int, time_s: float, truth: tuple[float, float, float], clearance_m: float
    ) -> None: ...
    def finish(self) -> None: ...

class LogReader:
    """What is in a log, in order; a file beside the messages has no time.

    Only messages whose topics end with one of `endings` come out, if those are given.
    """

    def __init__(self, path: Path, endings: set[str] | None = None) -> None: ...
    @property
    def complete(self) -> bool: ...
    def __iter__(self) -> Self: ...
    def __next__(self) -> tuple[str, int | None, bytes]: ...

def time_ticks(
    navigator: Navigator,
    ranges: NDArray[np.float64],
    wheels: NDArray[np.float64],
    gyro: NDArray[np.float64],
    dt_s: NDArray[np.float64],
    poses: NDArray[np.float64],
    goals: list[tuple[int, float, float]],
    record: Path | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times [ns] of every part of every tick of recorded inputs, and what each tick did.

    (ticks, 7): locate, map, keep, mode, act, record, log; (ticks, 4): V, ω, whether a plan was
    made, the mode's number.
    """

def transitions() -> list[tuple[str, str, str, str]]:
    """Every transition of the four modes: (mode, event, next mode, reason)."""

Links = NDArray[np.int64] | NDArray[np.uint64] | NDArray[np.float32] | NDArray[np.float64]

def plan_graph(
    indptr: NDArray[np.int64],
    indices: NDArray[np.int64],
    costs: Links,
    goals: list[int],
    threads: int | None,
) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Cost-to-go in its own type and next node or -1 of every node."""

def plan_layered(
    indptr: NDArray[np.int64],
    indices: NDArray[np.int64],
    costs: Links,
    goals: list[int],
    engine: str,
    max_levels: int | None,
    early_stop: bool,
    record_sequence: bool,
    record_walks: bool,
    threads: int | None,
    schedule: str,
    record_trace: bool,
) -> dict[str, Any]:
    """Run the layered planner of the paper; the fields of `LayeredResult` by name."""

def play_out(
    waits: list[list[tuple[int, int]]],
    schedule: str,
    slope: int,
    level: NDArray[np.int64],
    layer: NDArray[np.int64],
    duration_ns: NDArray[np.int64],
    workers: int,
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Begin and end [ns] of the tasks of a trace when so many workers play a schedule out."""

def graph_of_free(
    free: NDArray[np.bool_], corner_cutting: bool, paper_steps: bool
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.uint32]]:
    """Return the links of a bool grid as CSR arrays."""

def graph_of_costs_f32(
    costs: NDArray[np.float32], corner_cutting: bool
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float32]]:
    """Return the links of a float32 cost grid as CSR arrays."""

def graph_of_costs_f64(
    costs: NDArray[np.float64], corner_cutting: bool
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Return the links of a float64 cost grid as CSR arrays."""

# ---- ray casting, mapping, odometry, matching ----------------------------------------------------

def raycast(
    occupied: NDArray[np.bool_],
    resolution_m: float,
    origin: tuple[float, float, float],
    from_points: NDArray[np.float64],
    directions_rad: NDArray[np.float64],
    max_range_m: float,
) -> NDArray[np.float64]:
    """Distance along each ray to the first occupied cell [m], inf where there is none."""

def sonar_ranges(
    occupied: NDArray[np.bool_],
    resolution_m: float,
    origin: tuple[float, float, float],
    world_from_sonar: NDArray[np.float64],
    beam_rad: float,
    max_range_m: float,
) -> NDArray[np.float64]:
    """Range a sonar at each pose is expected to measure [m], inf for no echo."""

class OccupancyMap:
    """Log-odds occupancy, see `cairn.mapping.OccupancyMap`."""

    def __init__(
        self,
        resolution_m: float,
        prior: tuple[NDArray[np.uint8], float, tuple[float, float, float]] | None,
        config: dict[str, Any] | None,
    ) -> None: ...
    @staticmethod
    def default_config() -> dict[str, Any]: ...
    def integrate(
        self,
        profile: Profile,
        world_from_robot: tuple[float, float, float],
        ranges_m: NDArray[np.float64],
    ) -> None: ...
    def classes(self) -> NDArray[np.uint8]: ...
    def probabilities(self) -> NDArray[np.float32]: ...
    def unmapped(self) -> NDArray[np.bool_]: ...
    def occupied_near(
        self, center: tuple[float, float], radius_m: float
    ) -> NDArray[np.float64]: ...
    def unmapped_near(
        self, center: tuple[float, float], radius_m: float
    ) -> NDArray[np.float64]: ...
    def clear_disc(self, center: tuple[float, float], radius_m: float) -> None: ...
    @property
    def revision(self) -> int: ...
    @property
    def resolution_m(self) -> float: ...
    @property
    def origin(self) -> tuple[float, float, float]: ...

class Odometry:
    """Encoders and gyro fused into a pose, see `cairn.odometry.Odometry`."""

    def __init__(
        self,
        profile: Profile,
        start: tuple[float, float, float],
        config: dict[str, Any] | None,
    ) -> None: ...
    @staticmethod
    def default_config() -> dict[str, Any]: ...
    def predict(
        self, wheels_m: tuple[float, float], gyro_radps: float | None, dt_s: float
    ) -> None: ...
    def set_pose(self, pose: tuple[float, float, float]) -> None: ...
    @property
    def pose(self) -> tuple[float, float, float]: ...
    def covariance(self) -> NDArray[np.float64]: ...
    @property
    def twist(self) -> tuple[float, float]: ...
    @property
    def gyro_bias_radps(self) -> float: ...
    @property
    def path_m(self) -> float: ...
    @property
    def effective_track_m(self) -> tuple[float, float]: ...
    @property
    def veer_radpm(self) -> float: ...
    @property
    def path_scale(self) -> float: ...
    @property
    def gyro_scale(self) -> float: ...

class MapMatcher:
    """Pose corrections from sonar against a known map, see `cairn.odometry.MapMatcher`."""

    def __init__(
        self,
        prior: tuple[NDArray[np.uint8], float, tuple[float, float, float]],
        config: dict[str, Any] | None,
    ) -> None: ...
    @staticmethod
    def default_config() -> dict[str, Any]: ...
    def correct(
        self, odometry: Odometry, profile: Profile, ranges_m: NDArray[np.float64]
    ) -> dict[str, Any]: ...

class MonteCarlo:
    """A set of poses on a known map, see `cairn.localisation.MonteCarlo`."""

    def __init__(
        self,
        map: tuple[NDArray[np.uint8], float, tuple[float, float, float]],
        profile: Profile,
        seed: int,
        config: dict[str, Any] | None,
    ) -> None: ...
    @staticmethod
    def default_config() -> dict[str, Any]: ...
    def spread(
        self, pose: tuple[float, float, float], sigma_m: float, sigma_rad: float
    ) -> None: ...
    def search(self, ranges_m: NDArray[np.float64]) -> int: ...
    def predict(self, before_from_now: tuple[float, float, float]) -> None: ...
    def update(self, ranges_m: NDArray[np.float64]) -> int: ...
    @property
    def is_due(self) -> bool: ...
    def estimate(self) -> dict[str, Any] | None: ...
    def particles(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def likelihood(
        self, pose: tuple[float, float, float], ranges_m: NDArray[np.float64]
    ) -> float: ...

class Localiser:
    """A pose kept on a known map, see `cairn.localisation.Localiser`."""

    def __init__(
        self,
        map: tuple[NDArray[np.uint8], float, tuple[float, float, float]],
        profile: Profile,
        start: tuple[float, float, float] | None,
        config: dict[str, Any] | None,
        matching: dict[str, Any] | None,
        odometry: dict[str, Any] | None,
    ) -> None: ...
    @staticmethod
    def default_config() -> dict[str, Any]: ...
    def step(
        self,
        ranges_m: NDArray[np.float64],
        wheels_m: tuple[float, float],
        gyro_radps: float | None,
        dt_s: float,
    ) -> dict[str, Any]: ...
    def set_pose(self, pose: tuple[float, float, float]) -> None: ...
    def forget(self) -> None: ...
    @property
    def is_found(self) -> bool: ...
    @property
    def learnt(self) -> tuple[float, float, float]: ...
    @property
    def pose(self) -> tuple[float, float, float]: ...
    def covariance(self) -> NDArray[np.float64]: ...
    def particles(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...

class CurvatureVelocity:
    """The curvature velocity method for one robot."""

    def __init__(self, profile: Profile, config: dict[str, Any]) -> None:
        """For a robot of this profile; `config` holds settings that differ from their defaults."""

    def config(self) -> dict[str, Any]:
        """Return all settings."""

    def choose(
        self,
        twist: tuple[float, float],
        pending: tuple[float, float] | None,
        goal_bearing_rad: float,
        goal_distance_m: float,
        obstacles: NDArray[np.float64],
        dt_s: float,
    ) -> dict[str, Any]:
        """Return one choice as plain dicts and lists; obstacles are (n, 2)."""

    def choose_guided(
        self,
        twist: tuple[float, float],
        pending: tuple[float, float],
        guide: Any,
        obstacles: NDArray[np.float64],
        moving: NDArray[np.float64],
        goal_distance_m: float,
        dt_s: float,
    ) -> dict[str, Any]:
        """Return one choice guided by a field; obstacles are (n, 2), moving things (k, 5)."""

class FieldGuide:
    """The cost-to-go field over points around a robot, seen from it."""

    def __new__(
        cls,
        profile: Profile,
        config: dict[str, Any],
        points: NDArray[np.float64],
        robot: tuple[float, float, float],
        goal: tuple[float, float],
        resolution_m: float,
    ) -> Self:
        """Solve the field: points (n, 2), pose and goal in one frame."""

    @property
    def has_way(self) -> bool:
        """Whether a way is known that keeps off every point."""

    def to_go(self, point_in_robot: tuple[float, float]) -> tuple[float, float]:
        """Time to go [s] and direction to leave in [rad], of a point in the robot frame."""

    def price(self, point_in_robot: tuple[float, float]) -> float:
        """Time that a metre takes there [s/m]."""

# ---- worlds of circles and boxes -----------------------------------------------------------------

class Shapes:
    """Circles and boxes that stand: exact rays, exact contact."""

    def __new__(cls, circles: NDArray[np.float64], boxes: NDArray[np.float64]) -> Self:
        """From circles (n, 3): x, y, radius; and boxes (m, 5): x, y, heading, length, width."""

    def scan(
        self,
        pose: tuple[float, float, float],
        beams: int,
        first_rad: float,
        step_rad: float,
        max_range_m: float,
        moving: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]:
        """Ranges of a planar scanner at a pose; inf beyond `max_range_m`, 0 from inside a shape."""

    def cast(
        self, origin: tuple[float, float], directions_rad: NDArray[np.float64], max_range_m: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(ranges, cosines of incidence) of rays from one point along world directions."""

    def clearance(
        self,
        pose: tuple[float, float, float],
        outline: tuple[float, float],
        moving: NDArray[np.float64] | None = None,
    ) -> float:
        """Least distance from an outline (length, width) at a pose to any shape."""

    def first_touch(
        self,
        poses: NDArray[np.float64],
        outline: tuple[float, float],
        moving: NDArray[np.float64] | None = None,
    ) -> tuple[int, str, int] | None:
        """First of poses (n, 3) that touches: (number, `circle`, `box` or `moving`, which).

        `moving`: as many rows (x, y, radius) for each pose, pose after pose.
        """

# ---- benchmarks ----------------------------------------------------------------------------------

class TimedSolver:
    """A solver and a map, to be run and timed again and again."""

    def __new__(
        cls,
        solver: str,
        map: NDArray[Any],
        goals: list[tuple[int, int]],
        corner_cutting: bool,
        threads: int,
    ) -> Self:
        """Copy a map: bool True free, uint8 weights with 0 blocked, or float32 costs."""

    @staticmethod
    def terrain(
        solver: str,
        elevation: NDArray[np.float32],
        roughness: NDArray[np.float32],
        cell_size_m: float,
        model: dict[str, Any],
        goals: list[tuple[int, int]],
        corner_cutting: bool,
        threads: int,
    ) -> TimedSolver:
        """Copy a terrain, to be planned with a cost model."""

    def run(self) -> float:
        """Solve; return how long it took [s]."""

    def update(self, cells: list[tuple[int, int]], new: NDArray[Any]) -> tuple[float, bool]:
        """Change cells of the last run's field: (how long it took [s], solved anew after all)."""

    def native(self) -> NDArray[Any]:
        """Return a copy of the costs-to-go of the last run."""

    def next_node(self) -> NDArray[np.int8]:
        """Return a copy of the next cells' codes of the last run."""

def reversed_terrain_links(
    elevation: NDArray[np.float32],
    roughness: NDArray[np.float32],
    cell_size_m: float,
    model: dict[str, Any],
    corner_cutting: bool,
) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float64]]:
    """Return CSR arrays of a terrain's links turned round, for searches from the goal."""

def copy_seconds(cells: int) -> float:
    """Return how long it takes to copy so many uint32 [s]."""

def build_info() -> dict[str, str]:
    """Return how the brain was built and what the processor has."""

def perfect_maze(rows: int, cols: int, corridor: int, seed: int) -> NDArray[np.bool_] | None:
    """Return a maze, True free; None where no room fits."""
