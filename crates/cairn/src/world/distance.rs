//! Exact Euclidean distance to occupied cells, in integer arithmetic `[Meijster00]`.
//!
//! Everything is counted in half cells, so that both cell centres (even) and cell borders (odd)
//! have whole coordinates and squared distances are whole numbers.

use super::Grid;

/// Squared half cells when nothing is occupied.
const NOTHING: u64 = u64::MAX;

/// To which part of an occupied cell a distance is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum To {
    /// Its centre.
    Center,
    /// The nearest point of its square.
    Surface,
}

/// Distance from each cell's centre to the centre of the nearest occupied cell \[m\]: exact, 0 in
/// occupied cells, inf when nothing is occupied. Cells outside the grid are not occupied.
pub fn distance_to_occupied(occupied: &Grid<bool>) -> Grid<f32> {
    metres(occupied, To::Center)
}

/// Distance from each cell's centre to the nearest point of any occupied cell, cells being full
/// squares \[m\]: exact, 0 in occupied cells, inf when nothing is occupied.
pub fn distance_to_surface(occupied: &Grid<bool>) -> Grid<f32> {
    metres(occupied, To::Surface)
}

fn metres(occupied: &Grid<bool>, to: To) -> Grid<f32> {
    let half_cell_m = occupied.geometry.resolution_m / 2.0;
    let values = transform(occupied, to, |half_cells| (half_cells * half_cell_m) as f32);
    Grid::new(occupied.geometry, values)
}

/// `convert` of every cell's distance, given in half cells (inf: nothing is occupied).
pub(super) fn transform<T>(occupied: &Grid<bool>, to: To, convert: impl Fn(f64) -> T) -> Vec<T> {
    let (rows, cols) = (occupied.geometry.rows, occupied.geometry.cols);
    let down_the_columns = column_distances(&occupied.values, rows, cols);
    let mut envelope = Envelope::default();
    let mut squared = vec![NOTHING; cols];
    let mut out = Vec::with_capacity(rows * cols);
    for cell_rows in down_the_columns.chunks_exact(cols.max(1)) {
        envelope.build(cell_rows, to);
        match to {
            To::Center => envelope.read(&mut squared, 0),
            // A column beside is nearest at its facing border: half a cell less far. Asked half a
            // cell to either side, the envelope holds exactly that for the columns of that side and
            // only greater values for the others; the cell's own column is added by hand.
            To::Surface => {
                for (square, &column) in squared.iter_mut().zip(cell_rows) {
                    *square = height(column, to).unwrap_or(NOTHING);
                }
                envelope.read(&mut squared, -1);
                envelope.read(&mut squared, 1);
            }
        }
        out.extend(
            squared.iter().map(|&square| {
                convert(if square == NOTHING { f64::INFINITY } else { (square as f64).sqrt() })
            }),
        );
        squared.fill(NOTHING);
    }
    out
}

const NO_CELL: u32 = u32::MAX;

/// Cells to the nearest occupied cell of the same column.
fn column_distances(occupied: &[bool], rows: usize, cols: usize) -> Vec<u32> {
    let mut cells: Vec<u32> = occupied.iter().map(|&o| if o { 0 } else { NO_CELL }).collect();
    for row in 1..rows {
        let (above, below) = cells.split_at_mut(row * cols);
        for (here, &before) in below[..cols].iter_mut().zip(&above[(row - 1) * cols..]) {
            *here = (*here).min(before.saturating_add(1));
        }
    }
    for row in (1..rows).rev() {
        let (above, below) = cells.split_at_mut(row * cols);
        for (here, &before) in above[(row - 1) * cols..].iter_mut().zip(&below[..cols]) {
            *here = (*here).min(before.saturating_add(1));
        }
    }
    cells
}

/// Squared distance down a column in half cells, None when the column has no occupied cell.
fn height(cells: u32, to: To) -> Option<u64> {
    (cells != NO_CELL).then(|| match to {
        To::Center => 4 * u64::from(cells).pow(2),
        To::Surface => (2 * u64::from(cells)).saturating_sub(1).pow(2),
    })
}

/// The lower envelope of the parabolas (x − 2·col)² + height over one row.
#[derive(Default)]
struct Envelope {
    /// (position, height, first whole x at which it is the lowest), left to right.
    parabolas: Vec<(i64, i64, i64)>,
}

