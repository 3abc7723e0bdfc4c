//! How wheels that slip turn the robot, learnt from a gyroscope.

/// Two numbers that turn what the wheels did into the robot's turn: turn = gain · (right − left) / b +
/// veer · path. A Kalman filter over (gain, veer), which are constant, or nearly.
///
/// The gain is the profile's effective track over the true one; the veer comes from sides whose wheels
/// are not alike.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slip {
    pub gain: f64,
    /// \[rad/m\]
    pub veer: f64,
    covariance: [[f64; 2]; 2],
}

impl Slip {
    pub(super) fn new(gain_sigma: f64, veer_sigma: f64) -> Self {
        let covariance = [[gain_sigma * gain_sigma, 0.0], [0.0, veer_sigma * veer_sigma]];
        Self { gain: 1.0, veer: 0.0, covariance }
    }

    /// The turn of wheels that say `by_wheels` \[rad\] over a path \[m\].
    pub(super) fn turn(&self, by_wheels: f64, path_m: f64) -> f64 {
        self.gain * by_wheels + self.veer * path_m
    }

    /// Learns from a true turn, known with `variance` \[rad²\]; both wander by `walk` meanwhile.
    pub(super) fn learn(&mut self, by_wheels: f64, path_m: f64, turn: f64, variance: f64, walk: [f64; 2]) {
        let h = [by_wheels, path_m];
        let p = &mut self.covariance;
        p[0][0] += walk[0];
        p[1][1] += walk[1];
        let ph = [p[0][0] * h[0] + p[0][1] * h[1], p[1][0] * h[0] + p[1][1] * h[1]];
        let s = h[0] * ph[0] + h[1] * ph[1] + variance;
        if !(s.is_finite() && s > 0.0) {
            return;
        }
        let innovation = turn - (self.gain * h[0] + self.veer * h[1]);
        self.gain += ph[0] / s * innovation;
        self.veer += ph[1] / s * innovation;
        for (i, row) in p.iter_mut().enumerate() {
            for (j, value) in row.iter_mut().enumerate() {
                *value -= ph[i] * ph[j] / s;
            }
        }
        // Rounding must not make a variance negative.
        p[0][0] = p[0][0].max(1e-12);
        p[1][1] = p[1][1].max(1e-12);
        let cross = (p[0][1] + p[1][0]) / 2.0;
        (p[0][1], p[1][0]) = (cross, cross);
    }

    /// Standard deviation of the gain.
    pub(super) fn gain_sigma(&self) -> f64 {
        self.covariance[0][0].max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gain_and_veer_are_told_apart_by_turns_and_straights() {
        let mut slip = Slip::new(0.2, 0.05);
        for k in 0..200 {
            let (by_wheels, path_m) = if k % 2 == 0 { (0.1, 0.0) } else { (0.0, 0.05) };
            slip.learn(by_wheels, path_m, 0.93 * by_wheels - 0.012 * path_m, 1e-7, [0.0; 2]);
        }
        assert!((slip.gain - 0.93).abs() < 1e-3 && (slip.veer + 0.012).abs() < 1e-3, "{slip:?}");
        assert!(slip.gain_sigma() < 1e-3);
    }
}
