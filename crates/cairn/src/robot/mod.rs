//! What is known of a robot beforehand: outline, limits, wheels and sensors.

mod profile;

pub(crate) use profile::{Bound, outside};
pub use profile::{Drive, Footprint, Lidar, Limits, ProfileError, RobotProfile, Sonar};
