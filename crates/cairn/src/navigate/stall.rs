//! Does the robot move as its wheels say? Told to move and standing, or wheels that turn while nothing that
//! it hears comes nearer: something holds it that no sensor shows.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::recovery::Cause;
use crate::geometry::{Pose2, Twist2};
use crate::locate::WheelTravel;
use crate::robot::RobotProfile;

/// When a robot counts as held, and what it does then.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StallConfig {
    /// Wheels and echoes are compared over at most this time \[s\].
    pub window_s: f64,
    /// Wheels must have turned this far for echoes that stay to count \[m\].
    pub spun_m: f64,
    /// Wheels must have turned the robot by this for a gyroscope that stays to count \[rad\].
    pub turned_rad: f64,
    /// Wheels that stand for this long although they are told to turn are held \[s\].
    pub held_s: f64,
    /// How far to back off \[m\].
    pub back_off_m: f64,
    /// How fast \[m/s\].
    pub back_off_mps: f64,
    /// Wheels that stand for this long while backing off have no motors \[s\].
    pub silent_s: f64,
    /// How long to wait for the motors before the next plan \[s\].
    pub wait_s: f64,
}

impl Default for StallConfig {
    fn default() -> Self {
        Self {
            window_s: 4.0,
            spun_m: 0.3,
            turned_rad: 0.6,
            held_s: 2.0,
            back_off_m: 0.3,
            back_off_mps: 0.12,
            silent_s: 1.0,
            wait_s: 2.0,
        }
    }
}

/// Looking along the direction of motion within this, a range must change as the robot moves \[rad\].
const ALONG_RAD: f64 = 0.62;
/// A range that changed by less stays \[m\].
const STAYS_M: f64 = 0.04;
/// A range that changed by more shows that the robot, or something, moves \[m\].
const CHANGES_M: f64 = 0.08;
/// A range that the map expects to change by more speaks \[m\].
const EXPECTED_M: f64 = 0.12;
/// Turned by more than this, ranges say nothing of the path \[rad\].
const STRAIGHT_RAD: f64 = 0.2;
/// Ranges that must stay.
const WITNESSES: usize = 2;
/// At each end of the window this many readings are averaged.
const AVERAGED: usize = 3;
/// Beams of a lidar that are watched, at most.
const BEAMS: usize = 48;
/// Share of the wheels' turn that the gyroscope must see.
const SEEN_TURN: f64 = 0.15;
/// Commands below these may be too small for the robot to follow \[m/s, rad/s\].
const TOLD: Twist2 = Twist2::new(0.1, 0.3);
/// Wheels slower than these stand \[m/s, rad/s\].
const STANDS: Twist2 = Twist2::new(0.01, 0.03);

#[derive(Clone, Debug)]
struct Tick {
    dt_s: f64,
    path_m: f64,
    turned_by_wheels_rad: f64,
    turned_by_gyro_rad: Option<f64>,
    world_from_robot: Pose2,
    ranges_m: Vec<f64>,
}

/// How the robot moved in one tick by its own senses, and where that takes it.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// Way of each side's wheels.
    pub wheels: WheelTravel,
    /// Mean yaw rate by the gyroscope, without its bias \[rad/s\].
    pub gyro_radps: Option<f64>,
    /// Estimated pose after it.
    pub world_from_robot: Pose2,
    /// How long it took \[s\].
    pub dt_s: f64,
}

/// Watches the wheels against everything else, while the robot is under way.
#[derive(Clone, Debug)]
pub struct StallWatch {
    config: StallConfig,
    track_m: f64,
    /// Index of a range, and the direction it looks in, seen from the robot \[rad\].
    eyes: Vec<(usize, f64)>,
    ticks: VecDeque<Tick>,
    held_s: f64,
}

impl StallWatch {
    /// A watch that has seen nothing yet.
    pub fn new(config: StallConfig, profile: &RobotProfile) -> Self {
        let mut eyes: Vec<(usize, f64)> =
            profile.sonars.iter().enumerate().map(|(i, sonar)| (i, sonar.pose.heading)).collect();
        if let Some(lidar) = &profile.lidar {
            let stride = lidar.beams.div_ceil(BEAMS).max(1);
            let beams = (0..lidar.beams).step_by(stride);
            eyes.extend(beams.map(|beam| {
                let angle_rad = lidar.pose.heading + lidar.first_rad + beam as f64 * lidar.step_rad;
                (profile.sonars.len() + beam, angle_rad)
            }));
        }
        let track_m = profile.drive.effective_track_m;
        Self { config, track_m, eyes, ticks: VecDeque::new(), held_s: 0.0 }
    }

