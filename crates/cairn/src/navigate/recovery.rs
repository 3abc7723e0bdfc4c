//! What went wrong, and what is done about it: chosen by the reason, not one after another.

use serde::Serialize;

use crate::geometry::Point2;

/// Why the robot cannot go on as it did.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "code")]
pub enum Cause {
    /// It is far off its path: it was pushed, or has gone around something.
    OffPath {
        /// How far \[m\].
        off_m: f64,
    },
    /// Something that came since shuts the way.
    WayShut {
        /// How far ahead \[m\].
        ahead_m: f64,
        /// What the way round costs more; infinite if there is none.
        detour: f64,
    },
    /// A way that is much cheaper opened.
    CheaperWay {
        /// By how much.
        gain: f64,
    },
    /// No remaining waypoint is free.
    NoFreeWaypoint,
    /// It came back to where it had been.
    Circling {
        /// Where.
        at: Point2,
    },
    /// Straight on is a dead end: the way by the map is much longer.
    DeadEnd {
        /// By how much \[m\].
        detour_m: f64,
    },
    /// It gains nothing, though it may move.
    NoGain {
        /// For how long \[s\].
        seconds: f64,
    },
    /// Its wheels turn and nothing that it hears comes nearer or goes away.
    WheelsSpin {
        /// How far they turned \[m\].
        spun_m: f64,
    },
    /// Its wheels turn it and the gyroscope sees no turn.
    TurnHeld {
        /// By how much they turned it \[rad\].
        turned_rad: f64,
        /// How far they went meanwhile \[m\].
        path_m: f64,
    },
    /// It stands, though nothing holds it: no motion that it may make from here leads on.
    Wedged {
        /// For how long \[s\].
        seconds: f64,
        /// Pieces of the manoeuvre that leads out.
        legs: u32,
    },
    /// Its wheels stand although they are told to turn.
    WheelsHeld {
        /// For how long \[s\].
        seconds: f64,
    },
    /// Its wheels stand whatever they are told: motors off, an emergency stop.
    MotorsSilent {
        /// For how long \[s\].
        seconds: f64,
    },
}

/// What is done about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Remedy {
    /// Walks the pointers of the repaired field anew from where it is; no stop, no plan.
    WalkAnew,
    /// Stops and plans on the map as it is now.
    PlanAnew,
    /// Drives the manoeuvre that was searched for over place and heading: back off, align, go on.
    Manoeuvre,
    /// Puts what it ran into on the map, backs off and walks the repaired field.
    BackOff,
    /// Stops, waits for the motors, and plans then.
    WaitThenPlan,
}

/// A cause with its remedy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Recovery {
    /// Why.
    pub cause: Cause,
    /// What is done.
    pub remedy: Remedy,
}

impl Cause {
    /// What is to be done about it. Every cause is listed.
    pub fn remedied(self) -> Recovery {
        let remedy = match self {
            Self::OffPath { .. } | Self::CheaperWay { .. } => Remedy::WalkAnew,
            Self::WayShut { detour, .. } if detour.is_finite() => Remedy::WalkAnew,
            Self::WayShut { .. } | Self::NoFreeWaypoint => Remedy::PlanAnew,
            Self::Circling { .. } | Self::DeadEnd { .. } | Self::NoGain { .. } => Remedy::PlanAnew,
            Self::WheelsSpin { .. } | Self::TurnHeld { .. } | Self::WheelsHeld { .. } => Remedy::BackOff,
            Self::Wedged { .. } => Remedy::Manoeuvre,
            Self::MotorsSilent { .. } => Remedy::WaitThenPlan,
        };
        Recovery { cause: self, remedy }
    }

    /// The cause in words, to follow a mode.
    pub(super) fn words(&self) -> String {
        match *self {
            Self::OffPath { off_m } => format!("{off_m:.1} m off the path"),
            Self::WayShut { ahead_m, detour } if detour.is_finite() => {
                format!("the way is shut {ahead_m:.1} m ahead, another one costs {detour:.1} more")
            }
            Self::WayShut { ahead_m, .. } => {
                format!("the way is shut {ahead_m:.1} m ahead and no other leads on")
            }
            Self::CheaperWay { gain } => format!("a way opened that is cheaper by {gain:.1}"),
            Self::NoFreeWaypoint => "no free waypoint remains".to_owned(),
            Self::Circling { at } => {
                format!("was near ({:.2}, {:.2}) m before: going in circles", at.x, at.y)
            }
            Self::DeadEnd { detour_m } => {
                format!("straight on is a dead end: by what is seen the way is {detour_m:.1} m longer")
            }
            Self::NoGain { seconds } => format!("no nearer for {seconds:.1} s: stuck in a local minimum"),
            Self::WheelsSpin { spun_m } => {
                format!(
                    "the wheels have turned {spun_m:.2} m and nothing around came nearer: something holds the robot"
                )
            }
            Self::TurnHeld { turned_rad, .. } => {
                format!(
                    "the wheels have turned {turned_rad:.1} rad and the gyroscope saw none of it: something holds the robot"
                )
            }
            Self::Wedged { seconds, .. } => {
                format!("has hardly moved for {seconds:.1} s: it is too tight to go on as it stands")
            }
            Self::WheelsHeld { seconds } => {
                format!("the wheels have stood for {seconds:.1} s although they should turn")
            }
            Self::MotorsSilent { seconds } => {
                format!(
                    "the wheels have stood for {seconds:.1} s whatever they were told: waiting for the motors"
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_remedy_follows_from_the_cause_and_not_from_what_was_tried_before() {
        let at = Point2::new(1.0, 2.0);
        let expected = [
            (Cause::OffPath { off_m: 1.0 }, Remedy::WalkAnew),
            (Cause::WayShut { ahead_m: 1.0, detour: 9.0 }, Remedy::WalkAnew),
            (Cause::WayShut { ahead_m: 1.0, detour: f64::INFINITY }, Remedy::PlanAnew),
            (Cause::CheaperWay { gain: 4.0 }, Remedy::WalkAnew),
            (Cause::NoFreeWaypoint, Remedy::PlanAnew),
            (Cause::Circling { at }, Remedy::PlanAnew),
            (Cause::DeadEnd { detour_m: 6.0 }, Remedy::PlanAnew),
            (Cause::NoGain { seconds: 8.0 }, Remedy::PlanAnew),
            (Cause::Wedged { seconds: 2.0, legs: 3 }, Remedy::Manoeuvre),
            (Cause::WheelsSpin { spun_m: 0.4 }, Remedy::BackOff),
            (Cause::TurnHeld { turned_rad: 0.6, path_m: 0.1 }, Remedy::BackOff),
            (Cause::WheelsHeld { seconds: 2.0 }, Remedy::BackOff),
            (Cause::MotorsSilent { seconds: 3.0 }, Remedy::WaitThenPlan),
        ];
        for (cause, remedy) in expected {
            assert_eq!(cause.remedied(), Recovery { cause, remedy });
        }
    }
}
