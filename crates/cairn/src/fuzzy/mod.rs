//! Zero-order Sugeno fuzzy systems: named inputs with sets, named outputs with singletons, rules
//! between them; the output is the mean of the singletons weighted by how strongly rules fire.
//!
//! A system is checked once, in [`FuzzySystem::new`]: afterwards some rule always fires, so that
//! evaluation can only be refused for an input that is missing or not a number.

mod config;
mod error;
mod set;
mod system;

#[cfg(test)]
mod laws;

pub use config::{And, AnyOf, FuzzyConfig, FuzzyInput, FuzzyRule, FuzzyTable, Singleton};
pub use error::FuzzyError;
pub use set::FuzzySet;
pub use system::{Evaluation, FuzzySystem};
