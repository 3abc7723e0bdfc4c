//! Off what holds the robot: it goes on the map, the robot backs away from it, and then drives on.

use std::cell::OnceCell;

use super::navigator::Navigator;
use super::record::BackingRecord;
use super::recovery::{Cause, Recovery};
use super::stall::Moved;
use crate::geometry::{Point2, Pose2, Twist2};
use crate::locate::WheelTravel;
use crate::world::sonar_range;

/// Wheels that turned less than this did not answer \[m\].
const ANSWERED_M: f64 = 0.03;
/// What holds the robot is taken to reach this far beyond its sides \[m\].
const BESIDE_M: f64 = 0.05;
/// Wheels that turn less in a tick stand \[m\].
const STANDS_M: f64 = 0.002;
/// Wheels come to rest within this \[s\].
const SLOWING_S: f64 = 3.0;
/// Turning in vain, a robot that also pushed this far ran into something \[m\].
const PUSHED_M: f64 = 0.15;
/// Held a second time within this, it is the place and not the motors \[m\].
const SAME_PLACE_M: f64 = 0.6;

/// Backing off, from the moment it was held.
#[derive(Clone, Copy, Debug)]
pub(super) struct Backing {
    /// Why.
    pub cause: Cause,
    /// −1: backwards, as it drove forwards.
    direction: f64,
    moved_m: f64,
    spent_s: f64,
    /// Spent on wheels that still spin the old way.
    slowing_s: f64,
    /// Where it was held, world frame.
    at: Point2,
}

/// How backing off stands.
pub(super) enum Backed {
    /// Still at it.
    Goes,
    /// Far enough, or no farther: on with the way.
    Done,
    /// The wheels do not answer at all.
    Silent(Recovery),
}

impl Navigator {
    /// Watches the wheels, and takes back what they spun; None while nothing holds the robot.
    pub(super) fn watch_for_stall(
        &mut self,
        wheels: WheelTravel,
        gyro_radps: Option<f64>,
        ranges_m: &[f64],
        dt_s: f64,
    ) -> Option<Cause> {
        if !self.is_under_way() || self.backing.is_some() {
            self.stall.restart();
            return None;
        }
        let turn_radps = gyro_radps.map(|rate| rate - self.odometry.gyro_bias_radps());
        let told = self.commanded;
        let pose = self.odometry.pose();
        let occupied = OnceCell::new();
        let expected = |from: Pose2, to: Pose2, sensor: usize| {
            let sonar = self.profile.sonars.get(sensor)?;
            let grid = occupied.get_or_init(|| self.map.occupied());
            let at = |pose: Pose2| sonar_range(grid, pose * sonar.pose, sonar.beam_rad, sonar.max_range_m);
            Some(at(to) - at(from)).filter(|change| change.is_finite())
        };
        let moved = Moved { wheels, gyro_radps: turn_radps, world_from_robot: pose, dt_s };
        let cause = self.stall.step(told, &moved, ranges_m, expected)?;
        self.stall.restart();
        // What is measured outside, or scans laid on one another, took back already.
        let by_wheels = !self.pose_given && self.lidar.is_none();
        if let (Cause::WheelsSpin { spun_m }, true) = (cause, by_wheels) {
            let pose = self.odometry.pose();
            self.odometry.nudge_to(pose.moved(Twist2::new(-spun_m, 0.0), 1.0));
        }
        Some(cause)
    }

    /// What of the wheels' way the robot went: nothing of it while they spin on although it is held.
    pub(super) fn believed(&self, wheels: WheelTravel) -> WheelTravel {
        let spins = |backing: &Backing| (wheels.left_m + wheels.right_m) * backing.direction < 0.0;
        if self.backing.as_ref().is_some_and(spins) { WheelTravel::default() } else { wheels }
    }

