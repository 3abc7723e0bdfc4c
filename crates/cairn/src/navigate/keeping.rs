//! The field and the way kept right while driving: what changed on the map is priced anew and the field
//! repaired, and the way is walked anew where it is shut or a cheaper one opened. No new plan is needed.

use std::collections::HashSet;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::navigator::Navigator;
use super::planning::{Refusal, WorldField, solve_to};
use super::record::Task;
use super::recovery::{Cause, Recovery};
use super::strategy::Mode;
use crate::geometry::{Point2, Pose2};
use crate::plan::{GridPlanner, NewCosts};
use crate::world::{Cell, CostChanges, GridGeometry, KeptCosts};

/// When a way is left for another one. Costs are in metres of open ground, as the cost map prices them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct KeepingConfig {
    /// A way seen shut for this long is walked anew \[s\],
    pub shut_s: f64,
    /// and at most once in this time \[s\] ...
    pub again_s: f64,
    /// ... if that costs at most this much more. A longer detour asks for more:
    pub short_detour: f64,
    /// it must be shut this near ahead of the robot \[m\],
    pub near_m: f64,
    /// and be seen so for this long \[s\].
    pub sure_s: f64,
    /// Where no other way leads on and the map was doubted already, it must be shut this near \[m\].
    pub look_m: f64,
    /// An open way is left for one that is cheaper by this much,
    pub gain: f64,
    /// by this share of what is left,
    pub gain_share: f64,
    /// and for this long \[s\]. Every such change doubles what the next one must gain.
    pub gain_s: f64,
    /// A goal that is shut off is waited for this long before it is planned for again, and refused \[s\].
    pub wait_s: f64,
    /// A repair that would take more than this share of a solution is a solution.
    pub give_up: f64,
}

impl Default for KeepingConfig {
    fn default() -> Self {
        Self {
            shut_s: 0.3,
            again_s: 1.0,
            short_detour: 1.5,
            near_m: 1.5,
            sure_s: 1.0,
            look_m: 0.6,
            gain: 2.0,
            gain_share: 0.15,
            gain_s: 1.0,
            wait_s: 4.0,
            give_up: 0.1,
        }
    }
}

/// What keeping the field took in this tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct FieldRepair {
    /// Cells whose cost changed.
    pub cells: usize,
    /// Cells that were forgotten because their way became dearer.
    pub forgotten: usize,
    /// Visits to tiles.
    pub visits: usize,
    /// It was solved anew: the map has another shape now, or too much changed.
    pub anew: bool,
}

/// Memory for planning; a copy of the navigator starts with an empty one.
#[derive(Debug, Default)]
pub(super) struct Desk(pub GridPlanner);

impl Clone for Desk {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// What is kept between ticks.
#[derive(Clone, Debug, Default)]
pub(super) struct Keeper {
    pub costs: Option<KeptCosts>,
    /// The costs are those of the given map.
    on_given_map: bool,
    pub desk: Desk,
    /// What was left to pay at each waypoint when the way was walked.
    pub to_go: Vec<f64>,
    shut_for_s: f64,
    cheaper_for_s: f64,
    /// Since the way was walked \[s\].
    walked_s: f64,
    /// Changes to a cheaper way, or to a long detour, in this task.
    pub switches: u32,
}

/// What looking after the way found.
pub(super) enum Minded {
    /// It stays.
    Stays,
    /// It was walked anew.
    Walked(Recovery),
    /// It is shut for certain, and nothing else leads on.
    NoWay(Recovery),
}

/// Nearer than this the robot's own margin may be shut, and nothing is made of it \[m\].
const OWN_MARGIN_M: f64 = 0.35;

impl Navigator {
    /// Prices the map as it is now, unless that is done already, so that costs hold `points`.
    pub(super) fn price(&mut self, points: &[Point2]) -> Result<(), Refusal> {
        let on_given_map = self.map_given && self.pose_known;
        let changes = self.map.take_changes();
        if self.keeper.on_given_map != on_given_map {
            self.keeper.costs = None;
        }
        if let Some(kept) = &mut self.keeper.costs
            && follow(kept, &self.map.geometry(), changes).is_some()
            && (on_given_map || points.iter().all(|&point| kept.geometry().cell_at(point).is_some()))
        {
            return Ok(());
        }
        let seen = self.map_around(points)?;
        let ground = self.ground.clone().filter(|_| on_given_map);
        let kept =
            KeptCosts::new(seen, self.body, self.config.costmap, ground).map_err(|_| Refusal::NoPath)?;
        self.keeper.costs = Some(kept);
        self.keeper.on_given_map = on_given_map;
        Ok(())
    }

