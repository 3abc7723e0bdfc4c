//! Exact traversal of a grid by a ray `[AmanatidesWoo87]`.

use super::{Grid, GridGeometry};
use crate::geometry::Point2;

/// The cells a ray passes, in order, each with the distance at which the ray enters it.
///
/// The cell that holds the start comes first, at distance 0; a ray that starts outside begins
/// where it enters the grid. It ends where it leaves the grid.
#[derive(Clone, Debug)]
pub(crate) struct Traversal {
    row: i64,
    col: i64,
    rows: i64,
    cols: i64,
    step_row: i64,
    step_col: i64,
    next_row_m: f64,
    next_col_m: f64,
    delta_row_m: f64,
    delta_col_m: f64,
    entered_m: f64,
}

impl Traversal {
    /// The ray from `from` along `direction_rad` (world frame).
    pub(crate) fn new(geometry: &GridGeometry, from: Point2, direction_rad: f64) -> Self {
        let grid_from_world = geometry.world_from_grid.inverse();
        let start = grid_from_world * from;
        let (sin, cos) = (grid_from_world.heading + direction_rad).sin_cos();
        Self::in_grid(geometry, start, Point2::new(cos, sin))
    }

    fn in_grid(geometry: &GridGeometry, from: Point2, unit: Point2) -> Self {
        let res = geometry.resolution_m;
        let (width, height) = (geometry.cols as f64 * res, geometry.rows as f64 * res);
        // Where the ray is inside the grid: the overlap of the two slabs.
        let slab = |start: f64, along: f64, size: f64| {
            if along == 0.0 {
                if (0.0..size).contains(&start) { (0.0, f64::INFINITY) } else { (f64::INFINITY, 0.0) }
            } else {
                let (a, b) = (-start / along, (size - start) / along);
                (a.min(b), a.max(b))
            }
        };
        let (x0, x1) = slab(from.x, unit.x, width);
        let (y0, y1) = slab(from.y, unit.y, height);
        let entered_m = x0.max(y0).max(0.0);
        let leaves_m = x1.min(y1);
        let (rows, cols) = (geometry.rows as i64, geometry.cols as i64);
        // Written so that NaN counts as outside.
        let meets = from.is_finite() && unit.is_finite() && entered_m <= leaves_m && rows > 0 && cols > 0;
        if !meets {
            return Self {
                row: -1,
                col: -1,
                rows,
                cols,
                step_row: 0,
                step_col: 0,
                next_row_m: f64::INFINITY,
                next_col_m: f64::INFINITY,
                delta_row_m: f64::INFINITY,
                delta_col_m: f64::INFINITY,
                entered_m: f64::INFINITY,
            };
        }
        let at = from + unit * entered_m;
        let axis = |at: f64, from: f64, along: f64, cells: i64| {
            let cell = ((at / res).floor() as i64).clamp(0, cells - 1);
            if along > 0.0 {
                (cell, 1, ((cell + 1) as f64 * res - from) / along, res / along)
            } else if along < 0.0 {
                (cell, -1, (cell as f64 * res - from) / along, -res / along)
            } else {
                (cell, 0, f64::INFINITY, f64::INFINITY)
            }
        };
        let (col, step_col, next_col_m, delta_col_m) = axis(at.x, from.x, unit.x, cols);
        let (row, step_row, next_row_m, delta_row_m) = axis(at.y, from.y, unit.y, rows);
        Self {
            row,
            col,
            rows,
            cols,
            step_row,
            step_col,
            next_row_m,
            next_col_m,
            delta_row_m,
            delta_col_m,
            entered_m,
        }
    }
}

impl Iterator for Traversal {
    /// Row-major index of the cell, distance at which the ray enters it \[m\].
    type Item = (usize, f64);

    fn next(&mut self) -> Option<(usize, f64)> {
        if self.row < 0 || self.col < 0 || self.row >= self.rows || self.col >= self.cols {
            return None;
        }
        let item = ((self.row * self.cols + self.col) as usize, self.entered_m);
        if self.next_col_m < self.next_row_m {
            self.entered_m = self.next_col_m.max(self.entered_m);
            self.next_col_m += self.delta_col_m;
            self.col += self.step_col;
        } else {
            self.entered_m = self.next_row_m.max(self.entered_m);
            self.next_row_m += self.delta_row_m;
            self.row += self.step_row;
            if self.step_row == 0 {
                self.row = -1; // neither axis moves: a direction of zero length
            }
        }
        Some(item)
    }
}

