//! A robot that is under way and hardly moves: nothing it may do from here leads on. It looks for a manoeuvre
//! (back off, align, go in) and drives it.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use super::act::down_the_field;
use super::manoeuvre::{Leg, ManoeuvreConfig, Near, find};
use super::navigator::Navigator;
use super::recovery::Cause;
use crate::avoid::GrownBox;
use crate::geometry::{Point2, Pose2, Twist2, wrap_angle};
use crate::robot::Limits;
use crate::world::{Cell, Occupancy};

/// Commands above these are meant to take the robot on \[m/s, rad/s\].
const TOLD: Twist2 = Twist2::new(0.1, 0.3);
/// A leg is over this near to its end \[m\], \[rad\].
const THERE_M: f64 = 0.02;
const THERE_RAD: f64 = 0.03;
/// Another kind of leg begins below these speeds \[m/s\], \[rad/s\].
const RESTS: Twist2 = Twist2::new(0.03, 0.12);
/// Wheels that should move get at least this \[m/s\], \[rad/s\].
const LEAST: Twist2 = Twist2::new(0.04, 0.12);
/// Share of the greatest deceleration that a leg counts on.
const GENTLY: f64 = 0.5;
/// Corrections of heading by what is left of it, and by the offset, at most this \[1/s\], \[rad/(s·m)\], \[rad/s\].
const BY_HEADING: f64 = 1.5;
const BY_OFFSET: f64 = 1.5;
const MOST_RADPS: f64 = 0.3;
/// A leg that gets no nearer to its end for this long is given up \[s\].
const PATIENCE_S: f64 = 2.5;
/// Heading along the way within this, with this much room straight on, no turn is left to do \[rad\], \[m\].
const ALIGNED_RAD: f64 = 0.2;
const STRAIGHT_M: f64 = 0.5;
/// With this much more room than a turn needs, it is not for want of room that the robot stands \[m\].
const TIGHT_M: f64 = 0.1;
/// What a manoeuvre pays of what the field asks.
const BY_FIELD: f64 = 0.5;
/// Places nearer to each other than this are one \[m\].
const PLACE_M: f64 = 0.6;

/// Whether the robot moves at all, and where it stood before.
#[derive(Clone, Debug, Default)]
pub(super) struct StandWatch {
    poses: VecDeque<(f64, Pose2)>,
    /// Where it has been about since when.
    about: Option<(Point2, f64)>,
    /// Where manoeuvres began lately, and how many.
    tried: Option<(Point2, u32)>,
}

impl StandWatch {
    /// Begins anew.
    pub fn restart(&mut self) {
        self.poses.clear();
        self.about = None;
    }

    /// For how long it has milled about one place, once that is long enough.
    fn mill(&mut self, config: &ManoeuvreConfig, at: Point2, dt_s: f64) -> Option<f64> {
        let seconds = match self.about {
            Some((place, seconds)) if place.distance(at) < config.mills_m => {
                self.about = Some((place, seconds + dt_s));
                seconds + dt_s
            }
            _ => {
                self.about = Some((at, 0.0));
                0.0
            }
        };
        (seconds >= config.mills_s - 1e-9).then_some(seconds)
    }

    /// A new task: no place was tried.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// For how long it has stood, once that is long enough.
    fn step(&mut self, config: &ManoeuvreConfig, pose: Pose2, dt_s: f64) -> Option<f64> {
        let stays = |&(_, before): &(f64, Pose2)| {
            before.position().distance(pose.position()) < config.stands_m
                && wrap_angle(before.heading - pose.heading).abs() < config.stands_rad
        };
        if !self.poses.iter().all(stays) {
            self.poses.clear();
        }
        let seconds = self.poses.back().map_or(0.0, |(last, _)| last + dt_s);
        self.poses.push_back((seconds, pose));
        (seconds >= config.stands_s - 1e-9).then_some(seconds)
    }

    /// How many manoeuvres began about here.
    fn begun(&self, at: Point2) -> u32 {
        self.tried.filter(|(before, _)| before.distance(at) < PLACE_M).map_or(0, |(_, times)| times)
    }

    /// Another one begins here.
    fn begin(&mut self, at: Point2) {
        self.tried = Some((at, self.begun(at) + 1));
    }
}

/// A manoeuvre under way.
#[derive(Clone, Debug)]
pub(super) struct Manoeuvre {
    legs: VecDeque<Leg>,
    /// Least that was left of this leg, and for how long it has not become less.
    least_left: f64,
    waits_s: f64,
}

