//! The tracker on a kinematic robot with latency and acceleration limits, perfect pose, 10 Hz.

use std::collections::VecDeque;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::*;
use crate::geometry::{Point2, Pose2, Twist2};
use crate::robot::Limits;

const P3AT: &str = include_str!("../../../../python/cairn/data/controllers/p3at.toml");
const DT_S: f64 = 0.1;
const LIMITS: Limits =
    Limits { linear_mps: 0.7, angular_radps: 2.443461, linear_mps2: 0.3, angular_radps2: 1.745329 };

pub(super) fn controller() -> TrackerConfig {
    toml::from_str(P3AT).expect("the shipped controller parses")
}

pub(super) fn tracker() -> Tracker {
    Tracker::new(&controller(), &LIMITS).expect("the shipped controller is valid")
}

fn waypoints(path: &[Point2], spacing_m: f64) -> Waypoints {
    Waypoints::resample(path, spacing_m, |_, _| true).expect("a valid path")
}

struct Drive {
    tracker: Tracker,
    pose: Pose2,
    twist: Twist2,
    pending: VecDeque<Twist2>,
    records: Vec<TrackingRecord>,
    poses: Vec<Pose2>,
}

impl Drive {
    fn new(path: &[Point2], spacing_m: f64) -> Self {
        let mut tracker = tracker();
        tracker.follow(waypoints(path, spacing_m));
        Self {
            tracker,
            pose: Pose2::IDENTITY,
            twist: Twist2::ZERO,
            pending: VecDeque::from([Twist2::ZERO]),
            records: Vec::new(),
            poses: vec![Pose2::IDENTITY],
        }
    }

    fn step(&mut self) {
        let record = self.tracker.step(self.pose, self.twist, DT_S);
        let before = self.records.last().map_or(Twist2::ZERO, |record| record.twist);
        let sent = record.twist;
        assert!((0.0..=LIMITS.linear_mps).contains(&sent.linear_mps), "{record:?}");
        assert!(sent.angular_radps.abs() <= LIMITS.angular_radps, "{record:?}");
        assert!((sent.linear_mps - before.linear_mps).abs() <= LIMITS.linear_mps2 * DT_S + 1e-12);
        assert!((sent.angular_radps - before.angular_radps).abs() <= LIMITS.angular_radps2 * DT_S + 1e-12);
        self.pending.push_back(sent);
        let felt = self.pending.pop_front().expect("one is always pending");
        for _ in 0..10 {
            self.twist = LIMITS.reachable(self.twist, felt, DT_S / 10.0);
            self.pose = self.pose.moved(self.twist, DT_S / 10.0);
        }
        self.poses.push(self.pose);
        self.records.push(record);
    }

    fn run(&mut self, most_s: f64) -> &mut Self {
        for _ in 0..(most_s / DT_S) as usize {
            self.step();
            if self.records.last().is_some_and(|record| record.arrived) {
                break;
            }
        }
        self
    }

    fn assert_came_to_rest_at(&mut self, goal: Point2) {
        let end = self.records.last().expect("ran");
        assert!(end.arrived, "not arrived: {end:?}");
        assert!(self.twist.linear_mps < 0.05, "{}", self.twist.linear_mps);
        for _ in 0..20 {
            self.step();
        }
        assert!(self.pose.position().distance(goal) <= 0.03, "{:?}", self.pose);
        assert!(self.twist.linear_mps < 0.01 && self.twist.angular_radps.abs() < 0.01, "{:?}", self.twist);
    }

    /// Root mean square and greatest distance to `path` from pose `from` on.
    fn cross_track(&self, path: &[Point2], from: usize) -> (f64, f64) {
        let distances: Vec<f64> =
            self.poses[from..].iter().map(|pose| distance(pose.position(), path)).collect();
        let mean = distances.iter().map(|d| d * d).sum::<f64>() / distances.len() as f64;
        (mean.sqrt(), distances.iter().copied().fold(0.0, f64::max))
    }
}

fn distance(point: Point2, path: &[Point2]) -> f64 {
    path.windows(2).map(|side| point.distance_to_segment(side[0], side[1])).fold(f64::INFINITY, f64::min)
}

fn line(points: &[(f64, f64)]) -> Vec<Point2> {
    points.iter().map(|&(x, y)| Point2::new(x, y)).collect()
}

fn sine() -> Vec<Point2> {
    (0..=1000).map(|i| 2.0 * TAU * f64::from(i) / 1000.0).map(|x| Point2::new(x, x.sin())).collect()
}

