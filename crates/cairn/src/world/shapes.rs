//! A world of circles and boxes: exact ranges along rays, and exact contact of an outline.

use std::f64::consts::{PI, TAU};

use serde::Serialize;
use thiserror::Error;

use crate::geometry::{Point2, Pose2};
use crate::robot::Footprint;

/// Angles within this of a shape's edge are still tried, so that rounding loses no ray.
const ANGLE_TOLERANCE_RAD: f64 = 1e-9;

/// A round post, seen from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    /// Its middle \[m\].
    pub centre: Point2,
    /// Its radius \[m\].
    pub radius_m: f64,
}

/// A box on the ground, turned by the heading of its pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Its middle, and where its x axis points, `world_from_block`.
    pub pose: Pose2,
    /// Length along its x axis, width along its y axis.
    pub outline: Footprint,
}

/// Why shapes were refused.
#[derive(Clone, Debug, PartialEq, Error, Serialize)]
pub enum ShapeError {
    /// A circle without a finite middle or a positive finite radius.
    #[error(
        "circle {index}: ({x_m}, {y_m}) m with radius {radius_m} m; all must be finite, the radius positive"
    )]
    CircleNotUsable {
        /// Which one.
        index: usize,
        /// Its middle \[m\].
        x_m: f64,
        /// Its middle \[m\].
        y_m: f64,
        /// Its radius \[m\].
        radius_m: f64,
    },
    /// A box without a finite pose or positive finite sides.
    #[error(
        "box {index}: ({x_m}, {y_m}) m with sides {length_m} × {width_m} m; all must be finite, the sides positive"
    )]
    BlockNotUsable {
        /// Which one.
        index: usize,
        /// Its middle \[m\].
        x_m: f64,
        /// Its middle \[m\].
        y_m: f64,
        /// Its side along its own x axis \[m\].
        length_m: f64,
        /// Its side along its own y axis \[m\].
        width_m: f64,
    },
}

/// Where a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Distance to the first surface \[m\]; 0 from inside a shape, infinite where nothing is met.
    pub range_m: f64,
    /// Cosine of the angle between the ray and the surface's normal; 1 where nothing is met.
    pub cosine: f64,
}

/// What an outline touches first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Touch {
    /// Which of the poses given.
    pub step: usize,
    /// What is touched there.
    pub shape: Touched,
}

/// A kind of shape, and which of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touched {
    /// A circle that stands.
    Circle(usize),
    /// A box.
    Block(usize),
    /// A circle that moves.
    Moving(usize),
}

/// Circles and boxes that stand; those that move are given with each question.
#[derive(Clone, Debug, Default)]
pub struct Shapes {
    circles: Vec<Circle>,
    blocks: Vec<Block>,
}

const NOTHING: RayHit = RayHit { range_m: f64::INFINITY, cosine: 1.0 };

impl Circle {
    fn check(&self, index: usize) -> Result<(), ShapeError> {
        let Self { centre, radius_m } = *self;
        let usable = centre.is_finite() && radius_m.is_finite() && radius_m > 0.0;
        let refused = ShapeError::CircleNotUsable { index, x_m: centre.x, y_m: centre.y, radius_m };
        usable.then_some(()).ok_or(refused)
    }

    /// A ray from `from` along the unit vector `unit`.
    fn met(&self, from: Point2, unit: Point2) -> RayHit {
        let to_centre = self.centre - from;
        let squared = self.radius_m * self.radius_m;
        if to_centre.dot(to_centre) <= squared {
            return RayHit { range_m: 0.0, cosine: 1.0 };
        }
        let along_m = to_centre.dot(unit);
        let across_m = to_centre.cross(unit);
        let half_chord = squared - across_m * across_m;
        if along_m <= 0.0 || half_chord < 0.0 {
            return NOTHING;
        }
        let half_chord_m = half_chord.sqrt();
        RayHit { range_m: (along_m - half_chord_m).max(0.0), cosine: half_chord_m / self.radius_m }
    }

    /// Directions from `from` in which it is seen: middle and half width \[rad\]; None from inside.
    fn seen(&self, from: Point2) -> Option<(f64, f64)> {
        let to_centre = self.centre - from;
        let distance_m = to_centre.norm();
        (distance_m > self.radius_m).then(|| (to_centre.direction(), (self.radius_m / distance_m).asin()))
    }
}

impl Block {
    fn check(&self, index: usize) -> Result<(), ShapeError> {
        let Footprint { length_m, width_m } = self.outline;
        let sides = [length_m, width_m].iter().all(|side| side.is_finite() && *side > 0.0);
        let (x_m, y_m) = (self.pose.x, self.pose.y);
        let refused = ShapeError::BlockNotUsable { index, x_m, y_m, length_m, width_m };
        (sides && self.pose.is_finite()).then_some(()).ok_or(refused)
    }

