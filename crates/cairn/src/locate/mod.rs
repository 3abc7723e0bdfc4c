//! Where the robot is: encoders and gyro, and sonar matched to a known map.

mod matching;
mod odometry;

pub use matching::{MapMatcher, MatchReport, MatchingConfig, MatchingError};
pub use odometry::{Odometry, OdometryConfig, OdometryError, WheelTravel};
