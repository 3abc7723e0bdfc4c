//! What entering a mode changes; plans, and the way walked down their fields.

use super::navigator::Navigator;
use super::planning::{Planner, Refusal, WorldField, padded};
use super::record::{PlanRecord, Task, TaskStatus};
use super::strategy::{Mode, Reason};
use super::way::length_m;
use crate::geometry::{Point2, Pose2};
use crate::track::Waypoints;
use crate::world::OccupancyGrid;

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
            Reason::RegionVisitedTwice | Reason::LocalMinimum | Reason::NoFreeWaypoint if entered => {
                self.plan_wanted = true;
                self.field = None;
                self.shared = false;
            }
            Reason::NoMapOrPose if entered => {
                self.intermediate = None;
                self.trap.restart();
            }
            Reason::PathFound if entered => self.trap.restart(),
            Reason::WayClear if entered => {
                if let Some(index) = self.intermediate.take() {
                    self.tracker.set_index(index);
                }
            }
            _ => {}
        }
        if mode == Mode::Stop {
            self.intermediate = None;
        }
        if entered {
            self.nearest = None;
        }
        (mode == Mode::PathPlanning && entered).then(|| self.plan())
    }

    /// Solves a field, or takes the shared one, and walks it from where the robot is.
    pub(super) fn plan(&mut self) -> PlanRecord {
        let shared = self.field.is_some() && self.shared;
        let mut result = self.solve_and_walk();
        let mut doubted = false;
        if matches!(result, Err(Refusal::NoPath | Refusal::GoalBlocked { .. })) && self.doubts > 0 {
            let forgotten = self.map.forget_unmapped(self.odometry.pose().position(), self.config.doubt_m);
            if forgotten > 0 {
                self.doubts -= 1;
                doubted = true;
                result = self.solve_and_walk();
            }
        }
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
        self.field = Some(self.solve_or_share()?);
        self.walk(self.odometry.pose())
    }

    fn solve_or_share(&mut self) -> Result<WorldField, Refusal> {
        if let (Some(field), true) = (&self.field, self.shared) {
            return Ok(field.clone());
        }
        let pose = self.odometry.pose();
        let moved = self.planned_at.is_none_or(|last| last.distance(pose.position()) >= FRUITLESS_M);
        self.fruitless = if moved { 0 } else { self.fruitless + 1 };
        self.planned_at = Some(pose.position());
        if self.fruitless >= self.config.fruitless_plans {
            return Err(Refusal::NoProgress { plans: self.fruitless + 1 });
        }
        self.plan_count += 1;
        let on_given_map = self.map_given && self.pose_known;
        let planner = Planner {
            footprint: self.body,
            config: &self.config.costmap,
            escape_m: self.config.escape_m,
            ground: self.ground.as_deref().filter(|_| on_given_map),
        };
        match self.task {
            Some(Task::Goal { point }) => {
                let occupancy = self.map_around(&[pose.position(), point]);
                planner.solve(&occupancy, point)
            }
            _ => planner.solve_frontiers(&self.map_around(&[pose.position()]), pose.position()),
        }
    }

    /// The map as it is now; with none given, it reaches at least a margin around `points`.
    pub(super) fn map_around(&self, points: &[Point2]) -> OccupancyGrid {
        let occupancy = self.map.occupancy();
        if self.map_given && self.pose_known {
            return occupancy;
        }
        padded(&occupancy, points, self.config.open_margin_m)
    }

    /// Walks the field from `pose` and hands the waypoints to the tracker.
    pub(super) fn walk(&mut self, pose: Pose2) -> Result<(), Refusal> {
        let Some(field) = &self.field else { return Err(Refusal::NoPath) };
        let path = field.path(pose, &self.profile.footprint, self.config.escape_m)?;
        let waypoints = Waypoints::from_path(&path, &self.config.waypoints, |a, b| field.is_clear(a, b))
            .map_err(|_| Refusal::NoPath)?;
        self.path = path;
        self.waypoints = waypoints.points().to_vec();
        self.tracker.follow(waypoints);
        Ok(())
    }

    /// Far off the path: the pointers of the field are walked anew, without a new plan.
    pub(super) fn rewalk_if_off_path(&mut self, pose: Pose2) -> bool {
        let position = pose.position();
        let index = self.tracker.index();
        let around = index.saturating_sub(3)..(index + 4).min(self.waypoints.len());
        let off_m = self.waypoints[around]
            .windows(2)
            .map(|pair| position.distance_to_segment(pair[0], pair[1]))
            .fold(f64::INFINITY, f64::min);
        let off = self.waypoints.len() > 1 && off_m > self.config.off_path_m;
        off && self.walk(pose).is_ok()
    }
}