#[test]
fn a_sine_is_followed_within_three_centimetres() {
    for spacing_m in [0.2, 0.3, 0.4] {
        let path = sine();
        let mut drive = Drive::new(&path, spacing_m);
        drive.run(90.0).assert_came_to_rest_at(*path.last().expect("not empty"));
        let (rms, _) = drive.cross_track(&path, 0);
        println!("sine d {spacing_m}: rms {rms} in {} s", drive.poses.len() as f64 * DT_S);
        assert!(rms <= 0.03, "spacing {spacing_m}: {rms}");
    }
}

#[test]
fn a_ramp_at_135_degrees_is_met_by_turning_first() {
    let path = line(&[(0.0, 0.0), (-4.0, 4.0)]);
    let mut drive = Drive::new(&path, 0.3);
    drive.run(60.0).assert_came_to_rest_at(path[1]);
    let (rms, greatest) = drive.cross_track(&path, 0);
    assert!(rms <= 0.03 && greatest <= 0.06, "{rms} {greatest}");
}

#[test]
fn a_lateral_step_of_a_metre_is_overshot_by_at_most_ten_centimetres() {
    for spacing_m in [0.1, 0.15, 0.2, 0.3, 0.6] {
        let path = line(&[(0.0, 1.0), (8.0, 1.0)]);
        let mut drive = Drive::new(&path, spacing_m);
        drive.run(60.0).assert_came_to_rest_at(path[1]);
        let overshoot = drive.poses.iter().map(|pose| pose.y - 1.0).fold(0.0, f64::max);
        assert!(overshoot <= 0.10, "spacing {spacing_m}: {overshoot}");
    }
}

#[test]
fn a_straight_line_is_driven_without_weaving() {
    for spacing_m in [0.1, 0.3, 0.6, 1.0] {
        let path = line(&[(0.0, 0.03), (10.0, 0.03)]);
        let mut drive = Drive::new(&path, spacing_m);
        drive.run(120.0).assert_came_to_rest_at(path[1]);
        let late: Vec<&TrackingRecord> = drive.records.iter().filter(|r| r.remaining_m < 5.0).collect();
        let weave = late.iter().map(|r| r.twist.angular_radps.abs()).fold(0.0, f64::max);
        assert!(weave < 0.02, "spacing {spacing_m}: {weave}");
    }
}

#[test]
fn speed_grows_with_the_spacing_of_waypoints() {
    let path = line(&[(0.0, 0.0), (10.0, 0.0)]);
    let seconds = |spacing_m: f64| {
        let mut drive = Drive::new(&path, spacing_m);
        drive.run(200.0);
        drive.records.len()
    };
    let times = [0.05, 0.1, 0.2, 0.3, 0.6, 1.0].map(seconds);
    assert!(times.windows(2).all(|pair| pair[1] < pair[0]), "{times:?}");
}

#[test]
fn square_corners_are_cut_by_at_most_fifteen_centimetres() {
    let path = line(&[(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0), (0.0, 6.0)]);
    let mut drive = Drive::new(&path, 0.3);
    drive.run(90.0).assert_came_to_rest_at(path[4]);
    let (_, greatest) = drive.cross_track(&path, 0);
    assert!(greatest <= 0.15, "{greatest}");
}

#[test]
fn a_bend_beyond_the_sight_of_close_waypoints_is_braked_for_in_time() {
    let path = line(&[(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)]);
    let mut drive = Drive::new(&path, 0.1);
    drive.run(90.0).assert_came_to_rest_at(path[2]);
    let (_, greatest) = drive.cross_track(&path, 0);
    assert!(greatest <= 0.06, "{greatest}");
    let farther = |record: &&TrackingRecord| record.caps.contains(&Cap::BendAhead);
    assert!(drive.records.iter().filter(farther).all(|record| record.alpha1.max(record.alpha2) < 0.1));
}

#[test]
fn the_pointer_is_moved_where_the_robot_will_be() {
    let mut tracker = tracker();
    tracker.follow(waypoints(&line(&[(0.0, 0.0), (3.0, 0.0)]), 0.3));
    let moving = Twist2::new(0.5, 0.0);
    tracker.step(Pose2::new(0.05, 0.0, 0.0), moving, DT_S);
    // At 0.10 m now, beyond the half-way mark of 0.15 m when the command takes hold.
    let record = tracker.step(Pose2::new(0.10, 0.0, 0.0), moving, DT_S);
    assert!(record.world_from_robot_ahead.x > 0.15 && record.waypoint_index == 1, "{record:?}");
}

#[test]
fn a_goal_behind_is_reached_by_turning_not_reversing() {
    let path = line(&[(0.0, 0.0), (-1.0, 0.0)]);
    let mut drive = Drive::new(&path, 0.3);
    drive.run(30.0).assert_came_to_rest_at(path[1]);
}

#[test]
fn start_at_the_goal_is_arrival_at_once() {
    let mut drive = Drive::new(&line(&[(0.0, 0.0), (0.0, 0.0)]), 0.3);
    drive.step();
    assert!(drive.records[0].arrived && drive.records[0].twist == Twist2::ZERO);
}

