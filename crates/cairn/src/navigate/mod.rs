//! Modes and transitions, and the navigator that holds the parts together `[Maalouf06 §6]`.

mod act;
mod backing;
mod caution;
mod config;
mod error;
mod keeping;
mod lidar;
mod local_field;
mod locating;
mod navigator;
mod perceive;
mod planning;
mod plans;
mod record;
mod recovery;
mod stall;
mod strategy;
mod trap;
mod way;

pub use caution::{Caution, CautionConfig};
pub use config::{HeadBy, NavigatorConfig, PathShape, WeightsOnWay};
pub use error::NavigateError;
pub use keeping::{FieldRepair, KeepingConfig};
pub use lidar::{LidarConfig, LidarRecord, LidarSense};
pub use local_field::{LocalField, LocalFieldConfig, SeenField};
pub use navigator::{Navigator, TickInput, TickPart};
pub use planning::{Refusal, WorldField};
pub use record::{BackingRecord, Decision, PlanRecord, Task, TaskStatus};
pub use recovery::{Cause, Recovery, Remedy};
pub use stall::{StallConfig, StallWatch};
pub use strategy::{Event, Mode, PAPER, Reason, Row, Strategy, StrategyError};
pub use trap::{TrapConfig, TrapEvidence, TrapWatch};
pub use way::{Blocked, Look, WayAhead, first_free, look_ahead};
