//! What one array of ranges says about the cells: the inverse sensor models of [`OccupancyMap`].

use super::raycast::Traversal;
use super::sonar_model::{Surface, surface_in};
use super::{Cell, GridGeometry, MappingError, Occupancy, OccupancyMap};
use crate::geometry::{Point2, Pose2};
use crate::robot::{Lidar, RobotProfile, Sonar};

/// Directions a cone is divided into to see what stands before what.
const BINS: usize = 12;

/// Buffers kept between calls.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    cells: Vec<ConeCell>,
    /// Per cell, the number of the last array of ranges whose beams ended or passed there.
    stamp: Vec<u32>,
    count: u32,
}

/// A cell inside a cone.
#[derive(Clone, Copy, Debug)]
struct ConeCell {
    index: u32,
    distance_m: f32,
    /// Side of the axis: −1 and 1 at the edges of the cone.
    side: f32,
    /// How surely its surface answers; only computed for occupied cells.
    echo: f32,
}

/// A sonar's cone in the frame of the grid.
struct Cone {
    apex: Point2,
    heading: f64,
    half_rad: f64,
}

/// The part of a cone in which cells count that are not occupied.
#[derive(Clone, Copy)]
struct Open {
    tan: f32,
    near2: f32,
    far2: f32,
}

/// Where a row of cells may lie in a cone between two distances, told in generous bounds.
struct Strip {
    sides: [Side; 2],
    near2: f64,
    far2: f64,
    /// What single precision may be off by, where a side bounds at all.
    slack_m: f64,
    /// Side of a cell.
    res: f64,
}

/// Where a side of a cone crosses a row, by the row's offset, and whether it bounds the row to the right.
enum Side {
    Nowhere,
    Left(f64),
    Right(f64),
}

/// Sides of a cone flatter than this against a row bound nothing.
const FLAT: f64 = 1e-2;

impl Strip {
    fn new(axis: Point2, tan: f64, near_m: f64, far_m: f64, res: f64) -> Self {
        let slack_m = 1e-3 * far_m.abs() + 1e-6;
        // Inside, p · dx + q · dy is at most 0.
        let side = |p: f64, q: f64| {
            if p > FLAT {
                Side::Right(-q / p)
            } else if p < -FLAT {
                Side::Left(-q / p)
            } else {
                Side::Nowhere
            }
        };
        let sides = [
            side(-axis.y - tan * axis.x, axis.x - tan * axis.y),
            side(axis.y - tan * axis.x, -axis.x - tan * axis.y),
        ];
        let (near_m, far_m) = ((near_m - slack_m).max(0.0), far_m.abs() + slack_m);
        Self { sides, near2: near_m * near_m, far2: far_m * far_m, slack_m, res }
    }

    /// Spans of the offset from the apex along the row at `dy` from it \[m\], in order.
    fn at(&self, dy: f64) -> impl Iterator<Item = (f64, f64)> {
        let half_m = (self.far2 - dy * dy).max(0.0).sqrt();
        let (mut lo, mut hi) = (-half_m, half_m);
        for side in &self.sides {
            match *side {
                Side::Nowhere => {}
                Side::Left(slope) => lo = lo.max(slope * dy - self.slack_m),
                Side::Right(slope) => hi = hi.min(slope * dy + self.slack_m),
            }
        }
        let hollow_m = if self.near2 > 0.0 { (self.near2 - dy * dy).max(0.0).sqrt() } else { 0.0 };
        // Two spans only if they share no cell.
        let spans = if hollow_m > self.res {
            [(lo, hi.min(-hollow_m)), (lo.max(hollow_m), hi)]
        } else {
            [(lo, hi), (1.0, 0.0)]
        };
        spans.into_iter().filter(|(lo, hi)| lo <= hi)
    }
}

impl Cone {
    fn unit(&self, side: f32) -> Point2 {
        let (sin, cos) = (self.heading + f64::from(side) * self.half_rad).sin_cos();
        Point2::new(cos, sin)
    }
}

