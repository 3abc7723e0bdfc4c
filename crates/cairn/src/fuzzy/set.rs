use serde::{Deserialize, Serialize};

/// A membership function, piecewise linear and continuous.
///
/// In a file: `{ triangle = [0.1, 0.3, 0.6] }`, in the unit of the input.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FuzzySet {
    /// 0 at the first and last breakpoint, 1 at the middle one.
    Triangle([f64; 3]),
    /// Rises over the first two breakpoints, 1 up to the third, 0 at the fourth.
    Trapezoid([f64; 4]),
    /// 1 up to the first breakpoint, 0 from the second.
    LeftShoulder([f64; 2]),
    /// 0 up to the first breakpoint, 1 from the second.
    RightShoulder([f64; 2]),
}

impl FuzzySet {
    /// Degree to which `x` belongs to the set, in [0, 1].
    pub fn membership(&self, x: f64) -> f64 {
        let rise = |from: f64, to: f64| ((x - from) / (to - from)).clamp(0.0, 1.0);
        let fall = |from: f64, to: f64| ((to - x) / (to - from)).clamp(0.0, 1.0);
        match *self {
            Self::Triangle([a, b, c]) => rise(a, b).min(fall(b, c)),
            Self::Trapezoid([a, b, c, d]) => rise(a, b).min(fall(c, d)),
            Self::LeftShoulder([a, b]) => fall(a, b),
            Self::RightShoulder([a, b]) => rise(a, b),
        }
    }

    /// Where the slope changes, in rising order.
    pub fn breakpoints(&self) -> &[f64] {
        match self {
            Self::Triangle(points) => points,
            Self::Trapezoid(points) => points,
            Self::LeftShoulder(points) | Self::RightShoulder(points) => points,
        }
    }

    /// Breakpoints are finite and rise; only the plateau of a trapezoid may have no width.
    pub(super) fn is_valid(&self) -> bool {
        let points = self.breakpoints();
        let plateau = matches!(self, Self::Trapezoid(_)).then_some(1);
        points.iter().all(|p| p.is_finite())
            && points
                .windows(2)
                .enumerate()
                .all(|(i, pair)| pair[0] < pair[1] || (plateau == Some(i) && pair[0] == pair[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn sets_have_the_degrees_of_hand_drawn_figures() {
        let triangle = FuzzySet::Triangle([1.0, 2.0, 4.0]);
        let trapezoid = FuzzySet::Trapezoid([0.0, 1.0, 2.0, 4.0]);
        let left = FuzzySet::LeftShoulder([1.0, 3.0]);
        let right = FuzzySet::RightShoulder([1.0, 3.0]);
        for (set, x, degree) in [
            (triangle, 1.0, 0.0),
            (triangle, 1.5, 0.5),
            (triangle, 2.0, 1.0),
            (triangle, 3.0, 0.5),
            (triangle, 9.0, 0.0),
            (trapezoid, 0.25, 0.25),
            (trapezoid, 1.5, 1.0),
            (trapezoid, 3.0, 0.5),
            (left, -7.0, 1.0),
            (left, 2.5, 0.25),
            (right, 2.5, 0.75),
            (right, 7.0, 1.0),
        ] {
            assert_eq!(set.membership(x), degree, "{set:?} at {x}");
        }
    }

    proptest! {
        #[test]
        fn membership_is_a_degree_and_continuous(
            start in -5.0..5.0f64, widths in prop::array::uniform3(0.01..3.0f64), x in -10.0..15.0f64,
        ) {
            let [a, b, c] = widths;
            let points = [start, start + a, start + a + b, start + a + b + c];
            for set in [
                FuzzySet::Trapezoid(points),
                FuzzySet::Triangle([points[0], points[1], points[2]]),
                FuzzySet::LeftShoulder([points[0], points[1]]),
                FuzzySet::RightShoulder([points[0], points[1]]),
            ] {
                prop_assert!(set.is_valid());
                let (here, beside) = (set.membership(x), set.membership(x + 1e-6));
                prop_assert!((0.0..=1.0).contains(&here));
                prop_assert!((here - beside).abs() <= 1.1e-6 / 0.01);
            }
        }
    }
}
