//! How a wall answers a sonar: a smooth wall hit obliquely reflects the cry away and is not heard;
//! corners, edges and small things answer to every side `[KucSiegel87]`.

use super::marks::WINDOW;
use super::raycast::Traversal;
use super::{Grid, GridGeometry};
use crate::geometry::{Point2, Pose2};

/// Greatest incidence at which a smooth wall surely answers \[rad\].
pub(crate) const SURE_INCIDENCE_RAD: f64 = 0.35;
/// Least incidence at which a smooth wall surely does not answer \[rad\].
pub(crate) const LOST_INCIDENCE_RAD: f64 = 0.61;

/// What the surface of a cell is to a cry from one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Surface {
    /// Part of a straight face: cosine of the angle between the cry and its normal. None when the
    /// cells around do not form one (a corner, a post, a crumb).
    pub face_cos: Option<f64>,
    /// The straight face ends here.
    pub is_end: bool,
}

impl Surface {
    /// How surely this surface answers, 0 to 1; its ends answer as corners do when `ends_answer`.
    pub(super) fn echo(self, ends_answer: bool) -> f64 {
        match self.face_cos {
            None => 1.0,
            Some(_) if self.is_end && ends_answer => 1.0,
            Some(cos) => {
                let (sure, lost) = (SURE_INCIDENCE_RAD.cos(), LOST_INCIDENCE_RAD.cos());
                ((cos - lost) / (sure - lost)).clamp(0.0, 1.0)
            }
        }
    }
}

/// Half the side of the square of cells a surface is judged from.
const REACH: i64 = 3;

/// The surface at cell `index` for a cry that travels along `unit` (in the grid's frame).
fn surface(
    geometry: &GridGeometry,
    is_occupied: impl Fn(usize) -> bool,
    index: usize,
    unit: Point2,
) -> Surface {
    let (rows, cols) = (geometry.rows as i64, geometry.cols as i64);
    let (row, col) = (index as i64 / cols, index as i64 % cols);
    let full =
        |r: i64, c: i64| r >= 0 && c >= 0 && r < rows && c < cols && is_occupied((r * cols + c) as usize);
    let reach = WINDOW as i64;
    surface_in(
        std::array::from_fn(|i| {
            let r = row + i as i64 - reach;
            (0..=2 * reach).map(|j| u16::from(full(r, col + j - reach)) << j).sum()
        }),
        unit,
    )
}

/// The surface in the middle of a [window](super::marks::Marks::window) of occupied cells, for a cry that
/// travels along `unit`.
///
/// Only cells whose near side is open are looked at, so thick walls are judged by the face that is
/// turned to the sonar. A face is straight when the smaller spread of these cells is a small part
/// of the larger one.
pub(super) fn surface_in(full: [u16; 2 * WINDOW + 1], unit: Point2) -> Surface {
    // The cells beside the square count only as neighbours.
    const SQUARE: u16 = ((1 << (2 * REACH + 1)) - 1) << (WINDOW as i64 - REACH);
    let (aside, before) = (unit.x.abs() > 0.2, unit.y.abs() > 0.2);
    let (mut n, mut sx, mut sy, mut sxx, mut sxy, mut syy) = (0, 0, 0, 0, 0, 0);
    for dr in -REACH..=REACH {
        let at = (dr + WINDOW as i64) as usize;
        let mut open = 0;
        if aside {
            open |= if unit.x > 0.0 { !(full[at] << 1) } else { !(full[at] >> 1) };
        }
        if before {
            open |= if unit.y > 0.0 { !full[at - 1] } else { !full[at + 1] };
        }
        let mut faces = full[at] & open & SQUARE;
        while faces != 0 {
            let dc = i64::from(faces.trailing_zeros()) - WINDOW as i64;
            faces &= faces - 1;
            n += 1;
            sx += dc;
            sy += dr;
            sxx += dc * dc;
            sxy += dc * dr;
            syy += dr * dr;
        }
    }
    let [n, sx, sy, sxx, sxy, syy] = [n, sx, sy, sxx, sxy, syy].map(|sum| sum as f64);
    if n < 3.0 {
        return Surface { face_cos: None, is_end: true };
    }
    let (mx, my) = (sx / n, sy / n);
    let (cxx, cxy, cyy) = (sxx / n - mx * mx, sxy / n - mx * my, syy / n - my * my);
    let mean = (cxx + cyy) / 2.0;
    let swing = ((cxx - cyy) / 2.0).hypot(cxy);
    let (large, small) = (mean + swing, mean - swing);
    if small > 0.2 * large {
        return Surface { face_cos: None, is_end: true };
    }
    // Direction of the larger spread is along the face; the normal is across it.
    let along_rad = 0.5 * (2.0 * cxy).atan2(cxx - cyy);
    let normal = Point2::new(-along_rad.sin(), along_rad.cos());
    let offset_along = mx * along_rad.cos() + my * along_rad.sin();
    Surface { face_cos: Some(unit.dot(normal).abs()), is_end: offset_along.abs() >= 1.0 }
}

