//! Monte Carlo localisation: a set of poses, moved as the robot moves and weighed by what it hears
//! `[Fox99]`, as many as the spread needs `[Fox03]`.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::beams::{Poses, Scan, Tables, weigh};
use super::field::SurfaceField;
use super::history::{History, Place};
use super::matching::MapMatcher;
use super::modes::{Bins, Mode, best_modes};
use super::survey::{Lattice, Seeing, Survey, Surveyed};
use crate::geometry::{Pose2, wrap_angle};
use crate::robot::RobotProfile;
use crate::world::{Occupancy, OccupancyGrid, SplitMix};

/// How many poses are kept, how they move and how readings are weighed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MonteCarloConfig {
    /// Poses kept at most; as many are drawn from a search of the whole map.
    pub most_particles: usize,
    /// Poses kept at least.
    pub least_particles: usize,
    /// How far the poses may misrepresent what is known (Kullback-Leibler distance) `[Fox03]`.
    pub kld_error: f64,
    /// Weighed again after this way \[m\] …
    pub every_m: f64,
    /// … or this turn \[rad\].
    pub every_rad: f64,
    /// Variance of a motion along and across it, per path \[m²/m\].
    pub path_m2_per_m: f64,
    /// The same per turn \[m²/rad\].
    pub path_m2_per_rad: f64,
    /// Variance of its turn per turn \[rad²/rad\].
    pub turn_rad2_per_rad: f64,
    /// The same per path \[rad²/m\].
    pub turn_rad2_per_m: f64,
    /// Lattice of a search of the whole map: between positions \[m\].
    pub search_m: f64,
    /// Directions at each position of that lattice.
    pub search_headings: usize,
    /// Weighings after a search in which errors of the lattice's size are forgiven, less and less.
    pub search_settling: u32,
    /// Echoes of a sonar from farther away are not used \[m\].
    pub sonar_range_m: f64,
    /// Standard deviation of a sonar's echo from the map's nearest surface \[m\].
    pub sonar_m: f64,
    /// Added to it per range \[m/m\].
    pub sonar_m_per_m: f64,
    /// The same of a lidar's beam \[m\].
    pub lidar_m: f64,
    /// Beams of a lidar that are used, evenly spread.
    pub lidar_beams: usize,
    /// Share of readings that nothing on the map explains: boxes, people.
    pub stray: f64,
    /// Readings share their errors: each counts as this share of one.
    pub independence: f64,
}

impl Default for MonteCarloConfig {
    fn default() -> Self {
        Self {
            most_particles: 5000,
            least_particles: 400,
            kld_error: 0.02,
            every_m: 0.1,
            every_rad: 0.1,
            path_m2_per_m: 0.002,
            path_m2_per_rad: 0.0005,
            turn_rad2_per_rad: 0.002,
            turn_rad2_per_m: 0.0005,
            search_m: 0.2,
            search_headings: 36,
            search_settling: 8,
            sonar_range_m: 4.0,
            sonar_m: 0.08,
            sonar_m_per_m: 0.03,
            lidar_m: 0.08,
            lidar_beams: 60,
            stray: 0.1,
            independence: 0.4,
        }
    }
}

impl MonteCarloConfig {
    fn checked(self) -> Result<Self, LocaliseError> {
        let tiny = f64::MIN_POSITIVE;
        for (key, value, least, most) in [
            ("most_particles", self.most_particles as f64, 10.0, 1e6),
            ("least_particles", self.least_particles as f64, 10.0, self.most_particles as f64),
            ("kld_error", self.kld_error, 1e-4, 1.0),
            ("every_m", self.every_m, 0.0, 1e3),
            ("every_rad", self.every_rad, 0.0, 1e3),
            ("path_m2_per_m", self.path_m2_per_m, 0.0, 1.0),
            ("path_m2_per_rad", self.path_m2_per_rad, 0.0, 1.0),
            ("turn_rad2_per_rad", self.turn_rad2_per_rad, 0.0, 1.0),
            ("turn_rad2_per_m", self.turn_rad2_per_m, 0.0, 1.0),
            ("search_m", self.search_m, 0.01, 10.0),
            ("search_headings", self.search_headings as f64, 4.0, 360.0),
            ("sonar_range_m", self.sonar_range_m, tiny, 1e3),
            ("sonar_m", self.sonar_m, 1e-3, 10.0),
            ("sonar_m_per_m", self.sonar_m_per_m, 0.0, 1.0),
            ("lidar_m", self.lidar_m, 1e-3, 10.0),
            ("lidar_beams", self.lidar_beams as f64, 1.0, 1e5),
            ("stray", self.stray, 1e-6, 0.999),
            ("independence", self.independence, 1e-3, 1.0),
        ] {
            if !(value >= least && value <= most) {
                let key = key.to_owned();
                return Err(LocaliseError::LocaliseValueOutOfRange { key, value, least, most });
            }
        }
        Ok(self)
    }
}

