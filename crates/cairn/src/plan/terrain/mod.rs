//! Planning over terrain: what a move costs depends on how far it rises, so there and back differ.

mod exp2;
mod link;
mod links;
mod model;
mod path;
mod planner;
mod rows;
mod surface;
mod weights;

use super::{Field, GridPlanner, PlanError, PlanOptions};
use crate::world::{Cell, Grid};

pub use exp2::exp2;
pub use link::{LinkCost, P3atEnergyLinks, P3atTimeLinks, ToblerLinks};
pub use links::{AnyTerrainLinks, TerrainLinks, TerrainRoom};
pub use model::{P3at, TerrainModel, Tobler};
pub use path::terrain_path_cost;
pub use rows::DirectedRows;
pub use surface::roughness_of;
pub use weights::{DirectionWeights, plan_weights_f32, plan_weights_u32};

/// The field of an elevation grid \[m\], NaN where there is no data, in the unit of `model`: joules or seconds.
///
/// Cells are squares with the resolution of `elevation` as side. Roughness (see [`roughness_of`], which is used
/// without one) makes moves dearer; NaN is no data there too. Cells without data are blocked; which moves the
/// others allow is a matter of the model's limits on climb, descent, roll and roughness, and of the corner rule.
///
/// The least fixed point of J(goal) = 0, J(n) = min over moves n -> m of c(n, m) + J(m) \[Bellman57\], each c one
/// f32 as [`LinkCost`] gives it, one rounded add per move, summed from the goal.
///
/// # Errors
/// As [`AnyTerrainLinks::new`]; [`PlanError::EmptyGrid`], [`GridTooLarge`](PlanError::GridTooLarge),
/// [`NoGoal`](PlanError::NoGoal), [`GoalOutsideGrid`](PlanError::GoalOutsideGrid),
/// [`GoalBlocked`](PlanError::GoalBlocked), [`NoThreads`](PlanError::NoThreads),
/// [`SimdNotAvailable`](PlanError::SimdNotAvailable), [`StartOutsideGrid`](PlanError::StartOutsideGrid);
/// [`LinkCostAbsorbed`](PlanError::LinkCostAbsorbed), [`CostToGoOverflow`](PlanError::CostToGoOverflow).
pub fn plan_terrain(
    elevation: &Grid<f32>,
    roughness: Option<&Grid<f32>>,
    model: &TerrainModel,
    goals: &[Cell],
    options: &PlanOptions,
) -> Result<Field, PlanError> {
    GridPlanner::default().plan_terrain(elevation, roughness, model, goals, options)
}
