//! Perception and odometry against rooms made of exact segments, which the brain never sees.

mod mapping;
mod matching;
mod odometry;
mod rooms;
