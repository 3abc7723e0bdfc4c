//! Waypoints, look-ahead curvature and the path tracker `[Maalouf06 §4]`.

mod error;
mod lookahead;
mod tracker;
mod waypoints;

#[cfg(test)]
mod simulation;

pub use error::TrackError;
pub use lookahead::LookAhead;
pub use tracker::{Cap, Tracker, TrackerConfig, TrackingRecord};
pub use waypoints::{WaypointConfig, Waypoints};
