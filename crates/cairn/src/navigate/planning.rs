//! From the map as it is now to a field, and from a field to the robot's own path.

use std::sync::Arc;

use serde::Serialize;

use super::config::PathShape;
use crate::geometry::{Point2, Pose2};
use crate::plan::{Crossed, Field, GridPlanner, PlanOptions};
use crate::robot::Footprint;
use crate::world::{Cell, CellSet, Grid, GridGeometry, KeptCosts, Occupancy, OccupancyGrid};

/// A cost-to-go field laid over the world, shared by every robot that wants the same goal.
#[derive(Clone, Debug)]
pub struct WorldField {
    /// Cost-to-go and policy, with the cost per metre that they rest on.
    pub field: Arc<Field>,
    /// What the map held as occupied when the way was walked.
    pub occupied: Arc<CellSet>,
    /// What it leads to; several for exploring.
    pub goals: Vec<Point2>,
}

/// Why there is no plan; each ends the task and is told to the user.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "code")]
pub enum Refusal {
    /// The goal lies beyond the map or, where none is given, beyond what one may grow to.
    GoalOutsideMap,
    /// Something stands on the goal, or so near that the robot cannot stand there.
    GoalBlocked {
        /// From the goal to the nearest occupied place \[m\].
        clearance_m: f64,
        /// What the robot needs \[m\].
        needed_m: f64,
    },
    /// The robot is outside the map.
    StartOutsideMap,
    /// The footprint overlaps an occupied cell, or no free place is near enough.
    StartBlocked,
    /// Goal and robot are in parts of the map that nothing joins.
    NoPath,
    /// Several plans brought the robot no nearer.
    NoProgress {
        /// How many.
        plans: u32,
    },
    /// Exploring: nothing unknown is left that can be reached.
    NothingLeftToExplore,
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::GoalOutsideMap => write!(f, "the goal lies outside the map"),
            Self::GoalBlocked { clearance_m, needed_m } => write!(
                f,
                "the nearest obstacle is {clearance_m:.2} m from the goal and the robot needs {needed_m:.2} m"
            ),
            Self::StartOutsideMap => write!(f, "the robot is outside the map"),
            Self::StartBlocked => write!(f, "the robot stands in an obstacle of the map"),
            Self::NoPath => write!(f, "no path leads from the robot to the goal"),
            Self::NoProgress { plans } => write!(f, "{plans} plans brought the robot no nearer to the goal"),
            Self::NothingLeftToExplore => write!(f, "nothing unknown is left that the robot can reach"),
        }
    }
}

/// Solves the field for `goal` on `costs`.
///
/// # Errors
/// The [`Refusal`] that says why nobody could get there.
pub(super) fn solve(
    planner: &mut GridPlanner,
    costs: &KeptCosts,
    footprint: &Footprint,
    goal: Point2,
) -> Result<WorldField, Refusal> {
    let cell = costs.geometry().cell_at(goal).ok_or(Refusal::GoalOutsideMap)?;
    if !costs.costs().at(cell).is_finite() {
        return Err(Refusal::GoalBlocked {
            clearance_m: clearance(costs.seen(), goal),
            needed_m: footprint.inscribed_radius_m(),
        });
    }
    solve_to(planner, costs, vec![goal], &[cell])
}

/// Solves the field towards every frontier: free cells beside unknown ones, away from the robot.
///
/// # Errors
/// [`Refusal::NothingLeftToExplore`] where there is none.
pub(super) fn solve_frontiers(
    planner: &mut GridPlanner,
    costs: &KeptCosts,
    footprint: &Footprint,
    robot: Point2,
) -> Result<WorldField, Refusal> {
    let geometry = costs.geometry();
    let occupancy = costs.seen();
    let known_free = |row: usize, col: usize| *occupancy.at(Cell::new(row, col)) == Occupancy::Free;
    let mut cells = Vec::new();
    for row in 1..geometry.rows.saturating_sub(1) {
        for col in 1..geometry.cols.saturating_sub(1) {
            let cell = Cell::new(row, col);
            let beside_unknown = [(row - 1, col), (row + 1, col), (row, col - 1), (row, col + 1)]
                .iter()
                .any(|&(r, c)| *occupancy.at(Cell::new(r, c)) == Occupancy::Unknown);
            let reachable = costs.costs().at(cell).is_finite();
            let away = geometry.center(cell).distance(robot) > 2.0 * footprint.length_m;
            if known_free(row, col) && beside_unknown && reachable && away {
                cells.push(cell);
            }
        }
    }
    if cells.is_empty() {
        return Err(Refusal::NothingLeftToExplore);
    }
    let goals = cells.iter().map(|&cell| geometry.center(cell)).collect();
    solve_to(planner, costs, goals, &cells)
}

