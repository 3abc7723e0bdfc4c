use super::contact::GrownBox;
use crate::geometry::Point2;

/// Curvatures between which an arc meets the disc of `radius_m` about `center_in_robot`: 2(y ∓ r)/(d² − r²).
///
/// `None` if the robot's centre is inside the disc: then every arc does.
pub fn tangent_curvatures(center_in_robot: Point2, radius_m: f64) -> Option<(f64, f64)> {
    let power = center_in_robot.dot(center_in_robot) - radius_m * radius_m;
    (power > 0.0)
        .then(|| (2.0 * (center_in_robot.y - radius_m) / power, 2.0 * (center_in_robot.y + radius_m) / power))
}

/// Length of the arc of `curvature_per_m` until the robot's centre is first within `radius_m` of
/// `center_in_robot` \[m\]; infinite if it never is.
pub fn disc_first_contact(center_in_robot: Point2, radius_m: f64, curvature_per_m: f64) -> f64 {
    let disc = GrownBox { half_length_m: 0.0, half_width_m: 0.0, growth_m: radius_m };
    disc.first_contact_m(center_in_robot, curvature_per_m)
}

/// An obstacle of the round robot, its radius grown by the robot's.
pub(super) struct DiscObstacle {
    pub curvature_lo: f64,
    pub curvature_hi: f64,
    center: Point2,
    radius_m: f64,
    /// The arc with the shortest way to it.
    nearest: std::cell::OnceCell<f64>,
}

impl DiscObstacle {
    pub fn new(center: Point2, radius_m: f64) -> Option<Self> {
        tangent_curvatures(center, radius_m).map(|(curvature_lo, curvature_hi)| Self {
            curvature_lo,
            curvature_hi,
            center,
            radius_m,
            nearest: std::cell::OnceCell::new(),
        })
    }

    /// First contact; at a tangent, where rounding may miss, the length to the tangent point.
    fn contact_m(&self, curvature: f64) -> f64 {
        let contact_m = disc_first_contact(self.center, self.radius_m, curvature);
        if contact_m.is_finite() {
            return contact_m;
        }
        let inward = (self.curvature_hi - self.curvature_lo) * 1e-9;
        let inside = if curvature > (self.curvature_lo + self.curvature_hi) / 2.0 { -inward } else { inward };
        disc_first_contact(self.center, self.radius_m, curvature + inside)
    }

    /// Least first contact of the arcs in \[lo, hi\], which lies within the tangents.
    ///
    /// From one tangent to the other the first contact falls to one least value and rises again.
    pub fn least_contact_m(&self, lo: f64, hi: f64) -> f64 {
        let nearest = *self.nearest.get_or_init(|| self.nearest_curvature());
        self.contact_m(nearest.clamp(lo, hi)).min(self.contact_m(lo)).min(self.contact_m(hi))
    }

    fn nearest_curvature(&self) -> f64 {
        const SHRINK: f64 = 0.618_033_988_749_894_9;
        let (mut lo, mut hi) = (self.curvature_lo, self.curvature_hi);
        let (mut a, mut b) = (hi - SHRINK * (hi - lo), lo + SHRINK * (hi - lo));
        let (mut at_a, mut at_b) = (self.contact_m(a), self.contact_m(b));
        for _ in 0..36 {
            if at_a <= at_b {
                (hi, b, at_b) = (b, a, at_a);
                a = hi - SHRINK * (hi - lo);
                at_a = self.contact_m(a);
            } else {
                (lo, a, at_a) = (a, b, at_b);
                b = lo + SHRINK * (hi - lo);
                at_b = self.contact_m(b);
            }
        }
        (lo + hi) / 2.0
    }
}
