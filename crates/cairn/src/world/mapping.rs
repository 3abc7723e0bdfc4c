//! An occupancy map built from ranges: log-odds per cell `[Elfes89]`, on a grid that grows.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::marks::Marks;
use super::{Cell, CellSet, Grid, GridGeometry, Occupancy, OccupancyGrid};
use crate::geometry::{Point2, Pose2};
use crate::robot::RobotProfile;

/// Side of the blocks a map grows by \[cells\].
const CHUNK: i64 = 64;

/// More changed cells than this are not kept one by one.
const MOST_CHANGES: usize = 1 << 16;

/// How readings become evidence. All evidence is in log-odds (nats).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MappingConfig {
    /// What one echo adds to the cells that explain it, shared among them.
    pub sonar_hit: f64,
    /// How many cells' worth of full evidence one echo may hand out: larger closes arcs faster.
    pub sonar_hit_spread: f64,
    /// What one echo takes from a cell on the cone's axis that it looked through.
    pub sonar_free: f64,
    /// The same for a cry that was not answered: a smooth wall may have sent it elsewhere.
    pub sonar_miss_free: f64,
    /// An unanswered cry brings no cell below this.
    pub sonar_miss_floor: f64,
    /// Echoes from farther away mark nothing: their arcs are too wide \[m\].
    pub sonar_hit_range_m: f64,
    /// An echo frees cells up to here \[m\].
    pub sonar_free_range_m: f64,
    /// An unanswered cry frees cells up to here \[m\].
    pub sonar_miss_range_m: f64,
    /// Half the thickness of the arc an echo marks \[m\]; 2 % of the range is added.
    pub sonar_tolerance_m: f64,
    /// What one lidar return adds to the cell it ends in.
    pub lidar_hit: f64,
    /// What one lidar beam takes from a cell it passes.
    pub lidar_free: f64,
    /// A beam without return frees cells up to here \[m\].
    pub lidar_miss_range_m: f64,
    /// A wall of the prior map this near to where a reading ends explains it \[m\].
    pub prior_tolerance_m: f64,
    /// How far beside the cone a wall of the prior map explains an echo, whatever the range \[rad\] ...
    pub prior_slack_rad: f64,
    /// ... and by how far the pose may be off; also how well the range must fit there \[m\].
    pub prior_slack_m: f64,
    /// Evidence a wall of the prior map starts with, and its ceiling.
    pub prior_occupied: f64,
    /// Evidence a free cell of the prior map starts with.
    pub prior_free: f64,
    /// Share of free evidence that counts against a wall of the prior map.
    pub prior_erosion: f64,
    /// Ceiling of evidence for everything else: how long a thing that left is remembered.
    pub ceiling: f64,
    /// Floor of evidence: how long a thing that came stays unseen.
    pub floor: f64,
    /// From this on a cell is occupied.
    pub occupied_above: f64,
    /// An occupied cell stays so until its evidence falls to this.
    pub released_below: f64,
    /// A cell never seen before is free from this downwards: less than unanswered cries alone can say,
    /// because they would open every wall met at a slant.
    pub free_below: f64,
    /// Most cells a map may grow to.
    pub most_cells: usize,
}

impl Default for MappingConfig {
    fn default() -> Self {
        Self {
            sonar_hit: 1.5,
            sonar_hit_spread: 6.0,
            sonar_free: 0.6,
            sonar_miss_free: 0.25,
            sonar_miss_floor: -0.8,
            sonar_hit_range_m: 3.0,
            sonar_free_range_m: 3.0,
            sonar_miss_range_m: 2.2,
            sonar_tolerance_m: 0.03,
            lidar_hit: 1.2,
            lidar_free: 0.5,
            lidar_miss_range_m: 8.0,
            prior_tolerance_m: 0.12,
            prior_slack_rad: 0.03,
            prior_slack_m: 0.06,
            prior_occupied: 8.0,
            prior_free: -1.0,
            prior_erosion: 0.1,
            ceiling: 3.5,
            floor: -2.0,
            occupied_above: 1.0,
            released_below: 0.0,
            free_below: -0.9,
            most_cells: 64_000_000,
        }
    }
}

