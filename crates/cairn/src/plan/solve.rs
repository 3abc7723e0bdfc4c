//! The field of a grid: what is planned on is checked, solved in tiles, and checked again.
//!
//! A field is the least fixed point of J(goal) = 0, J(s) = min over neighbours n of c(s, n) + J(n)
//! in the arithmetic of its type, so it does not depend on the order of the work.
//!
//! Arithmetic. Free grids: integers, c = straight or diagonal step. Cost grids: in the precision
//! asked for (T), c = (a + b) · h with a, b the two cells' costs and h = 1/2 for a straight and
//! T(√2/2) for a diagonal move: the sum is rounded, then the product; one rounded add per link,
//! summed from the goal outwards; no fused operations.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::field::Native;
use super::moves::Moves;
use super::policy::policy;
use super::terrain::TerrainRoom;
use super::tiles::{CellNumber, FreeBits, FreeGrid, MeanGrid, Room, Simd, Solved, Task, TileCost, solve};
use super::update::{Basis, CostBasis, HasBasis};
use super::{Field, PlanError, Values};
use crate::world::{Cell, Grid, GridGeometry};

/// Integer lengths of a straight and a diagonal move on free grids.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Steps {
    /// 985 and 1393: √2 within 2.6e-7.
    #[default]
    #[serde(rename = "985/1393")]
    Fine,
    /// 100 and 141, the costs of [Maalouf06 Fig. 12].
    #[serde(rename = "100/141")]
    Paper,
}

impl Steps {
    /// (straight, diagonal).
    pub fn lengths(self) -> (u32, u32) {
        match self {
            Self::Fine => (985, 1393),
            Self::Paper => (100, 141),
        }
    }
}

/// How to plan on a grid.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlanOptions {
    /// Whether a diagonal move may pass between blocked cells. If not, both cells beside it must be free.
    pub corner_cutting: bool,
    /// Integer steps of free grids.
    pub steps: Steps,
    /// Most threads to use; None leaves it to the solver. The result does not depend on it.
    pub threads: Option<usize>,
    /// Instructions to use; None is the widest there are. The result does not depend on it.
    pub simd: Option<Simd>,
    /// The one cell whose way is wanted: cells farther from the goals than it are left out of the field,
    /// as if they had no way, which saves the work on them.
    pub start: Option<Cell>,
}

/// The field of a grid whose true cells are free and of unit cost, in integer steps.
///
/// Native values are u32, or u64 where a cost-to-go would not fit.
///
/// # Errors
/// [`PlanError::EmptyGrid`], [`GridTooLarge`](PlanError::GridTooLarge), [`NoGoal`](PlanError::NoGoal),
/// [`GoalOutsideGrid`](PlanError::GoalOutsideGrid), [`GoalBlocked`](PlanError::GoalBlocked),
/// [`StartOutsideGrid`](PlanError::StartOutsideGrid), [`NoThreads`](PlanError::NoThreads),
/// [`SimdNotAvailable`](PlanError::SimdNotAvailable).
pub fn plan_free(free: &Grid<bool>, goals: &[Cell], options: &PlanOptions) -> Result<Field, PlanError> {
    GridPlanner::default().plan_free(free, goals, options)
}

/// The field of a grid of costs per unit length, > 0, infinite where blocked, in single precision.
///
/// # Errors
/// As [`plan_free`]; [`PlanError::CellCostNan`], [`CellCostNegative`](PlanError::CellCostNegative),
/// [`CellCostZero`](PlanError::CellCostZero), each with the first such cell;
/// [`LinkCostAbsorbed`](PlanError::LinkCostAbsorbed) and [`CostToGoOverflow`](PlanError::CostToGoOverflow)
/// where costs differ too much in size for the precision.
///
/// The field keeps the grid, for [`Field::update`]; a borrowed one is copied.
pub fn plan_costs_f32(
    costs: impl ShareGrid<f32>,
    goals: &[Cell],
    options: &PlanOptions,
) -> Result<Field, PlanError> {
    GridPlanner::default().plan_costs_f32(costs, goals, options)
}

/// [`plan_costs_f32`] in double precision.
///
/// # Errors
/// As [`plan_costs_f32`].
pub fn plan_costs_f64(
    costs: impl ShareGrid<f64>,
    goals: &[Cell],
    options: &PlanOptions,
) -> Result<Field, PlanError> {
    GridPlanner::default().plan_costs_f64(costs, goals, options)
}

