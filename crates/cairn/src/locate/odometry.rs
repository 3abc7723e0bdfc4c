//! Encoders and gyro fused into a pose with covariance.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::slip::Slip;
use crate::geometry::{Pose2, Twist2, wrap_angle};
use crate::robot::Drive;

/// Path driven by each side since the last tick, from the encoders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WheelTravel {
    /// Left side \[m\].
    pub left_m: f64,
    /// Right side \[m\].
    pub right_m: f64,
}

/// How far encoders and gyro are believed. Defaults for heading are those of ARIA's gyro code.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OdometryConfig {
    /// Variance of the encoders' heading per turn \[rad²/rad\]: wheels of a skid-steer robot slip.
    pub encoder_turn_rad2_per_rad: f64,
    /// Variance of the encoders' heading per path \[rad²/m\].
    pub encoder_turn_rad2_per_m: f64,
    /// Variance of the gyro's turn per time \[rad²/s\].
    pub gyro_rad2_per_s: f64,
    /// Variance of the gyro's turn per turn \[rad²/rad\].
    pub gyro_rad2_per_rad: f64,
    /// Variance of the path along the robot's axis per path \[m²/m\].
    pub path_m2_per_m: f64,
    /// Variance of the path, along and across, per turn \[m²/rad\].
    pub path_m2_per_rad: f64,
    /// Variance of the sideways slip per path \[m²/m\].
    pub sideways_m2_per_m: f64,
    /// Variance of the gyro's turn per time at rest, where its bias is learnt \[rad²/s\].
    pub gyro_rest_rad2_per_s: f64,
    /// Standard deviation of the gyro's bias before it was seen at rest \[rad/s\].
    pub gyro_bias_radps: f64,
    /// Growth of the bias' variance \[(rad/s)²/s\].
    pub gyro_bias_walk: f64,
    /// Standard deviation of what a metre of the encoders is too long or too short by \[m/m\].
    pub path_scale: f64,
    /// The same of a radian of the gyro \[rad/rad\].
    pub gyro_scale: f64,
    /// Standard deviation of the turn per turn of the wheels, learnt from the gyro: the floor decides
    /// how skid-steer wheels slip.
    pub slip_gain: f64,
    /// Standard deviation of the turn per path of wheels that are not alike \[rad/m\], learnt likewise.
    pub slip_veer_radpm: f64,
    /// Growth of the variance of the slip's gain per turn of the wheels: floors change \[1/rad\].
    pub slip_walk: f64,
    /// The wheels must stand this long before the gyro's output counts as bias \[s\].
    pub rest_s: f64,
    /// Turning faster than this by the gyro is not rest, whatever the wheels say \[rad/s\].
    pub rest_radps: f64,
    /// Standard deviation of the start position \[m\].
    pub start_m: f64,
    /// Standard deviation of the start heading \[rad\].
    pub start_rad: f64,
}

impl Default for OdometryConfig {
    fn default() -> Self {
        const DEG: f64 = std::f64::consts::PI / 180.0;
        Self {
            encoder_turn_rad2_per_rad: 0.25 * DEG, // 0.25 deg²/deg
            encoder_turn_rad2_per_m: 4.0 * DEG * DEG,
            gyro_rad2_per_s: 10.0 * 0.01 * 0.01 * 10.0 * DEG * DEG, // 0.001 deg² each 0.1 s
            gyro_rad2_per_rad: 0.001 * DEG,
            path_m2_per_m: 4e-4,
            path_m2_per_rad: 1e-4,
            sideways_m2_per_m: 1e-4,
            gyro_rest_rad2_per_s: 4e-7,
            gyro_bias_radps: 0.001,
            gyro_bias_walk: 1e-9,
            path_scale: 0.005,
            gyro_scale: 0.003,
            slip_gain: 0.1,
            slip_veer_radpm: 0.02,
            slip_walk: 1e-5,
            rest_s: 0.3,
            rest_radps: 0.05,
            start_m: 0.0,
            start_rad: 0.0,
        }
    }
}

