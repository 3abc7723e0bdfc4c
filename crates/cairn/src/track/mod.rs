//! Waypoints, look-ahead curvature and the path tracker `[Maalouf06 §4]`.

mod aim;
mod deviation;
mod error;
mod lookahead;
mod prediction;
mod rehearsal;
mod tracker;
mod waypoints;

#[cfg(test)]
mod simulation;

pub use deviation::{Deviation, deviations};
pub use error::TrackError;
pub use lookahead::LookAhead;
pub use rehearsal::{Moment, Stage, rehearse};
pub use tracker::{Cap, Tracker, TrackerConfig, TrackingRecord};
pub use waypoints::{WaypointConfig, Waypoints};