fn bin_of(side: f32) -> usize {
    (((side + 1.0) * 0.5 * BINS as f32) as usize).min(BINS - 1)
}

/// A reading of a sonar, sorted by what it says.
#[derive(Clone, Copy, PartialEq)]
enum Heard {
    Nothing,
    Echo(f64),
}

impl OccupancyMap {
    /// Adds the evidence of all sensors. Free evidence of all cones comes first, so that what one
    /// cone looks through is not taken for the reflector of another.
    pub(super) fn add_evidence(
        &mut self,
        world_from_robot: Pose2,
        profile: &RobotProfile,
        ranges_m: &[f64],
    ) -> Result<(), MappingError> {
        let (sonar_ranges, lidar_ranges) = ranges_m.split_at(profile.sonars.len());
        self.reach_sensors(world_from_robot, profile, sonar_ranges, lidar_ranges)?;
        if self.geometry.is_empty() {
            return Ok(());
        }
        let grid_from_robot = self.geometry.world_from_grid.inverse() * world_from_robot;
        let heard = |sonar: &Sonar, range_m: f64| {
            if range_m.is_nan() {
                None
            } else if range_m < sonar.max_range_m {
                Some(Heard::Echo(range_m.max(sonar.min_range_m)))
            } else {
                Some(Heard::Nothing)
            }
        };
        let mut arcs: Vec<(Cone, f64, [f32; BINS])> = Vec::with_capacity(sonar_ranges.len());
        for (sonar, &range_m) in profile.sonars.iter().zip(sonar_ranges) {
            let Some(heard) = heard(sonar, range_m) else { continue };
            let grid_from_sonar = grid_from_robot * sonar.pose;
            let cone = Cone {
                apex: grid_from_sonar.position(),
                heading: grid_from_sonar.heading,
                half_rad: sonar.beam_rad / 2.0,
            };
            let blocked = self.free_cone(&cone, heard, sonar.max_range_m);
            if let Heard::Echo(range_m) = heard
                && range_m <= self.config.sonar_hit_range_m
            {
                arcs.push((cone, range_m, blocked));
            }
        }
        for (cone, range_m, blocked) in &arcs {
            self.mark_arc(cone, *range_m, blocked);
        }
        if let Some(lidar) = &profile.lidar {
            self.add_beams(world_from_robot * lidar.pose, lidar, lidar_ranges);
        }
        Ok(())
    }

    /// Grows the grid over everything the readings speak of.
    fn reach_sensors(
        &mut self,
        world_from_robot: Pose2,
        profile: &RobotProfile,
        sonar_ranges: &[f64],
        lidar_ranges: &[f64],
    ) -> Result<(), MappingError> {
        if self.prior.is_some() {
            return Ok(());
        }
        let margin = profile.footprint.circumscribed_radius_m() + 2.0 * self.geometry.resolution_m;
        let at = world_from_robot.position();
        let (mut lo, mut hi) = (at, at);
        let mut hold = |p: Point2| {
            lo = Point2::new(lo.x.min(p.x), lo.y.min(p.y));
            hi = Point2::new(hi.x.max(p.x), hi.y.max(p.y));
        };
        for (sonar, &range_m) in profile.sonars.iter().zip(sonar_ranges) {
            let far_m = if range_m.is_nan() {
                continue;
            } else if range_m < sonar.max_range_m {
                range_m.min(self.config.sonar_free_range_m.max(self.config.sonar_hit_range_m))
            } else {
                self.config.sonar_miss_range_m
            };
            let world_from_sonar = world_from_robot * sonar.pose;
            for side in [-0.5, -0.25, 0.0, 0.25, 0.5] {
                let (sin, cos) = (side * sonar.beam_rad).sin_cos();
                hold(world_from_sonar * Point2::new(far_m * cos, far_m * sin));
            }
        }
        if let Some(lidar) = &profile.lidar {
            let world_from_lidar = world_from_robot * lidar.pose;
            for (beam, &range_m) in lidar_ranges.iter().enumerate() {
                if let Some((far_m, _)) = self.beam(lidar, range_m) {
                    let (sin, cos) = (lidar.first_rad + beam as f64 * lidar.step_rad).sin_cos();
                    hold(world_from_lidar * Point2::new(far_m * cos, far_m * sin));
                }
            }
        }
        let margin = Point2::new(margin, margin);
        self.reach(lo - margin, hi + margin)
    }