/// Why a reading, or the settings of a map, were refused.
#[derive(Clone, Debug, PartialEq, Error, Serialize)]
pub enum MappingError {
    /// A setting cannot be.
    #[error("mapping: {key} is {value}, must be a number from {least} to {most}")]
    MappingValueOutOfRange {
        /// Name of the setting.
        key: String,
        /// What was given.
        value: f64,
        /// Least usable value.
        least: f64,
        /// Greatest usable value.
        most: f64,
    },
    /// The pose holds NaN or infinity.
    #[error("mapping: the pose ({x_m}, {y_m}) m, {heading_rad} rad is not a pose; all three must be finite")]
    MappingPoseNotFinite {
        /// Given x.
        x_m: f64,
        /// Given y.
        y_m: f64,
        /// Given heading.
        heading_rad: f64,
    },
    /// The array of ranges is not one reading for each sonar, then one for each beam.
    #[error("mapping: {given} ranges were given, the profile has {expected} (sonars, then lidar beams)")]
    MappingRangeCount {
        /// Length of the array.
        given: usize,
        /// Sensors of the profile.
        expected: usize,
    },
    /// A range is below zero.
    #[error("mapping: range {index} is {range_m} m; a range is at least 0 (inf: no echo, nan: not measured)")]
    MappingRangeNegative {
        /// Index in the array of ranges.
        index: usize,
        /// What was given.
        range_m: f64,
    },
    /// The map would grow beyond what the settings allow.
    #[error("mapping: the map would grow to {rows} x {cols} cells, more than {most} (mapping.most_cells)")]
    MappingTooLarge {
        /// Rows needed.
        rows: usize,
        /// Columns needed.
        cols: usize,
        /// Most cells allowed.
        most: usize,
    },
}

impl MappingConfig {
    fn checked(&self, resolution_m: f64) -> Result<(), MappingError> {
        let inf = f64::INFINITY;
        let checks = [
            ("resolution_m", resolution_m, 1e-3, 10.0),
            ("occupied_above", self.occupied_above, 0.0, 30.0),
            ("free_below", self.free_below, -30.0, 0.0),
            ("ceiling", self.ceiling, self.occupied_above, 30.0),
            ("floor", self.floor, -30.0, self.free_below),
            ("released_below", self.released_below, self.free_below, self.occupied_above),
            ("sonar_hit", self.sonar_hit, 0.0, inf),
            ("sonar_hit_spread", self.sonar_hit_spread, 1.0, inf),
            ("sonar_free", self.sonar_free, 0.0, inf),
            ("sonar_miss_free", self.sonar_miss_free, 0.0, inf),
            ("sonar_miss_floor", self.sonar_miss_floor, self.floor, self.ceiling),
            ("sonar_hit_range_m", self.sonar_hit_range_m, 0.0, 100.0),
            ("sonar_free_range_m", self.sonar_free_range_m, 0.0, 100.0),
            ("sonar_miss_range_m", self.sonar_miss_range_m, 0.0, 100.0),
            ("sonar_tolerance_m", self.sonar_tolerance_m, 0.0, 1.0),
            ("lidar_hit", self.lidar_hit, 0.0, inf),
            ("lidar_free", self.lidar_free, 0.0, inf),
            ("lidar_miss_range_m", self.lidar_miss_range_m, 0.0, 1000.0),
            ("prior_tolerance_m", self.prior_tolerance_m, 0.0, 1.0),
            ("prior_slack_rad", self.prior_slack_rad, 0.0, 0.5),
            ("prior_slack_m", self.prior_slack_m, 0.0, 1.0),
            ("prior_occupied", self.prior_occupied, self.occupied_above, 30.0),
            ("prior_free", self.prior_free, self.floor, self.occupied_above),
            ("prior_erosion", self.prior_erosion, 0.0, 1.0),
        ];
        for (key, value, least, most) in checks {
            if !(value.is_finite() && least <= value && value <= most) {
                return Err(MappingError::MappingValueOutOfRange { key: key.to_owned(), value, least, most });
            }
        }
        Ok(())
    }
}

/// Tells the cells of a row whose centres lie within a disc.
struct Within {
    res: f64,
    at_x: f64,
    dy: f64,
    radius_m: f64,
}

impl Within {
    #[inline]
    fn holds(&self, col: usize) -> bool {
        let dx = (col as f64 + 0.5) * self.res - self.at_x;
        dx * dx + self.dy * self.dy <= self.radius_m * self.radius_m
    }
}

