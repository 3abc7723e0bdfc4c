//! The field of a grid by Dijkstra's algorithm: two queues for integer steps, a heap for float costs.
//!
//! A field is the least fixed point of J(goal) = 0, J(s) = min over neighbours n of c(s, n) + J(n)
//! in the arithmetic of its type, so it does not depend on the order of the work.
//!
//! Arithmetic. Free grids: integers, c = straight or diagonal step. Cost grids: in the precision
//! asked for (T), c = (a + b) · h with a, b the two cells' costs and h = 1/2 for a straight and
//! T(√2/2) for a diagonal move: the sum is rounded, then the product; one rounded add per link,
//! summed from the goal outwards; no fused operations.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use serde::{Deserialize, Serialize};

use super::field::Native;
use super::moves::Moves;
use super::{Cost, Field, PlanError};
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
}

/// The field of a grid whose true cells are free and of unit cost, in integer steps.
///
/// Native values are u32, or u64 where a cost-to-go would not fit.
///
/// # Errors
/// [`PlanError::EmptyGrid`], [`GridTooLarge`](PlanError::GridTooLarge), [`NoGoal`](PlanError::NoGoal),
/// [`GoalOutsideGrid`](PlanError::GoalOutsideGrid), [`GoalBlocked`](PlanError::GoalBlocked),
/// [`NoThreads`](PlanError::NoThreads).
pub fn plan_free(free: &Grid<bool>, goals: &[Cell], options: &PlanOptions) -> Result<Field, PlanError> {
    let goal_indices = checked_goals(&free.geometry, &free.values, goals, options)?;
    let moves = Moves::new(&free.geometry, &free.values, options.corner_cutting);
    let (straight, diagonal) = options.steps.lengths();
    let unit = f64::from(straight);
    if let Some(values) = two_queues(&moves, &goal_indices, [straight, diagonal]) {
        let codes = policy(&free.geometry, &moves, &goal_indices, &values, |_, _, code| {
            [straight, diagonal][code % 2]
        })?;
        return Ok(Field::new(free.geometry, goals, values, unit, codes));
    }
    let steps = [u64::from(straight), u64::from(diagonal)];
    let values = two_queues(&moves, &goal_indices, steps).expect("2^32 cells of 2^11 steps fit in u64");
    let codes = policy(&free.geometry, &moves, &goal_indices, &values, |_, _, code| steps[code % 2])?;
    Ok(Field::new(free.geometry, goals, values, unit, codes))
}

/// The field of a grid of costs per unit length, > 0, infinite where blocked, in single precision.
///
/// # Errors
/// As [`plan_free`]; [`PlanError::CellCostNan`], [`CellCostNegative`](PlanError::CellCostNegative),
/// [`CellCostZero`](PlanError::CellCostZero), each with the first such cell;
/// [`LinkCostAbsorbed`](PlanError::LinkCostAbsorbed) and [`CostToGoOverflow`](PlanError::CostToGoOverflow)
/// where costs differ too much in size for the precision.
pub fn plan_costs_f32(costs: &Grid<f32>, goals: &[Cell], options: &PlanOptions) -> Result<Field, PlanError> {
    plan_costs(costs, goals, options)
}

/// [`plan_costs_f32`] in double precision.
///
/// # Errors
/// As [`plan_costs_f32`].
pub fn plan_costs_f64(costs: &Grid<f64>, goals: &[Cell], options: &PlanOptions) -> Result<Field, PlanError> {
    plan_costs(costs, goals, options)
}

/// Costs that a grid may have: f32 or f64.
pub(super) trait CellCost: Native {
    /// The cost of a move between cells of costs `self` and `other`.
    fn link(self, other: Self, code: usize) -> Self;
}

macro_rules! cell_cost {
    ($type:ident) => {
        impl CellCost for $type {
            #[inline]
            fn link(self, other: Self, code: usize) -> Self {
                const HALF_LENGTH: [$type; 2] = [0.5, std::f64::consts::FRAC_1_SQRT_2 as $type];
                (self + other) * HALF_LENGTH[code % 2]
            }
        }
    };
}
cell_cost!(f32);
cell_cost!(f64);

fn plan_costs<C: CellCost>(
    costs: &Grid<C>,
    goals: &[Cell],
    options: &PlanOptions,
) -> Result<Field, PlanError> {
    let free = free_cells(costs)?;
    let goal_indices = checked_goals(&costs.geometry, &free, goals, options)?;
    let moves = Moves::new(&costs.geometry, &free, options.corner_cutting);
    let link = |from: usize, to: usize, code: usize| costs.values[from].link(costs.values[to], code);
    let values = heap(&moves, &goal_indices, link);
    let codes = policy(&costs.geometry, &moves, &goal_indices, &values, link)?;
    Ok(Field::new(costs.geometry, goals, values, 1.0, codes))
}