/// Why a measurement or a setting of the odometry was refused.
#[derive(Clone, Debug, PartialEq, Error, Serialize)]
pub enum OdometryError {
    /// A setting cannot be.
    #[error("odometry: {key} is {value}, must be a finite number, at least {least}")]
    OdometryValueOutOfRange {
        /// Name of the setting.
        key: String,
        /// What was given.
        value: f64,
        /// Least usable value.
        least: f64,
    },
    /// A measurement is NaN or infinite.
    #[error("odometry: {name} is {value}; it must be a finite number (no gyro is None, not NaN)")]
    OdometryInputNotFinite {
        /// Which input.
        name: String,
        /// What was given.
        value: f64,
    },
}

/// The state is (x, y, heading, gyro bias, path scale, gyro scale); the scales are errors per unit.
const N: usize = 6;
const BIAS: usize = 3;
const PATH: usize = 4;
const GYRO: usize = 5;

/// Of the variance of the wheels' turn this share remains once their slip is learnt.
const LEARNING: f64 = 0.1;

pub(super) type State = [f64; N];
type Covariance = [[f64; N]; N];

/// The turn of one tick.
#[derive(Clone, Copy, Debug)]
struct Turn {
    rad: f64,
    variance: f64,
    /// The share the gyro had in it.
    gyro_share: f64,
    /// By the gyro alone.
    gyro_rad: f64,
}

/// Where the robot is by its own motion: an extended Kalman filter over its pose, the gyro's bias, and
/// the scales of encoders and gyro, which only a map can teach `[Martinelli07]`.
///
/// The turn of a tick is the mean of the encoders' and the gyro's, each weighted by the other's
/// variance; the path is the mean of both sides along the exact arc of equation (1) `[Maalouf06 §2]`.
/// At rest the gyro's output is its bias; while it turns, the gyro teaches how the wheels slip.
#[derive(Clone, Debug)]
pub struct Odometry {
    config: OdometryConfig,
    effective_track_m: f64,
    pub(super) pose: Pose2,
    bias_radps: f64,
    path_scale: f64,
    gyro_scale: f64,
    slip: Slip,
    pub(super) covariance: Covariance,
    twist: Twist2,
    resting_s: f64,
    path_m: f64,
}

impl Odometry {
    /// Odometry that starts at `start` (world frame).
    ///
    /// # Errors
    /// [`OdometryError`] names the setting or the coordinate that cannot be used.
    pub fn new(config: &OdometryConfig, drive: &Drive, start: Pose2) -> Result<Self, OdometryError> {
        for (key, value, least) in [
            ("effective_track_m", drive.effective_track_m, 1e-3),
            ("encoder_turn_rad2_per_rad", config.encoder_turn_rad2_per_rad, 0.0),
            ("encoder_turn_rad2_per_m", config.encoder_turn_rad2_per_m, 0.0),
            ("gyro_rad2_per_s", config.gyro_rad2_per_s, 0.0),
            ("gyro_rad2_per_rad", config.gyro_rad2_per_rad, 0.0),
            ("path_m2_per_m", config.path_m2_per_m, 0.0),
            ("path_m2_per_rad", config.path_m2_per_rad, 0.0),
            ("sideways_m2_per_m", config.sideways_m2_per_m, 0.0),
            ("gyro_rest_rad2_per_s", config.gyro_rest_rad2_per_s, 0.0),
            ("gyro_bias_radps", config.gyro_bias_radps, 0.0),
            ("gyro_bias_walk", config.gyro_bias_walk, 0.0),
            ("path_scale", config.path_scale, 0.0),
            ("gyro_scale", config.gyro_scale, 0.0),
            ("slip_gain", config.slip_gain, 0.0),
            ("slip_veer_radpm", config.slip_veer_radpm, 0.0),
            ("slip_walk", config.slip_walk, 0.0),
            ("rest_s", config.rest_s, 0.0),
            ("rest_radps", config.rest_radps, 0.0),
            ("start_m", config.start_m, 0.0),
            ("start_rad", config.start_rad, 0.0),
        ] {
            if !(value.is_finite() && value >= least) {
                return Err(OdometryError::OdometryValueOutOfRange { key: key.to_owned(), value, least });
            }
        }
        finite_pose(start)?;
        let mut odometry = Self {
            config: *config,
            effective_track_m: drive.effective_track_m,
            pose: start,
            bias_radps: 0.0,
            path_scale: 0.0,
            gyro_scale: 0.0,
            slip: Slip::new(config.slip_gain, config.slip_veer_radpm),
            covariance: [[0.0; N]; N],
            twist: Twist2::ZERO,
            resting_s: 0.0,
            path_m: 0.0,
        };
        odometry.covariance[BIAS][BIAS] = config.gyro_bias_radps.powi(2);
        odometry.covariance[PATH][PATH] = config.path_scale.powi(2);
        odometry.covariance[GYRO][GYRO] = config.gyro_scale.powi(2);
        odometry.place(start);
        Ok(odometry)
    }

