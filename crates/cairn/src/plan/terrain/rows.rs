//! Costs of moves by the row: what a solver that works on many cells at once asks for.

use crate::plan::Cost;
use crate::plan::moves::MOVES;
use crate::world::GridGeometry;

use super::link::LinkCost;
use super::links::TerrainLinks;
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

impl<M: LinkCost> DirectedRows for TerrainLinks<'_, M> {
    type Number = f32;

    fn geometry(&self) -> &GridGeometry {
        &self.geometry
    }

    #[inline(always)]
    fn row_costs<const CODE: usize>(&self, row: usize, first_col: usize, costs: &mut [f32]) {
        let (first_col, costs) = on_grid::<f32, CODE>(&self.geometry, row, first_col, costs);
        let n = costs.len();
        if n == 0 {
            return;
        }
        let (down, right) = MOVES[CODE];
        let from = row * self.geometry.cols + first_col;
        let to = from.wrapping_add_signed(down * self.geometry.cols as isize + right);
        let (here, there, allowed) =
            (&self.elevation[from..][..n], &self.elevation[to..][..n], &self.allowed[from..][..n]);
        let none: &[f32] = &[];
        let rough = |at: usize| if M::USES_ROUGHNESS { &self.roughness[at..][..n] } else { none };
        let (rough_here, rough_there) = (rough(from), rough(to));
        for i in 0..n {
            let rise = there[i] - here[i];
            let (leaving, entering) =
                if M::USES_ROUGHNESS { (rough_here[i], rough_there[i]) } else { (0.0, 0.0) };
            let cost = match CODE % 2 {
                1 => self.model.link::<true>(rise, leaving, entering),
                _ => self.model.link::<false>(rise, leaving, entering),
            };
            costs[i] = if allowed[i] & (1 << CODE) != 0 { cost } else { f32::INFINITY };
        }
    }
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
    use crate::plan::terrain::{AnyTerrainLinks, P3at, TerrainModel, Tobler};
    use crate::world::Grid;

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
            let heights = (0..rows * cols).map(|i| match noise(1, i) {
                x if x < 0.1 => f32::NAN,
                _ => noise(2, i),
            });
            let elevation = Grid::new(geometry, heights.collect());
            for model in [TerrainModel::P3atEnergy(P3at::default()), TerrainModel::Tobler(Tobler::default())]
            {
                let links = AnyTerrainLinks::new(&elevation, None, &model, false).unwrap();
                crate::plan::terrain::links::with_links!(&links, links => for row in 0..rows {
                    for code in 0..8 {
                        for (first, n) in [(0, cols), (cols / 3, cols - cols / 3), (0, cols / 2), (0, 0)] {
                            let costs = whole_row(links, code, row, first, n);
                            for (i, cost) in costs.iter().enumerate() {
                                let single = links.costs_from(row * cols + first + i)[code];
                                assert_eq!(cost.to_bits(), single.to_bits());
                            }
                        }
                    }
                });
            }
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