/// What stands where, learnt from sonar cones and lidar beams.
///
/// Without a prior map the grid grows in blocks of 64 cells as things are seen; its cell borders
/// always lie on multiples of the resolution. With a prior map it keeps that map's geometry, and
/// what happens outside is not recorded.
#[derive(Clone, Debug)]
pub struct OccupancyMap {
    pub(super) config: MappingConfig,
    pub(super) geometry: GridGeometry,
    /// First row and column, in cells from the world's origin; only for maps that grow.
    first: (i64, i64),
    pub(super) log_odds: Vec<f32>,
    pub(super) class: Vec<Occupancy>,
    /// Occupied cells, by [`Self::class`].
    pub(super) occupied: Marks,
    pub(super) prior: Option<Vec<Occupancy>>,
    revision: u64,
    /// Cells whose class changed since it was last asked; None before that, or once there were too many, or
    /// the grid grew.
    changed: Option<Vec<u32>>,
    /// Cells that the robot felt to be occupied: no range can free them.
    felt: Vec<u32>,
    /// Cells whose evidence changed since they were last classified; may repeat.
    pub(super) touched: Vec<u32>,
    pub(super) scratch: super::evidence::Scratch,
}

impl OccupancyMap {
    /// A map of nothing (0 × 0 cells), to grow as things are seen.
    ///
    /// # Errors
    /// [`MappingError::MappingValueOutOfRange`].
    pub fn new(config: &MappingConfig, resolution_m: f64) -> Result<Self, MappingError> {
        config.checked(resolution_m)?;
        Ok(Self {
            config: *config,
            geometry: GridGeometry { rows: 0, cols: 0, resolution_m, world_from_grid: Pose2::IDENTITY },
            first: (0, 0),
            log_odds: Vec::new(),
            class: Vec::new(),
            prior: None,
            revision: 0,
            changed: None,
            felt: Vec::new(),
            touched: Vec::new(),
            occupied: Marks::default(),
            scratch: Default::default(),
        })
    }

    /// A map that begins as `prior` and keeps its geometry.
    ///
    /// # Errors
    /// [`MappingError::MappingValueOutOfRange`], [`MappingError::MappingTooLarge`].
    pub fn from_occupancy(config: &MappingConfig, prior: &OccupancyGrid) -> Result<Self, MappingError> {
        config.checked(prior.geometry.resolution_m)?;
        let GridGeometry { rows, cols, .. } = prior.geometry;
        if prior.geometry.len() > config.most_cells.min(u32::MAX as usize) {
            return Err(MappingError::MappingTooLarge { rows, cols, most: config.most_cells });
        }
        let start = |occupancy: &Occupancy| match occupancy {
            Occupancy::Free => config.prior_free as f32,
            Occupancy::Occupied => config.prior_occupied as f32,
            Occupancy::Unknown => 0.0,
        };
        Ok(Self {
            config: *config,
            geometry: prior.geometry,
            first: (0, 0),
            log_odds: prior.values.iter().map(start).collect(),
            class: prior.values.clone(),
            prior: Some(prior.values.clone()),
            revision: 0,
            changed: None,
            felt: Vec::new(),
            touched: Vec::new(),
            occupied: Marks::of(rows, cols, &prior.values, |&class| class == Occupancy::Occupied),
            scratch: Default::default(),
        })
    }

    /// Adds one array of ranges taken at `world_from_robot`: sonars, then lidar beams \[m\].
    ///
    /// `inf`: no echo; NaN: not measured, says nothing. A sonar's range r says: nothing nearer
    /// than r in the cone, and something on its arc, most likely where something is known to be.
    ///
    /// # Errors
    /// [`MappingError::MappingPoseNotFinite`], [`MappingError::MappingRangeCount`],
    /// [`MappingError::MappingRangeNegative`], [`MappingError::MappingTooLarge`]; the map is then as before.
    pub fn integrate(
        &mut self,
        world_from_robot: Pose2,
        profile: &RobotProfile,
        ranges_m: &[f64],
    ) -> Result<(), MappingError> {
        if !world_from_robot.is_finite() {
            return Err(MappingError::MappingPoseNotFinite {
                x_m: world_from_robot.x,
                y_m: world_from_robot.y,
                heading_rad: world_from_robot.heading,
            });
        }
        if ranges_m.len() != profile.range_count() {
            return Err(MappingError::MappingRangeCount {
                given: ranges_m.len(),
                expected: profile.range_count(),
            });
        }
        if let Some((index, &range_m)) = ranges_m.iter().enumerate().find(|(_, r)| **r < 0.0) {
            return Err(MappingError::MappingRangeNegative { index, range_m });
        }
        self.add_evidence(world_from_robot, profile, ranges_m)?;
        self.hold_felt();
        self.classify();
        Ok(())
    }

