use std::ops::{Add, Mul, Sub};

use serde::{Deserialize, Serialize};

/// A point or a displacement in the plane \[m\]; its frame is in the name of the variable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point2 {
    /// Forward in a robot frame, right on a map \[m\].
    pub x: f64,
    /// Left in a robot frame, up on a map \[m\].
    pub y: f64,
}

impl Point2 {
    /// The point (x, y) \[m\].
    #[inline]
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// Length of the displacement \[m\].
    #[inline]
    pub fn norm(self) -> f64 {
        self.x.hypot(self.y)
    }

    /// Distance to `other` \[m\].
    #[inline]
    pub fn distance(self, other: Self) -> f64 {
        (other - self).norm()
    }

    /// Direction of the displacement, counter-clockwise from +x \[rad\].
    #[inline]
    pub fn direction(self) -> f64 {
        self.y.atan2(self.x)
    }

    /// Dot product \[m²\].
    #[inline]
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// z of the cross product \[m²\]; positive when `other` is to the left.
    #[inline]
    pub fn cross(self, other: Self) -> f64 {
        self.x * other.y - self.y * other.x
    }

    /// Distance from this point to the segment from `a` to `b` \[m\].
    #[inline]
    pub fn distance_to_segment(self, a: Self, b: Self) -> f64 {
        let along = b - a;
        let length2 = along.dot(along);
        if length2 == 0.0 {
            return self.distance(a);
        }
        let t = ((self - a).dot(along) / length2).clamp(0.0, 1.0);
        self.distance(a + along * t)
    }

    /// Both coordinates are finite numbers.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite()
    }
}

impl Add for Point2 {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y)
    }
}

impl Sub for Point2 {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y)
    }
}

impl Mul<f64> for Point2 {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self::new(self.x * factor, self.y * factor)
    }
}
