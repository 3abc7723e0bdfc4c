use super::common::Chosen;
use crate::avoid::{AvoidanceRecord, BrakeReason, Cvm, CvmConfig, Why};
use crate::geometry::{Point2, Pose2, Twist2};
use crate::robot::{Footprint, Limits};

pub use super::common::Dice;

pub const P3AT: Footprint = Footprint { length_m: 0.626, width_m: 0.505 };
pub const LIMITS: Limits =
    Limits { linear_mps: 0.7, angular_radps: 2.443461, linear_mps2: 0.3, angular_radps2: 1.745329 };
pub const TICK_S: f64 = 0.1;

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

/// What a chooser is asked every tick, in the robot frame.
pub struct Asked<'a> {
    pub twist: Twist2,
    pub pending: Twist2,
    pub pose: Pose2,
    pub seen: &'a [Point2],
}

/// What a closed loop came to.
pub struct Run {
    pub arrived: bool,
    pub pose: Pose2,
    pub clearance_m: f64,
    pub records: Vec<AvoidanceRecord>,
}

impl Run {
    pub fn count(&self, what: impl Fn(&Why) -> bool) -> usize {
        self.records.iter().filter(|record| what(&record.why)).count()
    }
}

/// A unicycle with limits among points, at 10 Hz, each command taking effect after the configured
/// latency of at most a tick; [`drive`] by the paper's objective.
///
/// At every tick the braking motion of what is commanded is marched in milliseconds, by code of its
/// own, beside every point: no command, whatever it is for, may lead to a touch.
pub fn drive_by(
    config: &CvmConfig,
    start: Pose2,
    goal: Point2,
    obstacles: &[Point2],
    seconds: f64,
    choose: impl Fn(&Cvm, &Asked) -> AvoidanceRecord,
    mut look: impl FnMut(&AvoidanceRecord, Pose2, Twist2),
) -> Run {
    const STEP_S: f64 = 0.01;
    let cvm = Cvm::new(config, &LIMITS, &P3AT).unwrap();
    let (mut pose, mut twist, mut pending) = (start, Twist2::ZERO, Twist2::ZERO);
    let mut run = Run { arrived: false, pose, clearance_m: f64::INFINITY, records: Vec::new() };
    for _ in 0..(seconds / TICK_S) as usize {
        let robot_from_world = pose.inverse();
        let seen: Vec<Point2> =
            obstacles.iter().map(|&p| robot_from_world * p).filter(|p| p.norm() < 4.0).collect();
        let record = choose(&cvm, &Asked { twist, pending, pose, seen: &seen });
        let latency_s = config.latency_s;
        let chosen = Chosen { now: twist, pending, command: record.twist, latency_s, tick_s: TICK_S };
        let gap_m = chosen.least_gap_m(&LIMITS, &P3AT, &seen);
        assert!(gap_m > 0.0, "{:?} at {pose:?}: {chosen:?}", record.why);
        assert_ne!(record.why, Why::Braking { reason: BrakeReason::TooFast });
        look(&record, pose, twist);
        let steps = (TICK_S / STEP_S).round() as usize;
        for step in 0..steps {
            let wanted = if (step as f64) < latency_s / STEP_S - 1e-9 { pending } else { record.twist };
            let next = LIMITS.reachable(twist, wanted, STEP_S);
            let mean = Twist2::new(
                (twist.linear_mps + next.linear_mps) / 2.0,
                (twist.angular_radps + next.angular_radps) / 2.0,
            );
            pose = pose.moved(mean, STEP_S);
            twist = next;
            let robot_from_world = pose.inverse();
            for &p in obstacles {
                run.clearance_m = run.clearance_m.min(P3AT.distance(robot_from_world * p));
            }
        }
        pending = record.twist;
        run.records.push(record);
        run.pose = pose;
        if pose.position().distance(goal) < 0.15 {
            run.arrived = true;
            break;
        }
    }
    run
}

/// As [`drive_by`], by the paper's objective.
pub fn drive(config: &CvmConfig, start: Pose2, goal: Point2, obstacles: &[Point2], seconds: f64) -> Run {
    drive_by(config, start, goal, obstacles, seconds, towards(goal), |_, _, _| {})
}

/// Chooses by the paper's objective towards `goal`.
pub fn towards(goal: Point2) -> impl Fn(&Cvm, &Asked) -> AvoidanceRecord {
    move |cvm, &Asked { twist, pending, pose, seen }| {
        let to_goal_m = pose.position().distance(goal);
        cvm.choose_after(twist, Some(pending), pose.bearing_to(goal), to_goal_m, seen, TICK_S)
    }
}
