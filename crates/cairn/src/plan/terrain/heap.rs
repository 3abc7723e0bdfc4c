//! Dijkstra's algorithm from the goals over links that cost one thing there and another back.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::plan::moves::MOVES;
use crate::plan::{Cost, PlanError};
use crate::world::{Cell, GridGeometry};

/// Links between neighbouring cells, each way with a cost of its own.
pub(super) trait DirectedLinks<C> {
    fn geometry(&self) -> &GridGeometry;
    /// Bit k: the move with code k out of the cell exists. It ends on the grid.
    fn allowed(&self, index: usize) -> u8;
    /// Cost of a move that exists, > 0.
    fn cost(&self, index: usize, code: usize) -> C;
}

/// A grid without cells is no grid to plan on.
pub(super) fn refuse_empty(geometry: &GridGeometry) -> Result<(), PlanError> {
    let GridGeometry { rows, cols, .. } = *geometry;
    if geometry.is_empty() { Err(PlanError::EmptyGrid { rows, cols }) } else { Ok(()) }
}

/// Row-major indices of the goals, ascending, each once; `blocked(index)` goals are refused.
pub(super) fn checked_goals(
    geometry: &GridGeometry,
    goals: &[Cell],
    threads: Option<usize>,
    blocked: impl Fn(usize) -> bool,
) -> Result<Vec<u32>, PlanError> {
    let GridGeometry { rows, cols, .. } = *geometry;
    if threads == Some(0) {
        return Err(PlanError::NoThreads);
    }
    if geometry.len() > u32::MAX as usize {
        return Err(PlanError::GridTooLarge { cells: geometry.len(), most: u32::MAX as usize });
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
            if blocked(index) { Err(PlanError::GoalBlocked { row, col }) } else { Ok(index as u32) }
        })
        .collect::<Result<Vec<_>, _>>()?;
    indices.sort_unstable();
    indices.dedup();
    Ok(indices)
}

/// J(goal) = 0, J(n) = min over moves n -> m of c(n, m) + J(m) [Bellman57], and the policy: the lowest code whose
/// cell is strictly nearer and gives exactly J(n).
///
/// # Errors
/// [`PlanError::CostToGoOverflow`], [`PlanError::LinkCostAbsorbed`].
pub(super) fn solve<C: Cost>(
    links: &impl DirectedLinks<C>,
    goals: &[u32],
) -> Result<(Vec<C>, Vec<i8>), PlanError> {
    let geometry = links.geometry();
    let (rows, cols) = (geometry.rows as isize, geometry.cols as isize);
    let mut values = vec![C::UNREACHABLE; geometry.len()];
    let mut open = BinaryHeap::new();
    for &goal in goals {
        values[goal as usize] = C::ZERO;
        open.push(Reverse((C::ZERO.key(), goal)));
    }
    while let Some(Reverse((key, to))) = open.pop() {
        let value = values[to as usize];
        if value.key() < key {
            continue; // a nearer way was found meanwhile
        }
        let (row, col) = (to as isize / cols, to as isize % cols);
        for (code, (down, right)) in MOVES.into_iter().enumerate() {
            let (row, col) = (row - down, col - right);
            if !(0..rows).contains(&row) || !(0..cols).contains(&col) {
                continue;
            }
            let from = (row * cols + col) as usize;
            if links.allowed(from) >> code & 1 == 0 {
                continue;
            }
            // A sum that overflows is left out here and refused below.
            let Some(candidate) = value.plus(links.cost(from, code)) else { continue };
            if candidate < values[from] {
                values[from] = candidate;
                open.push(Reverse((candidate.key(), from as u32)));
            }
        }
    }
    let codes = policy(links, goals, &values)?;
    Ok((values, codes))
}

fn policy<C: Cost>(links: &impl DirectedLinks<C>, goals: &[u32], values: &[C]) -> Result<Vec<i8>, PlanError> {
    let geometry = links.geometry();
    let offsets = MOVES.map(|(down, right)| down * geometry.cols as isize + right);
    let mut codes = vec![-1_i8; values.len()];
    for (index, &value) in values.iter().enumerate() {
        let allowed = links.allowed(index);
        let moves = (0..8).filter(|code| allowed >> code & 1 == 1);
        let mut ahead = moves.map(|code| (code, values[index.wrapping_add_signed(offsets[code])]));
        let Cell { row, col } = geometry.cell(index);
        if value == C::UNREACHABLE {
            if ahead.any(|(_, ahead)| ahead < C::UNREACHABLE) {
                return Err(PlanError::CostToGoOverflow { row, col, precision: C::NAME });
            }
            continue;
        }
        if goals.binary_search(&(index as u32)).is_ok() {
            continue;
        }
        let best =
            ahead.find(|&(code, ahead)| ahead < value && ahead.plus(links.cost(index, code)) == Some(value));
        match best {
            Some((code, _)) => codes[index] = code as i8,
            None => {
                let cost_to_go = value.to_f64();
                return Err(PlanError::LinkCostAbsorbed { row, col, cost_to_go, precision: C::NAME });
            }
        }
    }
    Ok(codes)
}