    /// One tick of `dt_s`: what the wheels drove and the mean yaw rate the gyro showed.
    ///
    /// # Errors
    /// [`OdometryError::OdometryInputNotFinite`]; the state is then as before. `dt_s` must be > 0
    /// ([`OdometryError::OdometryValueOutOfRange`]).
    pub fn predict(
        &mut self,
        wheels: WheelTravel,
        gyro_radps: Option<f64>,
        dt_s: f64,
    ) -> Result<(), OdometryError> {
        for (name, value) in [
            ("wheels.left_m", wheels.left_m),
            ("wheels.right_m", wheels.right_m),
            ("gyro_radps", gyro_radps.unwrap_or(0.0)),
            ("dt_s", dt_s),
        ] {
            if !value.is_finite() {
                return Err(OdometryError::OdometryInputNotFinite { name: name.to_owned(), value });
            }
        }
        if dt_s <= 0.0 {
            return Err(OdometryError::OdometryValueOutOfRange {
                key: "dt_s".to_owned(),
                value: dt_s,
                least: f64::MIN_POSITIVE,
            });
        }
        self.learn_bias(wheels, gyro_radps, dt_s);
        let by_wheels_m = (wheels.left_m + wheels.right_m) / 2.0;
        let path_m = by_wheels_m * (1.0 + self.path_scale);
        let turn = self.fused_turn(wheels, gyro_radps, dt_s);
        let per_scale = [by_wheels_m, turn.gyro_share * turn.gyro_rad];
        self.spread(path_m, turn.rad, turn.variance, turn.gyro_share * dt_s, per_scale);
        self.covariance[BIAS][BIAS] += self.config.gyro_bias_walk * dt_s;
        // Twist2 over one second has exactly this path and turn.
        self.pose = self.pose.moved(Twist2::new(path_m, turn.rad), 1.0);
        let turn_rad = turn.rad;
        self.twist = Twist2::new(path_m / dt_s, turn_rad / dt_s);
        self.path_m += path_m.abs();
        Ok(())
    }

