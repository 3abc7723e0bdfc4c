"""Missions in an office: random starts and goals, boxes no map shows, a trolley that is pushed.

The robot is a P3-AT with its sonars and the office's map. Boxes stand where the map shows nothing;
one more is put down before the robot as it comes; a trolley stands somewhere, is pushed across at
0.15 m/s and back, waits where the robot stands in its way, and is taken away in the end. A goal
counts as reached within 0.3 m by truth; a refusal is right where no way is left for the robot's
inscribed disc when everything stands as at the end.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

import cairn
from cairn import _brain
from cairn.experiments.nav.scoring import CAP, OLD_CAP, score
from cairn.experiments.nav.trial import COLLISION, ERROR, SUCCESS, TIMEOUT, Trial
from cairn.missions import Result, Scenario
from cairn.missions.setting import Setting, build, point_of
from cairn.robots import Box
from cairn.robots.robot import Pose
from cairn.world import World

MAP = "office"
LEAST_WAY_M = 4.0
BOXES = 3
TROLLEY_STEPS, TROLLEY_STEP_M, TROLLEY_STEP_S = 40, 0.06, 0.4
AWAY_M = 0.75
"""Boxes stand no nearer to start and goal than this, from centre to centre less their own size."""
TIMEOUT_S = 300.0
STANDS_MPS, STANDS_RADPS = 0.01, 0.02
WIDEST_M = 3.0


def office_mission(number: int, seed: int = 1, robot: str = "mujoco") -> Scenario:
    """Mission `number` of the series of `seed`.

    Args:
        number: any, from 0.
        seed: of the series.
        robot: `mujoco` (physics) or `kinematic`.
    """
    random = np.random.default_rng([seed, number, 11])
    world = cairn.maps.load(MAP)
    profile = cairn.Profile.load("p3at")
    costs = cairn.costmap(world, profile)
    outline = profile.footprint
    reach_m = math.hypot(outline.length_m, outline.width_m) / 2 + 0.05
    free = np.argwhere(_clearances(world) > reach_m)
    while True:
        start, goal = (_centre(world, free[int(random.integers(len(free)))]) for _ in range(2))
        way = cairn.plan(costs, goal).path(start)
        if way is not None and _length(way) >= LEAST_WAY_M:
            break
    boxes = _standing(random, world, free, start, goal)
    boxes += _put_down(random, way, start, goal)
    boxes += _pushed(random, way, start, goal)
    return Scenario.model_validate(
        {
            "name": f"office_{number}",
            "map": MAP,
            "robot": robot,
            "start": {
                "x_m": start[0],
                "y_m": start[1],
                "heading_rad": float(random.uniform(-math.pi, math.pi)),
            },
            "goals": [{"x_m": goal[0], "y_m": goal[1]}],
            "boxes": boxes,
            "seed": int(random.integers(2**31)),
            "timeout_s": TIMEOUT_S,
        }
    )


def drive_office(number: int, seed: int, robot: str = "mujoco") -> tuple[Trial, Result | None]:
    """Run a mission and judge it as a trial: (trial, result), no result after an error."""
    scenario = office_mission(number, seed, robot)
    settings: list[Setting] = []

    def kept(scenario: Scenario, seed: int) -> Setting:
        settings.append(build(scenario, seed))
        return settings[0]

    try:
        result = cairn.missions.run(scenario, setting=kept)
    except cairn.errors.CairnError as error:
        return _trial(number, ERROR, f"{type(error).__name__}: {error}", None), None
    ended = result.robots[0].goals[0]
    touched = result.robots[0].contacts
    if touched:
        return _trial(number, COLLISION, f"touched {touched[0].get('name', '')}", result), result
    if ended.outcome == "reached":
        return _trial(number, SUCCESS, ended.sentence, result), result
    if ended.outcome == "refused":
        stage = settings[0].agents[0].robot.stage
        stands = [box for box, stands in zip(stage.boxes, stage.standing, strict=True) if stands]
        width_m = widest_way_m(scenario, stands)
        if width_m <= cairn.Profile.load("p3at").footprint.width_m:
            return _trial(number, SUCCESS, f"rightly refused: {ended.sentence}", result), result
        reason = f"refused, though a way {width_m:.2f} m wide was left: {ended.sentence}"
        return _trial(number, TIMEOUT, reason, result), result
    return _trial(number, TIMEOUT, f"{ended.outcome}: {ended.sentence}", result), result


def widest_way_m(scenario: Scenario, standing: Sequence[Box]) -> float:
    """Width of the widest way past walls and all that stands, to a cell's size [m].

    The greatest diameter of a disc that passes from start to goal; 0 where none does.
    """
    world = cairn.maps.load(scenario.map)
    occupancy = np.array(world.occupancy)
    x0, y0, _ = world.origin
    rows, cols = np.indices(occupancy.shape)
    x = x0 + (cols + 0.5) * world.resolution_m
    y = y0 + (rows + 0.5) * world.resolution_m
    for box in standing:
        c, s = math.cos(box.heading), math.sin(box.heading)
        u, v = c * (x - box.x) + s * (y - box.y), c * (y - box.y) - s * (x - box.x)
        occupancy[(abs(u) <= box.length_m / 2) & (abs(v) <= box.width_m / 2)] = 1
    crowded = World(occupancy, resolution_m=world.resolution_m, origin=world.origin)
    clear_m = _clearances(crowded)
    cells = [
        (int((y - y0) / world.resolution_m), int((x - x0) / world.resolution_m))
        for x, y in (point_of(p, world) for p in (scenario.starts[0].start, scenario.goals[0]))
    ]
    clear_m[cells[0]] = np.inf  # it stands there already

    def passes(radius_m: float) -> bool:
        free = clear_m > radius_m
        if not free[cells[1]]:
            return False
        return bool(np.isfinite(cairn.plan_grid(free, goal=cells[1]).cost_to_go[cells[0]]))

    radii = np.unique(clear_m[(clear_m > 0) & (clear_m <= WIDEST_M / 2)])
    low, high = -1, len(radii)  # the widest that passes is below the first radius that does not
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if passes(float(radii[middle])) else (low, middle)
    if high == len(radii):
        return WIDEST_M
    return 2 * float(radii[high]) if passes(0.0) else 0.0


def office_figures(trials: Sequence[Trial]) -> dict[str, Any]:
    """Return what only missions tell, over trials of `drive_office` that came to an end.

    Contacts, and how many came while the robot itself stood; rightly refused missions; changes of
    mode in a minute; traps, with the median and the greatest time in one [s].
    """
    ended = [trial for trial in trials if trial.notes]
    trapped_s = [seconds for trial in ended for seconds in trial.notes["trapped_s"]]
    minutes = sum(trial.time_s for trial in ended) / 60

    def total(key: str) -> float:
        return sum(trial.notes[key] for trial in ended)

    return {
        "contacts": total("contacts"),
        "contacts_standing": total("contacts_standing"),
        "rightly_refused": total("rightly_refused"),
        "transitions_per_minute": total("transitions") / minutes if minutes else 0.0,
        "plans": total("plans"),
        "traps": len(trapped_s),
        "traps_not_left": total("trapped_for_good"),
        "trapped_median_s": float(np.median(trapped_s)) if trapped_s else 0.0,
        "trapped_most_s": max(trapped_s, default=0.0),
        "least_clearance_m": min((t.notes["least_clearance_m"] for t in ended), default=0.0),
    }


def _trial(number: int, outcome: str, reason: str, result: Result | None) -> Trial:
    if result is None:
        return Trial(f"office_{number}", 0, outcome, reason, 0.0, 0.0, 0.0, 0.0, Pose(0, 0, 0), 1,
                     {}, {"tick_mean_ms": 0.0, "tick_p99_ms": 0.0, "tick_max_ms": 0.0})  # fmt: skip
    robot = result.robots[0]
    goal = robot.goals[0]
    time_s = goal.ended_s - goal.started_s
    length_m = goal.planned_length_m or goal.path_length_m
    top_mps = cairn.Profile.load("p3at").limits.linear_mps
    scores = [
        score(outcome == SUCCESS and length_m > 0, time_s, length_m, top_mps, cap)
        for cap in (CAP, OLD_CAP)
    ]
    return Trial(
        world=f"office_{number}",
        trial=0,
        outcome=outcome,
        reason=reason,
        time_s=time_s,
        score=scores[0],
        score_old_cap=scores[1],
        path_length_m=goal.path_length_m,
        end=Pose(*robot.trace.truth[-1]),
        attempts=1,
        notes={
            "least_clearance_m": round(robot.least_clearance_m, 3),
            "drift_end_m": round(robot.drift_end_m, 3),
            "plans": robot.plan_count,
            "transitions": len(robot.transitions),
            "trapped_s": [round(trap.seconds, 1) for trap in robot.traps],
            "trapped_for_good": sum(not trap.left for trap in robot.traps),
            "rightly_refused": int(goal.outcome == "refused" and outcome == SUCCESS),
            "contacts": len(robot.contacts),
            "contacts_standing": sum(_stood(contact) for contact in robot.contacts),
        },
        wall={
            "tick_mean_ms": result.wall["decide_mean_ms"],
            "tick_p99_ms": result.wall["decide_max_ms"],
            "tick_max_ms": result.wall["decide_max_ms"],
        },
    )


def _stood(contact: dict[str, Any]) -> bool:
    """Whether the robot stood when it touched: what moved was the other one."""
    return contact["speed_mps"] < STANDS_MPS and contact["turn_radps"] < STANDS_RADPS


def _clearances(world: World) -> np.ndarray:
    """From cell centres to what stands or is unknown [m]."""
    taken = np.ascontiguousarray(np.asarray(world.occupancy) != 0)
    return _brain.distance_to_occupied(taken, world.resolution_m, surface=True)


def _centre(world: World, cell: np.ndarray) -> tuple[float, float]:
    x0, y0, _ = world.origin
    row, col = cell
    return (
        float(x0 + (col + 0.5) * world.resolution_m),
        float(y0 + (row + 0.5) * world.resolution_m),
    )


def _length(way: np.ndarray) -> float:
    return float(np.hypot(*np.diff(way, axis=0).T).sum())


def _is_away(box: dict[str, Any], *places: tuple[float, float]) -> bool:
    reach = math.hypot(box["length_m"], box["width_m"]) / 2
    return all(math.dist((box["x_m"], box["y_m"]), place) >= AWAY_M + reach for place in places)


def _box(random: np.random.Generator, x: float, y: float, name: str) -> dict[str, Any]:
    return {
        "x_m": float(x),
        "y_m": float(y),
        "length_m": float(random.uniform(0.2, 0.6)),
        "width_m": float(random.uniform(0.2, 0.5)),
        "yaw_rad": float(random.uniform(-math.pi, math.pi)),
        "name": name,
    }


def _standing(
    random: np.random.Generator,
    world: World,
    free: np.ndarray,
    start: tuple[float, float],
    goal: tuple[float, float],
) -> list[dict[str, Any]]:
    """Boxes anywhere on the floor."""
    boxes: list[dict[str, Any]] = []
    while len(boxes) < BOXES:
        x, y = _centre(world, free[int(random.integers(len(free)))])
        box = _box(random, x, y, f"box {len(boxes)}")
        if _is_away(box, start, goal):
            boxes.append(box)
    return boxes


def _put_down(
    random: np.random.Generator, way: np.ndarray, start: tuple[float, float],
    goal: tuple[float, float],
) -> list[dict[str, Any]]:  # fmt: skip
    """One box near the way, put down as the robot comes within 2 m."""
    x, y = way[int(random.uniform(0.3, 0.7) * len(way))] + random.uniform(-0.3, 0.3, 2)
    box = {**_box(random, x, y, "put down"), "appears_within_m": 2.0}
    return [box] if _is_away(box, start, goal) else []


def _pushed(
    random: np.random.Generator, way: np.ndarray, start: tuple[float, float],
    goal: tuple[float, float],
) -> list[dict[str, Any]]:  # fmt: skip
    """A trolley that stands beside the way, is pushed across it and back, and then taken away.

    It comes no nearer to start and goal than boxes stand: there it waits.
    """
    middle = way[int(random.uniform(0.3, 0.7) * len(way))]
    heading = float(random.uniform(-math.pi, math.pi))
    begins_s = float(random.uniform(2.0, 15.0))
    size = {"length_m": 0.5, "width_m": 0.4, "yaw_rad": heading, "name": "trolley"}
    boxes: list[dict[str, Any]] = []
    at: tuple[float, float] | None = None
    for step in range(TROLLEY_STEPS):
        offset = TROLLEY_STEP_M * (abs(step - TROLLEY_STEPS / 2) - TROLLEY_STEPS / 4)
        x, y = middle + offset * np.array([math.cos(heading), math.sin(heading)])
        place = {**size, "x_m": float(x), "y_m": float(y)}
        near = at is None or math.dist(at, (x, y)) < 1.5 * TROLLEY_STEP_M
        if _is_away(place, start, goal) and near:
            at = (float(x), float(y))
        if at is None:
            continue
        from_s = round(begins_s + TROLLEY_STEP_S * step, 6) if boxes else 0.0
        until_s = round(begins_s + TROLLEY_STEP_S * (step + 1), 6)
        boxes.append({**size, "x_m": at[0], "y_m": at[1], "from_s": from_s, "until_s": until_s})
    return boxes
