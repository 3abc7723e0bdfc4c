//! The decision record: everything one tick saw, decided and commands. Explanations are read from
//! it, never computed again.

use serde::Serialize;

use super::caution::Caution;
use super::keeping::FieldRepair;
use super::lidar::LidarRecord;
use super::planning::Refusal;
use super::recovery::{Cause, Recovery, Remedy};
use super::strategy::{Event, Mode, Reason};
use super::trap::TrapEvidence;
use super::way::WayAhead;
use crate::avoid::AvoidanceRecord;
use crate::geometry::{Point2, Pose2, Twist2};
use crate::locate::{LocaliseReport, MatchReport};
use crate::robot::Limits;
use crate::track::TrackingRecord;

/// How it stands with what the user asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "code")]
pub enum TaskStatus {
    /// Nothing was asked for yet.
    Idle,
    /// Under way.
    Driving,
    /// The goal is reached.
    Reached,
    /// It cannot be done, and why.
    Refused {
        /// Why.
        refusal: Refusal,
    },
    /// The user cancelled.
    Cancelled,
}

/// What the user asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Task {
    /// Drive to a point of the world.
    Goal {
        /// The point, in the world frame \[m\].
        point: Point2,
    },
    /// See what is unknown.
    Explore,
}

/// A plan made, or taken over, in this tick.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlanRecord {
    /// Plans this navigator has solved itself so far; a shared field counts for its maker.
    pub plan_count: u32,
    /// The field was given with the goal.
    pub shared: bool,
    /// There was no path on the map as seen, so what was seen only from afar was forgotten.
    pub doubted: bool,
    /// Cost-to-go from the robot.
    pub cost_to_go: Option<f64>,
    /// Length of the robot's path \[m\].
    pub path_length_m: Option<f64>,
    /// Number of waypoints.
    pub waypoints: usize,
    /// Why there is none.
    pub refusal: Option<Refusal>,
}

/// Backing off from what holds the robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BackingRecord {
    /// Why.
    pub cause: Cause,
    /// How far it has come \[m\].
    pub moved_m: f64,
    /// How far it goes \[m\].
    pub back_off_m: f64,
}

/// One tick: what was seen, what was decided and why, what is commanded.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Decision {
    /// Number of the tick, from 0.
    pub tick: u64,
    /// Time since the first tick, this one's step included \[s\].
    pub time_s: f64,
    /// Estimated pose, `world_from_robot`.
    pub pose: Pose2,
    /// Covariance of (x, y, heading) \[m², m·rad, rad²\].
    pub covariance: [[f64; 3]; 3],
    /// Measured speeds.
    pub measured: Twist2,
    /// What matching the ranges to the map did to the pose.
    pub matching: Option<MatchReport>,
    /// What is known of the pose on the map, where the robot localises itself.
    pub localisation: Option<LocaliseReport>,
    /// Mode before this tick.
    pub mode_before: Mode,
    /// What was perceived.
    pub event: Event,
    /// Mode now.
    pub mode: Mode,
    /// Why.
    pub reason: Reason,
    /// The same in a sentence, with the values.
    pub sentence: String,
    /// What the user asked for.
    pub task: Option<Task>,
    /// How it stands with it.
    pub status: TaskStatus,
    /// Index of the current waypoint N_i.
    pub waypoint_index: Option<usize>,
    /// The waypoint headed for while avoiding.
    pub intermediate: Option<usize>,
    /// What was seen on the way to the next waypoints.
    pub way: Option<WayAhead>,
    /// What speaks for a trap.
    pub trap: Option<TrapEvidence>,
    /// The path was walked anew from the field, with no new plan; why, says `recovery`.
    pub rewalked: bool,
    /// What went wrong in this tick, and what is done about it.
    pub recovery: Option<Recovery>,
    /// The map had changed, and the field was made right again.
    pub repair: Option<FieldRepair>,
    /// Value of the field under the robot.
    pub cost_to_go: Option<f64>,
    /// The plan made in this tick.
    pub plan: Option<PlanRecord>,
    /// The fuzzy controller's reasoning.
    pub tracking: Option<TrackingRecord>,
    /// The curvature velocity method's reasoning. While tracking: it took this tick's command, because
    /// stopping after the tracker's would have met an obstacle.
    pub avoidance: Option<AvoidanceRecord>,
    /// What the last scan told, where a lidar guides.
    pub lidar: Option<LidarRecord>,
    /// Backing off from what holds the robot gave the command.
    pub backing: Option<BackingRecord>,
    /// The command was slowed because the robot does not see far enough.
    pub caution: Option<Caution>,
    /// Limits in force.
    pub limits: Limits,
    /// The command.
    pub twist: Twist2,
}

/// What a sentence about a transition needs.
pub(super) struct Story<'a> {
    pub mode: Mode,
    pub reason: Reason,
    pub task: Option<Task>,
    pub status: TaskStatus,
    pub way: Option<&'a WayAhead>,
    pub trap: Option<&'a TrapEvidence>,
    pub plan: Option<&'a PlanRecord>,
    pub recovery: Option<&'a Recovery>,
    /// Waiting: for what shuts the way to leave, or else for the motors.
    pub waiting: Option<bool>,
    pub settling: bool,
    pub manoeuvring: bool,
    pub position: Point2,
    pub waypoint_index: Option<usize>,
    pub intermediate: Option<usize>,
}

