//! Fields of grids whose moves cost one thing there and another back, by the tile solver.

use crate::plan::moves::MOVES;
use crate::plan::solve::{Desk, checked_goals, task};
use crate::plan::tiles::{DirectedGrid, Links, Solved, TileCost, solve};
use crate::plan::{Cost, Field, GridPlanner, PlanError, PlanOptions};
use crate::world::{Cell, Grid, GridGeometry};

use super::link::LinkCost;
use super::links::{AnyTerrainLinks, TerrainLinks, with_links};
use super::model::TerrainModel;
use super::weights::DirectionWeights;

/// Links between neighbouring cells, one by one.
trait SingleLinks {
    /// Bit k: the move with code k out of the cell exists. It ends on the grid.
    fn allowed(&self, index: usize) -> u8;
    /// Cost of a move that exists, > 0.
    fn cost(&self, index: usize, code: usize) -> f32;
}

impl<M: LinkCost> SingleLinks for TerrainLinks<'_, M> {
    fn allowed(&self, index: usize) -> u8 {
        self.allowed[index]
    }
    fn cost(&self, index: usize, code: usize) -> f32 {
        TerrainLinks::cost(self, index, code)
    }
}

struct WeightLinks<'a> {
    weights: &'a DirectionWeights<'a, f32>,
    allowed: Vec<u8>,
}

impl SingleLinks for WeightLinks<'_> {
    fn allowed(&self, index: usize) -> u8 {
        self.allowed[index]
    }
    fn cost(&self, index: usize, code: usize) -> f32 {
        self.weights.plane(code)[index]
    }
}

impl GridPlanner {
    /// As the function [`plan_terrain`](crate::plan::plan_terrain).
    ///
    /// # Errors
    /// As there.
    pub fn plan_terrain(
        &mut self,
        elevation: &Grid<f32>,
        roughness: Option<&Grid<f32>>,
        model: &TerrainModel,
        goals: &[Cell],
        options: &PlanOptions,
    ) -> Result<Field, PlanError> {
        let room = &mut self.terrain;
        let links = AnyTerrainLinks::new_in(room, elevation, roughness, model, options.corner_cutting)?;
        let field = self.plan_links(&elevation.geometry, &links, goals, options);
        links.give_back(&mut self.terrain);
        field
    }

    fn plan_links(
        &mut self,
        geometry: &GridGeometry,
        links: &AnyTerrainLinks<'_>,
        goals: &[Cell],
        options: &PlanOptions,
    ) -> Result<Field, PlanError> {
        with_links!(links, links => {
            let free = |index: usize| !links.is_blocked(index);
            let indices = checked_goals(geometry, goals, options, free)?;
            let solved = solved(&mut self.in_f32, &mut self.codes, geometry, links, &indices, options);
            let codes = match is_sound(solved.largest, links.extremes()) {
                true => solved.codes,
                false => policy(geometry, links, &indices, &solved.values, options)?,
            };
            Ok(Field::new(*geometry, goals, solved.values, 1.0, codes))
        })
    }

    /// As the function [`plan_weights_f32`](crate::plan::plan_weights_f32).
    ///
    /// # Errors
    /// As there.
    pub fn plan_weights_f32(
        &mut self,
        weights: &DirectionWeights<'_, f32>,
        goals: &[Cell],
        options: &PlanOptions,
    ) -> Result<Field, PlanError> {
        let geometry = weights.geometry();
        let indices = checked_goals(geometry, goals, options, |_| true)?;
        let grid = DirectedGrid::<_, f32>::new(weights);
        let solved = solved(&mut self.in_f32, &mut self.codes, geometry, &grid, &indices, options);
        let codes = if is_sound(solved.largest, weights.extremes()) {
            solved.codes
        } else {
            let links = WeightLinks { weights, allowed: weights.allowed() };
            policy(geometry, &links, &indices, &solved.values, options)?
        };
        Ok(Field::new(*geometry, goals, solved.values, 1.0, codes))
    }