    /// Begins to back off.
    pub(super) fn begin_backing(&mut self, pose: Pose2, cause: Cause) {
        let forwards = self.commanded.linear_mps >= 0.0;
        let sign = if forwards { 1.0 } else { -1.0 };
        let ahead_m = self.profile.footprint.length_m / 2.0 + self.map.geometry().resolution_m;
        let aside_m = self.profile.footprint.width_m / 2.0 + BESIDE_M;
        let edge = [-aside_m, aside_m].map(|y| pose * Point2::new(sign * ahead_m, y));
        // Wheels that spin have motors: something is there. Wheels that stand may have none; only if they
        // turned meanwhile and stand again at the same place is it the place.
        let again = self.held_at.is_some_and(|at| at.distance(pose.position()) < SAME_PLACE_M);
        match cause {
            Cause::WheelsSpin { .. } => self.feel(edge),
            Cause::TurnHeld { path_m, .. } if path_m * sign >= PUSHED_M => self.feel(edge),
            Cause::WheelsHeld { .. } if again => self.feel(edge),
            _ => {}
        }
        self.held_at = None;
        self.backing = Some(Backing {
            cause,
            direction: -sign,
            moved_m: 0.0,
            spent_s: 0.0,
            slowing_s: 0.0,
            at: pose.position(),
        });
    }

    /// Takes note of how far it has come.
    pub(super) fn back_on(&mut self, wheels: WheelTravel, dt_s: f64) -> Backed {
        let Some(backing) = &mut self.backing else { return Backed::Done };
        let moved_m = (wheels.left_m + wheels.right_m) / 2.0 * backing.direction;
        if moved_m < -STANDS_M && backing.slowing_s < SLOWING_S {
            // The wheels still spin the old way: motors have their ramps.
            backing.slowing_s += dt_s;
            return Backed::Goes;
        }
        backing.moved_m += moved_m;
        backing.spent_s += dt_s;
        let backing = *backing;
        let config = self.config.stall;
        if backing.moved_m < ANSWERED_M {
            if backing.spent_s < config.silent_s {
                return Backed::Goes;
            }
            self.backing = None;
            let silent = matches!(backing.cause, Cause::WheelsHeld { .. });
            return if silent {
                Backed::Silent(Cause::MotorsSilent { seconds: config.held_s + backing.spent_s }.remedied())
            } else {
                Backed::Done
            };
        }
        // Backwards they turn: it was no matter of motors, or it is none any more.
        self.held_at = Some(backing.at);
        let longest_s = 2.0 * config.back_off_m / config.back_off_mps + config.silent_s;
        if backing.moved_m >= config.back_off_m || backing.spent_s > longest_s {
            self.backing = None;
            return Backed::Done;
        }
        Backed::Goes
    }

    /// The command: straight off, as long as nothing is there either; None ends it.
    ///
    /// The robot stands, whatever its wheels say, and what holds it is on the side that it leaves.
    pub(super) fn back_off(&mut self, pose: Pose2, dt_s: f64) -> Option<(Twist2, BackingRecord)> {
        let backing = self.backing?;
        let speed_mps = backing.direction * self.config.stall.back_off_mps;
        let rolls = if backing.moved_m > 0.0 { Twist2::new(speed_mps, 0.0) } else { Twist2::ZERO };
        let twist = Twist2::new(speed_mps, 0.0);
        let mut obstacles = self.obstacles_in_robot(pose);
        obstacles.retain(|p| p.x * backing.direction > 0.0);
        let clear = self.cvm.keeps_clear(rolls, rolls, twist, &obstacles, dt_s);
        if !clear {
            self.backing = None;
        }
        let Backing { cause, moved_m, .. } = backing;
        clear.then_some((twist, BackingRecord { cause, moved_m, back_off_m: self.config.stall.back_off_m }))
    }

    /// What no sensor shows, along an edge.
    fn feel(&mut self, [a, b]: [Point2; 2]) {
        let step_m = self.map.geometry().resolution_m / 2.0;
        let steps = (a.distance(b) / step_m).ceil().max(1.0);
        self.map.feel((0..=steps as usize).map(|i| a + (b - a) * (i as f64 / steps)));
    }
}