/// Why a localiser, its map or its input was refused.
#[derive(Clone, Debug, PartialEq, Error, Serialize)]
pub enum LocaliseError {
    /// A setting cannot be.
    #[error("localisation: {key} is {value}, must be a number from {least} to {most}")]
    LocaliseValueOutOfRange {
        /// Name of the setting.
        key: String,
        /// What was given.
        value: f64,
        /// Least usable value.
        least: f64,
        /// Greatest usable value.
        most: f64,
    },
    /// The map shows nothing that could be recognised.
    #[error("localisation: the map of {cells} cells shows nothing standing: there is nothing to recognise")]
    LocaliseMapEmpty {
        /// Cells of the map.
        cells: usize,
    },
    /// There is no place on the map where the robot could be.
    #[error(
        "localisation: the map has no free place with {radius_m:.2} m around it, so the robot is nowhere on it"
    )]
    LocaliseNoRoom {
        /// What the robot needs \[m\].
        radius_m: f64,
    },
    /// The profile has neither sonars nor a lidar.
    #[error("localisation: the profile `{profile}` has neither sonars nor a lidar")]
    LocaliseNoSensor {
        /// Name of the profile.
        profile: String,
    },
    /// The array of ranges has another length than the profile's list of sensors.
    #[error("localisation: {given} ranges were given, the profile has {expected} sensors")]
    LocaliseRangeCount {
        /// Length of the array.
        given: usize,
        /// Sonars and lidar beams of the profile.
        expected: usize,
    },
    /// A pose, a motion or a spread is no finite number, or a spread is negative.
    #[error("localisation: {name} is {value}; it must be a finite number, a spread not negative")]
    LocaliseInputNotFinite {
        /// Which input.
        name: String,
        /// What was given.
        value: f64,
    },
}

/// What the set of poses says.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PoseEstimate {
    /// Mean of the poses around the heaviest place, `world_from_robot`.
    pub pose: Pose2,
    /// Their covariance of (x \[m\], y \[m\], heading \[rad\]), world frame.
    pub covariance: [[f64; 3]; 3],
    /// Share of the weight that is around that place.
    pub share: f64,
    /// The heaviest place elsewhere.
    pub rival: Option<Pose2>,
    /// Share of the weight around the rival.
    pub rival_share: f64,
    /// Poses in the set.
    pub particles: usize,
}

impl PoseEstimate {
    /// Standard deviation of the position: of the worse of the two axes it has \[m\].
    pub fn sigma_m(&self) -> f64 {
        let c = &self.covariance;
        let (mean, swing) = ((c[0][0] + c[1][1]) / 2.0, ((c[0][0] - c[1][1]) / 2.0).hypot(c[0][1]));
        (mean + swing).max(0.0).sqrt()
    }

    /// Standard deviation of the heading \[rad\].
    pub fn sigma_rad(&self) -> f64 {
        self.covariance[2][2].max(0.0).sqrt()
    }
}

/// Monte Carlo localisation in a known map, from sonar, lidar or both.
///
/// Bits follow from the map, the seed and the inputs alone.
#[derive(Clone, Debug)]
pub struct MonteCarlo {
    config: MonteCarloConfig,
    profile: RobotProfile,
    field: Arc<SurfaceField>,
    map: Vec<Occupancy>,
    world_from_map: Pose2,
    map_from_world: Pose2,
    fine: Tables,
    lattice: Option<Arc<Lattice>>,
    random: SplitMix,
    poses: Poses,
    /// Sums to 1.
    weights: Vec<f64>,
    /// Motion since the poses were moved last, `before_from_now`, and its path and turn.
    pending: Pose2,
    pending_m: f64,
    pending_rad: f64,
    settling: u32,
    estimate: Option<PoseEstimate>,
    scratch: Vec<f32>,
}

