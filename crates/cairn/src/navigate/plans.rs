//! What entering a mode changes; plans, and the way walked down their fields.

use std::sync::Arc;

use super::navigator::Navigator;
use super::planning::{Refusal, WorldField, padded, solve, solve_frontiers};
use super::record::{PlanRecord, Task, TaskStatus};
use super::recovery::{Cause, Recovery};
use super::strategy::{Mode, Reason};
use super::way::length_m;
use crate::geometry::{Point2, Pose2};
use crate::plan::NewCosts;
use crate::track::Waypoints;
use crate::world::{Cell, KeptCosts, OccupancyGrid};

/// A robot that moved less than this since its last plan gained nothing by it \[m\].
const FRUITLESS_M: f64 = 0.3;

impl Navigator {
    /// What changes when `mode` is entered for `reason`.
    pub(super) fn enter(&mut self, mode: Mode, reason: Reason) -> Option<PlanRecord> {
        let entered = mode != self.mode;
        self.mode = mode;
        match reason {
            Reason::Cancelled => {
                self.task = None;
                self.status = TaskStatus::Cancelled;
            }
            Reason::GoalUnattainable if entered => {
                self.task = None;
                if let Some(refusal) = self.last_plan.as_ref().and_then(|plan| plan.refusal) {
                    self.status = TaskStatus::Refused { refusal };
                }
            }
            Reason::Arrived if entered && matches!(self.task, Some(Task::Goal { .. })) => {
                self.task = None;
                self.status = TaskStatus::Reached;
            }
            Reason::Arrived if entered => self.plan_wanted = false,
            Reason::RegionVisitedTwice | Reason::LocalMinimum if entered => {
                self.plan_wanted = true;
                self.drop_field();
            }
            Reason::NoFreeWaypoint if entered => {
                // The field is kept, to see by whether the way opens again.
                self.plan_wanted = true;
                self.shared = false;
                self.waiting_s = self.config.keeping.wait_s;
                self.waiting_for_way = true;
            }
            Reason::NoMapOrPose if entered => {
                self.drop_field();
                self.intermediate = None;
                self.trap.restart();
                if let Some(lidar) = &mut self.lidar {
                    lidar.restart();
                }
            }
            Reason::PathFound if entered => {
                self.tracker.rests();
                self.waiting_for_way = false;
                self.trap.restart();
            }
            Reason::WayClear if entered => {
                if let Some(index) = self.intermediate.take() {
                    self.tracker.set_index(index);
                }
            }
            _ => {}
        }
        if mode == Mode::Stop {
            self.intermediate = None;
            self.backing = None;
        }
        if mode != Mode::ObstacleAvoidance {
            self.manoeuvre = None;
        }
        if matches!(mode, Mode::Stop | Mode::PathPlanning) {
            self.stands.restart();
        }
        if entered {
            self.nearest = None;
            self.unsafe_for_s = 0.0;
        }
        (mode == Mode::PathPlanning && entered).then(|| self.plan())
    }

    /// Solves a field, or takes the shared one, and walks it from where the robot is.
    pub(super) fn plan(&mut self) -> PlanRecord {
        let shared = self.field.is_some() && self.shared;
        let mut result = self.solve_and_walk();
        let mut doubted = false;
        for beyond_m in [self.config.doubt_m, self.config.doubt_near_m] {
            let refused = matches!(
                result,
                Err(Refusal::NoPath
                    | Refusal::StartBlocked
                    | Refusal::GoalBlocked { .. }
                    | Refusal::NoProgress { .. })
            );
            if !refused || self.doubts == 0 {
                break;
            }
            let seen = self.map.forget_unmapped(self.odometry.pose().position(), beyond_m);
            if seen + self.map.forget_felt() > 0 {
                self.fruitless = 0;
                self.planned_at = None;
                result = self.solve_and_walk();
                doubted = result.is_ok();
            }
        }
        self.doubts -= u32::from(doubted);
        if matches!(self.task, Some(Task::Explore)) && result == Err(Refusal::NoPath) {
            result = Err(Refusal::NothingLeftToExplore);
        }
        let refusal = result.as_ref().err().copied();
        if refusal.is_some() {
            self.path.clear();
            self.waypoints.clear();
        }
        self.outcome = Some(result);
        let position = self.odometry.pose().position();
        let record = PlanRecord {
            plan_count: self.plan_count,
            shared,
            doubted,
            cost_to_go: self.field.as_ref().and_then(|field| field.cost_to_go(position)),
            path_length_m: refusal.is_none().then(|| length_m(&self.path)),
            waypoints: self.waypoints.len(),
            refusal,
        };
        self.last_plan = Some(record.clone());
        record
    }