/// Solves the field to goals in these cells, in memory of earlier ones.
pub(super) fn solve_to(
    planner: &mut GridPlanner,
    costs: &KeptCosts,
    goals: Vec<Point2>,
    cells: &[Cell],
) -> Result<WorldField, Refusal> {
    let geometry = costs.geometry();
    let grid = planner.copied_f32(geometry, &costs.costs().values);
    // On one thread the work of a solution, to which that of repairs is compared, is the same every time.
    let options = PlanOptions { threads: Some(1), ..PlanOptions::default() };
    let field = planner.plan_costs_f32(grid, cells, &options).map_err(|_| Refusal::NoPath)?;
    Ok(WorldField { field: Arc::new(field), occupied: Arc::new(costs.occupied()), goals })
}

/// Distance from `point` to the nearest occupied cell \[m\]; infinite if there is none.
fn clearance(occupancy: &OccupancyGrid, point: Point2) -> f64 {
    let geometry = occupancy.geometry;
    let occupied = occupancy.values.iter().enumerate().filter(|(_, seen)| **seen == Occupancy::Occupied);
    occupied
        .map(|(index, _)| geometry.center(geometry.cell(index)).distance(point))
        .fold(f64::INFINITY, f64::min)
}

impl WorldField {
    /// Where the field lies.
    pub fn geometry(&self) -> GridGeometry {
        *self.field.geometry()
    }

    /// Cost of a metre in `cell`, which must be inside; infinite where the robot cannot be.
    pub fn cost_at(&self, cell: Cell) -> f32 {
        match self.field.crossed() {
            Some((Crossed::F32(costs), _)) => costs[self.geometry().index(cell)],
            _ => f32::INFINITY,
        }
    }

    /// Cost still to pay from `point`; infinite where no path leads on, None outside.
    pub fn cost_to_go(&self, point: Point2) -> Option<f64> {
        let geometry = self.geometry();
        geometry.cell_at(point).map(|cell| self.field.cost_to_go(cell) * geometry.resolution_m)
    }

    /// The way from the robot to the exact goal, as the field leads.
    ///
    /// From inside the margin, or a pocket that margins enclose, it first leaves to the nearest place
    /// with a finite value, not through anything occupied.
    ///
    /// # Errors
    /// The [`Refusal`] that says why there is none.
    pub fn path(
        &self,
        world_from_robot: Pose2,
        footprint: &Footprint,
        escape_m: f64,
        shape: PathShape,
    ) -> Result<Vec<Point2>, Refusal> {
        let geometry = self.geometry();
        let robot = world_from_robot.position();
        let cell = geometry.cell_at(robot).ok_or(Refusal::StartOutsideMap)?;
        let start = if self.field.cost_to_go(cell).is_finite() {
            robot
        } else {
            geometry.center(self.escape(world_from_robot, cell, footprint, escape_m)?)
        };
        let onward = match (shape, self.field.crossed()) {
            (PathShape::AnyAngle, Some((crossed, corner_cutting))) => {
                self.field.any_angle_path_in_world(start, &self.goals, crossed, corner_cutting)
            }
            _ => self.field.path_in_world(start, &self.goals),
        };
        let mut path = onward.map_err(|_| Refusal::StartOutsideMap)?.ok_or(Refusal::NoPath)?;
        if start != robot {
            path.insert(0, robot);
        }
        Ok(path)
    }

    /// The nearest cell with a finite value, reached straight without crossing anything occupied.
    fn escape(
        &self,
        world_from_robot: Pose2,
        from: Cell,
        footprint: &Footprint,
        escape_m: f64,
    ) -> Result<Cell, Refusal> {
        let geometry = self.geometry();
        let start = world_from_robot.position();
        let robot_from_world = world_from_robot.inverse();
        let reach = (escape_m / geometry.resolution_m).ceil() as usize;
        let rows = from.row.saturating_sub(reach)..(from.row + reach + 1).min(geometry.rows);
        // A cell counts by its centre, and the pose is not known better than a cell.
        let body = Footprint {
            length_m: footprint.length_m - 2.0 * geometry.resolution_m,
            width_m: footprint.width_m - 2.0 * geometry.resolution_m,
        };
        let mut candidates = Vec::new();
        for row in rows {
            for col in from.col.saturating_sub(reach)..(from.col + reach + 1).min(geometry.cols) {
                let cell = Cell::new(row, col);
                let center = geometry.center(cell);
                if self.occupied.holds(cell) && body.distance(robot_from_world * center) == 0.0 {
                    return Err(Refusal::StartBlocked);
                }
                let distance_m = center.distance(start);
                if distance_m <= escape_m && self.field.cost_to_go(cell).is_finite() {
                    candidates.push((distance_m, cell));
                }
            }
        }
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        candidates
            .into_iter()
            .map(|(_, cell)| cell)
            .find(|&cell| {
                self.all_along(start, geometry.center(cell), |grid_cell| !self.occupied.holds(grid_cell))
            })
            .ok_or(if self.cost_at(from).is_finite() { Refusal::NoPath } else { Refusal::StartBlocked })
    }

