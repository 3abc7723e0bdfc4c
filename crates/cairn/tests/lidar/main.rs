//! Driving by lidar where nothing is known beforehand, in worlds of posts with exact geometry.

mod driving;
mod moving;
mod scene;
mod seeing;
#[path = "../support/mod.rs"]
mod support;