    fn fused_turn(&mut self, wheels: WheelTravel, gyro_radps: Option<f64>, dt_s: f64) -> Turn {
        let c = self.config;
        let path_m = (wheels.left_m + wheels.right_m) / 2.0;
        let plain = (wheels.right_m - wheels.left_m) / self.effective_track_m;
        let by_wheels = self.slip.turn(plain, path_m);
        let mut wheels_var =
            c.encoder_turn_rad2_per_rad * by_wheels.abs() + c.encoder_turn_rad2_per_m * path_m.abs();
        let Some(gyro_radps) = gyro_radps else {
            return Turn { rad: by_wheels, variance: wheels_var, gyro_share: 0.0, gyro_rad: 0.0 };
        };
        let by_gyro = (gyro_radps - self.bias_radps) * dt_s * (1.0 + self.gyro_scale);
        let gyro_var = c.gyro_rad2_per_s * dt_s + c.gyro_rad2_per_rad * by_gyro.abs();
        // Wheels that stand, or roll straight, while the gyro clearly turns: something shoved the robot.
        let beyond = (by_gyro - by_wheels).abs() - c.rest_radps * dt_s - 3.0 * (wheels_var + gyro_var).sqrt();
        if beyond <= 0.0 && (plain != 0.0 || path_m != 0.0) {
            let walk = [c.slip_walk * plain.abs(), 0.0];
            self.slip.learn(plain, path_m, by_gyro, LEARNING * wheels_var + gyro_var, walk);
        }
        wheels_var += beyond.max(0.0).powi(2) * 100.0;
        if wheels_var + gyro_var == 0.0 {
            return Turn { rad: by_wheels, variance: 0.0, gyro_share: 0.0, gyro_rad: by_gyro };
        }
        let gyro_share = wheels_var / (wheels_var + gyro_var);
        let rad = by_wheels + gyro_share * (by_gyro - by_wheels);
        Turn { rad, variance: gyro_share * gyro_var, gyro_share, gyro_rad: by_gyro }
    }

    /// P ← F P Fᵀ + G Q Gᵀ for a motion of `path_m` and `turn_rad`, which change by these per unit of
    /// bias and of both scales.
    fn spread(
        &mut self,
        path_m: f64,
        turn_rad: f64,
        turn_var: f64,
        turn_per_bias: f64,
        [path_per_scale, turn_per_scale]: [f64; 2],
    ) {
        let c = &self.config;
        let moved = Twist2::new(path_m, turn_rad).displacement(1.0);
        // Displacement of an arc and its derivatives by path and turn, world frame.
        let chord = if path_m == 0.0 {
            Twist2::new(1.0, turn_rad).displacement(1.0)
        } else {
            Pose2::new(moved.x / path_m, moved.y / path_m, 0.0)
        };
        let (sin, cos) = self.pose.heading.sin_cos();
        let to_world = |x: f64, y: f64| (cos * x - sin * y, sin * x + cos * y);
        let (dx, dy) = to_world(moved.x, moved.y);
        let step = 1e-4;
        let (plus, minus) = (
            Twist2::new(path_m, turn_rad + step).displacement(1.0),
            Twist2::new(path_m, turn_rad - step).displacement(1.0),
        );
        let by_turn = to_world((plus.x - minus.x) / (2.0 * step), (plus.y - minus.y) / (2.0 * step));
        let by_path = to_world(chord.x, chord.y);
        // Sideways slip moves the robot across the mean direction of the arc.
        let length = by_path.0.hypot(by_path.1).max(1e-9);
        let across = (-by_path.1 / length, by_path.0 / length);

        let mut f = identity();
        f[0][2] = -dy;
        f[1][2] = dx;
        f[0][BIAS] = -by_turn.0 * turn_per_bias;
        f[1][BIAS] = -by_turn.1 * turn_per_bias;
        f[2][BIAS] = -turn_per_bias;
        f[0][PATH] = by_path.0 * path_per_scale;
        f[1][PATH] = by_path.1 * path_per_scale;
        f[0][GYRO] = by_turn.0 * turn_per_scale;
        f[1][GYRO] = by_turn.1 * turn_per_scale;
        f[2][GYRO] = turn_per_scale;
        let mut p = multiply(&multiply(&f, &self.covariance), &transpose(&f));
        let slip = c.path_m2_per_rad * turn_rad.abs();
        for (direction, variance) in [
            ([by_path.0, by_path.1, 0.0], c.path_m2_per_m * path_m.abs() + slip),
            ([across.0, across.1, 0.0], c.sideways_m2_per_m * path_m.abs() + slip),
            ([by_turn.0, by_turn.1, 1.0], turn_var),
        ] {
            for i in 0..3 {
                for j in 0..3 {
                    p[i][j] += variance * direction[i] * direction[j];
                }
            }
        }
        self.covariance = symmetric(p);
    }