    /// Takes over what changed on the map since the last tick and repairs the field.
    pub(super) fn keep_field(&mut self) -> Option<FieldRepair> {
        let position = self.odometry.pose().position();
        let before = self.to_go(position);
        let repair = self.repair();
        // Without a way the watch counts metres to the goal, which no map changes.
        let on_way = self.mode == Mode::PathTracking || self.intermediate.is_some();
        if repair.is_some() && on_way {
            self.trap.raise(self.to_go(position) - before);
        }
        repair
    }

    fn repair(&mut self) -> Option<FieldRepair> {
        let kept = self.keeper.costs.as_mut()?;
        let changes = self.map.take_changes();
        let Some(changed) = follow(kept, &self.map.geometry(), changes) else {
            self.keeper.costs = None;
            return self.solve_on_new_shape();
        };
        let field = self.field.as_mut()?;
        if changed.cells.is_empty() {
            return None;
        }
        if kept.geometry() != field.geometry() {
            return self.solve_on_new_shape();
        }
        // A goal that something stands on stays a goal until a plan refuses it.
        let goals: HashSet<Cell> = field.field.goals().iter().copied().collect();
        let (cells, costs): (Vec<Cell>, Vec<f32>) = changed
            .cells
            .iter()
            .copied()
            .zip(changed.costs.iter().copied())
            .filter(|(cell, cost)| cost.is_finite() || !goals.contains(cell))
            .unzip();
        let give_up = self.config.keeping.give_up;
        match Arc::make_mut(&mut field.field).update(&cells, NewCosts::F32(&costs), give_up) {
            Ok(update) => Some(FieldRepair {
                cells: cells.len(),
                forgotten: update.forgotten,
                visits: update.visits,
                anew: update.anew,
            }),
            Err(_) => {
                self.field = None;
                None
            }
        }
    }

    /// The field to the same goals on the map as it is now; the way stays as it was walked.
    fn solve_on_new_shape(&mut self) -> Option<FieldRepair> {
        let old = self.field.take()?;
        let mut points = vec![self.odometry.pose().position()];
        if let Some(Task::Goal { point }) = self.task {
            points.push(point);
        }
        self.price(&points).ok()?;
        let kept = self.keeper.costs.as_ref()?;
        let geometry = kept.geometry();
        let (goals, cells): (Vec<Point2>, Vec<Cell>) = old
            .goals
            .iter()
            .filter_map(|&goal| Some((goal, geometry.cell_at(goal)?)))
            .filter(|&(_, cell)| kept.costs().at(cell).is_finite())
            .unzip();
        let mut new = solve_to(&mut self.keeper.desk.0, kept, goals, &cells).ok()?;
        new.occupied = old.occupied.clone();
        self.field = Some(new);
        self.give_back(old);
        Some(FieldRepair { cells: geometry.len(), forgotten: 0, visits: 0, anew: true })
    }

    /// Keeps the memory of a field that nobody else holds.
    pub(super) fn give_back(&mut self, old: WorldField) {
        if let Some(field) = Arc::into_inner(old.field) {
            self.keeper.desk.0.recycle(field);
        }
    }

