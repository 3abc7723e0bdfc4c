use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::guided::GuidedConfig;
use super::moving::MovingConfig;
use super::record::Weights;
use crate::geometry::{Point2, Twist2};
use crate::robot::outside;

/// What outline is swept along the arcs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// The paper's round robot: the circumscribed disc of the footprint.
    Disc,
    /// The box itself, exact on every arc; passes gaps that the disc cannot.
    Footprint,
}

/// Settings of the curvature velocity method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CvmConfig {
    /// a1 of (7): how much speed is worth.
    pub speed_weight: f64,
    /// a2 of (7): how much free arc length is worth.
    pub distance_weight: f64,
    /// a3 of (7): how much heading for the goal is worth. The three weights sum to 1.
    pub heading_weight: f64,
    /// L of (7): no arc is judged farther than this \[m\].
    pub horizon_m: f64,
    /// T_c of (7): the heading is judged after turning for this long \[s\].
    pub heading_time_s: f64,
    /// Outline swept along the arcs.
    pub shape: Shape,
    /// Radius of what an obstacle point stands for: half the diagonal of a map cell \[m\].
    pub obstacle_radius_m: f64,
    /// Distance kept from every obstacle on top of that \[m\].
    pub margin_m: f64,
    /// Room kept ahead when stopping, so that the box can still turn in place \[m\].
    pub turning_room_m: f64,
    /// Tightest arc \[1/m\]; sharper turns are made in place.
    pub max_curvature_per_m: f64,
    /// Widest piece of curvatures that shares one distance \[1/m\].
    pub curvature_step_per_m: f64,
    /// From a command to the motion that follows it \[s\].
    pub latency_s: f64,
    /// Least speed of a forward arc \[m/s\].
    pub min_speed_mps: f64,
    /// Forward arcs shorter than this are not free (unless the goal is nearer): turn instead \[m\].
    pub turn_below_m: f64,
    /// While turning in place, drive on only along an arc at least this long \[m\].
    pub resume_above_m: f64,
    /// Greatest rate of turning in place \[rad/s\].
    pub turn_rate_radps: f64,
    /// Speed when leaving the grown outline of an obstacle \[m/s\].
    pub leaving_speed_mps: f64,
    /// May run back when no forward arc is free and there is no room to turn (not in the paper).
    pub back_out: bool,
    /// Greatest speed when running back \[m/s\].
    pub backing_speed_mps: f64,
    /// Kept off every obstacle when leaving or backing out, on top of its radius \[m\].
    pub least_clearance_m: f64,
    /// Greatest speed close to an obstacle \[m/s\].
    pub near_speed_mps: f64,
    /// The speed may be greater by the clearance divided by this \[s\].
    pub clearance_time_s: f64,
    /// May back out of an obstacle's grown outline when nothing else gains clearance.
    pub reverse_to_leave: bool,
    /// How arcs are judged where a cost-to-go field guides.
    pub guided: GuidedConfig,
    /// How motions are chosen beside things that move.
    pub moving: MovingConfig,
}

impl Default for CvmConfig {
    fn default() -> Self {
        Self {
            speed_weight: 0.2,
            distance_weight: 0.3,
            heading_weight: 0.5,
            horizon_m: 3.0,
            heading_time_s: 1.0,
            shape: Shape::Footprint,
            obstacle_radius_m: 0.0354,
            margin_m: 0.03,
            turning_room_m: 0.1,
            max_curvature_per_m: 3.0,
            curvature_step_per_m: 0.05,
            latency_s: 0.1,
            min_speed_mps: 0.1,
            turn_below_m: 0.35,
            resume_above_m: 0.7,
            turn_rate_radps: 0.8,
            leaving_speed_mps: 0.1,
            back_out: true,
            backing_speed_mps: 0.15,
            least_clearance_m: 0.02,
            near_speed_mps: 0.25,
            clearance_time_s: 1.2,
            reverse_to_leave: false,
            guided: GuidedConfig::default(),
            moving: MovingConfig::default(),
        }
    }
}

/// What is wrong with the settings or the inputs of the curvature velocity method.
#[derive(Clone, Debug, PartialEq, Error, Serialize)]
pub enum AvoidError {
    /// A setting is outside its range.
    #[error("avoidance: {key} is {value}, must be a finite number in [{least}, {most}]")]
    AvoidanceValueOutOfRange {
        /// Name of the setting.
        key: String,
        /// What it is.
        value: f64,
        /// Inclusive lower bound.
        least: f64,
        /// Inclusive upper bound.
        most: f64,
    },
    /// The weights of (7) do not sum to one.
    #[error(
        "avoidance: speed_weight {speed_weight} + distance_weight {distance_weight} + heading_weight \
         {heading_weight} must sum to 1"
    )]
    AvoidanceWeightsNotOne {
        /// a1.
        speed_weight: f64,
        /// a2.
        distance_weight: f64,
        /// a3.
        heading_weight: f64,
    },
    /// An obstacle has a coordinate that is not a number.
    #[error("avoidance: obstacle {index} is ({x_m}, {y_m}) m in the robot frame, must be finite")]
    AvoidanceObstacleNotFinite {
        /// Which obstacle.
        index: usize,
        /// Forward \[m\].
        x_m: f64,
        /// Left \[m\].
        y_m: f64,
    },
    /// Another input is not a usable number.
    #[error("avoidance: {what} is {value}, must be {wanted}")]
    AvoidanceInputInvalid {
        /// Name of the input.
        what: String,
        /// What it is.
        value: f64,
        /// What would be right.
        wanted: String,
    },
}

