use serde::{Deserialize, Serialize};

use crate::geometry::{Point2, Pose2};

/// A place in a grid. Row 0 has the lowest y, as in a ROS OccupancyGrid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Cell {
    /// Row, from 0.
    pub row: usize,
    /// Column, from 0.
    pub col: usize,
}

impl Cell {
    /// The cell (row, col).
    pub const fn new(row: usize, col: usize) -> Self {
        Self { row, col }
    }
}

/// Shape of a grid and where it lies in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GridGeometry {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
    /// Side of a cell \[m\].
    pub resolution_m: f64,
    /// The outer corner of cell (0, 0), with the direction of the columns as heading.
    pub world_from_grid: Pose2,
}

impl GridGeometry {
    /// Number of cells.
    pub fn len(&self) -> usize {
        self.rows * self.cols
    }

    /// The grid has no cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Row-major index of `cell`, which must be inside.
    #[inline]
    pub fn index(&self, cell: Cell) -> usize {
        debug_assert!(cell.row < self.rows && cell.col < self.cols);
        cell.row * self.cols + cell.col
    }

    /// The cell at a row-major index.
    #[inline]
    pub fn cell(&self, index: usize) -> Cell {
        Cell::new(index / self.cols, index % self.cols)
    }

    /// Centre of `cell` in the world \[m\].
    #[inline]
    pub fn center(&self, cell: Cell) -> Point2 {
        let in_grid = Point2::new(
            (cell.col as f64 + 0.5) * self.resolution_m,
            (cell.row as f64 + 0.5) * self.resolution_m,
        );
        // Most maps are not turned: no angle is worked out for each cell, and the numbers are the same.
        let Pose2 { x, y, heading } = self.world_from_grid;
        if heading == 0.0 {
            Point2::new(x + in_grid.x, y + in_grid.y)
        } else {
            self.world_from_grid * in_grid
        }
    }

    /// `point_in_world` in the grid's frame, without working out angles where it is not turned \[m\].
    #[inline]
    pub(crate) fn in_grid(&self, point_in_world: Point2) -> Point2 {
        let Pose2 { x, y, heading } = self.world_from_grid;
        if heading == 0.0 {
            Point2::new(point_in_world.x - x, point_in_world.y - y)
        } else {
            self.world_from_grid.inverse() * point_in_world
        }
    }

    /// The cell that holds `point_in_world`, or None outside (and for NaN).
    #[inline]
    pub fn cell_at(&self, point_in_world: Point2) -> Option<Cell> {
        let in_grid = self.in_grid(point_in_world);
        let col = in_grid.x / self.resolution_m;
        let row = in_grid.y / self.resolution_m;
        let inside = row >= 0.0 && col >= 0.0 && row < self.rows as f64 && col < self.cols as f64;
        inside.then(|| Cell::new(row as usize, col as usize))
    }
}

/// One value for every cell, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<T> {
    /// Shape and place.
    pub geometry: GridGeometry,
    /// `geometry.len()` values, row-major.
    pub values: Vec<T>,
}

impl<T> Grid<T> {
    /// A grid of `values`, row-major.
    ///
    /// # Panics
    /// If there are not exactly `geometry.len()` values.
    pub fn new(geometry: GridGeometry, values: Vec<T>) -> Self {
        assert_eq!(geometry.len(), values.len(), "one value for every cell");
        Self { geometry, values }
    }

    /// The value of `cell`, which must be inside.
    #[inline]
    pub fn at(&self, cell: Cell) -> &T {
        &self.values[self.geometry.index(cell)]
    }

    /// The value at `point_in_world`, or None outside.
    #[inline]
    pub fn at_point(&self, point_in_world: Point2) -> Option<&T> {
        self.geometry.cell_at(point_in_world).map(|cell| self.at(cell))
    }
}

impl<T: Clone> Grid<T> {
    /// A grid with the same value everywhere.
    pub fn filled(geometry: GridGeometry, value: T) -> Self {
        Self { values: vec![value; geometry.len()], geometry }
    }
}

/// What is known of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[repr(u8)]
pub enum Occupancy {
    /// Nothing stands there.
    Free = 0,
    /// Something stands there.
    Occupied = 1,
    /// Never seen.
    Unknown = 2,
}

/// A map of what stands where.
pub type OccupancyGrid = Grid<Occupancy>;

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_centre_of_a_cell_lies_in_that_cell_whatever_the_yaw(
            row in 0usize..40, col in 0usize..60, x in -9.0..9.0f64, y in -9.0..9.0f64, yaw in -3.1..3.1f64,
        ) {
            let g = GridGeometry { rows: 40, cols: 60, resolution_m: 0.05, world_from_grid: Pose2::new(x, y, yaw) };
            prop_assert_eq!(g.cell_at(g.center(Cell::new(row, col))), Some(Cell::new(row, col)));
        }
    }

    proptest! {
        #[test]
        fn a_grid_that_is_not_turned_has_the_cells_and_centres_that_its_pose_gives(
            row in 0usize..40, col in 0usize..60, x in -9.0..9.0f64, y in -9.0..9.0f64,
            px in -12.0..12.0f64, py in -12.0..12.0f64,
        ) {
            let g = GridGeometry { rows: 40, cols: 60, resolution_m: 0.05, world_from_grid: Pose2::new(x, y, 0.0) };
            let in_grid = Point2::new((col as f64 + 0.5) * 0.05, (row as f64 + 0.5) * 0.05);
            prop_assert_eq!(g.center(Cell::new(row, col)), g.world_from_grid * in_grid);
            let point = Point2::new(px, py);
            let in_grid = g.world_from_grid.inverse() * point;
            prop_assert_eq!(g.in_grid(point), in_grid);
            let (col, row) = ((in_grid.x / 0.05).floor(), (in_grid.y / 0.05).floor());
            let inside = row >= 0.0 && col >= 0.0 && row < 40.0 && col < 60.0;
            prop_assert_eq!(g.cell_at(point), inside.then(|| Cell::new(row as usize, col as usize)));
        }
    }

    #[test]
    fn points_outside_and_nan_have_no_cell() {
        let g = GridGeometry { rows: 2, cols: 3, resolution_m: 1.0, world_from_grid: Pose2::IDENTITY };
        for (x, y) in [(-0.1, 0.5), (3.0, 0.5), (0.5, 2.0), (f64::NAN, 0.5)] {
            assert_eq!(g.cell_at(Point2::new(x, y)), None);
        }
    }
}