impl Navigator {
    /// Stands though under way: begins a manoeuvre if there is one.
    pub(super) fn wedged(&mut self, dt_s: f64) -> Option<Cause> {
        let config = self.config.manoeuvre;
        let pose = self.odometry.pose();
        let Twist2 { linear_mps, angular_radps } = self.commanded;
        let mills = self.stands.mill(&config, pose.position(), dt_s);
        let stands = if linear_mps.abs() > TOLD.linear_mps || angular_radps.abs() > TOLD.angular_radps {
            // It is told to go: if it does not, something else is wrong.
            self.stands.poses.clear();
            None
        } else {
            self.stands.step(&config, pose, dt_s)
        };
        let seconds = stands.or(mills)?;
        self.stands.restart();
        if self.stands.begun(pose.position()) >= config.most {
            return None;
        }
        let legs = self.find_manoeuvre(pose)?;
        self.stands.begin(pose.position());
        let cause = Cause::Wedged { seconds, legs: legs.len() as u32 };
        self.manoeuvre = Some(Manoeuvre { legs: legs.into(), least_left: f64::INFINITY, waits_s: 0.0 });
        Some(cause)
    }

    fn find_manoeuvre(&self, pose: Pose2) -> Option<Vec<Leg>> {
        let config = self.config.manoeuvre;
        let field = self.field.as_ref()?;
        let from = self.to_go_from(pose);
        if !from.is_finite() {
            return None;
        }
        let outline = self.profile.footprint;
        let body = GrownBox {
            half_length_m: outline.length_m / 2.0,
            half_width_m: outline.width_m / 2.0,
            growth_m: 0.0,
        };
        let around_m = config.reach_m + STRAIGHT_M + outline.circumscribed_radius_m() + 0.1;
        let seen = self.surfaces_near(pose.position(), around_m);
        let near = Near::new(seen, pose.position(), around_m, body);
        let kept = |clearance_m: f64| self.config.avoidance.obstacle_radius_m + clearance_m;
        let least_m = kept(config.least_clearance_m);
        let turning_m = outline.circumscribed_radius_m() + least_m;
        if near.distance_m(pose.position(), turning_m + TIGHT_M) >= turning_m + TIGHT_M {
            return None;
        }
        let leads_on = |at: Pose2| {
            let gains = field.cost_to_go(at.position()).is_some_and(|left| left <= from - config.gain);
            let faces = || {
                let ahead = down_the_field(field, at.position());
                let straight = |part: f64| at.moved(Twist2::new(part * STRAIGHT_M, 0.0), 1.0);
                ahead.is_some_and(|target| at.bearing_to(target).abs() < ALIGNED_RAD)
                    && (1..=4).all(|i| near.clearance_m(straight(f64::from(i) / 4.0), least_m) >= least_m)
            };
            gains && (near.distance_m(at.position(), turning_m) >= turning_m || faces())
        };
        // Close to things the field prices a metre higher than a manoeuvre does.
        let left = |at: Point2| {
            let left = field.cost_to_go(at).filter(|left| left.is_finite()).unwrap_or(from);
            BY_FIELD * (left - from + config.gain).max(0.0)
        };
        let with = |least_m: f64| find(&near, pose, least_m, config.reach_m, left, leads_on);
        with(kept(config.clearance_m)).or_else(|| with(least_m))
    }

    /// Occupied cells that are not inside something, and what is heard.
    fn surfaces_near(&self, center: Point2, radius_m: f64) -> Vec<Point2> {
        let geometry = self.map.geometry();
        let classes = self.map.classes();
        let is_inner = |point: &Point2| {
            geometry.cell_at(*point).is_some_and(|Cell { row, col }| {
                let inside = row > 0 && col > 0 && row + 1 < geometry.rows && col + 1 < geometry.cols;
                let taken = |row, col| classes[geometry.index(Cell::new(row, col))] == Occupancy::Occupied;
                inside
                    && taken(row - 1, col)
                    && taken(row + 1, col)
                    && taken(row, col - 1)
                    && taken(row, col + 1)
            })
        };
        let mut seen = self.map.occupied_near(center, radius_m);
        seen.retain(|point| !is_inner(point));
        seen.extend(self.heard_near());
        seen
    }

    /// The manoeuvre's next command; None once it is over, and the way was walked from there.
    pub(super) fn manoeuvre_on(&mut self, pose: Pose2, measured: Twist2, dt_s: f64) -> Option<Twist2> {
        let mut manoeuvre = self.manoeuvre.take()?;
        let obstacles = self.obstacles_in_robot(pose);
        let config = self.config.manoeuvre;
        while let Some(&leg) = manoeuvre.legs.front() {
            let Some((left, twist)) = drive_leg(&config, &self.profile.limits, leg, pose, measured) else {
                manoeuvre.legs.pop_front();
                (manoeuvre.least_left, manoeuvre.waits_s) = (f64::INFINITY, 0.0);
                continue;
            };
            if left < manoeuvre.least_left - THERE_M {
                (manoeuvre.least_left, manoeuvre.waits_s) = (left, 0.0);
            }
            manoeuvre.waits_s += dt_s;
            if manoeuvre.waits_s > PATIENCE_S {
                break;
            }
            let clear = self.cvm.keeps_off(measured, self.commanded, twist, &obstacles, dt_s);
            self.manoeuvre = Some(manoeuvre);
            return Some(if clear { twist } else { Twist2::ZERO });
        }
        self.trap.restart();
        self.stands.restart();
        if self.walk(pose).is_ok() && !self.waypoints.is_empty() {
            self.nearest = None;
            self.head_beyond(pose.position());
        }
        None
    }
}

