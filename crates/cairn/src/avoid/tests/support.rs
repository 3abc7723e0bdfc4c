use crate::geometry::Point2;
use crate::robot::{Footprint, Limits};

pub const P3AT: Footprint = Footprint { length_m: 0.626, width_m: 0.505 };
pub const LIMITS: Limits =
    Limits { linear_mps: 0.7, angular_radps: 2.443461, linear_mps2: 0.3, angular_radps2: 1.745329 };

/// A small generator of its own, so that scenes are the same everywhere.
pub struct Dice(pub u64);

impl Dice {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    pub fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n - 1)
    }
}

/// Centres of the 0.05 m cells that a wall from `a` to `b` passes.
pub fn wall(a: (f64, f64), b: (f64, f64)) -> Vec<Point2> {
    let (a, b) = (Point2::new(a.0, a.1), Point2::new(b.0, b.1));
    let count = (a.distance(b) / 0.05).ceil().max(1.0) as usize;
    (0..=count).map(|i| a + (b - a) * (i as f64 / count as f64)).collect()
}

/// The outline of a box.
pub fn block(center: (f64, f64), width: f64, height: f64) -> Vec<Point2> {
    let (x0, x1) = (center.0 - width / 2.0, center.0 + width / 2.0);
    let (y0, y1) = (center.1 - height / 2.0, center.1 + height / 2.0);
    [((x0, y0), (x1, y0)), ((x1, y0), (x1, y1)), ((x1, y1), (x0, y1)), ((x0, y1), (x0, y0))]
        .into_iter()
        .flat_map(|(a, b)| wall(a, b))
        .collect()
}
