use crate::geometry::Point2;

/// Curvatures flatter than this are straight: over 100 m the difference is 5 µm \[1/m\].
const STRAIGHT_PER_M: f64 = 1e-9;

/// A box about the robot's centre, grown by a disc: every point within `growth_m` of the box.
///
/// A box of no size is the paper's round robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrownBox {
    /// Half of the box along the robot's x axis \[m\].
    pub half_length_m: f64,
    /// Half of the box along the robot's y axis \[m\].
    pub half_width_m: f64,
    /// Radius of the disc \[m\].
    pub growth_m: f64,
}

impl GrownBox {
    /// Distance from the robot's centre to the farthest point of the grown box \[m\].
    pub fn radius_m(&self) -> f64 {
        self.half_length_m.hypot(self.half_width_m) + self.growth_m
    }

    /// The same box with `extra_m` more growth.
    pub fn grown(&self, extra_m: f64) -> Self {
        Self { growth_m: self.growth_m + extra_m, ..*self }
    }

    /// Distance from `point_in_robot` to the box without its growth \[m\]; zero inside.
    pub fn distance(&self, point_in_robot: Point2) -> f64 {
        self.squared_distance(point_in_robot).sqrt()
    }

    /// Whether `point_in_robot` is in the grown box, its edge included.
    pub fn contains(&self, point_in_robot: Point2) -> bool {
        self.squared_distance(point_in_robot) <= self.growth_m * self.growth_m
    }

    fn squared_distance(&self, p: Point2) -> f64 {
        let dx = (p.x.abs() - self.half_length_m).max(0.0);
        let dy = (p.y.abs() - self.half_width_m).max(0.0);
        dx * dx + dy * dy
    }

    /// Length of the arc of curvature `curvature_per_m` (left positive) driven forward until the
    /// grown box first holds `point_in_robot` \[m\]; 0 if it does already, infinite if it never does.
    pub fn first_contact_m(&self, point_in_robot: Point2, curvature_per_m: f64) -> f64 {
        if self.contains(point_in_robot) {
            return 0.0;
        }
        if curvature_per_m.abs() < STRAIGHT_PER_M {
            return self.first_contact_straight_m(point_in_robot);
        }
        self.sweep_on_arc(point_in_robot, curvature_per_m).angle_rad() / curvature_per_m.abs()
    }

    /// As [`Self::first_contact_m`] on an arc that is not straight; infinite as well where the turn
    /// up to there has an order ([`turn_order`]) beyond `most`, which saves working its length out.
    pub(super) fn first_contact_up_to_m(
        &self,
        point_in_robot: Point2,
        curvature_per_m: f64,
        most: f64,
    ) -> f64 {
        if self.contains(point_in_robot) {
            return 0.0;
        }
        let sweep = self.sweep_on_arc(point_in_robot, curvature_per_m);
        if sweep.order > most { f64::INFINITY } else { sweep.angle_rad() / curvature_per_m.abs() }
    }

    fn sweep_on_arc(&self, point_in_robot: Point2, curvature_per_m: f64) -> Sweep {
        let center = Point2::new(0.0, 1.0 / curvature_per_m);
        self.first_contact_about(point_in_robot, center, curvature_per_m > 0.0)
    }

    /// Angle turned in place, to the left or right, until the grown box first holds
    /// `point_in_robot` \[rad\]; 0 if it does already, infinite if it never does.
    pub fn first_contact_turning_rad(&self, point_in_robot: Point2, left: bool) -> f64 {
        if self.contains(point_in_robot) {
            return 0.0;
        }
        self.first_contact_about(point_in_robot, Point2::default(), left).angle_rad()
    }

    fn first_contact_straight_m(&self, p: Point2) -> f64 {
        let beside = p.y.abs() - self.half_width_m;
        if beside > self.growth_m {
            return f64::INFINITY;
        }
        let beside = beside.max(0.0);
        let reach = self.half_length_m + (self.growth_m * self.growth_m - beside * beside).max(0.0).sqrt();
        if p.x < 0.0 { f64::INFINITY } else { (p.x - reach).max(0.0) }
    }