impl MonteCarlo {
    /// A localiser in `map` that knows nothing yet: [`Self::spread`] or [`Self::search`] begins.
    ///
    /// # Errors
    /// [`LocaliseError`] names the setting, or what is wrong with the map or the profile.
    pub fn new(
        config: &MonteCarloConfig,
        profile: &RobotProfile,
        map: &OccupancyGrid,
        seed: u64,
    ) -> Result<Self, LocaliseError> {
        Self::on(config, profile, map, Arc::new(SurfaceField::new(map)), seed)
    }

    /// The same on the surfaces of `map`.
    pub(super) fn on(
        config: &MonteCarloConfig,
        profile: &RobotProfile,
        map: &OccupancyGrid,
        field: Arc<SurfaceField>,
        seed: u64,
    ) -> Result<Self, LocaliseError> {
        let config = config.checked()?;
        if profile.range_count() == 0 {
            return Err(LocaliseError::LocaliseNoSensor { profile: profile.name.clone() });
        }
        if !map.values.contains(&Occupancy::Occupied) {
            return Err(LocaliseError::LocaliseMapEmpty { cells: map.values.len() });
        }
        let world_from_map = map.geometry.world_from_grid;
        Ok(Self {
            fine: Tables::new(&config, 0.0, 0.0),
            lattice: None,
            field,
            map: map.values.clone(),
            map_from_world: world_from_map.inverse(),
            world_from_map,
            random: SplitMix::new(seed),
            poses: Poses::default(),
            weights: Vec::new(),
            pending: Pose2::IDENTITY,
            pending_m: 0.0,
            pending_rad: 0.0,
            settling: 0,
            estimate: None,
            scratch: Vec::new(),
            profile: profile.clone(),
            config,
        })
    }

    /// Begins around a pose that is known about: normally distributed with these deviations.
    ///
    /// # Errors
    /// [`LocaliseError::LocaliseInputNotFinite`].
    pub fn spread(
        &mut self,
        world_from_robot: Pose2,
        sigma_m: f64,
        sigma_rad: f64,
    ) -> Result<(), LocaliseError> {
        for (name, value, least) in [
            ("pose.x", world_from_robot.x, f64::MIN),
            ("pose.y", world_from_robot.y, f64::MIN),
            ("pose.heading", world_from_robot.heading, f64::MIN),
            ("sigma_m", sigma_m, 0.0),
            ("sigma_rad", sigma_rad, 0.0),
        ] {
            if !(value.is_finite() && value >= least) {
                return Err(LocaliseError::LocaliseInputNotFinite { name: name.to_owned(), value });
            }
        }
        let pose = self.map_from_world * world_from_robot;
        // As many as a mode of this size is worth: 0.1 m and 0.1 rad take the least.
        let size = (1.0 + sigma_m / 0.1) * (1.0 + sigma_m / 0.1) * (1.0 + sigma_rad / 0.1) / 8.0;
        let n = (self.config.least_particles as f64 * size.max(1.0)) as usize;
        let n = n.clamp(self.config.least_particles, self.config.most_particles);
        let mut poses = Poses::default();
        for _ in 0..n {
            let [x, y, turn] = [self.random.normal(), self.random.normal(), self.random.normal()];
            poses.push(
                pose.x as f32 + sigma_m as f32 * x,
                pose.y as f32 + sigma_m as f32 * y,
                pose.heading as f32 + sigma_rad as f32 * turn,
            );
        }
        self.begin(poses, 0);
        Ok(())
    }

    /// Begins anywhere: weighs a lattice over all free places of the map by one array of ranges, and
    /// draws from it. Gives the number of poses weighed.
    ///
    /// # Errors
    /// [`LocaliseError::LocaliseRangeCount`], or [`LocaliseError::LocaliseNoRoom`].
    pub fn search(&mut self, ranges_m: &[f64]) -> Result<usize, LocaliseError> {
        self.check(ranges_m)?;
        let config = self.config;
        let c = &config;
        let scan = Scan::new(c, &self.profile, ranges_m);
        let lattice = self.lattice()?;
        let turn_rad = lattice.turn_rad;
        let tables = Tables::new(c, 0.4 * c.search_m, 0.3 * turn_rad);
        let lattice = &lattice.poses;
        let mut logs = std::mem::take(&mut self.scratch);
        weigh(&self.field, &tables, &scan, 0.0, lattice, &mut logs);
        let weights = normalised(&logs, None);
        self.scratch = logs;
        let mut poses = Poses::default();
        let (half_m, half_rad) = (c.search_m as f32 / 2.0, turn_rad as f32 / 2.0);
        for i in draw(&weights, c.most_particles, &mut self.random) {
            let [x, y, turn] = [0; 3].map(|_| 2.0 * self.random.unit() as f32 - 1.0);
            poses.push(
                lattice.x[i] + half_m * x,
                lattice.y[i] + half_m * y,
                lattice.heading[i] + half_rad * turn,
            );
        }
        self.begin(poses, c.search_settling);
        Ok(lattice.len())
    }

