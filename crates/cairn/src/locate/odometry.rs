//! Encoders and gyro fused into a pose with covariance.

use serde::{Deserialize, Serialize};
use thiserror::Error;

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

/// Index of the gyro's bias in the state (x, y, heading, bias).
const BIAS: usize = 3;

pub(super) type Cov4 = [[f64; 4]; 4];

/// Where the robot is by its own motion: an extended Kalman filter over (x, y, heading, gyro bias).
///
/// The turn of a tick is the mean of the encoders' and the gyro's, each weighted by the other's
/// variance; the path is the mean of both sides along the exact arc of equation (1) `[Maalouf06 §2]`.
/// At rest the gyro's output is its bias.
#[derive(Clone, Debug)]
pub struct Odometry {
    config: OdometryConfig,
    effective_track_m: f64,
    pub(super) pose: Pose2,
    bias_radps: f64,
    pub(super) covariance: Cov4,
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
            covariance: [[0.0; 4]; 4],
            twist: Twist2::ZERO,
            resting_s: 0.0,
            path_m: 0.0,
        };
        odometry.covariance[BIAS][BIAS] = config.gyro_bias_radps.powi(2);
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
        let path_m = (wheels.left_m + wheels.right_m) / 2.0;
        let (turn_rad, turn_var, gyro_share) = self.fused_turn(wheels, gyro_radps, dt_s);
        self.spread(path_m, turn_rad, turn_var, gyro_share * dt_s);
        self.covariance[BIAS][BIAS] += self.config.gyro_bias_walk * dt_s;
        // Twist2 over one second has exactly this path and turn.
        self.pose = self.pose.moved(Twist2::new(path_m, turn_rad), 1.0);
        self.twist = Twist2::new(path_m / dt_s, turn_rad / dt_s);
        self.path_m += path_m.abs();
        Ok(())
    }

    /// Turn, its variance, and the share the gyro had in it.
    fn fused_turn(&self, wheels: WheelTravel, gyro_radps: Option<f64>, dt_s: f64) -> (f64, f64, f64) {
        let c = &self.config;
        let path_m = ((wheels.left_m + wheels.right_m) / 2.0).abs();
        let by_wheels = (wheels.right_m - wheels.left_m) / self.effective_track_m;
        let mut wheels_var =
            c.encoder_turn_rad2_per_rad * by_wheels.abs() + c.encoder_turn_rad2_per_m * path_m;
        let Some(gyro_radps) = gyro_radps else { return (by_wheels, wheels_var, 0.0) };
        let by_gyro = (gyro_radps - self.bias_radps) * dt_s;
        let gyro_var = c.gyro_rad2_per_s * dt_s + c.gyro_rad2_per_rad * by_gyro.abs();
        // Wheels that stand, or roll straight, while the gyro clearly turns: something shoved the robot.
        let beyond = (by_gyro - by_wheels).abs() - c.rest_radps * dt_s - 3.0 * (wheels_var + gyro_var).sqrt();
        wheels_var += beyond.max(0.0).powi(2) * 100.0;
        if wheels_var + gyro_var == 0.0 {
            return (by_wheels, 0.0, 0.0);
        }
        let gyro_share = wheels_var / (wheels_var + gyro_var);
        let turn = by_wheels + gyro_share * (by_gyro - by_wheels);
        (turn, gyro_share * gyro_var, gyro_share)
    }

    /// P ← F P Fᵀ + G Q Gᵀ for a motion of `path_m` and `turn_rad`.
    fn spread(&mut self, path_m: f64, turn_rad: f64, turn_var: f64, turn_per_bias: f64) {
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
        self.update([0.0, 0.0, 0.0, 1.0], gyro_radps - self.bias_radps, noise);
    }

    /// Kalman update by one number: state += K·innovation, in Joseph form.
    pub(super) fn update(&mut self, h: [f64; 4], innovation: f64, noise: f64) {
        let p = &self.covariance;
        let mut ph = [0.0; 4];
        for (i, v) in ph.iter_mut().enumerate() {
            *v = (0..4).map(|j| p[i][j] * h[j]).sum();
        }
        let s: f64 = (0..4).map(|i| h[i] * ph[i]).sum::<f64>() + noise;
        if !(s.is_finite() && s > 0.0) {
            return;
        }
        let gain = ph.map(|v| v / s);
        let mut a = identity();
        for i in 0..4 {
            for j in 0..4 {
                a[i][j] -= gain[i] * h[j];
            }
        }
        let mut next = multiply(&multiply(&a, p), &transpose(&a));
        for i in 0..4 {
            for j in 0..4 {
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
        let bias = self.covariance[BIAS][BIAS];
        self.covariance = [[0.0; 4]; 4];
        self.covariance[BIAS][BIAS] = bias;
        self.covariance[0][0] = self.config.start_m.powi(2);
        self.covariance[1][1] = self.config.start_m.powi(2);
        self.covariance[2][2] = self.config.start_rad.powi(2);
    }

    /// [`Self::update`] by a number that depends on the pose alone.
    pub(super) fn update_pose(&mut self, h: [f64; 3], innovation: f64, noise: f64) {
        self.update([h[0], h[1], h[2], 0.0], innovation, noise);
    }

    /// Puts the robot at `pose`, known as `covariance` says; what else was learnt stays.
    pub(super) fn relocate(&mut self, pose: Pose2, covariance: &[[f64; 3]; 3]) {
        self.place(pose);
        for (row, given) in self.covariance.iter_mut().zip(covariance) {
            row[..3].copy_from_slice(given);
        }
    }

    /// Moves the estimate by hand (a bounded correction); the covariance stays.
    pub(super) fn nudge_to(&mut self, pose: Pose2) {
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

fn identity() -> Cov4 {
    std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))))
}

fn multiply(a: &Cov4, b: &Cov4) -> Cov4 {
    let mut c = [[0.0; 4]; 4];
    for (row, out) in a.iter().zip(&mut c) {
        for (v, other) in row.iter().zip(b) {
            for j in 0..4 {
                out[j] += v * other[j];
            }
        }
    }
    c
}

fn transpose(a: &Cov4) -> Cov4 {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

fn symmetric(a: Cov4) -> Cov4 {
    std::array::from_fn(|i| std::array::from_fn(|j| (a[i][j] + a[j][i]) / 2.0))
}
