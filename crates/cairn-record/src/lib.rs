//! Open logs of runs: MCAP files with ROS 2 messages, the decision record and all inputs.
//!
//! A [`Recorder`] takes values of the brain and hands them to a thread of its own: nothing is
//! serialised, compressed or written where the control loop runs. A [`Log`] reads a file back, also
//! one whose writer was killed.

mod cdr;
mod error;
mod json;
mod reader;
mod recorder;
mod robot;
mod ros;
mod sink;

pub use error::RecordError;
pub use json::to_json;
pub use reader::{Entry, Log};
pub use recorder::{FieldSource, MapSnapshot, Recorder, Step, Tap, Told};
