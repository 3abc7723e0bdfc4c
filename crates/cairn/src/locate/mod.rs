//! Where the robot is: encoders and gyro, and sonar matched to a known map.

mod odometry;

pub use odometry::{Odometry, OdometryConfig, OdometryError, WheelTravel};