    /// The robot turns about `center`; in its own frame the point runs the other way on the circle
    /// through `p`. It enters the grown box on one of four sides or four corner discs; every
    /// crossing with any of them lies in the grown box, so the first of all crossings is the entry.
    fn first_contact_about(&self, p: Point2, center: Point2, left: bool) -> Sweep {
        let arm = p - center;
        let squared = arm.dot(arm);
        let mut first = Sweep { p, arm, squared, left, order: f64::INFINITY, best: p };
        let (hx, hy, g) = (self.half_length_m, self.half_width_m, self.growth_m);

        // Sides y = ±(hy + g), |x| ≤ hx, and x = ±(hx + g), |y| ≤ hy. The differences of squares
        // are written as products, so that nothing cancels when the centre is far away.
        if hx > 0.0 {
            for y in [hy + g, -hy - g] {
                let b2 = arm.x * arm.x + (p.y - y) * (p.y + y - 2.0 * center.y);
                if b2 >= 0.0 {
                    let b = b2.sqrt();
                    for x in [center.x + b, center.x - b] {
                        if x.abs() <= hx {
                            first.offer(Point2::new(x, y));
                        }
                    }
                }
            }
        }
        if hy > 0.0 {
            for x in [hx + g, -hx - g] {
                // y² − 2 yc y = m, the near root from the far one.
                let m = (p.x - x) * (p.x + x - 2.0 * center.x) + p.y * (p.y - 2.0 * center.y);
                let b2 = center.y * center.y + m;
                if b2 >= 0.0 {
                    let far = center.y + b2.sqrt().copysign(center.y);
                    let near = if far == 0.0 { 0.0 } else { -m / far };
                    for y in [far, near] {
                        if y.abs() <= hy {
                            first.offer(Point2::new(x, y));
                        }
                    }
                }
            }
        }
        let corners = [(hx, hy), (-hx, hy), (-hx, -hy), (hx, -hy)];
        for &(x, y) in if hx > 0.0 || hy > 0.0 { &corners[..] } else { &corners[..1] } {
            let corner = Point2::new(x, y);
            let to_center = center - corner;
            let apart2 = to_center.dot(to_center);
            if apart2 == 0.0 {
                continue;
            }
            let difference = (p - corner).dot(center * 2.0 - p - corner); // apart² − ρ²
            let along = (difference + g * g) / (2.0 * apart2);
            let across2 = g * g / apart2 - along * along;
            if across2 >= 0.0 {
                let across = across2.sqrt();
                let foot = corner + to_center * along;
                let normal = Point2::new(-to_center.y, to_center.x) * across;
                first.offer(foot + normal);
                first.offer(foot - normal);
            }
        }
        first
    }
}

/// Grows with an angle over \[0, 2π), told by anything proportional to its sine and cosine.
pub(super) fn turn_order(sin: f64, cos: f64) -> f64 {
    let ramp = sin / (sin.abs() + cos.abs());
    if cos < 0.0 {
        2.0 - ramp
    } else if sin >= 0.0 {
        ramp
    } else {
        4.0 + ramp
    }
}

/// Finds the crossing that a point meets first as it runs round its circle.
struct Sweep {
    p: Point2,
    arm: Point2,
    squared: f64,
    left: bool,
    order: f64,
    best: Point2,
}

impl Sweep {
    /// (sine, cosine), times ρ², of the angle from the start to `q` in the direction of running.
    fn turn(&self, q: Point2) -> (f64, f64) {
        let chord = q - self.p;
        let cross = self.arm.cross(chord);
        (if self.left { -cross } else { cross }, self.squared + self.arm.dot(chord))
    }

    fn offer(&mut self, q: Point2) {
        let (sin, cos) = self.turn(q);
        let order = turn_order(sin, cos);
        if order < self.order {
            self.order = order;
            self.best = q;
        }
    }

    fn angle_rad(&self) -> f64 {
        if self.order.is_infinite() {
            return f64::INFINITY;
        }
        let (sin, cos) = self.turn(self.best);
        let angle = sin.atan2(cos);
        if angle < 0.0 { angle + std::f64::consts::TAU } else { angle }
    }
}
