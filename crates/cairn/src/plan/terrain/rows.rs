//! Costs of moves by the row: what a solver that works on many cells at once asks for.

use crate::plan::Cost;
use crate::plan::moves::MOVES;
use crate::world::GridGeometry;

use super::weights::DirectionWeights;

/// A grid of which every move out of every cell has a cost of its own.
pub trait DirectedRows {
    /// What costs are counted in.
    type Number: Cost;

    /// Shape and place of the grid.
    fn geometry(&self) -> &GridGeometry;

    /// Costs of the moves with one code out of the cells `first_col..` of a row, as many as `costs` holds;
    /// `UNREACHABLE` where there is no such move. A plain loop: compiled for wider instructions where its caller is.
    ///
    /// # Panics
    /// Beyond the grid.
    fn row_costs<const CODE: usize>(&self, row: usize, first_col: usize, costs: &mut [Self::Number]);
}

/// The part of `costs` whose moves end on the grid, and where it begins; the rest becomes `UNREACHABLE`.
#[inline(always)]
fn on_grid<'c, C: Cost, const CODE: usize>(
    geometry: &GridGeometry,
    row: usize,
    first_col: usize,
    costs: &'c mut [C],
) -> (usize, &'c mut [C]) {
    let (down, right) = MOVES[CODE];
    let last_col = first_col + costs.len();
    let inside = row.checked_add_signed(down).is_some_and(|row| row < geometry.rows);
    let skip = usize::from(right < 0 && first_col == 0 && last_col > 0);
    let drop = usize::from(right > 0 && last_col == geometry.cols && last_col > first_col);
    let kept = if inside { costs.len().saturating_sub(skip + drop) } else { 0 };
    if kept == 0 {
        costs.fill(C::UNREACHABLE);
        return (first_col, &mut costs[..0]);
    }
    if skip > 0 {
        costs[0] = C::UNREACHABLE;
    }
    if drop > 0 {
        costs[skip + kept] = C::UNREACHABLE;
    }
    (first_col + skip, &mut costs[skip..skip + kept])
}

impl<T: Cost> DirectedRows for DirectionWeights<'_, T> {
    type Number = T;

    fn geometry(&self) -> &GridGeometry {
        DirectionWeights::geometry(self)
    }

    #[inline(always)]
    fn row_costs<const CODE: usize>(&self, row: usize, first_col: usize, costs: &mut [T]) {
        let geometry = DirectionWeights::geometry(self);
        let (first_col, costs) = on_grid::<T, CODE>(geometry, row, first_col, costs);
        costs.copy_from_slice(&self.plane(CODE)[row * geometry.cols + first_col..][..costs.len()]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose2;

    fn noise(seed: u32, i: usize) -> f32 {
        let mixed = (i as u32 ^ seed).wrapping_mul(0x9E37_79B9).rotate_left(13).wrapping_mul(0x85EB_CA6B);
        (mixed >> 8) as f32 / (1 << 24) as f32
    }

    fn whole_row<D: DirectedRows>(
        grid: &D,
        code: usize,
        row: usize,
        first: usize,
        n: usize,
    ) -> Vec<D::Number> {
        let mut costs = vec![D::Number::ZERO; n];
        match code {
            0 => grid.row_costs::<0>(row, first, &mut costs),
            1 => grid.row_costs::<1>(row, first, &mut costs),
            2 => grid.row_costs::<2>(row, first, &mut costs),
            3 => grid.row_costs::<3>(row, first, &mut costs),
            4 => grid.row_costs::<4>(row, first, &mut costs),
            5 => grid.row_costs::<5>(row, first, &mut costs),
            6 => grid.row_costs::<6>(row, first, &mut costs),
            _ => grid.row_costs::<7>(row, first, &mut costs),
        }
        costs
    }

    #[test]
    fn a_row_costs_what_its_cells_cost_one_by_one() {
        for (rows, cols) in [(1, 1), (1, 7), (7, 1), (2, 2), (9, 37), (16, 64)] {
            let geometry = GridGeometry { rows, cols, resolution_m: 2.0, world_from_grid: Pose2::IDENTITY };
            let planes: Vec<u32> = (0..8 * rows * cols).map(|i| 1 + (noise(3, i) * 9.0) as u32).collect();
            let weights = DirectionWeights::new(geometry, &planes).unwrap();
            let allowed = weights.allowed();
            for row in 0..rows {
                for (code, plane) in (0..8).map(|code| (code, weights.plane(code))) {
                    for (col, cost) in whole_row(&weights, code, row, 0, cols).into_iter().enumerate() {
                        let index = row * cols + col;
                        let there = allowed[index] >> code & 1 == 1;
                        assert_eq!(cost, if there { plane[index] } else { u32::MAX });
                    }
                }
            }
        }
    }
}