    /// A ray from `from` along the unit vector `unit`: the overlap of two slabs.
    fn met(&self, from: Point2, unit: Point2) -> RayHit {
        let (sin, cos) = self.pose.heading.sin_cos();
        let turned = |p: Point2| Point2::new(cos * p.x + sin * p.y, cos * p.y - sin * p.x);
        let (start, along) = (turned(from - self.pose.position()), turned(unit));
        let slab = |start: f64, along: f64, half: f64| {
            if along == 0.0 {
                if start.abs() <= half { (f64::NEG_INFINITY, f64::INFINITY) } else { (f64::INFINITY, 0.0) }
            } else {
                let (a, b) = ((-half - start) / along, (half - start) / along);
                (a.min(b), a.max(b))
            }
        };
        let (x0, x1) = slab(start.x, along.x, self.outline.length_m / 2.0);
        let (y0, y1) = slab(start.y, along.y, self.outline.width_m / 2.0);
        let (enter, leave) = (x0.max(y0), x1.min(y1));
        if enter > leave || leave < 0.0 {
            return NOTHING;
        }
        if enter <= 0.0 {
            return RayHit { range_m: 0.0, cosine: 1.0 };
        }
        RayHit { range_m: enter, cosine: if x0 >= y0 { along.x.abs() } else { along.y.abs() } }
    }

    /// The four corners \[m\].
    fn corners(&self) -> [Point2; 4] {
        self.outline.corners().map(|corner| self.pose * corner)
    }

    /// Directions from `from` in which it is seen: middle and half width \[rad\]; None from inside.
    fn seen(&self, from: Point2) -> Option<(f64, f64)> {
        if self.outline.distance(self.pose.inverse() * from) == 0.0 {
            return None;
        }
        // Seen from outside, a box spans less than half a turn about the direction of its middle.
        let middle = (self.pose.position() - from).direction();
        let offsets = self.corners().map(|c| crate::geometry::wrap_angle((c - from).direction() - middle));
        let (lo, hi) = offsets.iter().fold((PI, -PI), |(lo, hi), &o| (lo.min(o), hi.max(o)));
        Some((middle + (lo + hi) / 2.0, (hi - lo) / 2.0))
    }

    /// Least distance between two boxes \[m\]; zero where they overlap.
    fn distance(&self, other: &Self) -> f64 {
        if self.overlaps(other) {
            return 0.0;
        }
        // Apart, the nearest pair holds a corner of one of the two.
        let one_way = |a: &Self, b: &Self| {
            let inverse = a.pose.inverse();
            b.corners().iter().map(|&c| a.outline.distance(inverse * c)).fold(f64::INFINITY, f64::min)
        };
        one_way(self, other).min(one_way(other, self))
    }

    /// No axis of either separates them.
    fn overlaps(&self, other: &Self) -> bool {
        let between = other.pose.position() - self.pose.position();
        [self.pose.heading, other.pose.heading].iter().all(|&heading| {
            let (sin, cos) = heading.sin_cos();
            [Point2::new(cos, sin), Point2::new(-sin, cos)]
                .iter()
                .all(|&axis| between.dot(axis).abs() <= self.reach_m(axis) + other.reach_m(axis))
        })
    }

    /// Half of its extent along a unit vector \[m\].
    fn reach_m(&self, axis: Point2) -> f64 {
        let (sin, cos) = self.pose.heading.sin_cos();
        let x = axis.dot(Point2::new(cos, sin)).abs() * self.outline.length_m / 2.0;
        x + axis.dot(Point2::new(-sin, cos)).abs() * self.outline.width_m / 2.0
    }
}

impl Shapes {
    /// Circles and boxes that stand, in the world frame.
    ///
    /// # Errors
    /// [`ShapeError`] names the first shape that is none.
    pub fn new(circles: Vec<Circle>, blocks: Vec<Block>) -> Result<Self, ShapeError> {
        check_circles(&circles)?;
        for (index, block) in blocks.iter().enumerate() {
            block.check(index)?;
        }
        Ok(Self { circles, blocks })
    }

    /// What a planar scanner measures: `beams` ranges \[m\], beam i along `first_rad + i · step_rad`
    /// in the frame of the scanner; infinite beyond `max_range_m`, zero from inside a shape.
    ///
    /// Every shape is tried only on the beams whose directions it covers.
    pub fn scan(
        &self,
        world_from_lidar: Pose2,
        beams: usize,
        first_rad: f64,
        step_rad: f64,
        max_range_m: f64,
        moving: &[Circle],
    ) -> Vec<f64> {
        let from = world_from_lidar.position();
        let first_rad = world_from_lidar.heading + first_rad;
        let directions: Vec<Point2> = (0..beams)
            .map(|beam| {
                let (sin, cos) = (first_rad + beam as f64 * step_rad).sin_cos();
                Point2::new(cos, sin)
            })
            .collect();
        let mut ranges_m = vec![f64::INFINITY; beams];
        let mut enter = |seen: Option<(f64, f64)>, met: &dyn Fn(Point2) -> RayHit| {
            for (first, last) in beams_in(seen, first_rad, step_rad, beams) {
                for beam in first..last {
                    let range_m = met(directions[beam]).range_m;
                    if range_m < ranges_m[beam] {
                        ranges_m[beam] = range_m;
                    }
                }
            }
        };
        for circle in self.circles.iter().chain(moving) {
            if circle.centre.distance(from) - circle.radius_m <= max_range_m {
                enter(circle.seen(from), &|unit| circle.met(from, unit));
            }
        }
        for block in &self.blocks {
            enter(block.seen(from), &|unit| block.met(from, unit));
        }
        for range_m in &mut ranges_m {
            if *range_m > max_range_m {
                *range_m = f64::INFINITY;
            }
        }
        ranges_m
    }