/// Which cells of a cost grid may be entered; refuses what is no cost.
pub(super) fn free_cells<C: CellCost>(costs: &Grid<C>) -> Result<Vec<bool>, PlanError> {
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
fn checked_goals(
    geometry: &GridGeometry,
    free: &[bool],
    goals: &[Cell],
    options: &PlanOptions,
) -> Result<Vec<u32>, PlanError> {
    let GridGeometry { rows, cols, .. } = *geometry;
    if options.threads == Some(0) {
        return Err(PlanError::NoThreads);
    }
    if geometry.is_empty() {
        return Err(PlanError::EmptyGrid { rows, cols });
    }
    if free.len() > u32::MAX as usize {
        return Err(PlanError::GridTooLarge { cells: free.len(), most: u32::MAX as usize });
    }
    if goals.is_empty() {
        return Err(PlanError::NoGoal);
    }
    let mut indices = goals
        .iter()
        .map(|&Cell { row, col }| {
            if row >= rows || col >= cols {
                let outside = |value: usize| i64::try_from(value).unwrap_or(i64::MAX);
                return Err(PlanError::GoalOutsideGrid { row: outside(row), col: outside(col), rows, cols });
            }
            let index = row * cols + col;
            if free[index] { Ok(index as u32) } else { Err(PlanError::GoalBlocked { row, col }) }
        })
        .collect::<Result<Vec<_>, _>>()?;
    indices.sort_unstable();
    indices.dedup();
    Ok(indices)
}

/// Dijkstra's algorithm where links have only two lengths: cells leave in the order of their cost, so
/// what enters each queue is in order too, and the cheapest cell is at one of the two heads.
///
/// None if a cost-to-go might not fit the type.
fn two_queues<C: Cost>(moves: &Moves, goals: &[u32], steps: [C; 2]) -> Option<Vec<C>> {
    let mut values = vec![C::UNREACHABLE; moves.len()];
    let mut queues: [VecDeque<(C, u32)>; 2] = Default::default();
    for &goal in goals {
        values[goal as usize] = C::ZERO;
        queues[0].push_back((C::ZERO, goal));
    }
    loop {
        let nearest = match (queues[0].front(), queues[1].front()) {
            (Some(straight), Some(diagonal)) => usize::from(diagonal.0 < straight.0),
            (Some(_), None) => 0,
            (None, Some(_)) => 1,
            (None, None) => return Some(values),
        };
        let Some((value, cell)) = queues[nearest].pop_front() else { continue };
        if values[cell as usize] < value {
            continue; // a nearer way was found meanwhile
        }
        let through = [value.plus(steps[0])?, value.plus(steps[1])?];
        for (code, neighbour) in moves.from(cell as usize) {
            let candidate = through[code % 2];
            if candidate < values[neighbour] {
                values[neighbour] = candidate;
                queues[code % 2].push_back((candidate, neighbour as u32));
            }
        }
    }
}

/// Dijkstra's algorithm; `link(from, to, code)` costs the same both ways.
fn heap<C: Cost>(moves: &Moves, goals: &[u32], link: impl Fn(usize, usize, usize) -> C) -> Vec<C> {
    let mut values = vec![C::UNREACHABLE; moves.len()];
    let mut open = BinaryHeap::new();
    for &goal in goals {
        values[goal as usize] = C::ZERO;
        open.push(Reverse((C::ZERO.key(), goal)));
    }
    while let Some(Reverse((key, cell))) = open.pop() {
        let value = values[cell as usize];
        if value.key() < key {
            continue;
        }
        for (code, neighbour) in moves.from(cell as usize) {
            // A sum that overflows is left out here and refused by `policy`.
            let Some(candidate) = value.plus(link(neighbour, cell as usize, code)) else { continue };
            if candidate < values[neighbour] {
                values[neighbour] = candidate;
                open.push(Reverse((candidate.key(), neighbour as u32)));
            }
        }
    }
    values
}

/// The lowest code whose cell is strictly nearer and gives exactly the cost-to-go; -1 at goals and
/// where there is no way.
fn policy<C: Cost>(
    geometry: &GridGeometry,
    moves: &Moves,
    goals: &[u32],
    values: &[C],
    link: impl Fn(usize, usize, usize) -> C,
) -> Result<Vec<i8>, PlanError> {
    let mut codes = vec![-1_i8; values.len()];
    for (index, &value) in values.iter().enumerate() {
        if value == C::UNREACHABLE {
            if moves.from(index).any(|(_, neighbour)| values[neighbour] < C::UNREACHABLE) {
                let Cell { row, col } = geometry.cell(index);
                return Err(PlanError::CostToGoOverflow { row, col, precision: C::NAME });
            }
            continue;
        }
        let best = moves.from(index).find(|&(code, neighbour)| {
            let ahead = values[neighbour];
            ahead < value && ahead.plus(link(index, neighbour, code)) == Some(value)
        });
        match best {
            Some((code, _)) => codes[index] = code as i8,
            None if goals.binary_search(&(index as u32)).is_ok() => {}
            None => {
                let Cell { row, col } = geometry.cell(index);
                let cost_to_go = value.to_f64();
                return Err(PlanError::LinkCostAbsorbed { row, col, cost_to_go, precision: C::NAME });
            }
        }
    }
    Ok(codes)
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
