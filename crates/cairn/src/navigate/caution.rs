//! No faster than the robot can stop inside what it has seen.

use serde::{Deserialize, Serialize};

use super::act::braking;
use crate::geometry::{Point2, Pose2, Twist2};
use crate::robot::{Footprint, Limits};

/// How careful to be where nothing has been seen yet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CautionConfig {
    /// Speed always allowed, so that the robot gets to see more \[m/s\].
    pub creep_mps: f64,
}

impl Default for CautionConfig {
    fn default() -> Self {
        Self { creep_mps: 0.2 }
    }
}

/// The arc is looked at this often \[m\].
const STEP_M: f64 = 0.05;

/// A command held back because the robot does not see far enough.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Caution {
    /// Length of the arc ahead over which the front of the robot sweeps only what was seen \[m\].
    pub sight_m: f64,
    /// Speed that can be stopped within it \[m/s\].
    pub speed_mps: f64,
}

/// `wanted` at `cap_mps`, along its own curvature, or at what the robot can brake to in a tick: speeds that were
/// asked to fall faster would leave the arc, because each has a ramp of its own.
pub(super) fn slowed_to(
    limits: &Limits,
    commanded: Twist2,
    wanted: Twist2,
    cap_mps: f64,
    dt_s: f64,
) -> Twist2 {
    let way = wanted.linear_mps.signum();
    let reached_mps = braking(limits, commanded, dt_s).linear_mps * way;
    let share = (cap_mps.max(reached_mps) / wanted.linear_mps.abs()).min(1.0);
    Twist2::new(wanted.linear_mps * share, wanted.angular_radps * share)
}

/// `wanted`, slowed along its own curvature to what can be stopped within sight.
#[allow(clippy::too_many_arguments)]
pub(super) fn cautious(
    config: &CautionConfig,
    limits: &Limits,
    footprint: &Footprint,
    latency_s: f64,
    is_seen: impl Fn(Point2) -> bool,
    world_from_robot: Pose2,
    commanded: Twist2,
    wanted: Twist2,
    dt_s: f64,
) -> (Twist2, Option<Caution>) {
    let delay_s = latency_s + dt_s;
    let speed_mps = wanted.linear_mps;
    if speed_mps <= config.creep_mps {
        return (wanted, None);
    }
    let stop_m = limits.braking_distance_m(speed_mps) + speed_mps * delay_s;
    let curvature = wanted.angular_radps / speed_mps;
    let sight_m = sight_m(footprint, is_seen, world_from_robot, curvature, stop_m);
    if sight_m >= stop_m {
        return (wanted, None);
    }
    let cap_mps = limits.stoppable_mps(sight_m, delay_s).max(config.creep_mps);
    if cap_mps >= speed_mps {
        return (wanted, None);
    }
    (slowed_to(limits, commanded, wanted, cap_mps, dt_s), Some(Caution { sight_m, speed_mps: cap_mps }))
}

/// How far the front of the robot moves along the arc before it enters an unknown cell \[m\].
fn sight_m(
    footprint: &Footprint,
    is_seen: impl Fn(Point2) -> bool,
    world_from_robot: Pose2,
    curvature: f64,
    most_m: f64,
) -> f64 {
    let (x, y) = (footprint.length_m / 2.0, footprint.width_m / 2.0);
    let front = [
        Point2::new(x, -y),
        Point2::new(x, -y / 2.0),
        Point2::new(x, 0.0),
        Point2::new(x, y / 2.0),
        Point2::new(x, y),
    ];
    let mut along_m = 0.0;
    while along_m < most_m {
        let next_m = along_m + STEP_M;
        let pose = world_from_robot.moved(Twist2::new(next_m, curvature * next_m), 1.0).turned();
        if front.iter().any(|&corner| !is_seen(pose * corner)) {
            return along_m;
        }
        along_m = next_m;
    }
    most_m
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits =
        Limits { linear_mps: 0.7, angular_radps: 2.4, linear_mps2: 0.3, angular_radps2: 1.7 };
    const BOX: Footprint = Footprint { length_m: 0.6, width_m: 0.5 };

    fn slowed(seen_up_to_m: f64, wanted: Twist2) -> (Twist2, Option<Caution>) {
        let is_seen = |p: Point2| p.x <= seen_up_to_m;
        let config = CautionConfig::default();
        cautious(&config, &LIMITS, &BOX, 0.1, is_seen, Pose2::IDENTITY, Twist2::ZERO, wanted, 0.1)
    }

    #[test]
    fn a_robot_in_a_bend_is_slowed_no_faster_than_it_can_brake_along_the_bend() {
        let bend = Twist2::new(0.5, 0.75);
        let mut commanded = bend;
        for _ in 0..30 {
            let next = slowed_to(&LIMITS, commanded, bend, 0.1, 0.1);
            let reached = LIMITS.reachable(commanded, next, 0.1);
            assert!((reached.linear_mps - next.linear_mps).abs() < 1e-12);
            assert!((reached.angular_radps - next.angular_radps).abs() < 1e-12);
            assert!((next.angular_radps / next.linear_mps - 1.5).abs() < 1e-9);
            commanded = next;
        }
        assert!((commanded.linear_mps - 0.1).abs() < 1e-9);
        let backwards = slowed_to(&LIMITS, Twist2::new(0.5, 0.0), Twist2::new(-0.4, 0.2), 0.1, 0.1);
        assert!((backwards.linear_mps + 0.1).abs() < 1e-12);
    }

    #[test]
    fn what_is_seen_far_enough_is_driven_at_full_speed() {
        let wanted = Twist2::new(0.7, 0.1);
        assert_eq!(slowed(4.0, wanted), (wanted, None));
    }

    #[test]
    fn the_robot_could_stop_before_the_unseen_and_keeps_its_curvature() {
        let (twist, caution) = slowed(0.8, Twist2::new(0.7, 0.0));
        let sight_m = caution.unwrap().sight_m;
        assert!((sight_m - 0.5).abs() <= 0.05, "{sight_m}");
        assert!(LIMITS.braking_distance_m(twist.linear_mps) + 0.2 * twist.linear_mps <= sight_m + 1e-9);
        let (turned, _) = slowed(0.8, Twist2::new(0.6, 0.3));
        assert!((turned.angular_radps / turned.linear_mps - 0.5).abs() < 1e-12);
    }

    #[test]
    fn before_the_unseen_the_robot_still_creeps() {
        let (twist, _) = slowed(0.3, Twist2::new(0.7, 0.0));
        assert_eq!(twist.linear_mps, CautionConfig::default().creep_mps);
    }
}
