//! Angles, points, poses and twists in the plane.

mod angle;
mod point;
mod pose;
mod twist;

pub use angle::wrap_angle;
pub use point::Point2;
pub use pose::{Pose2, Turned};
pub use twist::Twist2;
