//! A drive worked out in advance: the tracker on a robot that obeys `[Maalouf06 (1)]` and its ramp.

use std::collections::VecDeque;

use super::{TrackError, Tracker};
use crate::geometry::{Pose2, Twist2};
use crate::robot::Limits;

/// Longest step of the robot's motion \[s\].
const STEP_S: f64 = 0.01;
/// Clocks are sums of steps; what is due to within this is due \[s\].
const DUE_S: f64 = 1e-7;

/// The robot and the loop of a rehearsal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// From one command to the next \[s\].
    pub tick_s: f64,
    /// From a command to the motion that follows it, in truth \[s\].
    pub latency_s: f64,
    /// Turn rate of the robot as a share of that of its wheels: below 1, it slips more.
    pub turn_share: f64,
    /// It ends after this \[s\].
    pub most_s: f64,
}

/// One tick of a rehearsal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Since the start \[s\].
    pub time_s: f64,
    /// Where the robot stands.
    pub world_from_robot: Pose2,
    /// How it moves.
    pub twist: Twist2,
    /// What it is told.
    pub command: Twist2,
}

/// Drives `tracker` along the path it follows, from rest at `start`, until it has arrived. Many
/// thousand times as fast as the clock: for tuning a controller, or to know how long a path will take.
///
/// # Errors
/// [`TrackError::TimeStepInvalid`] unless the tick is above 0, and [`TrackError::TrackValueOutOfRange`]
/// for a number of the stage that cannot be used.
pub fn rehearse(
    tracker: &mut Tracker,
    limits: &Limits,
    stage: &Stage,
    start: Pose2,
) -> Result<Vec<Moment>, TrackError> {
    for (key, value) in
        [("latency_s", stage.latency_s), ("turn_share", stage.turn_share), ("most_s", stage.most_s)]
    {
        if !(value.is_finite() && value >= 0.0) {
            let must_be = "of at least 0".to_owned();
            return Err(TrackError::TrackValueOutOfRange { key: key.to_owned(), value, must_be });
        }
    }
    let mut moments = Vec::new();
    let mut pending: VecDeque<(f64, Twist2)> = VecDeque::new();
    let (mut pose, mut ramp, mut wanted) = (start, Twist2::ZERO, Twist2::ZERO);
    let slipping = |twist: Twist2| Twist2::new(twist.linear_mps, twist.angular_radps * stage.turn_share);
    let mut time_s = 0.0;
    while time_s < stage.most_s {
        let twist = slipping(ramp);
        let record = tracker.try_step(pose, twist, stage.tick_s)?;
        moments.push(Moment { time_s, world_from_robot: pose, twist, command: record.twist });
        if record.arrived {
            break;
        }
        pending.push_back((time_s + stage.latency_s, record.twist));
        let steps = (stage.tick_s / STEP_S - 1e-9).ceil();
        let step_s = stage.tick_s / steps;
        for step in 0..steps as usize {
            let now_s = time_s + step as f64 * step_s;
            while pending.front().is_some_and(|(due_s, _)| *due_s <= now_s + DUE_S) {
                wanted = pending.pop_front().map_or(wanted, |(_, twist)| twist);
            }
            ramp = limits.reachable(ramp, wanted, step_s);
            pose = pose.moved(slipping(ramp), step_s);
        }
        time_s += stage.tick_s;
    }
    Ok(moments)
}