    /// Every pose that is looked at when the robot may be anywhere.
    pub(super) fn lattice(&mut self) -> Result<Arc<Lattice>, LocaliseError> {
        if let Some(lattice) = &self.lattice {
            return Ok(lattice.clone());
        }
        let c = &self.config;
        let radius_m = self.profile.footprint.inscribed_radius_m();
        let places = self.field.standing_places(&self.map, radius_m as f32, c.search_m);
        if places.is_empty() {
            return Err(LocaliseError::LocaliseNoRoom { radius_m });
        }
        let turn_rad = std::f64::consts::TAU / c.search_headings as f64;
        let mut poses = Poses::default();
        for k in 0..c.search_headings {
            for &(x, y) in &places {
                poses.push(x, y, wrap_angle(k as f64 * turn_rad) as f32);
            }
        }
        let lattice = Arc::new(Lattice { poses, pitch_m: c.search_m, turn_rad });
        self.lattice = Some(lattice.clone());
        Ok(lattice)
    }

    /// Readings as [`History`] keeps them.
    pub(super) fn scan(&self, ranges_m: &[f64]) -> Scan {
        Scan::new(&self.config, &self.profile, ranges_m)
    }

    /// A search of the whole map by all that `history` keeps, and near `starts` in any case. None where
    /// it keeps nothing.
    pub(super) fn survey(
        &mut self,
        history: &History,
        starts: &[Pose2],
    ) -> Result<Option<Survey>, LocaliseError> {
        let starts: Vec<Pose2> = starts.iter().map(|start| self.map_from_world * *start).collect();
        Ok(Survey::new(history, self.lattice()?, &starts))
    }

    /// Goes on with a search, and gives what it found at its end.
    pub(super) fn advance(
        &self,
        survey: &mut Survey,
        matcher: &MapMatcher,
        about: Pose2,
    ) -> Option<Surveyed> {
        let seeing = Seeing {
            field: &self.field,
            config: &self.config,
            fine: &self.fine,
            matcher,
            profile: &self.profile,
            world_from_map: self.world_from_map,
        };
        survey.advance(&seeing, about)
    }

    /// Begins at several places, with as many poses at each as it is likely.
    pub(super) fn gather(&mut self, places: &[Place]) {
        let Some(best) = places.first().map(|place| place.score) else { return };
        let weights: Vec<f64> = places.iter().map(|place| (0.5 * (place.score - best)).exp()).collect();
        let sum: f64 = weights.iter().sum();
        let n = self.config.most_particles / 2;
        let mut poses = Poses::default();
        for (place, weight) in places.iter().zip(weights) {
            let pose = self.map_from_world * place.pose;
            for _ in 0..(n as f64 * weight / sum) as usize {
                let [x, y, turn] = [self.random.normal(), self.random.normal(), self.random.normal()];
                poses.push(
                    pose.x as f32 + 0.08 * x,
                    pose.y as f32 + 0.08 * y,
                    pose.heading as f32 + 0.04 * turn,
                );
            }
        }
        self.begin(poses, 0);
    }

    /// No pose is likelier than any other.
    pub(super) fn forget(&mut self) {
        self.poses = Poses::default();
        self.weights = Vec::new();
        self.estimate = None;
    }

    fn begin(&mut self, poses: Poses, settling: u32) {
        self.weights = vec![1.0 / poses.len() as f64; poses.len()];
        self.poses = poses;
        self.pending = Pose2::IDENTITY;
        (self.pending_m, self.pending_rad) = (0.0, 0.0);
        self.settling = settling;
        self.summarise();
    }