    fn solve_and_walk(&mut self) -> Result<(), Refusal> {
        let field = self.solve_or_share()?;
        if let Some(old) = self.field.replace(field) {
            self.give_back(old);
        }
        self.walk(self.odometry.pose())
    }

    fn solve_or_share(&mut self) -> Result<WorldField, Refusal> {
        if self.shared
            && let Some(field) = self.field.clone()
        {
            return Ok(self.with_own_sight(field));
        }
        let pose = self.odometry.pose();
        let moved = self.planned_at.is_none_or(|last| last.distance(pose.position()) >= FRUITLESS_M);
        self.fruitless = if moved { 0 } else { self.fruitless + 1 };
        self.planned_at = Some(pose.position());
        if self.fruitless >= self.config.fruitless_plans {
            return Err(Refusal::NoProgress { plans: self.fruitless + 1 });
        }
        self.plan_count += 1;
        let points = match self.task {
            Some(Task::Goal { point }) => vec![pose.position(), point],
            _ => vec![pose.position()],
        };
        self.price(&points)?;
        let Some(kept) = &self.keeper.costs else { return Err(Refusal::NoPath) };
        let planner = &mut self.keeper.desk.0;
        match self.task {
            Some(Task::Goal { point }) => solve(planner, kept, &self.body, point),
            _ => solve_frontiers(planner, kept, &self.body, pose.position()),
        }
    }

    /// Another robot's field, with what this one saw that the given map does not show.
    fn with_own_sight(&mut self, mut theirs: WorldField) -> WorldField {
        let Some(prior) = self.map.prior().filter(|_| self.price(&[]).is_ok()) else { return theirs };
        let Some(kept) = self.keeper.costs.as_ref().filter(|kept| kept.geometry() == theirs.geometry())
        else {
            return theirs;
        };
        let unseen = KeptCosts::new(prior, self.body, self.config.costmap, self.ground.clone());
        let Ok(unseen) = unseen else { return theirs };
        let geometry = kept.geometry();
        let goals = theirs.field.goals();
        let (cells, costs): (Vec<Cell>, Vec<f32>) = (0..geometry.len())
            .map(|i| (geometry.cell(i), kept.costs().values[i], unseen.costs().values[i]))
            .filter(|(cell, now, before)| now != before && (now.is_finite() || !goals.contains(cell)))
            .map(|(cell, now, _)| (cell, now))
            .unzip();
        if !cells.is_empty() {
            let field = Arc::make_mut(&mut theirs.field);
            // What cannot be taken over is planned around once it is met.
            let _ = field.update(&cells, NewCosts::F32(&costs), self.config.keeping.give_up);
        }
        theirs
    }

    /// The field is of no use any more.
    pub(super) fn drop_field(&mut self) {
        if let Some(field) = self.field.take() {
            self.give_back(field);
        }
        self.shared = false;
    }

    /// The map as it is now; with none given, it reaches at least a margin around `points`.
    pub(super) fn map_around(&self, points: &[Point2]) -> Result<OccupancyGrid, Refusal> {
        let occupancy = self.map.occupancy();
        if self.map_given && self.pose_known {
            return Ok(occupancy);
        }
        padded(&occupancy, points, self.config.open_margin_m, self.config.mapping.most_cells)
            .ok_or(Refusal::GoalOutsideMap)
    }

    /// Walks the field from `pose` and hands the waypoints to the tracker.
    pub(super) fn walk(&mut self, pose: Pose2) -> Result<(), Refusal> {
        let Some(field) = &self.field else { return Err(Refusal::NoPath) };
        let path = field.path(pose, &self.profile.footprint, self.config.escape_m, self.config.path_shape)?;
        let waypoints = Waypoints::from_path(&path, &self.config.spacing(), |a, b| field.is_clear(a, b))
            .map_err(|_| Refusal::NoPath)?;
        self.path = path;
        self.waypoints = waypoints.points().to_vec();
        self.tracker.follow(waypoints);
        if let (Some(field), Some(kept)) = (&mut self.field, &self.keeper.costs) {
            field.occupied = Arc::new(kept.occupied());
        }
        self.begin_way();
        Ok(())
    }

    /// Far off the path: the pointers of the field are walked anew, without a new plan.
    pub(super) fn rewalk_if_off_path(&mut self, pose: Pose2) -> Option<Recovery> {
        let position = pose.position();
        let index = self.tracker.index();
        let around = index.saturating_sub(3)..(index + 4).min(self.waypoints.len());
        let off_m = self.waypoints[around]
            .windows(2)
            .map(|pair| position.distance_to_segment(pair[0], pair[1]))
            .fold(f64::INFINITY, f64::min);
        let off = self.waypoints.len() > 1 && off_m > self.config.off_path_m;
        (off && self.walk(pose).is_ok()).then(|| Cause::OffPath { off_m }.remedied())
    }
}