/// A grid to be kept: borrowed (then it is copied), given away, or shared.
pub trait ShareGrid<T> {
    /// The grid, shared.
    fn share(self) -> Arc<Grid<T>>;
}

impl<T: Clone> ShareGrid<T> for &Grid<T> {
    fn share(self) -> Arc<Grid<T>> {
        Arc::new(self.clone())
    }
}
impl<T> ShareGrid<T> for Grid<T> {
    fn share(self) -> Arc<Grid<T>> {
        Arc::new(self)
    }
}
impl<T> ShareGrid<T> for Arc<Grid<T>> {
    fn share(self) -> Arc<Grid<T>> {
        self
    }
}

/// Plans on grids one after the other with the same memory.
///
/// A planner's first field pays for fresh memory, up to three times the solution itself; later ones of
/// no larger grids do not, and not for their own arrays either if old fields are given back.
#[derive(Debug, Default)]
pub struct GridPlanner {
    pub(super) free: FreeBits,
    pub(super) in_u32: Desk<u32>,
    pub(super) in_u64: Desk<u64>,
    pub(super) in_f32: Desk<f32>,
    pub(super) in_f64: Desk<f64>,
    pub(super) codes: Vec<i8>,
    pub(super) terrain: TerrainRoom,
}

/// Room and spare arrays of one number type.
#[derive(Debug, Default)]
pub struct Desk<T: TileCost> {
    pub(super) room: Room<T>,
    pub(super) values: Vec<T>,
    costs: Vec<T>,
}

impl<T: TileCost> Desk<T> {
    fn copied(&mut self, geometry: GridGeometry, costs: &[T]) -> Grid<T> {
        let mut copy = std::mem::take(&mut self.costs);
        copy.clear();
        copy.extend_from_slice(costs);
        Grid::new(geometry, copy)
    }

    /// Keeps the memory of a grid that nobody else holds.
    fn keep_costs(&mut self, costs: Arc<Grid<T>>) {
        if let Some(grid) = Arc::into_inner(costs) {
            self.costs = grid.values;
        }
    }
}

impl GridPlanner {
    /// As the function [`plan_free`].
    ///
    /// # Errors
    /// As [`plan_free`].
    pub fn plan_free(
        &mut self,
        free: &Grid<bool>,
        goals: &[Cell],
        options: &PlanOptions,
    ) -> Result<Field, PlanError> {
        self.plan_free_cells(free.geometry, &free.values, goals, options)
    }

    /// As [`plan_free`](Self::plan_free), from cells in memory of somebody else's, row-major.
    ///
    /// # Errors
    /// As [`plan_free`].
    ///
    /// # Panics
    /// If there are not as many cells as the geometry says.
    pub fn plan_free_cells(
        &mut self,
        geometry: GridGeometry,
        free: &[bool],
        goals: &[Cell],
        options: &PlanOptions,
    ) -> Result<Field, PlanError> {
        let GridGeometry { rows, cols, .. } = geometry;
        assert_eq!(free.len(), rows * cols, "one value per cell");
        checked_goals(&geometry, goals, options, |index| free[index])?;
        let mut bits = std::mem::take(&mut self.free);
        bits.pack(rows, cols, free);
        Ok(self.plan_bits(bits, geometry, goals, options))
    }

    /// A grid of costs copied into memory of this planner's.
    ///
    /// # Panics
    /// If there are not as many costs as the geometry says.
    pub fn copied_f32(&mut self, geometry: GridGeometry, costs: &[f32]) -> Grid<f32> {
        self.in_f32.copied(geometry, costs)
    }

    /// A grid of costs copied into memory of this planner's.
    ///
    /// # Panics
    /// If there are not as many costs as the geometry says.
    pub fn copied_f64(&mut self, geometry: GridGeometry, costs: &[f64]) -> Grid<f64> {
        self.in_f64.copied(geometry, costs)
    }

    /// Keeps the memory of a grid for the next one copied.
    pub fn keep_f32(&mut self, grid: Grid<f32>) {
        self.in_f32.costs = grid.values;
    }

