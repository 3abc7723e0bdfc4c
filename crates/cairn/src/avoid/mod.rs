//! The curvature velocity method `[Simmons96]`, equation (7): obstacle avoidance on arcs.

mod backing;
mod config;
mod contact;
mod cvm;
mod disc;
mod guided;
mod intervals;
mod leaving;
mod moving;
mod objective;
mod record;
mod stopping;
mod turning;

pub use config::{AvoidError, CvmConfig, Shape};
pub use contact::GrownBox;
pub use cvm::Cvm;
pub use disc::{disc_first_contact, tangent_curvatures};
pub use guided::{Guide, GuidedConfig};
pub use intervals::FreeArcs;
pub use moving::{Moving, MovingConfig};
pub use objective::{Objective, Window};
pub use record::{
    ArcInterval, AvoidanceRecord, BrakeReason, Candidate, Guidance, Refusal, Side, Weights, Why,
};

#[cfg(test)]
mod tests;
