//! Planning over terrain: what a move costs depends on how far it rises, so there and back differ.

mod exp2;
mod heap;
mod link;
mod links;
mod model;
mod path;
mod rows;
mod surface;
mod weights;

use super::{Field, PlanError, PlanOptions};
use crate::world::{Cell, Grid, GridGeometry};

use heap::{DirectedLinks, checked_goals, solve};
use links::with_links;

pub use exp2::exp2;
pub use link::{LinkCost, P3atEnergyLinks, P3atTimeLinks, ToblerLinks};
pub use links::{AnyTerrainLinks, TerrainLinks};
pub use model::{P3at, TerrainModel, Tobler};
pub use path::terrain_path_cost;
pub use rows::DirectedRows;
pub use surface::roughness_of;
pub use weights::{DirectionWeights, plan_weights_f32, plan_weights_u32};

impl<M: LinkCost> DirectedLinks<f32> for TerrainLinks<'_, M> {
    fn geometry(&self) -> &GridGeometry {
        &self.geometry
    }
    fn allowed(&self, index: usize) -> u8 {
        self.allowed[index]
    }
    fn cost(&self, index: usize, code: usize) -> f32 {
        TerrainLinks::cost(self, index, code)
    }
}

/// The field of an elevation grid \[m\], NaN where there is no data, in the unit of `model`: joules or seconds.
///
/// Cells are squares with the resolution of `elevation` as side. Roughness (see [`roughness_of`], which is used
/// without one) makes moves dearer; NaN is no data there too. Cells without data are blocked; which moves the
/// others allow is a matter of the model's limits on climb, descent, roll and roughness, and of the corner rule.
///
/// The least fixed point of J(goal) = 0, J(n) = min over moves n -> m of c(n, m) + J(m) [Bellman57], each c one
/// f32 as [`LinkCost`] gives it, one rounded add per move, summed from the goal.
///
/// # Errors
/// As [`AnyTerrainLinks::new`]; [`PlanError::EmptyGrid`], [`GridTooLarge`](PlanError::GridTooLarge),
/// [`NoGoal`](PlanError::NoGoal), [`GoalOutsideGrid`](PlanError::GoalOutsideGrid),
/// [`GoalBlocked`](PlanError::GoalBlocked), [`NoThreads`](PlanError::NoThreads);
/// [`LinkCostAbsorbed`](PlanError::LinkCostAbsorbed), [`CostToGoOverflow`](PlanError::CostToGoOverflow).
pub fn plan_terrain(
    elevation: &Grid<f32>,
    roughness: Option<&Grid<f32>>,
    model: &TerrainModel,
    goals: &[Cell],
    options: &PlanOptions,
) -> Result<Field, PlanError> {
    let links = AnyTerrainLinks::new(elevation, roughness, model, options.corner_cutting)?;
    with_links!(&links, links => {
        let indices =
            checked_goals(&elevation.geometry, goals, options.threads, |index| links.is_blocked(index))?;
        let (values, codes) = solve(links, &indices)?;
        Ok(Field::new(elevation.geometry, goals, values, 1.0, codes))
    })
}