/// What is left of a leg, and the command for it; None once it is done.
fn drive_leg(
    config: &ManoeuvreConfig,
    limits: &Limits,
    leg: Leg,
    pose: Pose2,
    measured: Twist2,
) -> Option<(f64, Twist2)> {
    let stopping = |least: f64, most: f64, deceleration: f64, left: f64| {
        (2.0 * GENTLY * deceleration * left).sqrt().clamp(least, most.max(least))
    };
    match leg {
        Leg::Turn { heading_rad, side } => {
            let around = (side * (heading_rad - pose.heading)).rem_euclid(TAU);
            // Just past its end is past it, not a turn before it.
            let left = if around > TAU - 0.5 { 0.0 } else { around };
            if left < THERE_RAD {
                return None;
            }
            if measured.linear_mps.abs() > RESTS.linear_mps {
                return Some((left, Twist2::ZERO));
            }
            let rate = stopping(LEAST.angular_radps, config.turn_radps, limits.angular_radps2, left);
            Some((left, Twist2::new(0.0, side * rate)))
        }
        Leg::Straight { to, direction } => {
            let in_leg = to.inverse() * pose.position();
            let left = -in_leg.x * direction;
            if left < THERE_M {
                return None;
            }
            if measured.angular_radps.abs() > RESTS.angular_radps
                && measured.linear_mps.abs() < RESTS.linear_mps
            {
                return Some((left, Twist2::ZERO));
            }
            let speed = stopping(LEAST.linear_mps, config.speed_mps, limits.linear_mps2, left);
            let turn = BY_HEADING * wrap_angle(to.heading - pose.heading) - BY_OFFSET * direction * in_leg.y;
            Some((left, Twist2::new(direction * speed, turn.clamp(-MOST_RADPS, MOST_RADPS))))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits =
        Limits { linear_mps: 0.7, angular_radps: 2.4, linear_mps2: 0.3, angular_radps2: 1.7 };

    fn drive(leg: Leg, start: Pose2) -> (Pose2, f64) {
        let (mut pose, mut twist) = (start, Twist2::ZERO);
        for tick in 0..400 {
            let Some((_, wanted)) = drive_leg(&ManoeuvreConfig::default(), &LIMITS, leg, pose, twist) else {
                return (pose, 0.1 * f64::from(tick));
            };
            let next = LIMITS.reachable(twist, wanted, 0.1);
            pose = pose.moved(twist, 0.1);
            twist = next;
        }
        (pose, f64::INFINITY)
    }

    #[test]
    fn every_leg_ends_near_its_end() {
        let start = Pose2::new(0.03, -0.02, 0.1);
        for direction in [1.0, -1.0] {
            let to = Pose2::new(0.5 * direction, 0.0, 0.0);
            let (end, seconds) = drive(Leg::Straight { to, direction }, start);
            assert!(end.position().distance(to.position()) < 0.06 && end.heading.abs() < 0.1, "{end:?}");
            assert!(seconds < 8.0);
        }
        for side in [1.0, -1.0] {
            let (end, seconds) = drive(Leg::Turn { heading_rad: 1.0, side }, start);
            assert!((wrap_angle(end.heading - 1.0)).abs() < 0.12, "{end:?}");
            assert!(seconds < if side > 0.0 { 5.0 } else { 15.0 });
        }
    }

    #[test]
    fn a_robot_that_runs_to_and_fro_mills_about_and_one_that_creeps_on_does_not() {
        let config = ManoeuvreConfig::default();
        let mills = |x_m: &dyn Fn(f64) -> f64| {
            let mut watch = StandWatch::default();
            (0..200)
                .any(|tick| watch.mill(&config, Point2::new(x_m(0.1 * f64::from(tick)), 0.0), 0.1).is_some())
        };
        assert!(mills(&|t| 0.3 * (0.7 * t).sin()));
        assert!(!mills(&|t| 0.08 * t));
    }

    #[test]
    fn a_robot_that_wiggles_on_the_spot_stands_and_one_that_turns_or_drives_does_not() {
        let config = ManoeuvreConfig::default();
        let stood = |pose: &dyn Fn(f64) -> Pose2| {
            let mut watch = StandWatch::default();
            (0..100).any(|tick| watch.step(&config, pose(0.1 * f64::from(tick)), 0.1).is_some())
        };
        assert!(stood(&|t: f64| Pose2::new(0.02 * (3.0 * t).sin(), 0.0, 0.1 * (2.0 * t).sin())));
        assert!(!stood(&|t| Pose2::new(0.1 * t, 0.0, 0.0)));
        assert!(!stood(&|t| Pose2::new(0.0, 0.0, wrap_angle(0.4 * t))));
    }
}
