//! Ranges matched to a known map: small corrections that keep odometry from drifting.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::Odometry;
use super::field::SurfaceField;
use crate::geometry::{Pose2, wrap_angle};
use crate::robot::RobotProfile;
use crate::world::{Grid, Occupancy, OccupancyGrid, SonarEcho, sonar_echo};

/// Which readings are believed, and how far.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MatchingConfig {
    /// Echoes from farther away are not used \[m\].
    pub range_m: f64,
    /// An echo farther than this from what the map predicts came from something else \[m\].
    pub gate_m: f64,
    /// When most echoes are nearer than this to what the map predicts, the others came from
    /// something else \[m\].
    pub close_m: f64,
    /// The share of echoes that makes them most.
    pub close_share: f64,
    /// The gate in standard deviations of the innovation.
    pub gate_sigma: f64,
    /// Standard deviation of an echo from a straight wall: cells, noise, wood \[m\].
    pub noise_m: f64,
    /// Added to it per range \[m/m\].
    pub noise_m_per_m: f64,
    /// Factor on it for corners and ends of walls.
    pub corner_factor: f64,
    /// Readings of one wall tick after tick share their error: each counts as this share of one.
    pub independence: f64,
    /// Largest correction of one tick \[m\].
    pub most_m: f64,
    /// Largest correction of one tick \[rad\].
    pub most_rad: f64,
    /// Rays a cone is predicted with.
    pub rays: usize,
}

impl Default for MatchingConfig {
    fn default() -> Self {
        Self {
            range_m: 3.5,
            gate_m: 0.3,
            close_m: 0.12,
            close_share: 0.5,
            gate_sigma: 3.0,
            noise_m: 0.04,
            noise_m_per_m: 0.02,
            corner_factor: 1.5,
            independence: 0.2,
            most_m: 0.01,
            most_rad: 0.3 * std::f64::consts::PI / 180.0,
            rays: 15,
        }
    }
}

/// Why a matcher or its input was refused.
#[derive(Clone, Debug, PartialEq, Error, Serialize)]
pub enum MatchingError {
    /// A setting cannot be.
    #[error("matching: {key} is {value}, must be a finite number greater than {least}")]
    MatchingValueOutOfRange {
        /// Name of the setting.
        key: String,
        /// What was given.
        value: f64,
        /// Exclusive lower bound.
        least: f64,
    },
    /// The array of ranges is shorter than the profile's list of sonars.
    #[error("matching: {given} ranges were given, the profile has {expected} sonars")]
    MatchingRangeCount {
        /// Length of the array.
        given: usize,
        /// Sonars of the profile.
        expected: usize,
    },
}

/// What one call did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MatchReport {
    /// Echoes the map explains; they moved the pose.
    pub used: usize,
    /// Echoes the map does not explain: boxes, people, walls the pose error hides.
    pub rejected: usize,
    /// Added to the pose: x \[m\], y \[m\], heading \[rad\], world frame.
    pub correction: Pose2,
    /// The correction was larger than allowed in one tick and was cut.
    pub bounded: bool,
}

/// Compares sonar echoes with those the known map predicts, by the rules of [`sonar_echo`], and the
/// ends of lidar beams with the map's surfaces: an extended Kalman update of [`Odometry`] by each
/// reading that the map explains.
#[derive(Clone, Debug)]
pub struct MapMatcher {
    pub(super) config: MatchingConfig,
    pub(super) walls: Grid<bool>,
    pub(super) field: Arc<SurfaceField>,
}

impl MapMatcher {
    /// A matcher to the occupied cells of `prior`.
    ///
    /// # Errors
    /// [`MatchingError::MatchingValueOutOfRange`].
    pub fn new(config: &MatchingConfig, prior: &OccupancyGrid) -> Result<Self, MatchingError> {
        Self::on(config, prior, Arc::new(SurfaceField::new(prior)))
    }

    /// The same on the surfaces of `prior`.
    pub(super) fn on(
        config: &MatchingConfig,
        prior: &OccupancyGrid,
        field: Arc<SurfaceField>,
    ) -> Result<Self, MatchingError> {
        for (key, value) in [
            ("range_m", config.range_m),
            ("gate_m", config.gate_m),
            ("close_m", config.close_m),
            ("close_share", config.close_share),
            ("gate_sigma", config.gate_sigma),
            ("noise_m", config.noise_m),
            ("noise_m_per_m", config.noise_m_per_m + f64::MIN_POSITIVE),
            ("corner_factor", config.corner_factor),
            ("independence", config.independence),
            ("most_m", config.most_m),
            ("most_rad", config.most_rad),
            ("rays", config.rays as f64),
        ] {
            if !(value.is_finite() && value > 0.0) {
                let key = key.to_owned();
                return Err(MatchingError::MatchingValueOutOfRange { key, value, least: 0.0 });
            }
        }
        let occupied = prior.values.iter().map(|class| *class == Occupancy::Occupied).collect();
        Ok(Self { config: *config, walls: Grid::new(prior.geometry, occupied), field })
    }