    /// What is known now. The grid's shape is that of [`Self::geometry`].
    pub fn occupancy(&self) -> OccupancyGrid {
        Grid::new(self.geometry, self.class.clone())
    }

    /// True at occupied cells.
    pub fn occupied(&self) -> Grid<bool> {
        Grid::new(self.geometry, self.class.iter().map(|&class| class == Occupancy::Occupied).collect())
    }

    /// The prior map, if there is one.
    pub fn prior(&self) -> Option<OccupancyGrid> {
        self.prior.as_ref().map(|prior| Grid::new(self.geometry, prior.clone()))
    }

    /// The classes of [`Self::occupancy`], row-major, without a copy.
    pub fn classes(&self) -> &[Occupancy] {
        &self.class
    }

    /// Shape and place of the map; grows with it when there is no prior map.
    pub fn geometry(&self) -> GridGeometry {
        self.geometry
    }

    /// Probability that a cell is occupied, row-major, 0 to 1; 0.5 where nothing is known.
    pub fn probabilities(&self) -> Grid<f32> {
        Grid::new(self.geometry, self.log_odds.iter().map(|l| 1.0 / (1.0 + (-l).exp())).collect())
    }

    /// Counts the changes: greater whenever a cell changed its class or the grid its shape.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Cells whose class changed since this was last asked, each once, with what they are now; None if
    /// the grid has another shape now, or too much changed to say.
    pub fn take_changes(&mut self) -> Option<Vec<(Cell, Occupancy)>> {
        let mut changed = self.changed.replace(Vec::new())?;
        changed.sort_unstable();
        changed.dedup();
        Some(changed.into_iter().map(|i| (self.geometry.cell(i as usize), self.class[i as usize])).collect())
    }

    fn set_class(&mut self, index: usize, class: Occupancy) {
        self.class[index] = class;
        let Cell { row, col } = self.geometry.cell(index);
        self.occupied.set(row, col, class == Occupancy::Occupied);
        self.note_change(index);
    }

    fn note_change(&mut self, index: usize) {
        if let Some(changed) = &mut self.changed {
            if changed.len() < MOST_CHANGES {
                changed.push(index as u32);
            } else {
                self.changed = None;
            }
        }
    }

    /// Something that no range shows stands at `points_in_world`: the robot felt it. Such cells stay
    /// occupied whatever is measured, until [`Self::forget_felt`]. Points outside are left out.
    pub fn feel(&mut self, points_in_world: impl IntoIterator<Item = Point2>) {
        for point in points_in_world {
            let Some(cell) = self.geometry.cell_at(point) else { continue };
            let i = self.geometry.index(cell);
            if !self.felt.contains(&(i as u32)) {
                self.felt.push(i as u32);
            }
            self.touched.push(i as u32);
        }
        self.hold_felt();
        self.classify();
    }

    /// Forgets what was only felt: from now on ranges say what stands there. Returns how many cells.
    pub fn forget_felt(&mut self) -> usize {
        let felt = std::mem::take(&mut self.felt);
        for &i in &felt {
            if !self.is_prior_wall(i as usize) {
                self.log_odds[i as usize] = 0.0;
                self.touched.push(i);
            }
        }
        self.classify();
        felt.len()
    }

    /// Centres of the cells felt to be occupied, world frame \[m\].
    pub fn felt(&self) -> Vec<Point2> {
        self.felt.iter().map(|&i| self.geometry.center(self.geometry.cell(i as usize))).collect()
    }

    /// Whatever the ranges said, what was felt stands there.
    fn hold_felt(&mut self) {
        let most = self.config.ceiling as f32;
        for &i in &self.felt {
            let l = &mut self.log_odds[i as usize];
            *l = l.max(most);
        }
    }

    /// Centres of the occupied cells within `radius_m`, world frame \[m\], by row, then column.
    pub fn occupied_near(&self, center_in_world: Point2, radius_m: f64) -> Vec<Point2> {
        self.occupied_near_where(center_in_world, radius_m, None, |_| true)
    }

    /// Like [`Self::occupied_near`], but only what the prior map does not show. Without a prior
    /// map that is everything.
    pub fn unmapped_near(&self, center_in_world: Point2, radius_m: f64) -> Vec<Point2> {
        self.occupied_near_where(center_in_world, radius_m, None, |i| !self.is_prior_wall(i))
    }