    /// Forgets everything: the robot rests, or was moved.
    pub fn restart(&mut self) {
        self.ticks.clear();
        self.held_s = 0.0;
    }

    /// One tick: what was commanded before it, and what was measured.
    ///
    /// `expected(from, to, sensor)` is the change of a range that the map makes expected of a motion
    /// between two poses \[m\], if it says anything.
    pub fn step(
        &mut self,
        commanded: Twist2,
        moved: &Moved,
        ranges_m: &[f64],
        expected: impl Fn(Pose2, Pose2, usize) -> Option<f64>,
    ) -> Option<Cause> {
        let Moved { wheels, gyro_radps, world_from_robot, dt_s } = *moved;
        let path_m = (wheels.left_m + wheels.right_m) / 2.0;
        let turned_rad = (wheels.right_m - wheels.left_m) / self.track_m;
        self.ticks.push_back(Tick {
            dt_s,
            path_m,
            turned_by_wheels_rad: turned_rad,
            turned_by_gyro_rad: gyro_radps.map(|rate| rate * dt_s),
            world_from_robot,
            ranges_m: self.eyes.iter().map(|&(i, _)| ranges_m.get(i).copied().unwrap_or(f64::NAN)).collect(),
        });
        let mut time_s: f64 = self.ticks.iter().map(|tick| tick.dt_s).sum();
        while time_s > self.config.window_s && self.ticks.len() > 1 {
            time_s -= self.ticks.pop_front().map_or(0.0, |tick| tick.dt_s);
        }
        self.held(commanded, path_m / dt_s, turned_rad / dt_s, dt_s)
            .or_else(|| self.turns_in_vain())
            .or_else(|| self.spins(expected))
    }

    fn held(&mut self, told: Twist2, wheels_mps: f64, wheels_radps: f64, dt_s: f64) -> Option<Cause> {
        let is_told =
            told.linear_mps.abs() >= TOLD.linear_mps || told.angular_radps.abs() >= TOLD.angular_radps;
        let stands = wheels_mps.abs() < STANDS.linear_mps && wheels_radps.abs() < STANDS.angular_radps;
        self.held_s = if is_told && stands { self.held_s + dt_s } else { 0.0 };
        (self.held_s >= self.config.held_s).then_some(Cause::WheelsHeld { seconds: self.held_s })
    }

    /// The last ticks in which `of` adds up to at least `much`.
    fn last(&self, much: f64, of: impl Fn(&Tick) -> f64) -> Option<std::ops::Range<usize>> {
        let mut sum = 0.0;
        let first = (0..self.ticks.len()).rev().find(|&i| {
            sum += of(&self.ticks[i]);
            sum.abs() >= much
        })?;
        Some(first..self.ticks.len())
    }

    fn turns_in_vain(&self) -> Option<Cause> {
        let ticks = self.last(self.config.turned_rad, |tick| tick.turned_by_wheels_rad)?;
        let turned_rad: f64 = self.ticks.range(ticks.clone()).map(|tick| tick.turned_by_wheels_rad).sum();
        let path_m: f64 = self.ticks.range(ticks.clone()).map(|tick| tick.path_m).sum();
        let seen_rad = self.ticks.range(ticks).map(|tick| tick.turned_by_gyro_rad).sum::<Option<f64>>()?;
        let in_vain = seen_rad.abs() < SEEN_TURN * turned_rad.abs();
        in_vain.then_some(Cause::TurnHeld { turned_rad, path_m })
    }

