//! What each mode does in a tick.

use super::caution::{Caution, cautious};
use super::config::HeadBy;
use super::navigator::Navigator;
use super::planning::WorldField;
use super::record::Task;
use super::strategy::Mode;
use crate::avoid::AvoidanceRecord;
use crate::geometry::{Point2, Pose2, Twist2};
use crate::robot::Limits;
use crate::world::Occupancy;

/// How far down the field the robot looks for its heading \[m\].
const AHEAD_M: f64 = 1.5;

impl Navigator {
    /// The curvature velocity method towards the intermediate goal, the goal, or straight on.
    pub(super) fn avoid(&mut self, pose: Pose2, measured: Twist2, dt_s: f64) -> AvoidanceRecord {
        let position = pose.position();
        if let (true, Some(Task::Goal { point }), Some(lidar)) = (self.guided(), self.task, &mut self.lidar) {
            let slip = self.profile.drive.effective_track_m / self.odometry.effective_track_m().0;
            let record = lidar.drive(point, measured, self.commanded, slip, dt_s);
            self.path.clear();
            self.path.push(position);
            self.path.extend(lidar.field().lookouts());
            return record;
        }
        let final_index = self.waypoints.len().saturating_sub(1);
        let (bearing_rad, distance_m) = match (self.intermediate, self.task) {
            (Some(index), _) if index < final_index => {
                (pose.bearing_to(self.waypoints[index]), f64::INFINITY)
            }
            (_, Some(Task::Goal { point })) => (pose.bearing_to(point), position.distance(point)),
            _ => (0.0, f64::INFINITY),
        };
        let bearing_rad = match (self.config.head_by, &self.field) {
            (HeadBy::Field, Some(field)) => {
                down_the_field(field, position).map_or(bearing_rad, |to| pose.bearing_to(to))
            }
            _ => bearing_rad,
        };
        let obstacles = self.obstacles_in_robot(pose);
        let on_known_way = self.intermediate.is_some() && self.map_given && self.pose_known;
        let cvm = if on_known_way { &self.cvm_on_way } else { &self.cvm };
        cvm.choose_after(measured, Some(self.commanded), bearing_rad, distance_m, &obstacles, dt_s)
    }

    /// The field over what the lidar sees guides: towards a goal, with no plan to follow.
    pub(super) fn guided(&self) -> bool {
        let to_goal = matches!(self.task, Some(Task::Goal { .. }));
        let planless = self.mode == Mode::ObstacleAvoidance && self.intermediate.is_none();
        self.lidar.is_some() && to_goal && planless
    }

    /// Centres of the occupied cells that any motion could meet, and what is heard near, robot frame \[m\].
    pub(super) fn obstacles_in_robot(&self, pose: Pose2) -> Vec<Point2> {
        let robot_from_world = pose.inverse().turned();
        let reach_m = self.config.avoidance.horizon_m + self.profile.footprint.circumscribed_radius_m();
        let seen = self.map.occupied_near(pose.position(), reach_m).into_iter();
        seen.chain(self.heard_near()).map(|point| robot_from_world * point).collect()
    }

    /// `twist`, no faster than can be stopped inside what was seen.
    pub(super) fn within_sight(&self, pose: Pose2, twist: Twist2, dt_s: f64) -> (Twist2, Option<Caution>) {
        let Self { config, profile, map, commanded, .. } = self;
        let geometry = map.geometry();
        let is_seen = |point: Point2| {
            geometry.cell_at(point).is_some_and(|c| map.classes()[geometry.index(c)] != Occupancy::Unknown)
        };
        let latency_s = profile.drive.latency_s;
        cautious(
            &config.caution,
            &profile.limits,
            &profile.footprint,
            latency_s,
            is_seen,
            pose,
            *commanded,
            twist,
            dt_s,
        )
    }
}

/// The farthest point down the field from `position` that is seen straight, up to [`AHEAD_M`];
/// None where the field leads nowhere.
pub(super) fn down_the_field(field: &WorldField, position: Point2) -> Option<Point2> {
    let geometry = field.geometry();
    let mut cell = geometry.cell_at(position)?;
    let mut target = None;
    while let Some(next) = field.field.next(cell) {
        let center = geometry.center(next);
        let far = center.distance(position) > AHEAD_M;
        if far || (target.is_some() && !field.is_clear(position, center)) {
            break;
        }
        (cell, target) = (next, Some(center));
    }
    target
}

/// The next command on the way to rest: both speeds fall together, along one curvature, as fast as
/// the slower one can.
pub(super) fn braking(limits: &Limits, commanded: Twist2, dt_s: f64) -> Twist2 {
    let Twist2 { linear_mps, angular_radps } = commanded;
    let left_s = (linear_mps.abs() / limits.linear_mps2).max(angular_radps.abs() / limits.angular_radps2);
    if left_s <= dt_s {
        return Twist2::ZERO;
    }
    let share = 1.0 - dt_s / left_s;
    Twist2::new(linear_mps * share, angular_radps * share)
}