    /// At rest the gyro shows its bias: a Kalman update of the bias (and of what hangs on it).
    fn learn_bias(&mut self, wheels: WheelTravel, gyro_radps: Option<f64>, dt_s: f64) {
        let still = wheels.left_m.abs() < 1e-4 && wheels.right_m.abs() < 1e-4;
        let Some(gyro_radps) =
            gyro_radps.filter(|g| still && (g - self.bias_radps).abs() < self.config.rest_radps)
        else {
            self.resting_s = 0.0;
            return;
        };
        self.resting_s += dt_s;
        if self.resting_s <= self.config.rest_s {
            return;
        }
        // Mean of a rate over dt of white noise with this variance of its integral.
        let noise = (self.config.gyro_rest_rad2_per_s / dt_s).max(1e-12);
        let mut h = [0.0; N];
        h[BIAS] = 1.0;
        self.update(h, gyro_radps - self.bias_radps, noise);
    }

    /// Kalman update by one number: state += K·innovation, in Joseph form.
    pub(super) fn update(&mut self, h: State, innovation: f64, noise: f64) {
        let p = &self.covariance;
        let mut ph = [0.0; N];
        for (i, v) in ph.iter_mut().enumerate() {
            *v = (0..N).map(|j| p[i][j] * h[j]).sum();
        }
        let s: f64 = (0..N).map(|i| h[i] * ph[i]).sum::<f64>() + noise;
        if !(s.is_finite() && s > 0.0) {
            return;
        }
        let gain = ph.map(|v| v / s);
        let mut a = identity();
        for i in 0..N {
            for j in 0..N {
                a[i][j] -= gain[i] * h[j];
            }
        }
        let mut next = multiply(&multiply(&a, p), &transpose(&a));
        for i in 0..N {
            for j in 0..N {
                next[i][j] += noise * gain[i] * gain[j];
            }
        }
        self.covariance = symmetric(next);
        self.pose = Pose2::new(
            self.pose.x + gain[0] * innovation,
            self.pose.y + gain[1] * innovation,
            self.pose.heading + gain[2] * innovation,
        );
        self.bias_radps += gain[BIAS] * innovation;
        self.path_scale += gain[PATH] * innovation;
        self.gyro_scale += gain[GYRO] * innovation;
    }

    /// Where the robot is believed to be, world frame.
    pub fn pose(&self) -> Pose2 {
        self.pose
    }

    /// Covariance of (x \[m\], y \[m\], heading \[rad\]), world frame; symmetric, positive semidefinite.
    pub fn covariance(&self) -> [[f64; 3]; 3] {
        std::array::from_fn(|i| std::array::from_fn(|j| self.covariance[i][j]))
    }

    /// Mean speeds over the last tick.
    pub fn twist(&self) -> Twist2 {
        self.twist
    }

    /// What the gyro is believed to show at rest \[rad/s\].
    pub fn gyro_bias_radps(&self) -> f64 {
        self.bias_radps
    }

    /// How well the gyro's bias is known, as a standard deviation \[rad/s\].
    pub fn gyro_bias_sigma_radps(&self) -> f64 {
        self.covariance[BIAS][BIAS].max(0.0).sqrt()
    }

    /// What a metre of the encoders is too short by \[m/m\]: learnt where ranges are matched to a map.
    pub fn path_scale(&self) -> f64 {
        self.path_scale
    }

    /// What a radian of the gyro is too short by \[rad/rad\], learnt likewise.
    pub fn gyro_scale(&self) -> f64 {
        self.gyro_scale
    }

    /// The effective track that the gyro has taught so far, and its standard deviation \[m\]; the
    /// profile's to begin with.
    pub fn effective_track_m(&self) -> (f64, f64) {
        let track_m = self.effective_track_m / self.slip.gain;
        (track_m, track_m * self.slip.gain_sigma() / self.slip.gain.abs().max(1e-6))
    }