    /// Collects the cells of a cone whose centres lie between two distances. Of those that are not occupied
    /// only the ones with more evidence than `above`, and inside `open` if that is smaller.
    fn collect(&mut self, cone: &Cone, near_m: f64, far_m: f64, above: f32, open: Option<Open>) {
        let GridGeometry { rows, cols, resolution_m: res, .. } = self.geometry;
        let cells = &mut self.scratch.cells;
        cells.clear();
        let (mut lo, mut hi) = (cone.apex, cone.apex);
        for side in [-1.0, -0.5, 0.0, 0.5, 1.0] {
            let p = cone.apex + cone.unit(side) * far_m;
            lo = Point2::new(lo.x.min(p.x), lo.y.min(p.y));
            hi = Point2::new(hi.x.max(p.x), hi.y.max(p.y));
        }
        let span = |lo: f64, hi: f64, cells: usize| {
            let first = (lo / res - 1.0).floor().max(0.0);
            let end = (hi / res + 2.0).floor().min(cells as f64).max(0.0);
            first as usize..end as usize
        };
        let axis = cone.unit(0.0);
        let (ax, ay) = (axis.x as f32, axis.y as f32);
        let tan = cone.half_rad.min(1.5).tan() as f32;
        let (near2, far2) = ((near_m * near_m) as f32, (far_m * far_m) as f32);
        let near2 = if near_m <= 0.0 { -1.0 } else { near2 };
        let columns = span(lo.x, hi.x, cols);
        let strip = Strip::new(axis, f64::from(tan), near_m, far_m, res);
        let per_m = 1.0 / res;
        let Open { tan: open_tan, near2: open_near2, far2: open_far2 } =
            open.unwrap_or(Open { tan: f32::INFINITY, near2: -1.0, far2: f32::INFINITY });
        for row in span(lo.y, hi.y, rows) {
            let exact_dy = (row as f64 + 0.5) * res - cone.apex.y;
            let dy = exact_dy as f32;
            for (from_m, to_m) in strip.at(exact_dy) {
                let first = ((from_m + cone.apex.x) * per_m).max(columns.start as f64) as usize;
                let end = ((to_m + cone.apex.x) * per_m + 1.0).clamp(0.0, columns.end as f64) as usize;
                let first = first.min(end);
                let (from, to) = (row * cols + first, row * cols + end);
                let evidence = self.log_odds[from..to].iter().zip(&self.class[from..to]);
                for (col, (&log_odds, &class)) in (first..end).zip(evidence) {
                    let is_open = class != Occupancy::Occupied;
                    if is_open && log_odds <= above {
                        continue;
                    }
                    let dx = ((col as f64 + 0.5) * res - cone.apex.x) as f32;
                    let along = dx * ax + dy * ay;
                    let across = dy * ax - dx * ay;
                    let d2 = dx * dx + dy * dy;
                    if along <= 0.0 || across.abs() > tan * along || d2 > far2 || d2 < near2 {
                        continue;
                    }
                    if is_open && (across.abs() > open_tan * along || d2 > open_far2 || d2 < open_near2) {
                        continue;
                    }
                    cells.push(ConeCell {
                        index: (row * cols + col) as u32,
                        distance_m: d2.sqrt(),
                        side: across / (tan * along),
                        echo: 0.0,
                    });
                }
            }
        }
    }

