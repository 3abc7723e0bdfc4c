//! The policy of a field, cell by cell, with what may be wrong with it named.

use super::moves::Moves;
use super::{Cost, PlanError};
use crate::world::{Cell, GridGeometry};

/// The lowest code whose cell is strictly nearer and gives exactly the cost-to-go; -1 at goals and
/// where there is no way.
pub(super) fn policy<C: Cost>(
    geometry: &GridGeometry,
    moves: &Moves,
    goals: &[u32],
    values: &[C],
    most: C,
    link: impl Fn(usize, usize, usize) -> C,
) -> Result<Vec<i8>, PlanError> {
    let mut codes = vec![-1_i8; values.len()];
    for (index, &value) in values.iter().enumerate() {
        if value == C::UNREACHABLE {
            // Cells beyond `most` may be left out on purpose.
            let reached = |neighbour: usize| values[neighbour] < C::UNREACHABLE && most == C::UNREACHABLE;
            if moves.from(index).any(|(_, neighbour)| reached(neighbour)) {
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