    /// As the function [`plan_weights_u32`](crate::plan::plan_weights_u32).
    ///
    /// # Errors
    /// As there.
    pub fn plan_weights_u32(
        &mut self,
        weights: &DirectionWeights<'_, u32>,
        goals: &[Cell],
        options: &PlanOptions,
    ) -> Result<Field, PlanError> {
        let geometry = weights.geometry();
        let indices = checked_goals(geometry, goals, options, |_| true)?;
        let [_, most] = weights.extremes();
        if most < u32::FAR {
            let grid = DirectedGrid::<_, u32>::new(weights);
            let solved = solved(&mut self.in_u32, &mut self.codes, geometry, &grid, &indices, options);
            if solved.largest.sum(most) < u32::FAR {
                return Ok(Field::new(*geometry, goals, solved.values, 1.0, solved.codes));
            }
            self.in_u32.values = solved.values;
            self.codes = solved.codes;
        }
        // 2^32 cells, each left once by a move of less than 2^32, fit in half of u64.
        let grid = DirectedGrid::<_, u64>::new(weights);
        let solved = solved(&mut self.in_u64, &mut self.codes, geometry, &grid, &indices, options);
        if solved.largest < u64::from(u32::MAX) {
            let mut values = std::mem::take(&mut self.in_u32.values);
            values.clear();
            values.extend(solved.values.iter().map(|&value| u32::try_from(value).unwrap_or(u32::MAX)));
            self.in_u64.values = solved.values;
            return Ok(Field::new(*geometry, goals, values, 1.0, solved.codes));
        }
        Ok(Field::new(*geometry, goals, solved.values, 1.0, solved.codes))
    }
}

/// Solves a grid with the memory of `desk`.
fn solved<K: Links>(
    desk: &mut Desk<K::Number>,
    codes: &mut Vec<i8>,
    geometry: &GridGeometry,
    links: &K,
    goals: &[u32],
    options: &PlanOptions,
) -> Solved<K::Number> {
    let task = task(geometry, goals, options);
    let (values, spare) = (std::mem::take(&mut desk.values), std::mem::take(codes));
    solve(&mut desk.room, links, &task, values, spare)
}

/// Whether costs between `least` and `most` add to the numbers of a field, and stayed finite.
///
/// If the cheapest link adds to the largest cost-to-go, every link adds to every one; and if the dearest
/// link still fits, nothing became infinite on the way.
fn is_sound(largest: f32, [least, most]: [f32; 2]) -> bool {
    largest + least > largest && largest + most < f32::INFINITY
}

/// The lowest code whose cell is strictly nearer and gives exactly the cost-to-go, cell by cell.
///
/// # Errors
/// [`PlanError::CostToGoOverflow`], [`PlanError::LinkCostAbsorbed`].
fn policy(
    geometry: &GridGeometry,
    links: &impl SingleLinks,
    goals: &[u32],
    values: &[f32],
    options: &PlanOptions,
) -> Result<Vec<i8>, PlanError> {
    let most = options.start.map_or(f32::INFINITY, |start| values[geometry.index(start)]);
    let precision = f32::NAME;
    let offsets = MOVES.map(|(down, right)| down * geometry.cols as isize + right);
    let mut codes = vec![-1_i8; values.len()];
    for (index, &value) in values.iter().enumerate() {
        let allowed = links.allowed(index);
        let moves = (0..8).filter(|code| allowed >> code & 1 == 1);
        let mut ahead = moves.map(|code| (code, values[index.wrapping_add_signed(offsets[code])]));
        let Cell { row, col } = geometry.cell(index);
        if value == f32::INFINITY {
            // Cells beyond `most` may be left out on purpose.
            if most == f32::INFINITY && ahead.any(|(_, ahead)| ahead < f32::INFINITY) {
                return Err(PlanError::CostToGoOverflow { row, col, precision });
            }
            continue;
        }
        if goals.binary_search(&(index as u32)).is_ok() {
            continue;
        }
        let best = ahead.find(|&(code, ahead)| ahead < value && ahead + links.cost(index, code) == value);
        let Some((code, _)) = best else {
            return Err(PlanError::LinkCostAbsorbed { row, col, cost_to_go: value.to_f64(), precision });
        };
        codes[index] = code as i8;
    }
    Ok(codes)
}