    /// The field of free cells, where goals and options were found right.
    pub(super) fn plan_bits(
        &mut self,
        bits: FreeBits,
        geometry: GridGeometry,
        goals: &[Cell],
        options: &PlanOptions,
    ) -> Field {
        let indices = goal_indices(&geometry, goals);
        let (straight, diagonal) = options.steps.lengths();
        let unit = f64::from(straight);
        let task = task(&geometry, &indices, options);
        let narrow = in_steps(&mut self.in_u32, &mut self.codes, &bits, [straight, diagonal], &task, options);
        if let Some(solved) = narrow {
            let basis = Basis::Free { bits, options: options.clone(), work: solved.work };
            return Field::new(geometry, goals, solved.values, unit, solved.codes).on(basis);
        }
        let steps = [u64::from(straight), u64::from(diagonal)];
        let solved = in_steps(&mut self.in_u64, &mut self.codes, &bits, steps, &task, options)
            .expect("2^32 cells of 2^11 steps fit in u64");
        let basis = Basis::Free { bits, options: options.clone(), work: solved.work };
        Field::new(geometry, goals, solved.values, unit, solved.codes).on(basis)
    }

    /// As the function [`plan_costs_f32`].
    ///
    /// # Errors
    /// As [`plan_costs_f32`].
    pub fn plan_costs_f32(
        &mut self,
        costs: impl ShareGrid<f32>,
        goals: &[Cell],
        options: &PlanOptions,
    ) -> Result<Field, PlanError> {
        self.plan_shared_f32(costs.share(), goals, options)
    }

    // Apart, and the same whoever shares the costs: compiled once, not in every crate that plans.
    fn plan_shared_f32(
        &mut self,
        costs: Arc<Grid<f32>>,
        goals: &[Cell],
        options: &PlanOptions,
    ) -> Result<Field, PlanError> {
        plan_costs(&mut self.in_f32, &mut self.codes, costs, goals, options)
    }

    /// As the function [`plan_costs_f64`].
    ///
    /// # Errors
    /// As [`plan_costs_f32`].
    pub fn plan_costs_f64(
        &mut self,
        costs: impl ShareGrid<f64>,
        goals: &[Cell],
        options: &PlanOptions,
    ) -> Result<Field, PlanError> {
        self.plan_shared_f64(costs.share(), goals, options)
    }

    // Apart, and the same whoever shares the costs: compiled once, not in every crate that plans.
    fn plan_shared_f64(
        &mut self,
        costs: Arc<Grid<f64>>,
        goals: &[Cell],
        options: &PlanOptions,
    ) -> Result<Field, PlanError> {
        plan_costs(&mut self.in_f64, &mut self.codes, costs, goals, options)
    }

    /// Takes a field's arrays for the next one.
    pub fn recycle(&mut self, field: Field) {
        let (values, codes, basis) = field.into_arrays();
        self.keep_arrays(values, codes);
        match basis {
            Basis::Free { bits, .. } => self.free = bits,
            Basis::F32(basis) => self.in_f32.keep_costs(basis.costs),
            Basis::F64(basis) => self.in_f64.keep_costs(basis.costs),
            Basis::None => {}
        }
    }

    /// Keeps arrays for the next field.
    pub(super) fn keep_arrays(&mut self, values: Values, codes: Vec<i8>) {
        match values {
            Values::U32(values) => self.in_u32.values = values,
            Values::U64(values) => self.in_u64.values = values,
            Values::F32(values) => self.in_f32.values = values,
            Values::F64(values) => self.in_f64.values = values,
        }
        self.codes = codes;
    }
}

/// Grids of fewer cells are planned by one thread if it is left to the solver.
const CELLS_WORTH_THREADS: usize = 1 << 18;

pub(super) fn task<'a>(geometry: &GridGeometry, goals: &'a [u32], options: &PlanOptions) -> Task<'a> {
    let GridGeometry { rows, cols, .. } = *geometry;
    let threads = options.threads.unwrap_or_else(|| {
        let many = rows * cols >= CELLS_WORTH_THREADS;
        if many { std::thread::available_parallelism().map_or(1, usize::from) } else { 1 }
    });
    let start = options.start.map(|start| geometry.index(start) as u32);
    let most = rows.div_ceil(64); // more threads than rows of tiles would stand in each other's way
    Task {
        rows,
        cols,
        goals,
        start,
        threads: threads.min(most),
        simd: options.simd.unwrap_or_else(Simd::widest),
    }
}

/// The field of a free grid in integers; None where one might be too large for the type.
fn in_steps<T: TileCost>(
    desk: &mut Desk<T>,
    codes: &mut Vec<i8>,
    free: &FreeBits,
    [straight, diagonal]: [T; 2],
    task: &Task<'_>,
    options: &PlanOptions,
) -> Option<Solved<T>> {
    let (values, spare) = (std::mem::take(&mut desk.values), std::mem::take(codes));
    let solved = if options.corner_cutting {
        let links = FreeGrid::<T, true> { free, straight, diagonal };
        solve(&mut desk.room, &links, task, values, spare)
    } else {
        let links = FreeGrid::<T, false> { free, straight, diagonal };
        solve(&mut desk.room, &links, task, values, spare)
    };
    if solved.largest.sum(diagonal) < T::FAR {
        return Some(solved);
    }
    *codes = solved.codes;
    None
}

