use serde::{Deserialize, Serialize};

use super::Pose2;

/// Speeds of a robot in its own frame: the paper's (V, ω), CVM's (tv, rv).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist2 {
    /// Translational speed V along the robot's x axis \[m/s\].
    pub linear_mps: f64,
    /// Rotational speed ω, counter-clockwise \[rad/s\].
    pub angular_radps: f64,
}

impl Twist2 {
    /// Standing still.
    pub const ZERO: Self = Self { linear_mps: 0.0, angular_radps: 0.0 };

    /// The twist (V \[m/s\], ω \[rad/s\]).
    #[inline]
    pub const fn new(linear_mps: f64, angular_radps: f64) -> Self {
        Self { linear_mps, angular_radps }
    }

    /// Where the robot stands after `dt_s`, in its frame before: the exact arc of equation (1).
    #[inline]
    pub fn displacement(self, dt_s: f64) -> Pose2 {
        let distance_m = self.linear_mps * dt_s;
        let turn_rad = self.angular_radps * dt_s;
        // sin(a)/a and (1 − cos a)/a, from the half angle, so that they stay exact near a = 0.
        let half = turn_rad / 2.0;
        let chord = if half.abs() < 1e-6 { 1.0 - half * half / 6.0 } else { half.sin() / half };
        Pose2::new(distance_m * chord * half.cos(), distance_m * chord * half.sin(), turn_rad)
    }

    /// Both numbers are finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.linear_mps.is_finite() && self.angular_radps.is_finite()
    }
}