#[test]
fn a_single_waypoint_is_driven_to() {
    let mut drive = Drive::new(&line(&[(1.0, 1.0)]), 0.3);
    drive.run(30.0).assert_came_to_rest_at(Point2::new(1.0, 1.0));
}

#[test]
fn a_sideways_shove_of_a_metre_is_recovered_from() {
    let path = line(&[(0.0, 0.0), (10.0, 0.0)]);
    let mut drive = Drive::new(&path, 0.3);
    for _ in 0..80 {
        drive.step();
    }
    drive.pose.y += 1.0;
    drive.run(90.0).assert_came_to_rest_at(path[1]);
    let overshoot = drive.poses.iter().map(|pose| -pose.y).fold(0.0, f64::max);
    assert!(overshoot <= 0.10, "{overshoot}");
}

#[test]
fn commands_do_not_jump_when_the_path_is_exchanged() {
    let mut drive = Drive::new(&line(&[(0.0, 0.0), (10.0, 0.0)]), 0.3);
    for _ in 0..60 {
        drive.step();
    }
    let here = drive.pose.position();
    let new = [here, Point2::new(here.x + 3.0, here.y + 2.0)];
    drive.tracker.follow(waypoints(&new, 0.25));
    drive.run(60.0).assert_came_to_rest_at(new[1]); // Drive::step asserts the acceleration limits
    assert!(drive.records.len() > 70);
}

#[test]
fn a_mirrored_path_is_driven_as_a_mirror_image() {
    let path = sine();
    let mirrored: Vec<Point2> = path.iter().map(|p| Point2::new(p.x, -p.y)).collect();
    let (mut one, mut other) = (Drive::new(&path, 0.3), Drive::new(&mirrored, 0.3));
    one.run(60.0);
    other.run(60.0);
    assert_eq!(one.poses.len(), other.poses.len());
    for (a, b) in one.poses.iter().zip(&other.poses) {
        assert!((a.x - b.x).abs() < 1e-6 && (a.y + b.y).abs() < 1e-6);
    }
}

#[test]
fn the_same_drive_twice_is_the_same_to_the_bit() {
    let run = || {
        let mut drive = Drive::new(&sine(), 0.3);
        drive.run(30.0);
        drive.records
    };
    assert_eq!(run(), run());
}

#[test]
fn a_measurement_that_is_no_number_stops_and_is_refused_by_name() {
    let mut tracker = tracker();
    tracker.follow(waypoints(&line(&[(0.0, 0.0), (1.0, 0.0)]), 0.3));
    let bad = Pose2 { x: f64::NAN, y: 0.0, heading: 0.0 };
    let record = tracker.step(bad, Twist2::ZERO, DT_S);
    assert_eq!((record.twist, record.caps), (Twist2::ZERO, vec![Cap::MeasurementNotFinite]));
    let refused = tracker.try_step(bad, Twist2::ZERO, DT_S).expect_err("NaN");
    assert!(refused.to_string().contains("x of the pose"), "{refused}");
    assert!(tracker.try_step(Pose2::IDENTITY, Twist2::ZERO, 0.0).is_err());
}

#[test]
fn without_a_path_the_robot_brakes_to_a_stop() {
    let mut tracker = tracker();
    let record = tracker.step(Pose2::IDENTITY, Twist2::new(0.5, 1.0), DT_S);
    assert!(record.caps.contains(&Cap::NoPath));
    assert!((record.twist.linear_mps - 0.47).abs() < 1e-9 && record.twist.angular_radps < 1.0);
}

#[test]
fn look_ahead_curvature_is_table_1_at_full_membership() {
    let look_ahead = tracker().look_ahead().clone();
    let config = controller().look_ahead;
    let (straight, very_high) = (0.0, FRAC_PI_2);
    let high = config.inputs["alpha1"].sets["High1"].breakpoints()[1];
    let [none, moderate, c_high, c_very_high] =
        ["NoCurvature", "cModerate", "cHigh", "cVeryHigh"].map(|name| config.outputs["C"][name]);
    assert_eq!((none, c_very_high), (0.0, 5.0));
    for (alpha2, row) in [
        (straight, [none, c_high, c_very_high]),
        (high, [moderate, c_high, c_very_high]),
        (very_high, [c_high, c_high, c_very_high]),
    ] {
        for (alpha1, expected) in [straight, high, very_high].into_iter().zip(row) {
            let (c, evaluation) = look_ahead.curvature(alpha1, alpha2).expect("finite");
            assert_eq!(c, expected, "alpha1 {alpha1} alpha2 {alpha2}");
            assert_eq!(evaluation.rules.len(), 1);
        }
    }
    assert_eq!(look_ahead.curvature(PI, PI).expect("finite").0, 5.0);
}
