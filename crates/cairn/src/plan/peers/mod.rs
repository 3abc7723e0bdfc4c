//! Plain planners to measure the production solver against: Dial's buckets and a binary heap.
//!
//! Both are Dijkstra's algorithm \[Dijkstra59\], written as well as they can be while staying plain:
//! flat arrays that are used again, one ring of blocked cells so that no edge is tested, one bit per
//! allowed move. They give the same bits as the production solver in the same arithmetic, field and
//! policy, and so also serve as its oracle on large grids.

mod ground;
mod links;
mod queues;
mod slopes;

pub use links::{CellPrice, FreeLinks, LinkCosts, MeanLinks, Number};
pub use queues::{Buckets, Heap, Queue};
pub use slopes::{SlopeLinks, slope_range};

use super::{PlanError, PlanOptions};
use crate::world::{Cell, GridGeometry};
use ground::Ground;

/// Memory of a plain planner, used again by every plan.
#[derive(Default)]
pub struct Peer<C, Q> {
    queue: Q,
    ground: Ground,
    padded: Vec<C>,
    values: Vec<C>,
    next_codes: Vec<i8>,
}

impl<C: Number, Q: Queue<C>> Peer<C, Q> {
    /// A planner that has planned nothing yet.
    pub fn new(queue: Q) -> Self {
        Self { queue, ground: Ground::default(), padded: vec![], values: vec![], next_codes: vec![] }
    }

    /// Plans for all cells, as [`plan_free`](crate::plan::plan_free) does, along links of any cost.
    ///
    /// False if a cost-to-go did not fit the number type: the field is then of no use.
    ///
    /// # Errors
    /// [`PlanError::EmptyGrid`], [`NoGoal`](PlanError::NoGoal),
    /// [`GoalOutsideGrid`](PlanError::GoalOutsideGrid), [`GoalBlocked`](PlanError::GoalBlocked).
    pub fn plan<L: LinkCosts<C>>(
        &mut self,
        geometry: &GridGeometry,
        links: &mut L,
        goals: &[Cell],
        options: &PlanOptions,
    ) -> Result<bool, PlanError> {
        let GridGeometry { rows, cols, .. } = *geometry;
        if geometry.is_empty() {
            return Err(PlanError::EmptyGrid { rows, cols });
        }
        if goals.is_empty() {
            return Err(PlanError::NoGoal);
        }
        let free_row = |row: usize, free: &mut [u8]| links.free_row(row, cols, free);
        self.ground.lay(rows, cols, free_row, links.moves(), options.corner_cutting);
        links.pad(&self.ground);
        self.padded.clear();
        self.padded.resize(self.ground.len(), C::UNREACHABLE);
        let mut starts = Vec::with_capacity(goals.len());
        for &Cell { row, col } in goals {
            if row >= rows || col >= cols {
                return Err(PlanError::GoalOutsideGrid { row: row as i64, col: col as i64, rows, cols });
            }
            let index = self.ground.index(row, col);
            if !self.ground.is_free(index) {
                return Err(PlanError::GoalBlocked { row, col });
            }
            self.padded[index] = C::ZERO;
            starts.push(index as u32);
        }
        let fits = self.queue.settle(&self.ground, &*links, &starts, &mut self.padded);
        self.ground.read_out(&*links, &self.padded, &mut self.values, &mut self.next_codes);
        Ok(fits)
    }

    /// The cost-to-go of every cell, row-major; the largest value where there is no way.
    pub fn values(&self) -> &[C] {
        &self.values
    }

    /// The next cell's code of every cell, row-major, as [`Field::next_codes`](crate::plan::Field::next_codes).
    pub fn next_codes(&self) -> &[i8] {
        &self.next_codes
    }
}

#[cfg(test)]
mod tests;