/// What a sonar is expected to hear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SonarEcho {
    /// Distance to the nearest surface that answers \[m\].
    pub range_m: f64,
    /// Where it is, world frame \[m\].
    pub point_in_world: Point2,
    /// It is part of a straight face, not a corner or an end of one.
    pub on_face: bool,
}

/// The range a sonar at `world_from_sonar` is expected to measure: the nearest surface that
/// answers inside the cone of full angle `beam_rad`, looked for along `rays` rays.
///
/// Walls hit obliquely (beyond about 28°) do not answer, and what is behind them is not heard.
/// None when nothing answers within `max_range_m`.
pub fn sonar_echo(
    occupied: &Grid<bool>,
    world_from_sonar: Pose2,
    beam_rad: f64,
    max_range_m: f64,
    rays: usize,
) -> Option<SonarEcho> {
    let yaw = occupied.geometry.world_from_grid.heading;
    let rays = rays.max(1);
    let mut nearest: Option<SonarEcho> = None;
    for ray in 0..rays {
        let part = if rays == 1 { 0.0 } else { ray as f64 / (rays - 1) as f64 - 0.5 };
        let direction = world_from_sonar.heading + part * beam_rad;
        let limit = nearest.map_or(max_range_m, |echo| echo.range_m);
        let Some((index, range_m)) = first_hit(occupied, world_from_sonar.position(), direction, limit)
        else {
            continue;
        };
        let in_grid = direction - yaw;
        let s = surface(
            &occupied.geometry,
            |i| occupied.values[i],
            index,
            Point2::new(in_grid.cos(), in_grid.sin()),
        );
        if s.echo(true) >= 0.5 {
            nearest = Some(SonarEcho {
                range_m,
                point_in_world: world_from_sonar.position()
                    + Point2::new(direction.cos(), direction.sin()) * range_m,
                on_face: s.face_cos.is_some() && !s.is_end,
            });
        }
    }
    nearest
}

/// The range of [`sonar_echo`] along 15 rays; infinity when nothing answers.
pub fn sonar_range(occupied: &Grid<bool>, world_from_sonar: Pose2, beam_rad: f64, max_range_m: f64) -> f64 {
    sonar_echo(occupied, world_from_sonar, beam_rad, max_range_m, 15)
        .map_or(f64::INFINITY, |echo| echo.range_m)
}

fn first_hit(occupied: &Grid<bool>, from: Point2, direction: f64, limit_m: f64) -> Option<(usize, f64)> {
    for (index, entered_m) in Traversal::new(&occupied.geometry, from, direction) {
        if entered_m > limit_m {
            return None;
        }
        if occupied.values[index] {
            return Some((index, entered_m));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Cell;

    fn wall_at_x(x_m: f64, thick: usize) -> Grid<bool> {
        let geometry =
            GridGeometry { rows: 120, cols: 120, resolution_m: 0.05, world_from_grid: Pose2::IDENTITY };
        let mut g = Grid::filled(geometry, false);
        let first = (x_m / 0.05).round() as usize;
        for row in 0..120 {
            for col in first..first + thick {
                let i = geometry.index(Cell::new(row, col));
                g.values[i] = true;
            }
        }
        g
    }

    #[test]
    fn a_wall_straight_ahead_answers_and_the_same_wall_at_fifty_degrees_does_not() {
        for thick in [1, 2, 4, 9] {
            let g = wall_at_x(4.0, thick);
            let ahead = sonar_range(&g, Pose2::new(2.0, 3.02, 0.0), std::f64::consts::FRAC_PI_6, 5.0);
            assert!((ahead - 2.0).abs() < 1e-9, "{thick} cells thick: {ahead}");
            let oblique = sonar_range(&g, Pose2::new(2.0, 3.02, 0.87), 0.17, 5.0);
            assert_eq!(oblique, f64::INFINITY, "{thick} cells thick");
        }
    }

    #[test]
    fn a_post_answers_from_every_side() {
        let mut g = wall_at_x(5.0, 1);
        let post = g.geometry.index(Cell::new(60, 60));
        g.values[post] = true;
        for k in 0..12 {
            let heading = k as f64 * std::f64::consts::FRAC_PI_6;
            let from = Pose2::new(3.025 - 1.5 * heading.cos(), 3.025 - 1.5 * heading.sin(), heading);
            let range = sonar_range(&g, from, std::f64::consts::FRAC_PI_6, 5.0);
            assert!((range - 1.48).abs() < 0.05, "from {heading} rad: {range}");
        }
    }

    #[test]
    fn the_open_end_of_a_wall_answers_though_the_wall_itself_is_hit_obliquely() {
        let mut g = wall_at_x(4.0, 2);
        for row in 60..120 {
            for col in 80..82 {
                g.values[row * 120 + col] = false;
            }
        }
        let range = sonar_range(&g, Pose2::new(2.0, 1.0, 0.79), 0.3, 5.0);
        assert!((range - 2.83).abs() < 0.15, "{range}");
    }
}