    /// True at cells that are occupied and were not so in the prior map.
    pub fn unmapped(&self) -> Grid<bool> {
        Grid::new(self.geometry, (0..self.class.len()).map(|i| self.is_unmapped(i)).collect())
    }

    /// Forgets what the prior map does not show, what was only felt apart, farther than `beyond_m` from `center_in_world`: such
    /// cells become what the prior map, or nothing, says of them. Returns how many.
    pub fn forget_unmapped(&mut self, center_in_world: Point2, beyond_m: f64) -> usize {
        let mut forgotten = 0;
        for i in 0..self.class.len() {
            let far = || self.geometry.center(self.geometry.cell(i)).distance(center_in_world) > beyond_m;
            if self.is_unmapped(i) && far() && !self.felt.contains(&(i as u32)) {
                let prior = self.prior.as_ref().map_or(Occupancy::Unknown, |prior| prior[i]);
                self.set_class(i, prior);
                self.log_odds[i] = if prior == Occupancy::Free { self.config.prior_free as f32 } else { 0.0 };
                forgotten += 1;
            }
        }
        if forgotten > 0 {
            self.revision += 1;
        }
        forgotten
    }

    /// Frees every cell within `radius_m`, but not the walls of the prior map: the robot stands here.
    pub fn clear_disc(&mut self, center_in_world: Point2, radius_m: f64) {
        self.clear_discs([center_in_world], radius_m);
    }

    /// As [`Self::clear_disc`], around every one of `centers_in_world`.
    pub fn clear_discs(&mut self, centers_in_world: impl IntoIterator<Item = Point2>, radius_m: f64) {
        let floor = self.config.floor as f32;
        let mut touched = std::mem::take(&mut self.touched);
        let mut log_odds = std::mem::take(&mut self.log_odds);
        for center in centers_in_world {
            self.visit(center, radius_m, |i| {
                let is_clear = log_odds[i] <= floor && self.class[i] == Occupancy::Free;
                if !is_clear && !self.is_prior_wall(i) {
                    log_odds[i] = log_odds[i].min(floor);
                    touched.push(i as u32);
                }
            });
        }
        (self.log_odds, self.touched) = (log_odds, touched);
        self.classify();
    }

    pub(super) fn is_prior_wall(&self, index: usize) -> bool {
        self.prior.as_ref().is_some_and(|prior| prior[index] == Occupancy::Occupied)
    }

    fn is_unmapped(&self, index: usize) -> bool {
        self.class[index] == Occupancy::Occupied && !self.is_prior_wall(index)
    }

    /// Of [`Self::occupied_near`], the cells that are not `known`.
    pub fn occupied_near_but(&self, center_in_world: Point2, radius_m: f64, known: &CellSet) -> Vec<Point2> {
        if known.geometry() == self.geometry {
            return self.occupied_near_where(center_in_world, radius_m, Some(known.marks()), |_| true);
        }
        let mut near = self.occupied_near(center_in_world, radius_m);
        near.retain(|&point| !known.holds_at(point));
        near
    }

    fn occupied_near_where(
        &self,
        center: Point2,
        radius_m: f64,
        but: Option<&Marks>,
        wanted: impl Fn(usize) -> bool,
    ) -> Vec<Point2> {
        let mut found = Vec::new();
        self.visit_rows(center, radius_m, |row, first, last, within| {
            self.occupied.each_in(row, first, last, but, |col| {
                let cell = Cell::new(row, col);
                if within.holds(col) && wanted(self.geometry.index(cell)) {
                    found.push(self.geometry.center(cell));
                }
            });
        });
        found
    }

    /// Calls `seen` with every cell whose centre lies within `radius_m`, by row, then column.
    fn visit(&self, center_in_world: Point2, radius_m: f64, mut seen: impl FnMut(usize)) {
        self.visit_rows(center_in_world, radius_m, |row, first, last, within| {
            for col in (first..=last).filter(|&col| within.holds(col)) {
                seen(self.geometry.index(Cell::new(row, col)));
            }
        });
    }

