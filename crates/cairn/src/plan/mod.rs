//! Exact cost-to-go and policy: the paper's layered engines [Maalouf06 §3] and the production solver.

mod any_angle;
mod cost;
mod dijkstra;
mod error;
mod field;
mod graph;
pub mod layered;
mod moves;
pub mod peers;

mod policy;
mod search;
mod sight;
mod solve;
pub mod terrain;
mod tiles;
mod update;

pub use any_angle::{Crossed, shortened};
pub use cost::Cost;
pub use dijkstra::{GraphCost, GraphField, plan_graph};
pub use error::PlanError;
pub use field::{Field, Values};
pub use graph::{Graph, graph_of_costs_f32, graph_of_costs_f64, graph_of_free};
pub use layered::{Engine, LayeredOptions, LayeredPlan, Schedule, plan_layered, trace_layered};
pub use moves::MOVES;
pub use sight::{Ground, Sight, Toll, Vertex};
pub use solve::{GridPlanner, PlanOptions, ShareGrid, Steps, plan_costs_f32, plan_costs_f64, plan_free};
pub use terrain::{DirectionWeights, TerrainModel, plan_terrain, plan_weights_f32, plan_weights_u32};
pub use tiles::Simd;
pub use update::{NewCosts, Update};