    /// Nothing answered nearer than the reading. Gives the distance of the nearest thing that hides
    /// what is behind it, for each direction.
    fn free_cone(&mut self, cone: &Cone, heard: Heard, max_range_m: f64) -> [f32; BINS] {
        let c = self.config;
        let res = self.geometry.resolution_m;
        let (free_end_m, strength, floor) = match heard {
            Heard::Echo(r) => {
                let tolerance_m = c.sonar_tolerance_m + 0.02 * r + 0.5 * res;
                ((r - tolerance_m).min(c.sonar_free_range_m), c.sonar_free, c.floor)
            }
            Heard::Nothing => (c.sonar_miss_range_m.min(max_range_m), c.sonar_miss_free, c.sonar_miss_floor),
        };
        let mut blocked = [f32::INFINITY; BINS];
        self.collect(cone, 0.0, free_end_m, floor as f32, None);
        let mut cells = std::mem::take(&mut self.scratch.cells);
        let half_res = 0.5 * res as f32;
        let block = |cell: &ConeCell, blocked: &mut [f32; BINS]| {
            let half = half_res / cell.distance_m.max(res as f32) / cone.half_rad as f32;
            for bin in &mut blocked[bin_of(cell.side - half)..=bin_of(cell.side + half)] {
                *bin = bin.min(cell.distance_m);
            }
        };
        // Nothing is learnt of what stands behind a wall of the prior map, so that is found first ...
        for cell in cells.iter().filter(|cell| self.class[cell.index as usize] == Occupancy::Occupied) {
            if self.is_prior_wall(cell.index as usize) {
                block(cell, &mut blocked);
            }
        }
        // ... nor behind a wall that would not have answered.
        for cell in &mut cells {
            let i = cell.index as usize;
            let hidden = cell.distance_m > blocked[bin_of(cell.side)] + half_res;
            if self.class[i] != Occupancy::Occupied || hidden {
                continue;
            }
            let seen = self.surface_at(i, cone.unit(cell.side));
            cell.echo = seen.echo(false) as f32;
            if cell.echo < 0.5 {
                block(cell, &mut blocked);
            }
        }
        let reach_m = free_end_m.max(1e-6) as f32;
        for cell in &cells {
            if cell.distance_m > blocked[bin_of(cell.side)] + half_res {
                continue;
            }
            let i = cell.index as usize;
            let edge = 1.0 - 0.7 * cell.side * cell.side;
            let far = 1.0 - 0.5 * (cell.distance_m / reach_m) * (cell.distance_m / 3.0).min(1.0);
            let mut step = strength as f32 * edge * far;
            if self.class[i] == Occupancy::Occupied {
                // Where an answer was due, silence says as much as a longer range.
                step = c.sonar_free as f32 * edge * far * (cell.echo * cell.echo).max(0.01);
                if self.is_prior_wall(i) {
                    step *= c.prior_erosion as f32;
                }
            }
            let l = &mut self.log_odds[i];
            if *l > floor as f32 {
                *l = (*l - step).max(floor as f32);
                self.touched.push(cell.index);
            }
        }
        self.scratch.cells = cells;
        blocked
    }

    fn surface_at(&self, index: usize, unit: Point2) -> Surface {
        let Cell { row, col } = self.geometry.cell(index);
        surface_in(self.occupied.window(row, col), unit)
    }

