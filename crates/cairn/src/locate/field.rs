//! How far the nearest surface of a known map is from any point: the likelihood field `[Thrun05 §6.4]`.

use crate::geometry::{Point2, Pose2};
use crate::world::{Grid, GridGeometry, Occupancy, OccupancyGrid, distance_to_surface};

/// Steps of the rounded distance \[m\].
pub(super) const STEP_M: f32 = 0.02;

/// Bytes behind the last cell, so that any cell can be read as the first of four bytes.
const BEHIND: usize = 3;

/// Distances to the surfaces of a map, inside of things as well as outside: what lies deep in a thick
/// wall is as far from any surface as what lies before it.
#[derive(Clone, Debug)]
pub(super) struct SurfaceField {
    geometry: GridGeometry,
    /// Distance to the nearest surface in steps, with a frame of one cell around it.
    near: Vec<u8>,
    /// As `near`: nothing stands there, and it is on the map.
    open: Vec<bool>,
    stride: i32,
    last_col: f32,
    last_row: f32,
    cells_per_m: f32,
    /// Distance to the nearest surface, negative inside of things \[m\], (rows, cols).
    signed_m: Vec<f32>,
}

impl SurfaceField {
    pub(super) fn new(map: &OccupancyGrid) -> Self {
        let geometry = map.geometry;
        let occupied: Vec<bool> = map.values.iter().map(|class| *class == Occupancy::Occupied).collect();
        let empty = occupied.iter().map(|occupied| !occupied).collect();
        let outside = distance_to_surface(&Grid::new(geometry, occupied)).values;
        let inside = distance_to_surface(&Grid::new(geometry, empty)).values;
        let signed_m: Vec<f32> = outside
            .iter()
            .zip(&inside)
            .map(|(&outside, &inside)| (if outside > 0.0 { outside } else { -inside }).clamp(-99.0, 99.0))
            .collect();
        let (rows, cols) = (geometry.rows, geometry.cols);
        let stride = cols + 2;
        let mut near = vec![u8::MAX; stride * (rows + 2) + BEHIND];
        let mut open = vec![false; near.len()];
        for row in 0..rows {
            for col in 0..cols {
                let (from, to) = (row * cols + col, (row + 1) * stride + col + 1);
                // Rounded half down: a cell beside a surface is at it.
                near[to] = (signed_m[from].abs() / STEP_M).min(255.0) as u8;
                open[to] = map.values[from] != Occupancy::Occupied;
            }
        }
        Self {
            geometry,
            near,
            open,
            stride: stride as i32,
            last_col: (cols + 1) as f32,
            last_row: (rows + 1) as f32,
            cells_per_m: (1.0 / geometry.resolution_m) as f32,
            signed_m,
        }
    }

    /// Index into [`Self::near_at`] of a point in the map's frame \[m\]; outside: of the frame.
    #[inline(always)]
    pub(super) fn index(&self, x: f32, y: f32) -> i32 {
        let col = Self::whole(x * self.cells_per_m + 0.5, self.last_col);
        let row = Self::whole(y * self.cells_per_m + 0.5, self.last_row);
        row.wrapping_mul(self.stride).wrapping_add(col)
    }

    /// Nearer to a surface than this, in steps, is in a cell that touches it.
    pub(super) fn met(&self) -> u8 {
        (self.geometry.resolution_m as f32 / 2.0 / STEP_M).min(254.0) as u8
    }

    /// `value` to the nearest whole number in 0 ..= `last`; NaN gives 0. The sum's last bits are that
    /// number: conversions that saturate are done one by one by the processor, this is not.
    #[inline(always)]
    fn whole(value: f32, last: f32) -> i32 {
        const TWO_TO_23: f32 = 8_388_608.0;
        let value = if value > 0.0 { value } else { 0.0 };
        let value = if value < last { value } else { last };
        (value + TWO_TO_23).to_bits() as i32 & 0x7f_ffff
    }

    /// Distance to the nearest surface in steps of [`STEP_M`].
    #[inline(always)]
    pub(super) fn near_at(&self, index: i32) -> u8 {
        self.near[index as usize]
    }

    /// All that [`Self::near_at`] reads, by index; behind the last there are three bytes more.
    pub(super) fn near_cells(&self) -> &[u8] {
        &self.near
    }

    /// Nothing stands there, and it is on the map.
    #[inline(always)]
    pub(super) fn is_open(&self, index: i32) -> bool {
        self.open[index as usize]
    }

