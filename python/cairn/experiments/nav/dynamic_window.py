"""The dynamic window approach as ROS ships it, a yardstick: parameters are the usual defaults.

[Fox97] in the form of move_base with navfn, costmap_2d and dwa_local_planner, parameters at their
defaults but for the top speed of 0.5 m/s; written anew from what those packages document:

- cells of 0.05 m in the odometry frame, marked by the lidar within 2.5 m, cleared within 3 m;
- outline padded by 0.01 m; forbidden to the robot's centre within the inscribed radius of an
  obstacle, and up to 0.55 m dearer by exp(−10 d);
- a global path by costs of navfn (50 + 0.8 · cost), unknown cells free, five times a second;
- 3 × 20 pairs (v, ω) of what acceleration allows in a period, each driven for 1.7 s;
- scored 16 · distance to the path, 16 · the same 0.325 m ahead, 12 · distance to where the path
  leaves the local map, 12 · the same ahead, and 0.01 · cost under the outline at the end;
- a turn in place keeps its sense until the robot has moved 0.05 m or turned 0.2 rad;
- where every pair hits something it stands, and after 15 s forgets its map and turns round once.
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
from cairn.robots.robot import Pose, wrap_angle

Floats = NDArray[np.float64]

CELL_M = 0.05
HALF_SIDE_M = 20.0
LOCAL_HALF_SIDE_M = 5.0
MARK_WITHIN_M, CLEAR_WITHIN_M = 2.5, 3.0
PADDING_M = 0.01
INFLATION_M, DECAY_PER_M = 0.55, 10.0
NEUTRAL, FACTOR = 50.0, 0.8
LETHAL, INSCRIBED = 254.0, 253.0
PLAN_EVERY_S, PATIENCE_S = 0.2, 15.0

MAX_V, MAX_W = 0.5, 1.0
LEAST_V, LEAST_W = 0.1, 0.4  # a pair slower than both is none
ACC_V, ACC_W = 2.5, 3.2
V_SAMPLES, W_SAMPLES = 3, 20
SIM_S, SIM_STEP_S = 1.7, 0.1
PATH_SCALE, GOAL_SCALE, OBSTACLE_SCALE = 16.0, 12.0, 0.01
AHEAD_M = 0.325
OSCILLATION_RESET_M, OSCILLATION_RESET_RAD = 0.05, 0.2
FAR_M = 1e3  # counted where there is no way, or no map
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
        outline = task.profile.footprint
        self._half = (outline.length_m / 2 + PADDING_M, outline.width_m / 2 + PADDING_M)
        self._edge = _edge_points(*self._half)
        self._turning = 0.0  # sense of the turns in place since it last moved
        self._turned_at = Pose(0.0, 0.0, 0.0)
        self._free_s = 0.0  # when a pair was free last
        self._round_rad = 0.0  # left of a turn to recover

    def __call__(self, seen: Observation) -> tuple[float, float]:
        """One period: mark, plan when it is time, choose."""
        self._mark(seen)
        pose = seen.odometry
        local = self._window(pose)
        self._inflate(local)
        if seen.time_s - self._planned_s >= PLAN_EVERY_S - 1e-9:
            self._planned_s = seen.time_s
            self._plan(pose)
        if self._round_rad > 0.0:
            self._round_rad -= MAX_W * self._task.period_s
            self._free_s = seen.time_s
            return 0.0, MAX_W
        chosen = None if self.path is None else self._choose(pose, seen.twist, local)
        if chosen is not None:
            self._free_s = seen.time_s
            return chosen
        self._stuck += 1
        if seen.time_s - self._free_s > PATIENCE_S:
            self._marked[:] = False
            self._round_rad = 2 * math.pi
        return 0.0, 0.0

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
        inscribed = min(self._half)
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
    ) -> tuple[float, float] | None:
        """The best pair; None where every one hits something."""
        assert self.path is not None
        to_path, to_goal = self._distances(pose, window)
        dt = self._task.period_s
        v_now, w_now = (max(0.0, min(MAX_V, twist[0])), max(-MAX_W, min(MAX_W, twist[1])))
        vs = np.linspace(max(0.0, v_now - ACC_V * dt), min(MAX_V, v_now + ACC_V * dt), V_SAMPLES)
        ws = np.linspace(max(-MAX_W, w_now - ACC_W * dt), min(MAX_W, w_now + ACC_W * dt), W_SAMPLES)
        if ws[0] < 0 < ws[-1]:
            ws = np.sort(np.append(ws, 0.0))
        v, w = (each.ravel() for each in np.meshgrid(vs, ws, indexing="ij"))
        moved_m = math.dist(self._turned_at[:2], pose[:2])
        turned = abs(wrap_angle(pose.heading - self._turned_at.heading))
        if moved_m > OSCILLATION_RESET_M or turned > OSCILLATION_RESET_RAD:
            self._turning = 0.0
        slow = v < LEAST_V - 1e-9
        allowed = ~(slow & (np.abs(w) < min(LEAST_W, np.abs(ws).max()) - 1e-9))
        allowed &= ~(slow & (w * self._turning < 0.0))
        v, w = v[allowed], w[allowed]
        if not len(v):
            return None
        cost = self._scored(pose, v, w, window, to_path, to_goal)
        best = int(cost.argmin())
        if not np.isfinite(cost[best]):
            return None
        chosen = float(v[best]), float(w[best])
        if chosen[0] < LEAST_V and self._turning == 0.0 and chosen[1] != 0.0:
            self._turning, self._turned_at = math.copysign(1.0, chosen[1]), pose
        return chosen

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
    ) -> Floats:
        """Costs of driving pairs of speeds; inf where they hit."""
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
        under = centre[:, -1].copy()
        # The outline is looked at only where something is near enough to meet it.
        reach = float(np.hypot(*self._edge.T).max()) + CELL_M
        at, when = np.nonzero(self._away[r, c] <= reach)
        if len(at):
            ch, sh = np.cos(heading[at, when])[:, None], np.sin(heading[at, when])[:, None]
            ex = x[at, when][:, None] + ch * self._edge[:, 0] - sh * self._edge[:, 1]
            ey = y[at, when][:, None] + sh * self._edge[:, 0] + ch * self._edge[:, 1]
            er = np.floor((ey + HALF_SIDE_M) / CELL_M).astype(int) - rows.start
            ec = np.floor((ex + HALF_SIDE_M) / CELL_M).astype(int) - cols.start
            met = local[er, ec].max(axis=1)
            hit[at[met >= LETHAL]] = True
            ends = when == len(t) - 1
            under[at[ends]] = np.maximum(under[at[ends]], met[ends])
        ends = np.column_stack([x[:, -1], y[:, -1]])
        ahead = ends + AHEAD_M * np.column_stack([np.cos(heading[:, -1]), np.sin(heading[:, -1])])
        cost = OBSTACLE_SCALE * under
        for points, leading in ((ends, False), (ahead, True)):
            for field, scale in ((to_path, PATH_SCALE), (to_goal, GOAL_SCALE)):
                away = self._look(field, points, window)
                cost = cost + scale * (np.minimum(away, FAR_M) if leading else away)
        return np.where(hit, np.inf, cost)

    def _look(self, field: Any, points: Floats, window: tuple[slice, slice]) -> Floats:
        rows, cols = window
        r = np.floor((points[:, 1] + HALF_SIDE_M) / CELL_M).astype(int) - rows.start
        c = np.floor((points[:, 0] + HALF_SIDE_M) / CELL_M).astype(int) - cols.start
        inside = (r >= 0) & (c >= 0) & (r < field.shape[0]) & (c < field.shape[1])
        found = np.full(len(points), np.inf)
        found[inside] = _metres(field[r[inside], c[inside]])
        return found


def _metres(steps: NDArray[np.unsignedinteger]) -> Floats:
    """Of a field over free cells; inf where there is no way."""
    return np.where(steps == np.iinfo(steps.dtype).max, np.inf, steps * (CELL_M / STRAIGHT))


def _around(middle: int, reach: int, size: int) -> slice:
    return slice(max(0, middle - reach), min(size, middle + reach + 1))


def _edge_points(x: float, y: float) -> Floats:
    """Points (n, 2) along an outline of these half sides, no farther apart than a cell."""
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