    /// Something on the arc answered. As one reflector is enough, the evidence is shared in
    /// proportion to the odds of each cell being it (and of its surface answering): known walls
    /// take all of it, an arc of which nothing is known shares it evenly.
    fn mark_arc(&mut self, cone: &Cone, range_m: f64, blocked: &[f32; BINS]) {
        let c = self.config;
        let half_res = 0.5 * self.geometry.resolution_m;
        let own_m = (c.sonar_tolerance_m + 0.02 * range_m).max(half_res) as f32;
        let prior_m = (c.prior_tolerance_m + 0.02 * range_m) as f32;
        let wide_m = f64::from(if self.prior.is_some() { own_m.max(prior_m) } else { own_m });
        // A door post just beyond the edge of the cone by an estimate a little off may have answered.
        let slack_rad =
            if self.prior.is_some() { c.prior_slack_rad + c.prior_slack_m / range_m.max(0.1) } else { 0.0 };
        let wide = Cone { half_rad: cone.half_rad + slack_rad, ..*cone };
        let beyond = (wide.half_rad.min(1.5).tan() / cone.half_rad.min(1.5).tan()) as f32;
        let beside_m = (c.prior_slack_m + 0.02 * range_m) as f32;
        // Only a wall may answer from beside the cone, or from as far off as the prior map may be; bounds with
        // room for rounding, as what is told below decides.
        let (near_m, far_m) = ((range_m as f32 - own_m - 1e-3).max(0.0), range_m as f32 + own_m + 1e-3);
        let open_tan = (cone.half_rad.min(1.5).tan() * 1.001) as f32;
        let open = Open { tan: open_tan, near2: near_m * near_m, far2: far_m * far_m };
        self.collect(&wide, range_m - wide_m, range_m + wide_m, f32::NEG_INFINITY, Some(open));
        let mut cells = std::mem::take(&mut self.scratch.cells);
        let mut total = 0.0f32;
        for cell in &mut cells {
            cell.side *= beyond;
            let i = cell.index as usize;
            let off_m = (cell.distance_m - range_m as f32).abs();
            let wall = self.is_prior_wall(i) && self.class[i] == Occupancy::Occupied;
            let beside = cell.side.abs() > 1.0;
            let near_m = match (wall, beside) {
                (true, true) => beside_m,
                (true, false) => prior_m,
                (false, _) => own_m,
            };
            let bin = bin_of(cell.side);
            let mut sight_m = blocked[bin];
            if wall {
                // Past the edge of what hides it, by an estimate a little off.
                for &other_m in &blocked[bin.saturating_sub(1)..=(bin + 1).min(BINS - 1)] {
                    sight_m = sight_m.max(other_m);
                }
            }
            let hidden = cell.distance_m > sight_m + 2.0 * half_res as f32;
            if hidden || (beside && !wall) || off_m > near_m {
                cell.echo = 0.0;
                continue;
            }
            let answers = if self.class[i] == Occupancy::Occupied {
                self.surface_at(i, cone.unit(cell.side)).echo(true) as f32
            } else {
                1.0
            };
            cell.echo = self.log_odds[i].exp() * answers * (1.0 - 0.5 * cell.side * cell.side).max(0.3);
            total += cell.echo;
        }
        if total > 0.0 {
            let (spread, hit) = (c.sonar_hit_spread as f32, c.sonar_hit as f32);
            for cell in cells.iter().filter(|cell| cell.echo > 0.0) {
                let i = cell.index as usize;
                let most = if self.is_prior_wall(i) { c.prior_occupied } else { c.ceiling } as f32;
                let step = hit * (spread * cell.echo / total).min(1.0);
                self.log_odds[i] = (self.log_odds[i] + step).min(most.max(self.log_odds[i]));
                self.touched.push(cell.index);
            }
        }
        self.scratch.cells = cells;
    }

    /// Whether a wall of the prior map stands where a sonar's echo came from, by an estimate a little off.
    pub fn explains(&self, world_from_sonar: Pose2, beam_rad: f64, range_m: f64) -> bool {
        if self.prior.is_none() {
            return false;
        }
        let c = &self.config;
        let near_m = c.prior_tolerance_m + 0.02 * range_m;
        let half_rad = beam_rad / 2.0 + c.prior_slack_rad + c.prior_slack_m / range_m.max(0.1);
        let step_m = self.geometry.resolution_m;
        let across = ((2.0 * half_rad * (range_m + near_m) / step_m).ceil() as usize).max(1);
        let along = (2.0 * near_m / step_m).ceil() as usize;
        (0..=across).any(|i| {
            let (sin, cos) = (half_rad * (2.0 * i as f64 / across as f64 - 1.0)).sin_cos();
            (0..=along).any(|j| {
                let r = range_m + near_m * (2.0 * j as f64 / along as f64 - 1.0);
                let cell = self.geometry.cell_at(world_from_sonar * Point2::new(r * cos, r * sin));
                cell.is_some_and(|cell| self.is_prior_wall(self.geometry.index(cell)))
            })
        })
    }

