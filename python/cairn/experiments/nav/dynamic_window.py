"""The dynamic window approach as the BARN Challenge ships it: a yardstick, never tuned here.

[Fox97] with the map, the global planner and the parameters of the challenge's own baseline at
0.5 m/s: TrajectoryPlannerROS in its dynamic-window mode on costmap_2d, guided by navfn, as set in
its files `base_local_planner_params.yaml`, `costmap_common_params.yaml` and `odom_nav_params`.
Written anew from what those describe:

- cells of 0.05 m in the odometry frame, marked by the lidar within 2.5 m, cleared within 3 m;
- every cell inside the padded outline's inscribed radius of an obstacle is forbidden to the robot's
  centre, and up to 0.30 m dear;
- a global path by costs of navfn (50 + 0.8 · cost), unknown cells free, five times a second;
- 6 × 20 pairs (v, ω) of what acceleration allows in a period, and turns in place; each is driven
  for two seconds and scored 0.75 · distance to the path + 1.0 · distance to where the path leaves
  the local map + 0.1 · 0.05 · greatest cost under the outline (`meter_scoring`);
- a turn in place keeps its sense until the robot has moved 0.05 m;
- where every one of them hits something, the robot backs up at 0.5 m/s, blind, as it does there.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

import cairn
from cairn import _brain, errors
from cairn.experiments.nav.points import PointsOfRanges
from cairn.experiments.nav.stacks import Observation, Task
from cairn.robots.robot import Pose

Floats = NDArray[np.float64]

CELL_M = 0.05
HALF_SIDE_M = 20.0
LOCAL_HALF_SIDE_M = 5.0
MARK_WITHIN_M, CLEAR_WITHIN_M = 2.5, 3.0
OUTLINE_M, PADDING_M = (0.42, 0.33), 0.1
INFLATION_M, DECAY_PER_M = 0.30, 10.0
NEUTRAL, FACTOR = 50.0, 0.8
LETHAL, INSCRIBED = 254.0, 253.0
PLAN_EVERY_S = 0.2

MAX_V, MIN_V, MAX_W, MIN_TURN_W = 0.5, 0.1, 1.57, 0.314
ACC_V, ACC_W = 10.0, 20.0
V_SAMPLES, W_SAMPLES = 6, 20
SIM_S, SIM_STEP_S = 2.0, 0.1
PATH_SCALE, GOAL_SCALE = 0.75, 1.0
OBSTACLE_SCALE = 0.1 * CELL_M  # `meter_scoring` takes all three times the resolution
ESCAPE_V = -0.5
HEADING_LOOKAHEAD_M = 0.325
OSCILLATION_RESET_M = 0.05
STRAIGHT = 985  # steps of a field from one free cell to the next


class DynamicWindow:
    """The baseline; see the module."""

    def __init__(self, task: Task) -> None:
        self._task = task
        self._points = PointsOfRanges(task.profile)
        size = round(2 * HALF_SIDE_M / CELL_M)
        self._marked = np.zeros((size, size), bool)
        self._goal = self._cell(*task.goal)
        self._costs = np.zeros((size, size), np.float32)
        self._planned_s = -math.inf
        self.path: Floats | None = None
        self._plans = self._stuck = 0
        self._turning = 0.0  # sense of the turns in place since it last moved
        self._moved_from = (0.0, 0.0)
        self._edge = _edge_points()

    def __call__(self, seen: Observation) -> tuple[float, float]:
        """One period: mark, plan when it is time, choose."""
        self._mark(seen)
        pose = seen.odometry
        local = self._window(pose)
        self._inflate(local)
        if seen.time_s - self._planned_s >= PLAN_EVERY_S - 1e-9:
            self._planned_s = seen.time_s
            self._plan(pose)
        if self.path is None:
            self._stuck += 1
            return 0.0, MIN_TURN_W  # its recovery: turn and look
        return self._choose(pose, seen.twist, local)

    def notes(self) -> dict[str, int]:
        """How often it planned, and for how many periods no motion was free."""
        return {"plans": self._plans, "stuck": self._stuck}

    # ---- map ------------------------------------------------------------------------------------

    def _cell(self, x: float, y: float) -> tuple[int, int]:
        return math.floor((y + HALF_SIDE_M) / CELL_M), math.floor((x + HALF_SIDE_M) / CELL_M)

    def _mark(self, seen: Observation) -> None:
        """Clear what beams pass through, then mark where they end."""
        lidar = self._task.profile.lidar
        if lidar is None:
            raise errors.StackNotFound(
                "dynamic-window needs a lidar", name="dynamic-window", reason="it needs a lidar"
            )
        pose = seen.scan_pose
        c, s = math.cos(pose.heading), math.sin(pose.heading)
        x, y = pose.x + c * lidar.pose.x, pose.y + s * lidar.pose.x
        ranges = seen.ranges_m[-lidar.beams :]
        row, col = self._cell(x, y)
        reach = math.ceil(CLEAR_WITHIN_M / CELL_M)
        rows, cols = _around(row, reach, len(self._marked)), _around(col, reach, len(self._marked))
        block = self._marked[rows, cols]
        ys = (np.arange(rows.start, rows.stop) + 0.5) * CELL_M - HALF_SIDE_M - y
        xs = (np.arange(cols.start, cols.stop) + 0.5) * CELL_M - HALF_SIDE_M - x
        at_row, at_col = np.nonzero(block)
        if len(at_row):
            dx, dy = xs[at_col], ys[at_row]
            away = np.hypot(dx, dy)
            angle = np.arctan2(dy, dx) - pose.heading - lidar.first_rad
            beam = np.rint(np.mod(angle, 2 * math.pi) / lidar.step_rad).astype(int)
            inside = beam < lidar.beams
            through = np.zeros(len(beam), bool)
            through[inside] = away[inside] < ranges[beam[inside]] - CELL_M / 2
            through &= away < CLEAR_WITHIN_M
            block[at_row[through], at_col[through]] = False
        points = self._points(seen.ranges_m, MARK_WITHIN_M)
        px = pose.x + c * points[:, 0] - s * points[:, 1]
        py = pose.y + s * points[:, 0] + c * points[:, 1]
        rs = np.floor((py + HALF_SIDE_M) / CELL_M).astype(int)
        cs = np.floor((px + HALF_SIDE_M) / CELL_M).astype(int)
        good = (rs >= 0) & (cs >= 0) & (rs < len(self._marked)) & (cs < len(self._marked))
        self._marked[rs[good], cs[good]] = True

    def _window(self, pose: Pose) -> tuple[slice, slice]:
        row, col = self._cell(pose.x, pose.y)
        reach = round(LOCAL_HALF_SIDE_M / CELL_M)
        size = len(self._marked)
        return _around(row, reach, size), _around(col, reach, size)

    def _inflate(self, window: tuple[slice, slice]) -> None:
        """costmap_2d's inflation, around the robot; what is farther off has not changed."""
        marked = np.ascontiguousarray(self._marked[window])
        away = _brain.distance_to_occupied(marked, CELL_M, surface=False)
        inscribed = min(OUTLINE_M) / 2 + PADDING_M
        costs = np.zeros(away.shape, np.float32)
        near = away <= INFLATION_M
        costs[near] = np.floor((INSCRIBED - 1) * np.exp(-DECAY_PER_M * (away[near] - inscribed)))
        costs[away <= inscribed] = INSCRIBED
        costs[marked] = LETHAL
        self._costs[window] = costs
        self._away = away

    # ---- global path ----------------------------------------------------------------------------

    def _plan(self, pose: Pose) -> None:
        """Plan as navfn does; where the robot's own cell is forbidden, it plans all the same."""
        start = self._cell(pose.x, pose.y)
        rows, cols = self._extent(start)
        part = NEUTRAL + FACTOR * self._costs[rows, cols]
        part[self._costs[rows, cols] >= INSCRIBED] = np.inf
        goal = (self._goal[0] - rows.start, self._goal[1] - cols.start)
        begin = (start[0] - rows.start, start[1] - cols.start)
        near = part[max(0, begin[0] - 2) : begin[0] + 3, max(0, begin[1] - 2) : begin[1] + 3]
        near[np.isinf(near)] = NEUTRAL + FACTOR * INSCRIBED
        part[goal] = NEUTRAL
        field = cairn.plan_grid(part, goal=goal, threads=1)
        cells = field.path(begin)
        self._plans += 1
        if cells is None:
            self.path = None
            return
        self.path = np.column_stack(
            [
                (cells[:, 1] + cols.start + 0.5) * CELL_M - HALF_SIDE_M,
                (cells[:, 0] + rows.start + 0.5) * CELL_M - HALF_SIDE_M,
            ]
        )

    def _extent(self, start: tuple[int, int]) -> tuple[slice, slice]:
        """Rows and columns around robot and goal; the rest of the map is as good as never used."""
        size, margin = len(self._marked), round(5.0 / CELL_M)
        low = [max(0, min(a, b) - margin) for a, b in zip(start, self._goal, strict=True)]
        high = [min(size, max(a, b) + margin) for a, b in zip(start, self._goal, strict=True)]
        return slice(low[0], high[0]), slice(low[1], high[1])

    # ---- local choice ---------------------------------------------------------------------------

    def _choose(
        self, pose: Pose, twist: tuple[float, float], window: tuple[slice, slice]
    ) -> tuple[float, float]:
        assert self.path is not None
        to_path, to_goal = self._distances(pose, window)
        dt = self._task.period_s
        v_now, w_now = twist
        vs = np.linspace(
            max(MIN_V, v_now - ACC_V * dt), max(MIN_V, min(MAX_V, v_now + ACC_V * dt)), V_SAMPLES
        )
        ws = np.linspace(max(-MAX_W, w_now - ACC_W * dt), min(MAX_W, w_now + ACC_W * dt), W_SAMPLES)
        v, w = (each.ravel() for each in np.meshgrid(vs, ws, indexing="ij"))
        cost, _, _ = self._scored(pose, v, w, window, to_path, to_goal)
        best = int(cost.argmin())
        # Turning in place wins only where it is at least as good; the one that faces the lower
        # ground ahead of it is taken.
        if math.dist(self._moved_from, pose[:2]) > OSCILLATION_RESET_M:
            self._turning, self._moved_from = 0.0, (pose.x, pose.y)
        turns = ws[(np.abs(ws) >= MIN_TURN_W) & (ws * self._turning >= 0.0)]
        if len(turns):
            zero = np.zeros(len(turns))
            turn_cost, ends, headings = self._scored(pose, zero, turns, window, to_path, to_goal)
            least = turn_cost.min()
            if np.isfinite(least) and least <= cost[best]:
                ahead = ends + HEADING_LOOKAHEAD_M * np.column_stack(
                    [np.cos(headings), np.sin(headings)]
                )
                faced = np.where(turn_cost == least, self._look(to_goal, ahead, window), np.inf)
                turn = float(turns[int(faced.argmin())])
                self._turning = math.copysign(1.0, turn)
                return 0.0, turn
        if np.isfinite(cost[best]):
            return float(v[best]), float(w[best])
        self._stuck += 1
        return ESCAPE_V, 0.0

    def _distances(self, pose: Pose, window: tuple[slice, slice]) -> tuple[Any, Any]:
        """Steps from every local cell to the path, and to where it leaves the local map."""
        assert self.path is not None
        rows, cols = window
        free = np.ascontiguousarray(self._costs[window] < INSCRIBED)
        row = np.floor((self.path[:, 1] + HALF_SIDE_M) / CELL_M).astype(int) - rows.start
        col = np.floor((self.path[:, 0] + HALF_SIDE_M) / CELL_M).astype(int) - cols.start
        inside = (row >= 0) & (col >= 0) & (row < free.shape[0]) & (col < free.shape[1])
        leaves = int(inside.argmin()) if not inside.all() else len(inside)
        row, col = row[: max(leaves, 1)], col[: max(leaves, 1)]
        free[row, col] = True
        cells = list(zip(row.tolist(), col.tolist(), strict=True))
        path, goal = (cairn.plan_grid(free, goal=g, threads=1) for g in (cells, cells[-1]))
        return path.native, goal.native

    def _scored(
        self,
        pose: Pose,
        v: Floats,
        w: Floats,
        window: tuple[slice, slice],
        to_path: Any,
        to_goal: Any,
    ) -> tuple[Floats, Floats, Floats]:
        """(costs, ends (n, 2), headings) of driving pairs of speeds; inf where they hit."""
        t = SIM_STEP_S * np.arange(1, round(SIM_S / SIM_STEP_S) + 1)
        turn = w[:, None] * t
        heading = pose.heading + turn
        chord = v[:, None] * t * np.sinc(turn / (2 * math.pi))
        x = pose.x + chord * np.cos(pose.heading + turn / 2)
        y = pose.y + chord * np.sin(pose.heading + turn / 2)
        rows, cols = window
        r = np.floor((y + HALF_SIDE_M) / CELL_M).astype(int) - rows.start
        c = np.floor((x + HALF_SIDE_M) / CELL_M).astype(int) - cols.start
        local = self._costs[window]
        centre = local[r, c]
        hit = np.asarray((centre >= LETHAL).any(axis=1))
        worst = centre.max(axis=1)
        # The outline is looked at only where something is near enough to meet it.
        reach = float(np.hypot(*self._edge.T).max()) + CELL_M
        at, when = np.nonzero(self._away[r, c] <= reach)
        if len(at):
            ch, sh = np.cos(heading[at, when])[:, None], np.sin(heading[at, when])[:, None]
            ex = x[at, when][:, None] + ch * self._edge[:, 0] - sh * self._edge[:, 1]
            ey = y[at, when][:, None] + sh * self._edge[:, 0] + ch * self._edge[:, 1]
            er = np.floor((ey + HALF_SIDE_M) / CELL_M).astype(int) - rows.start
            ec = np.floor((ex + HALF_SIDE_M) / CELL_M).astype(int) - cols.start
            under = local[er, ec].max(axis=1)
            np.maximum.at(worst, at, under)
            hit[at[under >= LETHAL]] = True
        end_r, end_c = r[:, -1], c[:, -1]
        cost = (
            PATH_SCALE * _metres(to_path[end_r, end_c])
            + GOAL_SCALE * _metres(to_goal[end_r, end_c])
            + OBSTACLE_SCALE * worst
        )
        ends = np.column_stack([x[:, -1], y[:, -1]])
        return np.where(hit, np.inf, cost), ends, heading[:, -1]

    def _look(self, field: Any, points: Floats, window: tuple[slice, slice]) -> Floats:
        rows, cols = window
        r = np.floor((points[:, 1] + HALF_SIDE_M) / CELL_M).astype(int) - rows.start
        c = np.floor((points[:, 0] + HALF_SIDE_M) / CELL_M).astype(int) - cols.start
        return _metres(field[r, c])


def _metres(steps: NDArray[np.unsignedinteger]) -> Floats:
    """Of a field over free cells; inf where there is no way."""
    return np.where(steps == np.iinfo(steps.dtype).max, np.inf, steps * (CELL_M / STRAIGHT))


def _around(middle: int, reach: int, size: int) -> slice:
    return slice(max(0, middle - reach), min(size, middle + reach + 1))


def _edge_points() -> Floats:
    """Points (n, 2) along the padded outline, no farther apart than a cell."""
    x, y = OUTLINE_M[0] / 2 + PADDING_M, OUTLINE_M[1] / 2 + PADDING_M
    along = np.linspace(-x, x, math.ceil(2 * x / CELL_M) + 1)
    across = np.linspace(-y, y, math.ceil(2 * y / CELL_M) + 1)
    return np.vstack(
        [
            np.column_stack([along, np.full(len(along), y)]),
            np.column_stack([along, np.full(len(along), -y)]),
            np.column_stack([np.full(len(across), x), across]),
            np.column_stack([np.full(len(across), -x), across]),
        ]
    )


def dynamic_window(task: Task) -> DynamicWindow:
    """Make the `dynamic-window` stack."""
    return DynamicWindow(task)