impl Story<'_> {
    /// Why the way was walked anew in this tick, if it was.
    fn walks_anew(&self) -> Option<String> {
        let recovery = self.recovery.filter(|recovery| recovery.remedy == Remedy::WalkAnew)?;
        Some(format!("{}: the repaired field is walked anew from here", recovery.cause.words()))
    }

    /// The manoeuvre that begins in this tick, if one does.
    fn manoeuvres(&self) -> Option<String> {
        let recovery = self.recovery.filter(|recovery| recovery.remedy == Remedy::Manoeuvre)?;
        let Cause::Wedged { legs, .. } = recovery.cause else { return None };
        Some(format!("{}; manoeuvring out in {legs} legs", recovery.cause.words()))
    }

    /// Mode and reason in words a person would use.
    pub fn sentence(&self) -> String {
        let destination = match self.task {
            Some(Task::Goal { point }) => format!("({:.2}, {:.2}) m", point.x, point.y),
            Some(Task::Explore) => "what is unknown".to_owned(),
            None => "nowhere".to_owned(),
        };
        let blocked = || match self.way.and_then(|way| way.blocked) {
            Some(seen) => format!(
                "something the plan did not know at ({:.2}, {:.2}) m stands {:.2} m from the way to waypoint {}",
                seen.obstacle.x, seen.obstacle.y, seen.distance_m, seen.waypoint
            ),
            None => "something the plan did not know stands on the way".to_owned(),
        };
        let head = match self.reason {
            Reason::ObstacleOnPath | Reason::Avoiding if self.manoeuvres().is_some() => {
                self.manoeuvres().unwrap_or_default()
            }
            Reason::Avoiding if self.manoeuvring => "manoeuvring out of a tight place".to_owned(),
            Reason::FollowingPath | Reason::Avoiding if self.walks_anew().is_some() => {
                self.walks_anew().unwrap_or_default()
            }
            Reason::Waiting if self.task.is_none() => "waiting for a command".to_owned(),
            Reason::Waiting if self.settling => {
                "standing still until the gyroscope's bias is known well enough to drive without a map"
                    .to_owned()
            }
            Reason::Waiting if self.waiting == Some(true) => {
                "waiting for what shuts the way to leave".to_owned()
            }
            Reason::Waiting if self.waiting == Some(false) => "waiting for the motors".to_owned(),
            Reason::Waiting => "coming to rest".to_owned(),
            Reason::TaskAccepted => format!("asked for {destination}: beginning at rest"),
            Reason::NewTaskWhileMoving => format!("asked for {destination} while moving: first to rest"),
            Reason::Cancelled => "cancelled".to_owned(),
            Reason::MapAndPoseKnown => {
                format!("the map and the place in it are known: planning to {destination}")
            }
            Reason::NoMapOrPose => {
                format!("no map to plan on: heading for {destination} and mapping on the way")
            }
            Reason::Planning => "planning".to_owned(),
            Reason::PathFound => match self.plan.and_then(|plan| plan.path_length_m) {
                Some(length_m) => format!("a path of {length_m:.1} m to {destination} was found"),
                None => format!("a path to {destination} was found"),
            },
            Reason::GoalUnattainable => match self.status {
                TaskStatus::Refused { refusal } => format!("cannot be reached: {refusal}"),
                _ => "the goal cannot be reached".to_owned(),
            },
            Reason::FollowingPath => match self.waypoint_index {
                Some(index) => format!("the way is clear, following it from waypoint {index}"),
                None => "the way is clear".to_owned(),
            },
            Reason::ObstacleOnPath => match self.intermediate {
                Some(index) => format!("{}; heading for waypoint {index} beyond it", blocked()),
                None => blocked(),
            },
            Reason::NoFreeWaypoint => {
                format!("{} and no free waypoint remains: a new plan is needed", blocked())
            }
            Reason::Avoiding => match self.intermediate {
                Some(index) => format!("going around what stands on the way, towards waypoint {index}"),
                None => format!("heading for {destination} around what is seen"),
            },
            Reason::WayClear => "the way is clear again".to_owned(),
            Reason::Arrived => match self.status {
                TaskStatus::Reached => "arrived".to_owned(),
                _ => "arrived where the unknown begins".to_owned(),
            },
            Reason::RegionVisitedTwice => match self.trap.and_then(|trap| trap.revisited) {
                Some(place) => format!(
                    "was near ({:.2}, {:.2}) m before: going in circles, a new plan is needed",
                    place.x, place.y
                ),
                None => "going in circles: a new plan is needed".to_owned(),
            },
            Reason::Stalled => match self.recovery {
                Some(recovery) => format!("{}: backing off from it", recovery.cause.words()),
                None => "something unseen holds the robot: backing off".to_owned(),
            },
            Reason::LocalMinimum
                if self.recovery.is_some_and(|r| !matches!(r.cause, Cause::NoGain { .. })) =>
            {
                let why = self.recovery.map(|recovery| recovery.cause.words()).unwrap_or_default();
                format!("{why}, at ({:.2}, {:.2}) m; a new plan is needed", self.position.x, self.position.y)
            }
            Reason::LocalMinimum => match self.trap {
                Some(trap) => format!(
                    "no nearer for {:.1} s at ({:.2}, {:.2}) m: stuck in a local minimum, a new plan is needed",
                    trap.without_progress_s, self.position.x, self.position.y
                ),
                None => "stuck in a local minimum: a new plan is needed".to_owned(),
            },
        };
        let mode = match self.mode {
            Mode::Stop => "Stop",
            Mode::PathPlanning => "Path planning",
            Mode::PathTracking => "Path tracking",
            Mode::ObstacleAvoidance => "Obstacle avoidance",
        };
        format!("{mode}: {head}.")
    }
}