    /// Without a way to follow: a field to the goal all the same, to see traps by.
    pub(super) fn keep_lookout(&mut self) {
        let Some(Task::Goal { point }) = self.task else { return };
        let position = self.odometry.pose().position();
        let is_kept = self.field.as_ref().is_some_and(|field| {
            field.geometry().cell_at(position).is_some() && field.geometry().cell_at(point).is_some()
        });
        if is_kept || self.price(&[position, point]).is_err() {
            return;
        }
        let Some(kept) = &self.keeper.costs else { return };
        self.field = super::planning::solve(&mut self.keeper.desk.0, kept, &self.body, point).ok();
    }

    /// A new way was walked: what it costs from each waypoint on, and nothing is shut yet.
    pub(super) fn begin_way(&mut self) {
        let field = self.field.as_ref();
        let to_go = |&point: &Point2| field.and_then(|f| f.cost_to_go(point)).unwrap_or(f64::INFINITY);
        self.keeper.to_go = self.waypoints.iter().map(to_go).collect();
        self.keeper.shut_for_s = 0.0;
        self.keeper.cheaper_for_s = 0.0;
        self.keeper.walked_s = 0.0;
    }

    /// Is the way still open, and still about the cheapest? If not, and for long enough, it is walked anew.
    pub(super) fn mind_the_way(&mut self, pose: Pose2, dt_s: f64) -> Minded {
        let Some(field) = &self.field else { return Minded::Stays };
        if self.waypoints.len() < 2 || self.keeper.to_go.len() != self.waypoints.len() {
            return Minded::Stays;
        }
        let config = self.config.keeping;
        let next = self.next_waypoint();
        self.keeper.walked_s += dt_s;
        match field.way_cost(pose.position(), &self.waypoints[next..]) {
            Err(ahead_m) => {
                self.keeper.cheaper_for_s = 0.0;
                self.keeper.shut_for_s += dt_s;
                let shut_for_s = self.keeper.shut_for_s;
                if shut_for_s < config.shut_s || self.keeper.walked_s < config.again_s {
                    return Minded::Stays;
                }
                let before = self.keeper.to_go[next] + pose.position().distance(self.waypoints[next]);
                let now = self.to_go_from(pose);
                let detour = (now - before).max(0.0);
                let cause = Cause::WayShut { ahead_m, detour };
                if detour <= config.short_detour {
                    return self.walk_anew(pose, cause, false);
                }
                // What was doubted is looked at from near before it is believed again.
                let doubted = !now.is_finite() && self.doubts < self.config.doubts;
                let near_m = if doubted { config.look_m } else { config.near_m };
                if ahead_m > near_m || shut_for_s < config.sure_s {
                    return Minded::Stays;
                }
                if now.is_finite() {
                    self.walk_anew(pose, cause, true)
                } else {
                    Minded::NoWay(cause.remedied())
                }
            }
            Ok(way) => {
                self.keeper.shut_for_s = 0.0;
                let best = field.cost_to_go(self.waypoints[next]).unwrap_or(f64::INFINITY);
                let gain = way - best;
                let wanted = config.gain.max(config.gain_share * way);
                let enough = gain >= wanted * f64::from(1u32 << self.keeper.switches.min(16));
                if !enough {
                    self.keeper.cheaper_for_s = 0.0;
                    return Minded::Stays;
                }
                self.keeper.cheaper_for_s += dt_s;
                if self.keeper.cheaper_for_s < config.gain_s {
                    return Minded::Stays;
                }
                self.walk_anew(pose, Cause::CheaperWay { gain }, true)
            }
        }
    }

    fn walk_anew(&mut self, pose: Pose2, cause: Cause, switches: bool) -> Minded {
        if self.walk(pose).is_err() {
            return Minded::Stays;
        }
        if switches {
            self.keeper.switches += 1;
            self.trap.restart_under_way();
        }
        Minded::Walked(cause.remedied())
    }

