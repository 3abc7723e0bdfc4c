use serde::Serialize;

use super::objective::Window;
use crate::geometry::Twist2;

/// Arcs of neighbouring curvatures that share one free length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ArcInterval {
    /// Rightmost arc \[1/m\], left positive.
    pub curvature_lo: f64,
    /// Leftmost arc \[1/m\].
    pub curvature_hi: f64,
    /// Free length of every arc between them, at most the horizon \[m\].
    pub distance_m: f64,
}

/// The best motion of one interval, scored by (7).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Candidate {
    /// The motion.
    pub twist: Twist2,
    /// Which of the record's intervals it belongs to.
    pub interval: usize,
    /// First term of (7), without its weight.
    pub speed: f64,
    /// Second term of (7), without its weight.
    pub distance: f64,
    /// Third term of (7), without its weight.
    pub heading: f64,
    /// The weighted sum.
    pub total: f64,
    /// Why it may not be driven, if it may not.
    pub refused: Option<Refusal>,
}

/// Why a candidate was not driven although it scored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Refusal {
    /// The interval's free length is too short to drive on; turning is better.
    TooShort,
    /// Changing over to it and then stopping would meet an obstacle.
    StoppingMeetsObstacle,
}

/// A side of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Counter-clockwise.
    Left,
    /// Clockwise.
    Right,
}

/// Why the robot brakes.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum BrakeReason {
    /// No forward arc is free; it must be at rest before it turns in place.
    StopsToTurn,
    /// A turn has found a free arc; the rotation must slow before it can be driven.
    EndsTurn,
    /// Every reachable motion is too fast to stop before what lies on its arc.
    TooFast,
    /// No forward arc is free and there is no room to turn.
    NoRoomToTurn,
    /// No forward arc is free and no heading is better than the present one.
    NothingFree,
    /// An obstacle is within the margin and no motion gains clearance.
    CannotGainClearance,
    /// The goal is under the robot.
    AtGoal,
    /// An input is not a usable number.
    InputRefused {
        /// What is wrong with it.
        message: String,
    },
}

/// What kind of motion was chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Why {
    /// The best-scored motion along a free arc.
    BestArc,
    /// No forward arc is free, or the goal is far to the side: turns on the spot.
    TurningInPlace {
        /// Which way.
        direction: Side,
        /// The heading it turns to, seen from the present one \[rad\].
        to_heading_rad: f64,
    },
    /// An obstacle is within the margin: moves so as to gain clearance.
    LeavingObstacle {
        /// Distance between footprint and nearest obstacle point now \[m\].
        clearance_m: f64,
    },
    /// Something moves nearby: the best of whole manoeuvres followed in time beside it.
    GivingWay {
        /// How many things move.
        things: usize,
        /// When it would be touched all the same, if it would \[s\].
        touches_s: Option<f64>,
        /// Least distance to any of them on the way \[m\].
        nearest_m: f64,
    },
    /// No forward arc is free and there is no room to turn: runs back to where there is.
    BackingOut {
        /// How far to the place where it can turn \[m\].
        to_room_m: f64,
        /// How far back the body runs clear \[m\].
        clear_m: f64,
    },
    /// Brakes as hard as allowed.
    Braking {
        /// Why.
        reason: BrakeReason,
    },
}

/// What a field said when it guided a choice.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Guidance {
    /// Time to the goal from where the robot is when the command takes effect \[s\].
    pub to_go_s: f64,
    /// The margin could not be kept; only the touch was kept off.
    pub tight: bool,
    /// Moving things that were looked ahead for.
    pub moving: usize,
}

/// a1, a2 and a3 of (7).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Weights {
    /// Of the speed.
    pub speed: f64,
    /// Of the free length.
    pub distance: f64,
    /// Of the heading.
    pub heading: f64,
}

/// One choice of the curvature velocity method, with everything it was made from.
///
/// `intervals` are the merged, disjoint intervals of curvature from right to left; neighbours with
/// the same free length are one. `candidates` holds the best motion of each interval that has a
/// reachable, stoppable one: at most one per interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AvoidanceRecord {
    /// Speeds reachable within this tick.
    pub window: Window,
    /// θ_g: direction of the goal in the robot frame \[rad\].
    pub goal_bearing_rad: f64,
    /// Distance to the goal \[m\].
    pub goal_distance_m: f64,
    /// Distance between footprint and nearest obstacle point \[m\]; infinite without obstacles.
    pub clearance_m: f64,
    /// What the terms of a candidate count for in its total.
    pub weights: Weights,
    /// What the field said, if one guided: then every candidate's total is minus the time to the goal \[s\].
    pub guided: Option<Guidance>,
    /// Merged intervals of curvature and their free lengths.
    pub intervals: Vec<ArcInterval>,
    /// Best motion of each interval.
    pub candidates: Vec<Candidate>,
    /// The candidate that is driven, if one is.
    pub chosen: Option<usize>,
    /// The motion to drive.
    pub twist: Twist2,
    /// Why that one.
    pub why: Why,
}