    /// Signed distance to the nearest surface \[m\], and its gradient in the world, between the cells'
    /// centres bilinear. None within a cell of the map's border, and outside.
    pub(super) fn signed(&self, point_in_world: Point2) -> Option<(f64, Point2)> {
        let g = &self.geometry;
        let in_grid = g.world_from_grid.inverse() * point_in_world;
        let (u, v) = (in_grid.x / g.resolution_m - 0.5, in_grid.y / g.resolution_m - 0.5);
        let inside = u >= 0.0 && v >= 0.0 && u < (g.cols as f64 - 1.0) && v < (g.rows as f64 - 1.0);
        if !inside {
            return None;
        }
        let (col, row) = (u as usize, v as usize);
        let (fu, fv) = (u - col as f64, v - row as f64);
        let at = |dr: usize, dc: usize| f64::from(self.signed_m[(row + dr) * g.cols + col + dc]);
        let (a, b, c, d) = (at(0, 0), at(0, 1), at(1, 0), at(1, 1));
        let value = (a * (1.0 - fu) + b * fu) * (1.0 - fv) + (c * (1.0 - fu) + d * fu) * fv;
        let du = ((b - a) * (1.0 - fv) + (d - c) * fv) / g.resolution_m;
        let dv = ((c - a) * (1.0 - fu) + (d - b) * fu) / g.resolution_m;
        let gradient = Pose2::new(0.0, 0.0, g.world_from_grid.heading) * Point2::new(du, dv);
        Some((value, gradient))
    }

    /// Poses a robot could have whose outline keeps `radius_m` free, on a lattice of `pitch_m` and
    /// `headings` directions: positions in the map's frame \[m\].
    pub(super) fn standing_places(&self, map: &[Occupancy], radius_m: f32, pitch_m: f64) -> Vec<(f32, f32)> {
        let g = &self.geometry;
        let every = ((pitch_m / g.resolution_m).round() as usize).max(1);
        let mut places = Vec::new();
        for row in (every / 2..g.rows).step_by(every) {
            for col in (every / 2..g.cols).step_by(every) {
                let index = row * g.cols + col;
                if map[index] == Occupancy::Free && self.signed_m[index] >= radius_m {
                    places.push((
                        ((col as f64 + 0.5) * g.resolution_m) as f32,
                        ((row as f64 + 0.5) * g.resolution_m) as f32,
                    ));
                }
            }
        }
        places
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall_of_a_metre() -> SurfaceField {
        let geometry =
            GridGeometry { rows: 40, cols: 80, resolution_m: 0.05, world_from_grid: Pose2::IDENTITY };
        let cells = (0..geometry.len())
            .map(|i| if (40..60).contains(&(i % 80)) { Occupancy::Occupied } else { Occupancy::Free });
        SurfaceField::new(&Grid::new(geometry, cells.collect()))
    }

    #[test]
    fn the_signed_distance_is_linear_across_a_surface_and_its_gradient_points_out_of_the_wall() {
        let field = wall_of_a_metre();
        for x in [1.6, 1.83, 1.975, 2.0, 2.025, 2.1, 2.31] {
            let (value, gradient) = field.signed(Point2::new(x, 1.0)).unwrap();
            assert!((value - (2.0 - x)).abs() < 0.026, "{x}: {value}");
            assert!((gradient.x + 1.0).abs() < 1e-3 && gradient.y.abs() < 1e-6, "{x}: {gradient:?}");
        }
        assert!(field.signed(Point2::new(-1.0, 1.0)).is_none());
    }

    #[test]
    fn deep_in_a_wall_is_far_from_every_surface_and_outside_the_map_is_nothing() {
        let field = wall_of_a_metre();
        assert!(field.near_at(field.index(1.99, 1.0)) <= 1);
        assert!(field.near_at(field.index(2.5, 1.0)) >= 20);
        assert!(field.is_open(field.index(1.99, 1.0)) && !field.is_open(field.index(2.5, 1.0)));
        for (x, y) in [(-3.0, 1.0), (9.0, 1.0), (1.0, -0.1), (1.0, 77.0), (f32::NAN, 1.0)] {
            assert_eq!(field.near_at(field.index(x, y)), u8::MAX, "{x} {y}");
            assert!(!field.is_open(field.index(x, y)));
        }
    }
}