    /// Calls `seen` with every row that a disc may touch, the columns that hold it, and what tells which of
    /// their cells are within it there.
    #[inline]
    fn visit_rows(
        &self,
        center_in_world: Point2,
        radius_m: f64,
        mut seen: impl FnMut(usize, usize, usize, Within),
    ) {
        let res = self.geometry.resolution_m;
        let at = self.geometry.in_grid(center_in_world);
        if !(at.is_finite() && radius_m >= 0.0) || self.geometry.is_empty() {
            return;
        }
        let span = |center: f64, cells: usize| {
            let lo = ((center - radius_m) / res - 0.5).ceil().max(0.0);
            let hi = ((center + radius_m) / res - 0.5).floor().min(cells as f64 - 1.0);
            (lo <= hi).then_some((lo as usize, hi as usize))
        };
        let (Some((row0, row1)), Some((col0, col1))) =
            (span(at.y, self.geometry.rows), span(at.x, self.geometry.cols))
        else {
            return;
        };
        for row in row0..=row1 {
            let dy = (row as f64 + 0.5) * res - at.y;
            seen(row, col0, col1, Within { res, at_x: at.x, dy, radius_m });
        }
    }

    /// Turns the evidence of touched cells into classes, with hysteresis.
    pub(super) fn classify(&mut self) {
        let mut changed = false;
        let mut touched = std::mem::take(&mut self.touched);
        for i in touched.drain(..) {
            let i = i as usize;
            let l = f64::from(self.log_odds[i]);
            let class = match self.class[i] {
                _ if l >= self.config.occupied_above => Occupancy::Occupied,
                Occupancy::Occupied if l > self.config.released_below => Occupancy::Occupied,
                Occupancy::Occupied | Occupancy::Free => Occupancy::Free,
                Occupancy::Unknown if l <= self.config.free_below => Occupancy::Free,
                Occupancy::Unknown => Occupancy::Unknown,
            };
            if class != self.class[i] {
                changed = true;
                self.set_class(i, class);
            }
        }
        self.touched = touched;
        self.revision += u64::from(changed);
    }

    /// Makes the grid hold the box from `lo` to `hi` (world frame), if it is one that grows.
    pub(super) fn reach(&mut self, lo: Point2, hi: Point2) -> Result<(), MappingError> {
        if self.prior.is_some() {
            return Ok(());
        }
        let res = self.geometry.resolution_m;
        // In blocks; a float too large for the map saturates and is refused below.
        let block = |v: f64| ((v / res).floor() as i64).div_euclid(CHUNK);
        let most = self.config.most_cells.min(u32::MAX as usize);
        let (mut row0, mut row1) = (block(lo.y), block(hi.y));
        let (mut col0, mut col1) = (block(lo.x), block(hi.x));
        if !self.geometry.is_empty() {
            row0 = row0.min(self.first.0 / CHUNK);
            col0 = col0.min(self.first.1 / CHUNK);
            row1 = row1.max((self.first.0 + self.geometry.rows as i64) / CHUNK - 1);
            col1 = col1.max((self.first.1 + self.geometry.cols as i64) / CHUNK - 1);
        }
        let rows = row1.saturating_sub(row0).saturating_add(1).saturating_mul(CHUNK) as usize;
        let cols = col1.saturating_sub(col0).saturating_add(1).saturating_mul(CHUNK) as usize;
        if (rows, cols) == (self.geometry.rows, self.geometry.cols) {
            return Ok(());
        }
        if rows.saturating_mul(cols) > most {
            return Err(MappingError::MappingTooLarge { rows, cols, most });
        }
        let first = (row0 * CHUNK, col0 * CHUNK);
        let geometry = GridGeometry {
            rows,
            cols,
            resolution_m: res,
            world_from_grid: Pose2::new(first.1 as f64 * res, first.0 as f64 * res, 0.0),
        };
        let mut log_odds = vec![0.0; rows * cols];
        let mut class = vec![Occupancy::Unknown; rows * cols];
        let (dr, dc) = ((self.first.0 - first.0) as usize, (self.first.1 - first.1) as usize);
        for row in 0..self.geometry.rows {
            let old = row * self.geometry.cols..(row + 1) * self.geometry.cols;
            let new = (row + dr) * cols + dc;
            log_odds[new..new + old.len()].copy_from_slice(&self.log_odds[old.clone()]);
            class[new..new + old.len()].copy_from_slice(&self.class[old]);
        }
        let moved = |i: u32| {
            let cell = self.geometry.cell(i as usize);
            geometry.index(Cell::new(cell.row + dr, cell.col + dc)) as u32
        };
        self.felt = self.felt.iter().map(|&i| moved(i)).collect();
        self.changed = None;
        self.geometry = geometry;
        self.first = first;
        self.log_odds = log_odds;
        self.occupied = Marks::of(rows, cols, &class, |&class| class == Occupancy::Occupied);
        self.class = class;
        self.revision += 1;
        Ok(())
    }
}
