use std::ops::Mul;

use serde::{Deserialize, Serialize};

use super::{Point2, Twist2, wrap_angle};

/// A planar rigid transform `a_from_b`: where frame b stands in frame a `[Maalouf06 §2]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose2 {
    /// Origin of b in a \[m\].
    pub x: f64,
    /// Origin of b in a \[m\].
    pub y: f64,
    /// Heading of b's x axis in a, counter-clockwise, in (−π, π] \[rad\].
    pub heading: f64,
}

impl Pose2 {
    /// The transform of frames that coincide.
    pub const IDENTITY: Self = Self { x: 0.0, y: 0.0, heading: 0.0 };

    /// The pose (x, y) \[m\], heading \[rad\], wrapped.
    #[inline]
    pub fn new(x: f64, y: f64, heading: f64) -> Self {
        Self { x, y, heading: wrap_angle(heading) }
    }

    /// Origin of b in a \[m\].
    #[inline]
    pub fn position(self) -> Point2 {
        Point2::new(self.x, self.y)
    }

    /// `b_from_a`.
    #[inline]
    pub fn inverse(self) -> Self {
        let (sin, cos) = self.heading.sin_cos();
        Self::new(-(self.x * cos + self.y * sin), self.x * sin - self.y * cos, -self.heading)
    }

    /// Bearing of `point_in_a` seen from b: direction minus heading, wrapped \[rad\].
    #[inline]
    pub fn bearing_to(self, point_in_a: Point2) -> f64 {
        wrap_angle((point_in_a - self.position()).direction() - self.heading)
    }

    /// Equation (1) integrated exactly: the pose after driving `twist` for `dt_s` along its arc.
    #[inline]
    pub fn moved(self, twist: Twist2, dt_s: f64) -> Self {
        self * twist.displacement(dt_s)
    }

    /// The same, to take many points over.
    #[inline]
    pub fn turned(self) -> Turned {
        let (sin, cos) = self.heading.sin_cos();
        Turned { pose: self, sin, cos }
    }

    /// All three numbers are finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.position().is_finite() && self.heading.is_finite()
    }
}

/// A pose with its sine and cosine worked out, to take many points over: to the bit as the pose does.
#[derive(Clone, Copy, Debug)]
pub struct Turned {
    pose: Pose2,
    sin: f64,
    cos: f64,
}

impl Mul<Point2> for Turned {
    type Output = Point2;
    /// The point of frame `b`, seen in frame `a`.
    #[inline]
    fn mul(self, point_in_b: Point2) -> Point2 {
        let Self { pose, sin, cos } = self;
        Point2::new(
            pose.x + cos * point_in_b.x - sin * point_in_b.y,
            pose.y + sin * point_in_b.x + cos * point_in_b.y,
        )
    }
}

impl Mul for Pose2 {
    type Output = Self;
    /// `a_from_c = a_from_b * b_from_c`.
    #[inline]
    fn mul(self, b_from_c: Self) -> Self {
        let origin_in_a = self * b_from_c.position();
        Self::new(origin_in_a.x, origin_in_a.y, self.heading + b_from_c.heading)
    }
}

impl Mul<Point2> for Pose2 {
    type Output = Point2;
    /// `point_in_a = a_from_b * point_in_b`.
    #[inline]
    fn mul(self, point_in_b: Point2) -> Point2 {
        self.turned() * point_in_b
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_quarter_circle_of_one_metre_ends_at_one_one_heading_left() {
        let pose = Pose2::IDENTITY.moved(Twist2::new(FRAC_PI_2, FRAC_PI_2), 1.0);
        assert!((pose.x - 1.0).abs() < 1e-12 && (pose.y - 1.0).abs() < 1e-12);
        assert!((pose.heading - FRAC_PI_2).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn a_pose_times_its_inverse_is_the_identity(x in -50.0..50.0f64, y in -50.0..50.0f64, h in -3.2..3.2f64) {
            let p = Pose2::new(x, y, h);
            let i = p * p.inverse();
            prop_assert!(i.x.abs() < 1e-9 && i.y.abs() < 1e-9 && i.heading.abs() < 1e-9);
        }

        #[test]
        fn two_half_steps_of_one_twist_equal_one_whole_step(v in -1.0..1.0f64, w in -3.0..3.0f64, dt in 0.0..1.0f64) {
            let twist = Twist2::new(v, w);
            let whole = Pose2::IDENTITY.moved(twist, dt);
            let halves = Pose2::IDENTITY.moved(twist, dt / 2.0).moved(twist, dt / 2.0);
            prop_assert!(whole.position().distance(halves.position()) < 1e-9);
            prop_assert!(wrap_angle(whole.heading - halves.heading).abs() < 1e-9);
        }
    }
}