    /// Echoes that stay although they should change, as the wheels turn, and no range that changes.
    fn spins(&self, expected: impl Fn(Pose2, Pose2, usize) -> Option<f64>) -> Option<Cause> {
        let ticks = self.last(self.config.spun_m, |tick| tick.path_m)?;
        // Averages at both ends: the ways between their middles add up to what was asked for.
        let first = ticks.start.checked_sub(AVERAGED)?;
        let ends = [first..first + AVERAGED, ticks.end - AVERAGED..ticks.end];
        if ends[0].end > ends[1].start {
            return None;
        }
        let spun = ends[0].end..ticks.end;
        let path_m: f64 = self.ticks.range(spun).map(|tick| tick.path_m).sum();
        let seen = |tick: &Tick| tick.turned_by_gyro_rad.unwrap_or(tick.turned_by_wheels_rad);
        let turned_rad: f64 = self.ticks.range(first..ticks.end).map(seen).sum();
        if turned_rad.abs() > STRAIGHT_RAD {
            return None;
        }
        let mut stay = Vec::new();
        for eye in 0..self.eyes.len() {
            let [Some(first_m), Some(last_m)] = ends.clone().map(|end| self.mean_range(eye, end)) else {
                continue;
            };
            let change_m = (last_m - first_m).abs();
            if change_m >= CHANGES_M {
                return None;
            }
            if change_m < STAYS_M {
                stay.push(eye);
            }
        }
        let middle = |end: &std::ops::Range<usize>| self.ticks[end.start + AVERAGED / 2].world_from_robot;
        let [from, to] = [middle(&ends[0]), middle(&ends[1])];
        let should_change = |&&eye: &&usize| {
            let (sensor, axis_rad) = self.eyes[eye];
            let looks_along = axis_rad.sin().abs() <= ALONG_RAD.sin();
            looks_along || expected(from, to, sensor).is_some_and(|m| m.abs() >= EXPECTED_M)
        };
        (stay.iter().filter(should_change).count() >= WITNESSES)
            .then_some(Cause::WheelsSpin { spun_m: path_m })
    }

