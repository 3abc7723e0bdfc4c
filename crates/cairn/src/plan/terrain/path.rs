use crate::plan::PlanError;
use crate::plan::moves::MOVES;
use crate::world::{Cell, Grid, GridGeometry};

use super::links::{AnyTerrainLinks, with_links};
use super::model::TerrainModel;

/// How far from a path the elevation bears on it: cells beside it, and the roughness of these.
const MARGIN: usize = 2;

/// Cost of one way over a terrain, summed in f32 from its last cell, as a field sums it: joules or seconds.
/// Infinite if one of its moves is not allowed; 0 for a single cell.
///
/// # Errors
/// [`PlanError::PathWithoutCells`]; [`PathOutsideGrid`](PlanError::PathOutsideGrid) and
/// [`PathBroken`](PlanError::PathBroken) with the first such place; those of [`AnyTerrainLinks::new`] for the
/// cells around the path.
pub fn terrain_path_cost(
    elevation: &Grid<f32>,
    roughness: Option<&Grid<f32>>,
    model: &TerrainModel,
    path: &[Cell],
    corner_cutting: bool,
) -> Result<f32, PlanError> {
    let GridGeometry { rows, cols, .. } = elevation.geometry;
    if let Some(given) = roughness {
        let (found, wanted) = ((given.geometry.rows, given.geometry.cols), (rows, cols));
        if found != wanted {
            return Err(PlanError::RoughnessShape {
                rows: found.0,
                cols: found.1,
                elevation_rows: rows,
                elevation_cols: cols,
            });
        }
    }
    if path.is_empty() {
        return Err(PlanError::PathWithoutCells);
    }
    if let Some(index) = path.iter().position(|cell| cell.row >= rows || cell.col >= cols) {
        let Cell { row, col } = path[index];
        let outside = |value: usize| i64::try_from(value).unwrap_or(i64::MAX);
        let (row, col) = (outside(row), outside(col));
        return Err(PlanError::PathOutsideGrid { index, row, col, rows, cols });
    }
    let around = Window::around(path, &elevation.geometry);
    let heights = around.cut(elevation);
    let rough = roughness.map(|roughness| around.cut(roughness));
    let links = AnyTerrainLinks::new(&heights, rough.as_ref(), model, corner_cutting)?;
    with_links!(&links, links => {
        let mut cost = 0.0_f32;
        for (index, pair) in path.windows(2).enumerate().rev() {
            let code = code_of(pair[0], pair[1]).ok_or(PlanError::PathBroken {
                index,
                row: pair[0].row,
                col: pair[0].col,
                next_row: pair[1].row,
                next_col: pair[1].col,
            })?;
            let from = heights.geometry.index(around.place(pair[0]));
            cost += links.costs_from(from)[code];
        }
        Ok(cost)
    })
}

fn code_of(from: Cell, to: Cell) -> Option<usize> {
    let down = to.row as isize - from.row as isize;
    let right = to.col as isize - from.col as isize;
    MOVES.iter().position(|&step| step == (down, right))
}

/// A rectangle of cells.
struct Window {
    first: Cell,
    last: Cell,
}

impl Window {
    fn around(path: &[Cell], geometry: &GridGeometry) -> Self {
        let (mut first, mut last) = (path[0], path[0]);
        for cell in path {
            first = Cell::new(first.row.min(cell.row), first.col.min(cell.col));
            last = Cell::new(last.row.max(cell.row), last.col.max(cell.col));
        }
        Self {
            first: Cell::new(first.row.saturating_sub(MARGIN), first.col.saturating_sub(MARGIN)),
            last: Cell::new(
                (last.row + MARGIN).min(geometry.rows - 1),
                (last.col + MARGIN).min(geometry.cols - 1),
            ),
        }
    }

    fn place(&self, cell: Cell) -> Cell {
        Cell::new(cell.row - self.first.row, cell.col - self.first.col)
    }

    fn cut(&self, grid: &Grid<f32>) -> Grid<f32> {
        let (rows, cols) = (self.last.row - self.first.row + 1, self.last.col - self.first.col + 1);
        let mut values = Vec::with_capacity(rows * cols);
        for row in self.first.row..=self.last.row {
            values.extend_from_slice(&grid.values[row * grid.geometry.cols + self.first.col..][..cols]);
        }
        Grid::new(GridGeometry { rows, cols, ..grid.geometry }, values)
    }
}
