//! Exact cost-to-go and policy: the paper's layered engines [Maalouf06 §3] and the production solver.

mod cost;
mod error;
mod field;
mod moves;
mod solve;

pub use cost::Cost;
pub use error::PlanError;
pub use field::{Field, Values};
pub use moves::MOVES;
pub use solve::{PlanOptions, Steps, plan_costs_f32, plan_costs_f64, plan_free};