    /// Notes a motion of the robot, `before_from_now`, by odometry.
    ///
    /// # Errors
    /// [`LocaliseError::LocaliseInputNotFinite`].
    pub fn predict(&mut self, before_from_now: Pose2) -> Result<(), LocaliseError> {
        let Pose2 { x, y, heading } = before_from_now;
        for (name, value) in [("motion.x", x), ("motion.y", y), ("motion.heading", heading)] {
            if !value.is_finite() {
                return Err(LocaliseError::LocaliseInputNotFinite { name: name.to_owned(), value });
            }
        }
        self.pending = self.pending * before_from_now;
        self.pending_m += x.hypot(y);
        self.pending_rad += heading.abs();
        Ok(())
    }

    /// The robot has moved enough since the poses were last weighed for another look to say something new.
    pub fn is_due(&self) -> bool {
        self.pending_m >= self.config.every_m || self.pending_rad >= self.config.every_rad
    }

    /// Moves all poses by the motion noted, weighs them by one array of ranges, and draws anew where
    /// few of them carry the weight. Gives the number of readings used.
    ///
    /// # Errors
    /// [`LocaliseError::LocaliseRangeCount`].
    pub fn update(&mut self, ranges_m: &[f64]) -> Result<usize, LocaliseError> {
        self.check(ranges_m)?;
        if self.poses.len() == 0 {
            return Ok(0);
        }
        self.shift();
        let c = &self.config;
        let scan = Scan::new(c, &self.profile, ranges_m);
        let coarse = (self.settling > 0).then(|| {
            let part = f64::from(self.settling) / f64::from(c.search_settling.max(1));
            let turn_rad = std::f64::consts::TAU / c.search_headings as f64;
            Tables::new(c, part * 0.4 * c.search_m, part * 0.3 * turn_rad)
        });
        let tables = coarse.as_ref().unwrap_or(&self.fine);
        let radius_m = 0.5 * self.profile.footprint.inscribed_radius_m() as f32;
        let mut logs = std::mem::take(&mut self.scratch);
        weigh(&self.field, tables, &scan, radius_m, &self.poses, &mut logs);
        self.weights = normalised(&logs, Some(&self.weights));
        self.scratch = logs;
        self.settling = self.settling.saturating_sub(1);
        self.summarise();
        self.draw_anew();
        Ok(scan.len())
    }

    pub(super) fn check(&self, ranges_m: &[f64]) -> Result<(), LocaliseError> {
        let (given, expected) = (ranges_m.len(), self.profile.range_count());
        if given == expected { Ok(()) } else { Err(LocaliseError::LocaliseRangeCount { given, expected }) }
    }

    /// Moves every pose by the motion noted and an error of its own.
    fn shift(&mut self) {
        let c = &self.config;
        let (path_m, turn_rad) = (self.pending_m, self.pending_rad);
        let sigma_m = (c.path_m2_per_m * path_m + c.path_m2_per_rad * turn_rad).sqrt() as f32;
        let sigma_rad = (c.turn_rad2_per_rad * turn_rad + c.turn_rad2_per_m * path_m).sqrt() as f32;
        let Pose2 { x: dx, y: dy, heading: turn } = self.pending;
        let (dx, dy, turn) = (dx as f32, dy as f32, turn as f32);
        for i in 0..self.poses.len() {
            let along = dx + sigma_m * self.random.normal();
            let across = dy + 0.5 * sigma_m * self.random.normal();
            let off = sigma_rad * self.random.normal();
            let heading = self.poses.heading[i];
            // Half of the error of the turn was there on the way.
            let (sin, cos) = (heading + 0.5 * off).sin_cos();
            self.poses.x[i] += cos * along - sin * across;
            self.poses.y[i] += sin * along + cos * across;
            self.poses.heading[i] = wrap_angle(f64::from(heading + turn + off)) as f32;
        }
        self.pending = Pose2::IDENTITY;
        (self.pending_m, self.pending_rad) = (0.0, 0.0);
    }

    fn draw_anew(&mut self) {
        let n = self.poses.len();
        let effective = 1.0 / self.weights.iter().map(|w| w * w).sum::<f64>();
        let bins = Bins::new(&self.poses, &self.weights);
        let wanted = self.wanted(bins.count());
        if effective > 0.5 * n as f64 && wanted as f64 > 0.6 * n as f64 && wanted <= n {
            return;
        }
        let mut poses = Poses::default();
        for i in draw(&self.weights, wanted, &mut self.random) {
            poses.push(self.poses.x[i], self.poses.y[i], self.poses.heading[i]);
        }
        self.weights = vec![1.0 / wanted as f64; wanted];
        self.poses = poses;
    }