impl CvmConfig {
    /// The weights of (7).
    pub fn weights(&self) -> Weights {
        let Self { speed_weight: speed, distance_weight: distance, heading_weight: heading, .. } = *self;
        Weights { speed, distance, heading }
    }

    /// Checks every number once.
    ///
    /// # Errors
    /// The first setting that is outside its range, or weights that do not sum to one.
    pub fn validated(self) -> Result<Self, AvoidError> {
        const TINY: f64 = 1e-3;
        let mut bounds = vec![
            ("speed_weight", self.speed_weight, 0.0, 1.0),
            ("distance_weight", self.distance_weight, 0.0, 1.0),
            ("heading_weight", self.heading_weight, 0.0, 1.0),
            ("horizon_m", self.horizon_m, 0.1, 100.0),
            ("heading_time_s", self.heading_time_s, TINY, 100.0),
            ("obstacle_radius_m", self.obstacle_radius_m, 0.0, 10.0),
            ("margin_m", self.margin_m, 0.0, 10.0),
            ("turning_room_m", self.turning_room_m, 0.0, 10.0),
            ("max_curvature_per_m", self.max_curvature_per_m, 0.1, 50.0),
            ("curvature_step_per_m", self.curvature_step_per_m, TINY, 0.5),
            ("latency_s", self.latency_s, 0.0, 10.0),
            ("min_speed_mps", self.min_speed_mps, TINY, 10.0),
            ("turn_below_m", self.turn_below_m, 0.0, 100.0),
            ("resume_above_m", self.resume_above_m, self.turn_below_m, 100.0),
            ("turn_rate_radps", self.turn_rate_radps, TINY, 100.0),
            ("leaving_speed_mps", self.leaving_speed_mps, TINY, 10.0),
            ("backing_speed_mps", self.backing_speed_mps, TINY, 10.0),
            ("least_clearance_m", self.least_clearance_m, 0.0, 10.0),
            ("near_speed_mps", self.near_speed_mps, TINY, 10.0),
            ("clearance_time_s", self.clearance_time_s, TINY, 1000.0),
        ];
        bounds.extend(self.guided.bounds());
        bounds.extend(self.moving.bounds());
        if let Some((key, value, least, most)) = outside(bounds) {
            let key = key.to_owned();
            return Err(AvoidError::AvoidanceValueOutOfRange { key, value, least, most });
        }
        if (self.speed_weight + self.distance_weight + self.heading_weight - 1.0).abs() > 1e-9 {
            return Err(AvoidError::AvoidanceWeightsNotOne {
                speed_weight: self.speed_weight,
                distance_weight: self.distance_weight,
                heading_weight: self.heading_weight,
            });
        }
        Ok(self)
    }

    /// Distance that the outline is grown by \[m\].
    pub fn growth_m(&self) -> f64 {
        self.obstacle_radius_m + self.margin_m
    }
}

/// Refuses inputs of one choice that are no usable numbers.
pub(super) fn check_inputs(
    current: Twist2,
    goal_bearing_rad: f64,
    goal_distance_m: f64,
    obstacles_in_robot: &[Point2],
    dt_s: f64,
) -> Result<(), AvoidError> {
    let refuse = |what: &str, value: f64, wanted: &str| {
        let (what, wanted) = (what.to_owned(), wanted.to_owned());
        Err(AvoidError::AvoidanceInputInvalid { what, value, wanted })
    };
    for (what, value) in [
        ("current.linear_mps", current.linear_mps),
        ("current.angular_radps", current.angular_radps),
        ("goal_bearing_rad", goal_bearing_rad),
    ] {
        if !value.is_finite() {
            return refuse(what, value, "finite");
        }
    }
    if goal_distance_m.is_nan() || goal_distance_m < 0.0 {
        return refuse("goal_distance_m", goal_distance_m, "at least 0 (infinity: no goal to stop at)");
    }
    if !(dt_s.is_finite() && dt_s > 0.0) {
        return refuse("dt_s", dt_s, "finite and greater than 0");
    }
    match obstacles_in_robot.iter().position(|p| !p.is_finite()) {
        Some(index) => {
            let Point2 { x: x_m, y: y_m } = obstacles_in_robot[index];
            Err(AvoidError::AvoidanceObstacleNotFinite { index, x_m, y_m })
        }
        None => Ok(()),
    }
}