    fn mean_range(&self, eye: usize, ticks: std::ops::Range<usize>) -> Option<f64> {
        let heard =
            || self.ticks.range(ticks.clone()).map(|tick| tick.ranges_m[eye]).filter(|r| r.is_finite());
        let count = heard().count();
        (count > 0).then(|| heard().sum::<f64>() / count as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{Drive, Footprint, Limits, Sonar};

    const DT_S: f64 = 0.1;

    fn robot() -> RobotProfile {
        let sonar = |degrees: f64| Sonar {
            pose: Pose2::new(0.0, 0.0, degrees.to_radians()),
            beam_rad: 0.5,
            min_range_m: 0.1,
            max_range_m: 5.0,
        };
        RobotProfile {
            name: "test".into(),
            footprint: Footprint { length_m: 0.6, width_m: 0.5 },
            limits: Limits { linear_mps: 0.7, angular_radps: 2.4, linear_mps2: 0.3, angular_radps2: 1.7 },
            drive: Drive { effective_track_m: 0.6, latency_s: 0.1 },
            sonars: [90.0, 30.0, 10.0, -10.0, -30.0, -90.0, 180.0].map(sonar).to_vec(),
            lidar: None,
        }
    }

    /// Ticks until the watch speaks, and what it says; `ranges` by the way driven \[m\].
    fn drive(
        told: Twist2,
        wheels: Twist2,
        gyro_radps: f64,
        ranges: impl Fn(f64, usize) -> Vec<f64>,
    ) -> Option<(usize, Cause)> {
        let mut watch = StallWatch::new(StallConfig::default(), &robot());
        (0..100).find_map(|tick| {
            let (path, turn) = (wheels.linear_mps * DT_S, wheels.angular_radps * DT_S * 0.6 / 2.0);
            let travel = WheelTravel { left_m: path - turn, right_m: path + turn };
            let heard = ranges(wheels.linear_mps * DT_S * tick as f64, tick);
            let way_m = wheels.linear_mps * DT_S * tick as f64;
            let moved = Moved {
                wheels: travel,
                gyro_radps: Some(gyro_radps),
                world_from_robot: Pose2::new(way_m, 0.0, 0.0),
                dt_s: DT_S,
            };
            // A map of a wall to the left that runs towards the robot's way, half as far as it goes.
            let expected = |from: Pose2, to: Pose2, sensor: usize| {
                [0, 1].contains(&sensor).then_some(-0.5 * (to.x - from.x))
            };
            watch.step(told, &moved, &heard, expected).map(|cause| (tick, cause))
        })
    }

    fn jitter(tick: usize) -> f64 {
        0.01 * ((tick * 7919 % 13) as f64 / 6.0 - 1.0)
    }

    /// A wall ahead and one behind; nothing to the sides.
    fn walls(way_m: f64, tick: usize) -> Vec<f64> {
        let (ahead, behind) = (4.0 - way_m + jitter(tick), 1.0 + way_m);
        vec![f64::INFINITY, ahead, ahead, ahead, ahead, f64::INFINITY, behind]
    }

    #[test]
    fn wheels_that_spin_before_walls_that_stay_are_noticed_within_a_metre() {
        let forward = Twist2::new(0.4, 0.0);
        let (tick, cause) = drive(forward, forward, 0.0, |_, tick| walls(0.0, tick)).unwrap();
        assert!(matches!(cause, Cause::WheelsSpin { spun_m } if spun_m > 0.25 && spun_m < 0.6), "{cause:?}");
        assert!(tick <= 12, "{tick}");
    }

    #[test]
    fn a_robot_that_is_held_on_its_way_is_noticed_within_half_a_metre_of_wheels() {
        let forward = Twist2::new(0.5, 0.0);
        let held_after_m = |way_m: f64| 2.0_f64.min(way_m);
        let (tick, cause) =
            drive(forward, forward, 0.0, |way_m, tick| walls(held_after_m(way_m), tick)).unwrap();
        let since_m = 0.5 * DT_S * tick as f64 - 2.0;
        assert!(since_m > 0.3 && since_m < 0.7, "{since_m}");
        assert!(matches!(cause, Cause::WheelsSpin { .. }));
    }

    #[test]
    fn where_the_map_expects_side_ranges_to_change_they_are_witnesses_too() {
        let forward = Twist2::new(0.4, 0.0);
        let aside = |_: f64, tick: usize| {
            let side = 0.8 + jitter(tick);
            vec![side, side, f64::INFINITY, f64::INFINITY, f64::INFINITY, side, f64::INFINITY]
        };
        assert!(matches!(drive(forward, forward, 0.0, aside), Some((_, Cause::WheelsSpin { .. }))));
    }

    #[test]
    fn a_robot_that_moves_is_not_held_whatever_it_follows_or_passes() {
        let forward = Twist2::new(0.35, 0.0);
        assert_eq!(drive(forward, forward, 0.0, walls), None);
        let beside_walls = |_: f64, tick: usize| {
            let side = 0.8 + jitter(tick);
            let nothing = f64::INFINITY;
            vec![nothing, nothing, nothing, nothing, nothing, side, nothing]
        };
        assert_eq!(drive(forward, forward, 0.0, beside_walls), None);
        let behind_somebody = |way_m: f64, tick: usize| {
            let ahead = 1.2 + jitter(tick);
            vec![f64::INFINITY, ahead, ahead, ahead, ahead, f64::INFINITY, 1.0 + way_m]
        };
        assert_eq!(drive(forward, forward, 0.0, behind_somebody), None);
        assert_eq!(drive(forward, forward, 0.0, |_, _| vec![f64::INFINITY; 7]), None);
    }

    #[test]
    fn wheels_that_stand_though_told_to_turn_are_held_after_the_patience() {
        let told = Twist2::new(0.3, 0.0);
        let (tick, cause) = drive(told, Twist2::ZERO, 0.0, |_, tick| walls(0.0, tick)).unwrap();
        assert!(matches!(cause, Cause::WheelsHeld { .. }));
        assert!((19..=21).contains(&tick), "{tick}");
        assert_eq!(drive(Twist2::new(0.05, 0.1), Twist2::ZERO, 0.0, |_, tick| walls(0.0, tick)), None);
    }

    #[test]
    fn a_turn_that_the_gyroscope_does_not_see_is_held_and_one_that_slips_is_not() {
        let turn = Twist2::new(0.0, 0.8);
        let quiet = |_: f64, _: usize| vec![f64::INFINITY; 7];
        assert!(matches!(drive(turn, turn, 0.02, quiet), Some((_, Cause::TurnHeld { .. }))));
        assert_eq!(drive(turn, turn, 0.5, quiet), None);
    }
}