    /// Turn per path of wheels that are not alike \[rad/m\], as learnt so far.
    pub fn veer_radpm(&self) -> f64 {
        self.slip.veer
    }

    /// How long the wheels have stood now \[s\]; 0 without a gyro.
    pub fn resting_s(&self) -> f64 {
        self.resting_s
    }

    /// Length of the path driven so far \[m\].
    pub fn path_m(&self) -> f64 {
        self.path_m
    }

    /// Puts the robot at `pose`, known as well as a start is; the gyro's bias stays as learnt.
    ///
    /// # Errors
    /// [`OdometryError::OdometryInputNotFinite`].
    pub fn set_pose(&mut self, pose: Pose2) -> Result<(), OdometryError> {
        finite_pose(pose)?;
        self.place(pose);
        Ok(())
    }

    fn place(&mut self, pose: Pose2) {
        self.pose = pose;
        // What was learnt stays; what it had to do with the pose is forgotten.
        for i in 0..N {
            for j in 0..N {
                if i < BIAS || j < BIAS {
                    self.covariance[i][j] = 0.0;
                }
            }
        }
        self.covariance[0][0] = self.config.start_m.powi(2);
        self.covariance[1][1] = self.config.start_m.powi(2);
        self.covariance[2][2] = self.config.start_rad.powi(2);
    }

    /// [`Self::update`] by a number that depends on the pose alone.
    pub(super) fn update_pose(&mut self, h: [f64; 3], innovation: f64, noise: f64) {
        let mut all = [0.0; N];
        all[..3].copy_from_slice(&h);
        self.update(all, innovation, noise);
    }

    /// Puts the robot at `pose`, known as `covariance` says; what else was learnt stays.
    pub(super) fn relocate(&mut self, pose: Pose2, covariance: &[[f64; 3]; 3]) {
        self.place(pose);
        for (row, given) in self.covariance.iter_mut().zip(covariance) {
            row[..3].copy_from_slice(given);
        }
    }

    /// Puts the robot at `pose`, which is known no better than before, but not by what else was learnt:
    /// that stays, and moves the pose no more.
    ///
    /// # Errors
    /// [`OdometryError::OdometryInputNotFinite`].
    pub(crate) fn settle_at(&mut self, pose: Pose2) -> Result<(), OdometryError> {
        finite_pose(pose)?;
        let covariance = self.covariance();
        self.relocate(pose, &covariance);
        Ok(())
    }

    /// Bias and scales, to be put back with [`Self::set_learnt`].
    pub(super) fn learnt(&self) -> [f64; 3] {
        [self.bias_radps, self.path_scale, self.gyro_scale]
    }

    pub(super) fn set_learnt(&mut self, learnt: [f64; 3]) {
        [self.bias_radps, self.path_scale, self.gyro_scale] = learnt;
    }

    /// Moves the estimate by hand (a bounded correction); the covariance stays.
    pub(crate) fn nudge_to(&mut self, pose: Pose2) {
        self.pose = Pose2::new(pose.x, pose.y, wrap_angle(pose.heading));
    }
}

fn finite_pose(pose: Pose2) -> Result<(), OdometryError> {
    for (name, value) in [("pose.x", pose.x), ("pose.y", pose.y), ("pose.heading", pose.heading)] {
        if !value.is_finite() {
            return Err(OdometryError::OdometryInputNotFinite { name: name.to_owned(), value });
        }
    }
    Ok(())
}

fn identity() -> Covariance {
    std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))))
}

fn multiply(a: &Covariance, b: &Covariance) -> Covariance {
    let mut c = [[0.0; N]; N];
    for (row, out) in a.iter().zip(&mut c) {
        for (v, other) in row.iter().zip(b) {
            for j in 0..N {
                out[j] += v * other[j];
            }
        }
    }
    c
}

fn transpose(a: &Covariance) -> Covariance {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

fn symmetric(a: Covariance) -> Covariance {
    std::array::from_fn(|i| std::array::from_fn(|j| (a[i][j] + a[j][i]) / 2.0))
}
