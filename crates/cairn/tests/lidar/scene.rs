//! A world of discs and a robot with a lidar in it, its braking checked at every tick.

use super::support::Chosen;
use cairn::avoid::{AvoidanceRecord, Why};
use cairn::geometry::{Point2, Pose2, Twist2};
use cairn::navigate::{LidarConfig, LidarSense};
use cairn::robot::{Drive, Footprint, Lidar, Limits, RobotProfile};

pub const TICK_S: f64 = 0.05;
const STEP_S: f64 = 0.005;

/// A disc that moves straight on.
#[derive(Clone, Copy)]
pub struct Disc {
    pub center: Point2,
    pub radius_m: f64,
    pub velocity_mps: Point2,
}

pub fn post(x: f64, y: f64) -> Disc {
    Disc { center: Point2::new(x, y), radius_m: 0.075, velocity_mps: Point2::default() }
}

/// Posts from `a` to `b`, so close together that nothing passes between.
pub fn wall(a: (f64, f64), b: (f64, f64)) -> Vec<Disc> {
    let (a, b) = (Point2::new(a.0, a.1), Point2::new(b.0, b.1));
    let count = (a.distance(b) / 0.15).ceil().max(1.0) as usize;
    (0..=count).map(|i| a + (b - a) * (i as f64 / count as f64)).map(|p| post(p.x, p.y)).collect()
}

/// A small skid-steer robot with a lidar of 270 degrees.
pub fn profile() -> RobotProfile {
    RobotProfile {
        name: "rover".to_owned(),
        footprint: Footprint { length_m: 0.458, width_m: 0.416 },
        limits: Limits { linear_mps: 2.0, angular_radps: 4.0, linear_mps2: 5.0, angular_radps2: 20.0 },
        drive: Drive { effective_track_m: 0.563, latency_s: 0.08 },
        sonars: Vec::new(),
        lidar: Some(Lidar {
            pose: Pose2::new(0.055, 0.0, 0.0),
            beams: 361,
            first_rad: -135f64.to_radians(),
            step_rad: 0.75f64.to_radians(),
            min_range_m: 0.05,
            max_range_m: 30.0,
        }),
    }
}

/// Ranges of the profile's lidar among discs, exact.
pub fn scan(profile: &RobotProfile, world_from_robot: Pose2, discs: &[Disc]) -> Vec<f64> {
    let lidar = profile.lidar.unwrap();
    let at = world_from_robot * lidar.pose;
    (0..lidar.beams)
        .map(|beam| {
            let angle = at.heading + lidar.first_rad + beam as f64 * lidar.step_rad;
            let (sin, cos) = angle.sin_cos();
            let mut range_m = f64::INFINITY;
            for disc in discs {
                let away = disc.center - at.position();
                let (along, beside) = (cos * away.x + sin * away.y, -sin * away.x + cos * away.y);
                let half2 = disc.radius_m * disc.radius_m - beside * beside;
                if half2 >= 0.0 && along > 0.0 {
                    range_m = range_m.min(along - half2.sqrt());
                }
            }
            range_m
        })
        .collect()
}

pub struct Run {
    pub arrived: bool,
    pub seconds: f64,
    pub clearance_m: f64,
    /// Between where the robot is and where it believes to be, at most \[m\].
    pub drift_m: f64,
    pub turn_gain: f64,
    pub path: Vec<Point2>,
    pub records: Vec<AvoidanceRecord>,
}

impl Run {
    pub fn count(&self, what: impl Fn(&Why) -> bool) -> usize {
        self.records.iter().filter(|record| what(&record.why)).count()
    }
}

/// Drives to `goal` through `discs` from the origin; wheels tell a turn too small by `turn_gain`.
///
/// At every tick the braking motion of what is commanded is marched finely against every point that
/// the robot has seen: it must not touch.
pub fn drive(discs: &[Disc], goal: Point2, turn_gain: f64, seconds: f64) -> Run {
    let profile = profile();
    let mut sense = LidarSense::new(&LidarConfig::default(), &profile, Pose2::IDENTITY).unwrap().unwrap();
    let (mut pose, mut twist, mut command) = (Pose2::IDENTITY, Twist2::ZERO, Twist2::ZERO);
    let mut queue: Vec<(f64, Twist2)> = Vec::new();
    let mut wanted = Twist2::ZERO;
    let mut told = Pose2::IDENTITY;
    let mut run = Run {
        arrived: false,
        seconds,
        clearance_m: f64::INFINITY,
        drift_m: 0.0,
        turn_gain: 1.0,
        path: Vec::new(),
        records: Vec::new(),
    };
    let place = |time_s: f64| -> Vec<Disc> {
        discs.iter().map(|d| Disc { center: d.center + d.velocity_mps * time_s, ..*d }).collect()
    };
    for tick in 0..(seconds / TICK_S) as usize {
        let time_s = tick as f64 * TICK_S;
        let ranges = scan(&profile, pose, &place(time_s));
        let believed = sense.observe(told, &ranges, None, TICK_S);
        run.drift_m = run.drift_m.max(believed.position().distance(pose.position()));
        let measured = Twist2::new(twist.linear_mps, twist.angular_radps / turn_gain);
        let record = sense.drive(goal, measured, command, 1.0, TICK_S);
        if !matches!(record.why, Why::Braking { .. }) {
            let gain = sense.turn_gain();
            let real = |t: Twist2| Twist2::new(t.linear_mps, t.angular_radps * gain);
            let robot_from_frame = believed.inverse();
            let seen: Vec<Point2> = sense.map().points().map(|p| robot_from_frame * p).collect();
            let [now, pending, chosen] = [measured, command, record.twist].map(real);
            let latency_s = profile.drive.latency_s;
            let chosen = Chosen { now, pending, command: chosen, latency_s, tick_s: TICK_S };
            let gap_m = chosen.least_gap_m(&profile.limits, &profile.footprint, &seen);
            assert!(gap_m > 0.0, "at {time_s:.2} s: {:?}", record.why);
        }
        command = record.twist;
        queue.push((time_s + profile.drive.latency_s, command));
        run.records.push(record);
        run.path.push(pose.position());
        let before = pose;
        let mut turned = 0.0;
        for step in 0..(TICK_S / STEP_S).round() as usize {
            let now_s = time_s + step as f64 * STEP_S;
            while queue.first().is_some_and(|(due_s, _)| *due_s <= now_s + 1e-9) {
                wanted = queue.remove(0).1;
            }
            let real = Twist2::new(wanted.linear_mps, wanted.angular_radps * turn_gain);
            twist = profile.limits.reachable(twist, real, STEP_S);
            pose = pose.moved(twist, STEP_S);
            turned += twist.angular_radps * STEP_S / turn_gain;
            let robot_from_world = pose.inverse();
            for disc in place(now_s + STEP_S) {
                let gap_m = profile.footprint.distance(robot_from_world * disc.center) - disc.radius_m;
                run.clearance_m = run.clearance_m.min(gap_m);
            }
        }
        let moved = before.inverse() * pose;
        told = Pose2::new(moved.x, moved.y, turned);
        if pose.position().distance(goal) < 0.3 {
            run.arrived = true;
            run.seconds = time_s;
            break;
        }
    }
    run.turn_gain = sense.turn_gain();
    run
}