/// Distance from `from` along `direction_rad` (world frame) to the first occupied cell \[m\].
///
/// Zero when `from` lies in an occupied cell. None when nothing is met within `max_range_m`, and
/// for numbers that are not finite. What lies outside the grid is open space.
pub fn raycast(occupied: &Grid<bool>, from: Point2, direction_rad: f64, max_range_m: f64) -> Option<f64> {
    for (index, entered_m) in Traversal::new(&occupied.geometry, from, direction_rad) {
        if entered_m > max_range_m {
            return None;
        }
        if occupied.values[index] {
            return Some(entered_m);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose2;
    use crate::world::Cell;
    use proptest::prelude::*;

    fn grid(rows: usize, cols: usize, resolution_m: f64, world_from_grid: Pose2) -> Grid<bool> {
        Grid::filled(GridGeometry { rows, cols, resolution_m, world_from_grid }, false)
    }

    #[test]
    fn a_ray_straight_at_a_wall_measures_to_its_face() {
        let mut g = grid(10, 100, 0.05, Pose2::IDENTITY);
        for row in 0..10 {
            let i = g.geometry.index(Cell::new(row, 60));
            g.values[i] = true;
        }
        let from = Point2::new(0.5, 0.26);
        assert!((raycast(&g, from, 0.0, 10.0).unwrap() - 2.5).abs() < 1e-12);
        assert_eq!(raycast(&g, from, 0.0, 2.4), None);
        assert_eq!(raycast(&g, from, std::f64::consts::PI, 10.0), None);
        // From outside, through the open left side.
        assert!((raycast(&g, Point2::new(-1.0, 0.26), 0.0, 10.0).unwrap() - 4.0).abs() < 1e-12);
    }

    #[test]
    fn a_ray_that_never_meets_the_grid_or_is_not_a_number_sees_nothing() {
        let g = Grid::filled(grid(4, 4, 1.0, Pose2::IDENTITY).geometry, true);
        assert_eq!(raycast(&g, Point2::new(-1.0, -1.0), std::f64::consts::PI, 99.0), None);
        assert_eq!(raycast(&g, Point2::new(-1.0, 9.0), 0.0, 99.0), None);
        assert_eq!(raycast(&g, Point2::new(f64::NAN, 1.0), 0.0, 99.0), None);
        assert_eq!(raycast(&g, Point2::new(1.0, 1.0), f64::NAN, 99.0), None);
        assert_eq!(raycast(&grid(0, 0, 1.0, Pose2::IDENTITY), Point2::new(0.0, 0.0), 0.3, 9.0), None);
    }

    proptest! {
        #[test]
        fn a_ray_meets_the_cell_that_slab_intersection_over_all_cells_meets_first(
            cells in proptest::collection::vec((0usize..12, 0usize..15), 1..25),
            x in -0.5..2.0f64, y in -0.5..2.0f64, direction in -3.2..3.2f64, yaw in -3.0..3.0f64,
        ) {
            let mut g = grid(12, 15, 0.1, Pose2::new(0.3, -0.2, yaw));
            for (row, col) in cells { let i = g.geometry.index(Cell::new(row, col)); g.values[i] = true; }
            let from = Point2::new(x, y);
            let start = g.geometry.world_from_grid.inverse() * from;
            let unit = Point2::new((direction - yaw).cos(), (direction - yaw).sin());
            let mut best = f64::INFINITY;
            for (i, &full) in g.values.iter().enumerate() {
                if !full { continue; }
                let c = g.geometry.cell(i);
                let (lo, hi) = (Point2::new(c.col as f64 * 0.1, c.row as f64 * 0.1), Point2::new((c.col + 1) as f64 * 0.1, (c.row + 1) as f64 * 0.1));
                let (ax, bx) = ((lo.x - start.x) / unit.x, (hi.x - start.x) / unit.x);
                let (ay, by) = ((lo.y - start.y) / unit.y, (hi.y - start.y) / unit.y);
                let enter = ax.min(bx).max(ay.min(by)).max(0.0);
                let leave = ax.max(bx).min(ay.max(by));
                // Grazing a corner may go either way in floating point.
                if enter < leave - 1e-9 { best = best.min(enter); }
            }
            match raycast(&g, from, direction, 100.0) {
                Some(found) => prop_assert!(found <= best + 1e-9, "{found} {best}"),
                None => prop_assert!(best.is_infinite()),
            }
            if best.is_finite() { prop_assert!((raycast(&g, from, direction, 100.0).unwrap() - best).abs() < 1e-6); }
        }
    }
}