impl Envelope {
    fn build(&mut self, columns: &[u32], to: To) {
        self.parabolas.clear();
        for (col, &cells) in columns.iter().enumerate() {
            let Some(height) = height(cells, to) else { continue };
            let (u, hu) = (2 * col as i64, height as i64);
            let mut from = i64::MIN;
            while let Some(&(i, hi, i_from)) = self.parabolas.last() {
                // Up to this x parabola i is no higher than the new one.
                from = ((u * u - i * i + hu - hi).div_euclid(2 * (u - i))) + 1;
                if from > i_from {
                    break;
                }
                self.parabolas.pop();
                from = i64::MIN;
            }
            self.parabolas.push((u, hu, from));
        }
    }

    /// Lowers `squared[col]` to the envelope at 2·col + `offset`.
    fn read(&self, squared: &mut [u64], offset: i64) {
        if self.parabolas.is_empty() {
            return;
        }
        let mut lowest = 0;
        for (col, square) in squared.iter_mut().enumerate() {
            let x = 2 * col as i64 + offset;
            while self.parabolas.get(lowest + 1).is_some_and(|&(_, _, from)| from <= x) {
                lowest += 1;
            }
            let (position, height, _) = self.parabolas[lowest];
            *square = (*square).min(((x - position) * (x - position) + height) as u64);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose2;
    use crate::world::GridGeometry;
    use proptest::prelude::*;

    fn grid(rows: usize, cols: usize, values: Vec<bool>) -> Grid<bool> {
        let world_from_grid = Pose2::IDENTITY;
        Grid::new(GridGeometry { rows, cols, resolution_m: 1.0, world_from_grid }, values)
    }

    fn any_grid() -> impl Strategy<Value = Grid<bool>> {
        (1usize..24, 1usize..24, 1u32..40).prop_flat_map(|(rows, cols, rarity)| {
            proptest::collection::vec((0..rarity).prop_map(|n| n == 0), rows * cols)
                .prop_map(move |values| grid(rows, cols, values))
        })
    }

    /// Half cells between two indices of one axis.
    fn axis(a: usize, b: usize, to: To) -> u64 {
        match to {
            To::Center => 2 * a.abs_diff(b) as u64,
            To::Surface => (2 * a.abs_diff(b) as u64).saturating_sub(1),
        }
    }

    fn brute_force(occupied: &Grid<bool>, to: To) -> Vec<f64> {
        let g = occupied.geometry;
        let things: Vec<_> = (0..g.len()).filter(|&i| occupied.values[i]).map(|i| g.cell(i)).collect();
        (0..g.len())
            .map(|i| g.cell(i))
            .map(|c| {
                let square =
                    |t: &crate::world::Cell| axis(c.row, t.row, to).pow(2) + axis(c.col, t.col, to).pow(2);
                things.iter().map(square).min().map_or(f64::INFINITY, |s| (s as f64).sqrt())
            })
            .collect()
    }

    proptest! {
        #[test]
        fn distances_to_centres_equal_brute_force_to_the_bit(occupied in any_grid()) {
            prop_assert_eq!(transform(&occupied, To::Center, |d| d), brute_force(&occupied, To::Center));
        }

        #[test]
        fn distances_to_surfaces_equal_brute_force_to_the_bit(occupied in any_grid()) {
            prop_assert_eq!(transform(&occupied, To::Surface, |d| d), brute_force(&occupied, To::Surface));
        }
    }

    #[test]
    fn nothing_occupied_is_infinitely_far_and_no_cells_are_no_distances() {
        let far = distance_to_occupied(&grid(2, 3, vec![false; 6]));
        assert_eq!(far.values, vec![f32::INFINITY; 6]);
        assert!(distance_to_surface(&grid(0, 0, vec![])).values.is_empty());
        assert!(distance_to_surface(&grid(3, 0, vec![])).values.is_empty());
    }

    #[test]
    fn distances_are_in_metres() {
        let mut occupied = grid(1, 4, vec![true, false, false, false]);
        occupied.geometry.resolution_m = 0.5;
        assert_eq!(distance_to_occupied(&occupied).values, vec![0.0, 0.5, 1.0, 1.5]);
        assert_eq!(distance_to_surface(&occupied).values, vec![0.0, 0.25, 0.75, 1.25]);
    }
}