    /// What is left to pay from the robot, or from the nearest place where something is known of it.
    pub(super) fn to_go_from(&self, pose: Pose2) -> f64 {
        let Some(field) = &self.field else { return f64::INFINITY };
        let here = field.cost_to_go(pose.position()).unwrap_or(f64::INFINITY);
        if here.is_finite() {
            return here;
        }
        field.nearest_with_a_way(pose, &self.profile.footprint, self.config.escape_m).unwrap_or(f64::INFINITY)
    }

    /// The keeper looks after ways in these modes only.
    pub(super) fn is_under_way(&self) -> bool {
        matches!(self.mode, Mode::PathTracking | Mode::ObstacleAvoidance)
    }
}

impl WorldField {
    /// What the way from `position` over `waypoints` costs from the first of these on, or else how far
    /// ahead of the robot it is shut \[m\].
    fn way_cost(&self, position: Point2, waypoints: &[Point2]) -> Result<f64, f64> {
        let geometry = self.geometry();
        let step_m = geometry.resolution_m / 2.0;
        let (mut from, mut ahead_m, mut cost) = (position, 0.0, 0.0);
        for (index, &to) in waypoints.iter().enumerate() {
            let length_m = from.distance(to);
            let steps = (length_m / step_m).ceil().max(1.0);
            let share = length_m / steps;
            for i in 0..steps as usize {
                let point = from + (to - from) * ((i as f64 + 0.5) / steps);
                let price = geometry.cell_at(point).map_or(f32::INFINITY, |cell| self.cost_at(cell));
                let along_m = ahead_m + (i as f64 + 0.5) * share;
                if price.is_finite() {
                    cost += if index == 0 { 0.0 } else { f64::from(price) * share };
                } else if along_m > OWN_MARGIN_M {
                    return Err(along_m);
                }
            }
            ahead_m += length_m;
            from = to;
        }
        Ok(cost)
    }
}

/// Brings `kept` up to date with the map; None if it does not hold the map any more.
fn follow(
    kept: &mut KeptCosts,
    map: &GridGeometry,
    changes: Option<Vec<(Cell, crate::world::Occupancy)>>,
) -> Option<CostChanges> {
    let (down, right) = offset(&kept.geometry(), map)?;
    let moved = |cell: Cell| Cell::new(cell.row + down, cell.col + right);
    Some(kept.update(changes?.into_iter().map(|(cell, seen)| (moved(cell), seen))))
}

/// Rows and columns from the first cell of `outer` to that of `inner`, if it lies inside, cell on cell.
fn offset(outer: &GridGeometry, inner: &GridGeometry) -> Option<(usize, usize)> {
    let corner = outer.world_from_grid.inverse() * inner.world_from_grid;
    let whole = |metres: f64| {
        let cells = metres / outer.resolution_m;
        let fits = (cells - cells.round()).abs() < 1e-6 && cells.round() >= 0.0;
        fits.then_some(cells.round() as usize)
    };
    let same = corner.heading.abs() < 1e-12 && outer.resolution_m == inner.resolution_m;
    let (down, right) = (whole(corner.y)?, whole(corner.x)?);
    let holds = down + inner.rows <= outer.rows && right + inner.cols <= outer.cols;
    (same && holds).then_some((down, right))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_lies_in_another_cell_on_cell_or_not_at_all() {
        let grid = |rows, cols, x, y| GridGeometry {
            rows,
            cols,
            resolution_m: 0.05,
            world_from_grid: Pose2::new(x, y, 0.0),
        };
        let outer = grid(40, 60, -1.0, -0.5);
        assert_eq!(offset(&outer, &grid(10, 20, 0.0, 0.0)), Some((10, 20)));
        assert_eq!(offset(&outer, &outer), Some((0, 0)));
        assert_eq!(offset(&outer, &grid(10, 20, 0.02, 0.0)), None);
        assert_eq!(offset(&outer, &grid(10, 20, -1.05, 0.0)), None);
        assert_eq!(offset(&outer, &grid(40, 60, 0.0, 0.0)), None);
    }
}
