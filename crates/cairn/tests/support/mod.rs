//! What tests of the avoider and of the lidar share: dice, and a braking motion marched by itself.

use cairn::geometry::{Point2, Pose2, Twist2};
use cairn::robot::{Footprint, Limits};

/// A small generator of its own, so that scenes are the same everywhere.
pub struct Dice(pub u64);

impl Dice {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }
}

/// One choice as the robot will drive it if it is the last one.
#[derive(Clone, Copy, Debug)]
pub struct Chosen {
    pub now: Twist2,
    /// The command before this one, in effect until `latency_s` has passed.
    pub pending: Twist2,
    pub command: Twist2,
    pub latency_s: f64,
    pub tick_s: f64,
}

const STEP_S: f64 = 2e-3;
/// Gaps are looked at this often \[steps\].
const EVERY: usize = 2;

impl Chosen {
    /// Least distance of the outline to any of `seen` (robot frame) from now until rest \[m\].
    ///
    /// Marched in steps of 2 ms: towards the pending command for the latency, towards this one for a
    /// tick, then both speeds fall together.
    pub fn least_gap_m(&self, limits: &Limits, footprint: &Footprint, seen: &[Point2]) -> f64 {
        let body_m = footprint.circumscribed_radius_m();
        let fastest = [self.now, self.pending, self.command]
            .map(|t| t.linear_mps.abs())
            .into_iter()
            .fold(0.0, f64::max);
        let run_m = fastest * (self.latency_s + self.tick_s) + fastest * fastest / (2.0 * limits.linear_mps2);
        let near: Vec<Point2> = seen.iter().copied().filter(|p| p.norm() < body_m + run_m + 0.05).collect();
        let mut least_m = f64::INFINITY;
        let mut look = |pose: Pose2| {
            let robot_from_start = pose.inverse();
            for &p in &near {
                least_m = least_m.min(footprint.distance(robot_from_start * p));
            }
        };
        let (mut pose, mut twist) = (Pose2::IDENTITY, self.now);
        for (wanted, for_s) in [(self.pending, self.latency_s), (self.command, self.tick_s)] {
            for step in 0..(for_s / STEP_S).round() as usize {
                twist = limits.reachable(twist, wanted, STEP_S);
                pose = pose.moved(twist, STEP_S);
                if step % EVERY == 0 {
                    look(pose);
                }
            }
        }
        let from = twist;
        let stop_s = (from.linear_mps.abs() / limits.linear_mps2)
            .max(from.angular_radps.abs() / limits.angular_radps2);
        let steps = (stop_s / STEP_S).ceil() as usize;
        for step in 0..steps {
            let share = 1.0 - (step as f64 + 0.5) / steps as f64;
            let mean = Twist2::new(from.linear_mps * share, from.angular_radps * share);
            pose = pose.moved(mean, stop_s / steps as f64);
            if step % EVERY == 0 {
                look(pose);
            }
        }
        look(pose);
        least_m
    }
}