pub(super) fn plan_costs<T: CellNumber + Native + HasBasis>(
    desk: &mut Desk<T>,
    codes: &mut Vec<i8>,
    costs: Arc<Grid<T>>,
    goals: &[Cell],
    options: &PlanOptions,
) -> Result<Field, PlanError> {
    let [least, most] = checked_costs(&costs)?;
    let free = |index: usize| costs.values[index] < T::UNREACHABLE;
    let goal_indices = checked_goals(&costs.geometry, goals, options, free)?;
    let GridGeometry { rows, cols, .. } = costs.geometry;
    let task = task(&costs.geometry, &goal_indices, options);
    let (values, spare) = (std::mem::take(&mut desk.values), std::mem::take(codes));
    let solved = if options.corner_cutting {
        let links = MeanGrid::<T, true> { costs: &costs.values, rows, cols };
        solve(&mut desk.room, &links, &task, values, spare)
    } else {
        let links = MeanGrid::<T, false> { costs: &costs.values, rows, cols };
        solve(&mut desk.room, &links, &task, values, spare)
    };
    let mut codes = solved.codes;
    let safe = is_safe(solved.largest, [least, most]);
    if !safe {
        let free: Vec<bool> = (0..costs.values.len()).map(free).collect();
        let moves = Moves::new(&costs.geometry, &free, options.corner_cutting);
        let link =
            |from: usize, to: usize, code: usize| costs.values[from].link(costs.values[to], code % 2 == 1);
        let most = task.start.map_or(T::UNREACHABLE, |start| solved.values[start as usize]);
        codes = policy(&costs.geometry, &moves, &goal_indices, &solved.values, most, link)?;
    }
    let (geometry, work) = (costs.geometry, solved.work);
    let basis = T::basis(CostBasis { costs, options: options.clone(), range: [least, most], safe, work });
    Ok(Field::new(geometry, goals, solved.values, 1.0, codes).on(basis))
}

/// Whether no sum on the way to costs-to-go up to `largest` lost a link or went beyond the type: if the
/// cheapest link adds to the largest, every link adds to every one, and if the dearest link still fits,
/// nothing became infinite.
pub(super) fn is_safe<T: CellNumber>(largest: T, [least, most]: [T; 2]) -> bool {
    largest.sum(least.link(least, false)) > largest && largest.sum(most.link(most, true)) < T::UNREACHABLE
}

/// The least and the largest finite cost of a grid; refuses what is no cost.
fn checked_costs<T: CellNumber>(costs: &Grid<T>) -> Result<[T; 2], PlanError> {
    let mut all_positive = true;
    let (mut least, mut most) = (T::UNREACHABLE, T::ZERO);
    for &cost in &costs.values {
        all_positive &= cost > T::ZERO; // not so for NaN
        least = if cost < least { cost } else { least };
        let finite = if cost < T::UNREACHABLE { cost } else { T::ZERO };
        most = if finite > most { finite } else { most };
    }
    if all_positive { Ok([least, most]) } else { free_cells(costs).map(|_| [least, most]) }
}

/// Which cells of a cost grid may be entered; refuses what is no cost.
pub(super) fn free_cells<C: CellNumber>(costs: &Grid<C>) -> Result<Vec<bool>, PlanError> {
    let mut free = Vec::with_capacity(costs.values.len());
    for (index, &cost) in costs.values.iter().enumerate() {
        let refused = cost.is_nan() || cost <= C::ZERO;
        if refused {
            let Cell { row, col } = costs.geometry.cell(index);
            let value = cost.to_f64();
            return Err(if cost.is_nan() {
                PlanError::CellCostNan { row, col, value }
            } else if cost < C::ZERO {
                PlanError::CellCostNegative { row, col, value }
            } else {
                PlanError::CellCostZero { row, col, value }
            });
        }
        free.push(cost < C::UNREACHABLE);
    }
    Ok(free)
}