    /// How far a beam frees, and whether it ended at something. None: says nothing.
    fn beam(&self, lidar: &Lidar, range_m: f64) -> Option<(f64, bool)> {
        if range_m.is_nan() || range_m < lidar.min_range_m {
            None
        } else if range_m < lidar.max_range_m {
            Some((range_m, true))
        } else {
            Some((self.config.lidar_miss_range_m.min(lidar.max_range_m), false))
        }
    }

    /// Adds a whole scan: every cell gets at most one piece of evidence, and an end counts before a pass.
    fn add_beams(&mut self, world_from_lidar: Pose2, lidar: &Lidar, ranges_m: &[f64]) {
        let c = self.config;
        let from = world_from_lidar.position();
        let mut scratch = std::mem::take(&mut self.scratch);
        if scratch.stamp.len() != self.log_odds.len() || scratch.count == u32::MAX {
            scratch.stamp = vec![0; self.log_odds.len()];
            scratch.count = 0;
        }
        scratch.count += 1;
        let direction =
            |beam: usize| world_from_lidar.heading + lidar.first_rad + beam as f64 * lidar.step_rad;
        for (beam, &range_m) in ranges_m.iter().enumerate() {
            let Some((end_m, true)) = self.beam(lidar, range_m) else { continue };
            let (sin, cos) = direction(beam).sin_cos();
            let Some(i) = self.reflector(from + Point2::new(cos, sin) * end_m) else { continue };
            if scratch.stamp[i] == scratch.count {
                continue;
            }
            scratch.stamp[i] = scratch.count;
            let most = if self.is_prior_wall(i) { c.prior_occupied } else { c.ceiling } as f32;
            self.log_odds[i] = (self.log_odds[i] + c.lidar_hit as f32).min(most.max(self.log_odds[i]));
            self.touched.push(i as u32);
        }
        for (beam, &range_m) in ranges_m.iter().enumerate() {
            let Some((end_m, _)) = self.beam(lidar, range_m) else { continue };
            let near_end_m = end_m - self.geometry.resolution_m;
            for (i, entered_m) in Traversal::new(&self.geometry, from, direction(beam)) {
                if entered_m >= near_end_m {
                    break;
                }
                if scratch.stamp[i] == scratch.count {
                    continue;
                }
                scratch.stamp[i] = scratch.count;
                let wall = self.is_prior_wall(i) && self.class[i] == Occupancy::Occupied;
                let step = c.lidar_free as f32 * if wall { c.prior_erosion as f32 } else { 1.0 };
                self.log_odds[i] = (self.log_odds[i] - step).max((c.floor as f32).min(self.log_odds[i]));
                self.touched.push(i as u32);
            }
        }
        self.scratch = scratch;
    }