    /// Poses that represent a spread over `bins` bins within the error allowed, with 99 % certainty
    /// `[Fox03]` (Wilson-Hilferty).
    fn wanted(&self, bins: usize) -> usize {
        let c = &self.config;
        let k = bins as f64;
        let n = if bins < 2 {
            0.0
        } else {
            let a = 2.0 / (9.0 * (k - 1.0));
            (k - 1.0) / (2.0 * c.kld_error) * (1.0 - a + a.sqrt() * 2.326).powi(3)
        };
        (n as usize).clamp(c.least_particles, c.most_particles)
    }

    fn summarise(&mut self) {
        let [best, rival] = best_modes(&self.poses, &self.weights);
        self.estimate = best.map(|best: Mode| {
            let turn = self.world_from_map.heading;
            let (sin, cos) = turn.sin_cos();
            let p = best.covariance;
            // World axes: R P Rᵀ on the position's part.
            let r = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
            let covariance = std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    (0..3).map(|a| (0..3).map(|b| r[i][a] * p[a][b] * r[j][b]).sum::<f64>()).sum()
                })
            });
            PoseEstimate {
                pose: self.world_from_map * best.pose,
                covariance,
                share: best.share,
                rival: rival.map(|rival| self.world_from_map * rival.pose),
                rival_share: rival.map_or(0.0, |rival| rival.share),
                particles: self.poses.len(),
            }
        });
    }

    /// Where the robot is by now: the last weighing's estimate, moved by what was noted since. None
    /// before [`Self::spread`] or [`Self::search`].
    pub fn estimate(&self) -> Option<PoseEstimate> {
        self.estimate.map(|estimate| PoseEstimate {
            pose: estimate.pose * self.pending,
            rival: estimate.rival.map(|rival| rival * self.pending),
            ..estimate
        })
    }

    /// Every pose of the set in the world, with its weight; they sum to 1.
    pub fn particles(&self) -> Vec<(Pose2, f64)> {
        (0..self.poses.len())
            .map(|i| {
                let (x, y) = (f64::from(self.poses.x[i]), f64::from(self.poses.y[i]));
                let pose = Pose2::new(x, y, f64::from(self.poses.heading[i]));
                (self.world_from_map * pose * self.pending, self.weights[i])
            })
            .collect()
    }

    /// Mean logarithm of the likelihood of a reading at `world_from_robot`; 0 without a reading.
    pub fn likelihood(&self, world_from_robot: Pose2, ranges_m: &[f64]) -> Result<f64, LocaliseError> {
        self.check(ranges_m)?;
        let scan = Scan::new(&self.config, &self.profile, ranges_m);
        let pose = self.map_from_world * world_from_robot;
        let mut poses = Poses::default();
        poses.push(pose.x as f32, pose.y as f32, pose.heading as f32);
        let mut out = Vec::new();
        weigh(&self.field, &self.fine, &scan, 0.0, &poses, &mut out);
        Ok(f64::from(out[0]) / scan.len().max(1) as f64)
    }
}

/// Weights that sum to 1, of logarithms and of weights before. All equal where nothing is possible.
fn normalised(logs: &[f32], before: Option<&[f64]>) -> Vec<f64> {
    let most = logs.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let prior = |i: usize| before.map_or(1.0, |before| before[i]);
    let mut weights: Vec<f64> = if most == f32::NEG_INFINITY {
        vec![1.0; logs.len()]
    } else {
        logs.iter().enumerate().map(|(i, log)| prior(i) * f64::from(log - most).exp()).collect()
    };
    let sum: f64 = weights.iter().sum();
    if !(sum.is_finite() && sum > 0.0) {
        return vec![1.0 / logs.len() as f64; logs.len()];
    }
    for weight in &mut weights {
        *weight /= sum;
    }
    weights
}

/// Indices of `n` draws by weight, in order, with one random number `[Thrun05, table 4.4]`.
fn draw(weights: &[f64], n: usize, random: &mut SplitMix) -> Vec<usize> {
    let step = 1.0 / n as f64;
    let mut at = random.unit() * step;
    let (mut i, mut upto) = (0, weights[0]);
    (0..n)
        .map(|_| {
            while at > upto && i + 1 < weights.len() {
                i += 1;
                upto += weights[i];
            }
            at += step;
            i
        })
        .collect()
}