/// The row-major indices of the goals, ascending, each once.
pub(super) fn checked_goals(
    geometry: &GridGeometry,
    goals: &[Cell],
    options: &PlanOptions,
    free: impl Fn(usize) -> bool,
) -> Result<Vec<u32>, PlanError> {
    let GridGeometry { rows, cols, .. } = *geometry;
    if options.threads == Some(0) {
        return Err(PlanError::NoThreads);
    }
    if geometry.is_empty() {
        return Err(PlanError::EmptyGrid { rows, cols });
    }
    if rows * cols > u32::MAX as usize {
        return Err(PlanError::GridTooLarge { cells: rows * cols, most: u32::MAX as usize });
    }
    if goals.is_empty() {
        return Err(PlanError::NoGoal);
    }
    if let Some(simd) = options.simd.filter(|simd| !simd.is_available()) {
        return Err(PlanError::SimdNotAvailable { simd, widest: Simd::widest() });
    }
    if let Some(Cell { row, col }) = options.start.filter(|start| start.row >= rows || start.col >= cols) {
        return Err(PlanError::StartOutsideGrid { row: row as i64, col: col as i64, rows, cols });
    }
    let mut indices = goals
        .iter()
        .map(|&Cell { row, col }| {
            if row >= rows || col >= cols {
                let outside = |value: usize| i64::try_from(value).unwrap_or(i64::MAX);
                return Err(PlanError::GoalOutsideGrid { row: outside(row), col: outside(col), rows, cols });
            }
            let index = row * cols + col;
            if free(index) { Ok(index as u32) } else { Err(PlanError::GoalBlocked { row, col }) }
        })
        .collect::<Result<Vec<_>, _>>()?;
    indices.sort_unstable();
    indices.dedup();
    Ok(indices)
}

/// The row-major indices of goals that were checked.
fn goal_indices(geometry: &GridGeometry, goals: &[Cell]) -> Vec<u32> {
    goals.iter().map(|&goal| geometry.index(goal) as u32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose2;

    fn grid<T>(rows: usize, cols: usize, values: Vec<T>) -> Grid<T> {
        Grid::new(GridGeometry { rows, cols, resolution_m: 1.0, world_from_grid: Pose2::IDENTITY }, values)
    }

    #[test]
    fn cost_to_go_is_the_octile_distance_on_an_open_grid() {
        let free = grid(9, 13, vec![true; 9 * 13]);
        let field = plan_free(&free, &[Cell::new(4, 6)], &PlanOptions::default()).unwrap();
        for row in 0..9_usize {
            for col in 0..13_usize {
                let (down, right) = (row.abs_diff(4), col.abs_diff(6));
                let steps = 1393 * down.min(right) + 985 * down.abs_diff(right);
                assert_eq!(field.cost_to_go(Cell::new(row, col)), steps as f64 / 985.0);
            }
        }
    }

    #[test]
    fn a_field_too_long_for_u32_is_solved_in_u64() {
        // A serpentine corridor of about 4.5 million cells.
        let (rows, cols) = (3001, 3001);
        let free = (0..rows * cols)
            .map(|i| {
                let (row, col) = (i / cols, i % cols);
                row % 2 == 0 || col == if row % 4 == 1 { cols - 1 } else { 0 }
            })
            .collect();
        let field = plan_free(&grid(rows, cols, free), &[Cell::new(0, 0)], &PlanOptions::default()).unwrap();
        let length = (1501 * 3000 + 3000) as f64;
        assert_eq!(field.cost_to_go(Cell::new(3000, 3000)), length);
        assert!(matches!(field.native(), super::super::Values::U64(_)));
    }

    #[test]
    fn costs_that_vanish_beside_the_cost_to_go_are_refused_in_f32_and_planned_in_f64() {
        let costs = grid(1, 4, vec![1e9_f32, 1e9, 1.0, 1.0]);
        let error = plan_costs_f32(&costs, &[Cell::new(0, 0)], &PlanOptions::default()).unwrap_err();
        assert!(matches!(error, PlanError::LinkCostAbsorbed { row: 0, col: 3, .. }), "{error}");
        let costs = grid(1, 4, vec![1e9_f64, 1e9, 1.0, 1.0]);
        assert!(plan_costs_f64(&costs, &[Cell::new(0, 0)], &PlanOptions::default()).is_ok());
    }

    #[test]
    fn a_cost_to_go_beyond_the_type_is_refused_not_called_unreachable() {
        let costs = grid(1, 4, vec![3e38_f32, 1.0, 3e38, 1.0]);
        let error = plan_costs_f32(&costs, &[Cell::new(0, 0)], &PlanOptions::default()).unwrap_err();
        assert!(matches!(error, PlanError::CostToGoOverflow { row: 0, col: 3, .. }), "{error}");
    }
}