    /// The cell a beam's end speaks of: the nearest wall of the prior map within the tolerance,
    /// else the cell the end lies in.
    fn reflector(&self, end_in_world: Point2) -> Option<usize> {
        let here = self.geometry.cell_at(end_in_world)?;
        let index = self.geometry.index(here);
        if self.prior.is_none() || self.is_prior_wall(index) {
            return Some(index);
        }
        let reach = (self.config.prior_tolerance_m / self.geometry.resolution_m) as i64;
        let mut best = (i64::MAX, index);
        for dr in -reach..=reach {
            for dc in -reach..=reach {
                let (r, k) = (here.row as i64 + dr, here.col as i64 + dc);
                let far2 = dr * dr + dc * dc;
                let inside =
                    r >= 0 && k >= 0 && r < self.geometry.rows as i64 && k < self.geometry.cols as i64;
                if inside && far2 <= reach * reach && far2 < best.0 {
                    let i = (r * self.geometry.cols as i64 + k) as usize;
                    if self.is_prior_wall(i) && self.class[i] == Occupancy::Occupied {
                        best = (far2, i);
                    }
                }
            }
        }
        Some(best.1)
    }
}

#[cfg(test)]
mod tests {
    use super::super::MappingConfig;
    use super::*;
    use proptest::prelude::*;

    /// Every cell of the grid is looked at.
    fn looked_for(map: &OccupancyMap, cone: &Cone, near_m: f64, far_m: f64, above: f32) -> Vec<[u32; 3]> {
        let res = map.geometry.resolution_m;
        let axis = cone.unit(0.0);
        let (ax, ay, tan) = (axis.x as f32, axis.y as f32, cone.half_rad.tan() as f32);
        let near2 = if near_m <= 0.0 { -1.0 } else { (near_m * near_m) as f32 };
        let mut found = Vec::new();
        for i in 0..map.geometry.len() {
            let Cell { row, col } = map.geometry.cell(i);
            let dx = ((col as f64 + 0.5) * res - cone.apex.x) as f32;
            let dy = ((row as f64 + 0.5) * res - cone.apex.y) as f32;
            let (along, across, d2) = (dx * ax + dy * ay, dy * ax - dx * ay, dx * dx + dy * dy);
            let inside = along > 0.0 && across.abs() <= tan * along;
            let counts = map.class[i] == Occupancy::Occupied || map.log_odds[i] > above;
            if counts && inside && d2 <= (far_m * far_m) as f32 && d2 >= near2 {
                found.push([i as u32, d2.sqrt().to_bits(), (across / (tan * along)).to_bits()]);
            }
        }
        found
    }

    proptest! {
        #[test]
        fn a_cone_holds_the_same_cells_row_by_row_as_when_every_cell_is_looked_at(
            at in (-0.5..4.5f64, -0.5..3.5f64),
            heading in prop_oneof![-3.2..3.2f64, (-4i32..5).prop_map(|i| f64::from(i) * std::f64::consts::FRAC_PI_4)],
            half_rad in 0.02..0.6f64,
            near_m in prop_oneof![Just(0.0), 0.0..2.5f64],
            depth_m in 0.02..3.0f64,
            res in prop_oneof![Just(0.05), 0.02..0.3f64],
            seed in any::<u64>(),
        ) {
            let (rows, cols) = ((3.0 / res) as usize, (4.0 / res) as usize);
            let geometry = GridGeometry { rows, cols, resolution_m: res, world_from_grid: Pose2::IDENTITY };
            let prior = super::super::Grid::filled(geometry, Occupancy::Free);
            let mut map = OccupancyMap::from_occupancy(&MappingConfig::default(), &prior).unwrap();
            for i in 0..geometry.len() {
                let chance = (i as u64 + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 61;
                map.log_odds[i] = chance as f32 - 4.0;
                map.class[i] = if chance == 7 { Occupancy::Occupied } else { Occupancy::Free };
            }
            let cone = Cone { apex: Point2::new(at.0, at.1), heading, half_rad };
            for above in [f32::NEG_INFINITY, -2.0] {
                map.collect(&cone, near_m, near_m + depth_m, above, None);
                let told: Vec<[u32; 3]> = map
                    .scratch
                    .cells
                    .iter()
                    .map(|cell| [cell.index, cell.distance_m.to_bits(), cell.side.to_bits()])
                    .collect();
                prop_assert_eq!(told, looked_for(&map, &cone, near_m, near_m + depth_m, above));
            }
        }
    }
}
