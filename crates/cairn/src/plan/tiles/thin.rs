//! Long thin grids, of which tiles would be mostly margin: Dijkstra's algorithm, cell by cell.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::SIDE;
use super::lanes::TileCost;
use super::run::{Solved, Task};
use super::visit::Links;
use crate::plan::Cost;
use crate::plan::moves::MOVES;

/// Grids whose tiles hold this many times the grid's own cells are thin.
const MARGIN: usize = 8;
/// Grids whose tiles hold fewer cells are not worth a thought.
const SMALL: usize = 1 << 18;

/// Whether a grid is better not cut into tiles.
pub fn is_thin(rows: usize, cols: usize) -> bool {
    let padded = rows.next_multiple_of(SIDE) * cols.next_multiple_of(SIDE);
    padded > SMALL && padded > MARGIN * rows * cols
}

/// The same field as the tiles give.
pub fn solve_thin<K: Links>(
    links: &K,
    task: &Task<'_>,
    mut values: Vec<K::Number>,
    mut codes: Vec<i8>,
) -> Solved<K::Number> {
    let Task { rows, cols, .. } = *task;
    let (zero, far, unreachable) = (K::Number::ZERO, K::Number::FAR, K::Number::UNREACHABLE);
    values.clear();
    values.resize(rows * cols, far);
    codes.clear();
    codes.resize(rows * cols, -1);
    let beside = |index: usize, code: usize| {
        let (down, right) = MOVES[code];
        let row = (index / cols).checked_add_signed(down).filter(|&row| row < rows)?;
        let col = (index % cols).checked_add_signed(right).filter(|&col| col < cols)?;
        Some((row, col))
    };
    let mut open = BinaryHeap::new();
    for &goal in task.goals {
        values[goal as usize] = zero;
        open.push(Reverse((zero.key(), goal)));
    }
    let start = task.start.map(|start| start as usize);
    while let Some(Reverse((key, index))) = open.pop() {
        let value = values[index as usize];
        if value.key() < key {
            continue;
        }
        if start.is_some_and(|start| values[start] < value) {
            break;
        }
        for code in 0..8 {
            let Some((row, col)) = beside(index as usize, code) else { continue };
            let offered = value.sum(links.cost(row, col, (code + 4) % 8)); // from there to here
            let there = row * cols + col;
            if offered < values[there] {
                values[there] = offered;
                open.push(Reverse((offered.key(), there as u32)));
            }
        }
    }
    let most = start.map_or(far, |start| values[start]);
    let mut largest = zero;
    for index in 0..rows * cols {
        let value = values[index];
        if value == far || value > most {
            continue;
        }
        largest = if value > largest { value } else { largest };
        let on_the_way = |&code: &usize| {
            let Some((row, col)) = beside(index, code) else { return false };
            values[row * cols + col].sum(links.cost(index / cols, index % cols, code)) == value
        };
        codes[index] = (0..8).find(on_the_way).map_or(-1, |code| code as i8);
    }
    for value in &mut values {
        if *value == far || *value > most {
            *value = unreachable;
        }
    }
    Solved { values, codes, largest, work: 0 }
}