    /// Cost still to pay from the nearest place that has a way, if that can be reached from the robot.
    pub(super) fn nearest_with_a_way(
        &self,
        world_from_robot: Pose2,
        footprint: &Footprint,
        escape_m: f64,
    ) -> Option<f64> {
        let geometry = self.geometry();
        let from = geometry.cell_at(world_from_robot.position())?;
        let cell = self.escape(world_from_robot, from, footprint, escape_m).ok()?;
        let away_m = geometry.center(cell).distance(world_from_robot.position());
        Some(self.field.cost_to_go(cell) * geometry.resolution_m + away_m)
    }

    /// The robot's centre may pass straight from `a` to `b`.
    pub fn is_clear(&self, a: Point2, b: Point2) -> bool {
        self.all_along(a, b, |cell| self.cost_at(cell).is_finite())
    }

    /// `holds` for every cell touched at steps of a quarter cell from `a` to `b`.
    fn all_along(&self, a: Point2, b: Point2, holds: impl Fn(Cell) -> bool) -> bool {
        let geometry = self.geometry();
        let steps = (a.distance(b) / (geometry.resolution_m / 4.0)).ceil().max(1.0) as usize;
        (0..=steps).all(|i| {
            let point = a + (b - a) * (i as f64 / steps as f64);
            geometry.cell_at(point).is_some_and(&holds)
        })
    }
}

/// `occupancy` grown by unknown cells until it holds `margin_m` around every one of `points`; None where
/// that takes more than `most_cells`.
pub(super) fn padded(
    occupancy: &OccupancyGrid,
    points: &[Point2],
    margin_m: f64,
    most_cells: usize,
) -> Option<OccupancyGrid> {
    let old = occupancy.geometry;
    let grid_from_world = old.world_from_grid.inverse();
    let (mut row_lo, mut col_lo, mut row_hi, mut col_hi) = (0i64, 0i64, old.rows as i64, old.cols as i64);
    for &point in points {
        let in_grid = grid_from_world * point;
        let cell = |metres: f64| (metres / old.resolution_m).floor() as i64;
        row_lo = row_lo.min(cell(in_grid.y - margin_m));
        col_lo = col_lo.min(cell(in_grid.x - margin_m));
        row_hi = row_hi.max(cell(in_grid.y + margin_m).saturating_add(1));
        col_hi = col_hi.max(cell(in_grid.x + margin_m).saturating_add(1));
    }
    let rows = usize::try_from(row_hi.checked_sub(row_lo)?).ok()?;
    let cols = usize::try_from(col_hi.checked_sub(col_lo)?).ok()?;
    if rows.checked_mul(cols)? > most_cells {
        return None;
    }
    let corner =
        old.world_from_grid * Point2::new(col_lo as f64 * old.resolution_m, row_lo as f64 * old.resolution_m);
    let geometry = GridGeometry {
        rows,
        cols,
        resolution_m: old.resolution_m,
        world_from_grid: Pose2::new(corner.x, corner.y, old.world_from_grid.heading),
    };
    let mut grown = Grid::filled(geometry, Occupancy::Unknown);
    for row in 0..old.rows {
        let from = row * old.cols;
        let to = (row as i64 - row_lo) as usize * cols + (-col_lo) as usize;
        grown.values[to..to + old.cols].copy_from_slice(&occupancy.values[from..from + old.cols]);
    }
    Some(grown)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_is_padded_up_to_its_most_cells_and_a_point_beyond_is_refused_not_allocated() {
        let geometry =
            GridGeometry { rows: 4, cols: 4, resolution_m: 0.05, world_from_grid: Pose2::IDENTITY };
        let map = Grid::filled(geometry, Occupancy::Free);
        let to = |x, y| padded(&map, &[Point2::default(), Point2::new(x, y)], 1.0, 64_000_000);
        let grown = to(10.0, -3.0).unwrap();
        assert!(grown.geometry.cell_at(Point2::new(10.9, -3.9)).is_some());
        assert_eq!(grown.values.iter().filter(|&&seen| seen == Occupancy::Free).count(), 16);
        for far in [5e5, 1e12, 1e300, f64::MAX] {
            assert!(to(far, far).is_none() && to(-far, 0.5 * far).is_none(), "{far}");
        }
    }
}