    /// Where rays from one point end, one per direction \[rad, world frame\].
    pub fn cast(&self, from: Point2, directions_rad: &[f64], max_range_m: f64) -> Vec<RayHit> {
        let near: Vec<&Circle> =
            self.circles.iter().filter(|c| c.centre.distance(from) - c.radius_m <= max_range_m).collect();
        directions_rad
            .iter()
            .map(|direction| {
                let (sin, cos) = direction.sin_cos();
                let unit = Point2::new(cos, sin);
                let circles = near.iter().map(|circle| circle.met(from, unit));
                let hits = circles.chain(self.blocks.iter().map(|block| block.met(from, unit)));
                let first = hits.fold(NOTHING, |a, b| if b.range_m < a.range_m { b } else { a });
                if first.range_m <= max_range_m { first } else { NOTHING }
            })
            .collect()
    }

    /// Least distance from an outline to any shape \[m\]; zero in contact, infinite alone.
    pub fn clearance_m(&self, world_from_robot: Pose2, outline: &Footprint, moving: &[Circle]) -> f64 {
        let robot_from_world = world_from_robot.inverse();
        let robot = Block { pose: world_from_robot, outline: *outline };
        let circles =
            self.circles.iter().chain(moving).map(|circle| {
                (outline.distance(robot_from_world * circle.centre) - circle.radius_m).max(0.0)
            });
        let blocks = self.blocks.iter().map(|block| robot.distance(block));
        circles.chain(blocks).fold(f64::INFINITY, f64::min)
    }

    /// The first of some poses at which an outline touches a shape.
    ///
    /// `moving` holds the circles that move, as many for each pose; none where it is empty.
    pub fn first_touch(&self, poses: &[Pose2], outline: &Footprint, moving: &[Circle]) -> Option<Touch> {
        let each = moving.len().checked_div(poses.len()).unwrap_or(0);
        let reach_m = outline.circumscribed_radius_m();
        for (step, &pose) in poses.iter().enumerate() {
            let robot_from_world = pose.inverse();
            let touches = |circle: &Circle| {
                let to = circle.centre - pose.position();
                let most_m = reach_m + circle.radius_m;
                to.dot(to) <= most_m * most_m
                    && outline.distance(robot_from_world * circle.centre) <= circle.radius_m
            };
            let now = &moving[step * each..(step + 1) * each];
            let robot = Block { pose, outline: *outline };
            let circle = || self.circles.iter().position(touches).map(Touched::Circle);
            let block = || self.blocks.iter().position(|b| robot.overlaps(b)).map(Touched::Block);
            let moved = || now.iter().position(touches).map(Touched::Moving);
            if let Some(shape) = circle().or_else(block).or_else(moved) {
                return Some(Touch { step, shape });
            }
        }
        None
    }
}

/// Checks circles that move, as [`Shapes::new`] does those that stand.
///
/// # Errors
/// [`ShapeError::CircleNotUsable`] names the first that is none.
pub fn check_circles(circles: &[Circle]) -> Result<(), ShapeError> {
    circles.iter().enumerate().try_for_each(|(index, circle)| circle.check(index))
}

/// Ranges first..last of the beams that look into `seen` (middle, half width); all for None.
fn beams_in(
    seen: Option<(f64, f64)>,
    first_rad: f64,
    step_rad: f64,
    beams: usize,
) -> impl Iterator<Item = (usize, usize)> {
    let whole = seen.is_none() || step_rad == 0.0;
    let (middle, half) = seen.unwrap_or((0.0, 0.0));
    let half = half + ANGLE_TOLERANCE_RAD;
    let span_rad = step_rad.abs() * beams.saturating_sub(1) as f64;
    // In turns of the scan's own sense: beam k looks |step| · k past beam 0.
    let from_first = step_rad.signum() * (middle - first_rad);
    let base = (from_first + half).rem_euclid(TAU) - half; // middle, so that middle + half is in [0, 2π)
    let turns = if whole { 1 } else { (span_rad / TAU).ceil() as usize + 2 };
    (0..turns).filter_map(move |turn| {
        if whole {
            return Some((0, beams));
        }
        let middle = base + turn as f64 * TAU;
        let first = ((middle - half) / step_rad.abs()).ceil().max(0.0) as usize;
        let last = ((middle + half) / step_rad.abs()).floor() + 1.0;
        let last = if last > 0.0 { (last as usize).min(beams) } else { 0 };
        (first < last).then_some((first, last))
    })
}

#[cfg(test)]
#[path = "shapes_tests.rs"]
mod tests;