    /// Corrects `odometry` by `ranges_m`, sonars and then lidar beams, taken at its pose.
    ///
    /// At most [`MatchingConfig::most_m`] and [`MatchingConfig::most_rad`] per call. Echoes nearer or
    /// farther than the map predicts by more than the gate, unanswered cries and NaN move nothing.
    ///
    /// # Errors
    /// [`MatchingError::MatchingRangeCount`].
    pub fn correct(
        &self,
        odometry: &mut Odometry,
        profile: &RobotProfile,
        ranges_m: &[f64],
    ) -> Result<MatchReport, MatchingError> {
        if ranges_m.len() < profile.sonars.len() {
            return Err(MatchingError::MatchingRangeCount {
                given: ranges_m.len(),
                expected: profile.sonars.len(),
            });
        }
        let c = &self.config;
        let (before, spread_before, learnt_before) = (odometry.pose, odometry.covariance, odometry.learnt());
        let mut report = MatchReport::default();
        let mut echoes = Vec::with_capacity(profile.sonars.len());
        for (sonar, &range_m) in profile.sonars.iter().zip(ranges_m) {
            if !(range_m > sonar.min_range_m && range_m < sonar.max_range_m.min(c.range_m)) {
                continue; // also NaN and infinity
            }
            // Predicted where the pose was before this tick's echoes, so their order does not matter much.
            let sonar_in_world = before * sonar.pose;
            let farthest_m = range_m + c.gate_m;
            let echo = sonar_echo(&self.walls, sonar_in_world, sonar.beam_rad, farthest_m, c.rays);
            match echo.filter(|echo| (range_m - echo.range_m).abs() <= c.gate_m) {
                Some(echo) => echoes.push((sonar_in_world, echo, range_m)),
                None => report.rejected += 1,
            }
        }
        // A thing before a wall answers a little nearer than the wall would, tick after tick. Where
        // the pose is good, most echoes say so, and what does not fit as well is such a thing.
        let close = echoes.iter().filter(|(_, echo, range_m)| (range_m - echo.range_m).abs() <= c.close_m);
        let sure = close.count() as f64 > c.close_share * echoes.len() as f64;
        let gate_m = if sure { c.close_m.min(c.gate_m) } else { c.gate_m };
        for (sonar_in_world, echo, range_m) in &echoes {
            if (range_m - echo.range_m).abs() <= gate_m
                && self.update(odometry, before, *sonar_in_world, echo, *range_m)
            {
                report.used += 1;
            } else {
                report.rejected += 1;
            }
        }
        self.correct_by_lidar(odometry, profile, ranges_m, &mut report);
        let after = odometry.pose;
        let (dx, dy, turn) =
            (after.x - before.x, after.y - before.y, wrap_angle(after.heading - before.heading));
        let share = (c.most_m / dx.hypot(dy).max(1e-12)).min(c.most_rad / turn.abs().max(1e-12)).min(1.0);
        if share < 1.0 {
            report.bounded = true;
            // The rest of the correction is still to come, and teaches nothing before it is done.
            odometry.covariance = spread_before;
            odometry.set_learnt(learnt_before);
        }
        report.correction = Pose2 { x: dx * share, y: dy * share, heading: turn * share };
        odometry.nudge_to(Pose2::new(
            before.x + report.correction.x,
            before.y + report.correction.y,
            before.heading + report.correction.heading,
        ));
        Ok(report)
    }

    /// One echo. The nearest point of a wall moves against the sonar: d range / d position = −u, and
    /// by turning, the sonar moves about the robot's centre.
    fn update(
        &self,
        odometry: &mut Odometry,
        before: Pose2,
        sonar_in_world: Pose2,
        echo: &SonarEcho,
        range_m: f64,
    ) -> bool {
        let c = &self.config;
        let toward = echo.point_in_world - sonar_in_world.position();
        if toward.norm() < 1e-6 {
            return false;
        }
        let u = toward * (1.0 / toward.norm());
        let arm = sonar_in_world.position() - before.position();
        let h = [-u.x, -u.y, -(u.y * arm.x - u.x * arm.y)];
        // The prediction was made at `before`; echoes used since have moved the pose.
        let pose = odometry.pose;
        let moved = h[0] * (pose.x - before.x)
            + h[1] * (pose.y - before.y)
            + h[2] * wrap_angle(pose.heading - before.heading);
        let innovation = range_m - echo.range_m - moved;
        let mut sigma = c.noise_m + c.noise_m_per_m * range_m;
        if !echo.on_face {
            sigma *= c.corner_factor;
        }
        let p = &odometry.covariance;
        let expected: f64 = (0..3).map(|i| (0..3).map(|j| h[i] * p[i][j] * h[j]).sum::<f64>()).sum();
        if innovation * innovation > c.gate_sigma * c.gate_sigma * (expected + sigma * sigma) {
            return false;
        }
        odometry.update_pose(h, innovation, sigma * sigma / c.independence);
        true
    }
}
