//! Where the robot will be when a command takes hold: what was sent before is still on its way.

use std::collections::VecDeque;

use crate::geometry::{Pose2, Twist2};
use crate::robot::Limits;

/// Longest piece of time over which a ramp is taken as one arc \[s\].
const STEP_S: f64 = 0.01;
/// Ages are sums of ticks; what is due to within this is due \[s\].
const DUE_S: f64 = 1e-7;

/// Commands that the robot has not yet carried out, each with the time since it was sent.
///
/// A robot with latency T is, at any moment, still on its way to the command sent T ago. A controller
/// that decides on the pose measured now turns late: with T = 0.1 s and 0.5 m/s, 5 cm late at every
/// corner. So the pose is first moved along what is already decided: the commands in flight, each
/// when its time comes, at the accelerations that the robot's ramp allows.
#[derive(Clone, Debug, Default)]
pub struct InFlight {
    sent: VecDeque<(f64, Twist2)>,
}

impl InFlight {
    /// A command goes out now.
    pub fn send(&mut self, twist: Twist2) {
        self.sent.push_back((0.0, twist));
    }

    /// The command sent last was replaced by another on its way to the robot.
    pub fn replace_last(&mut self, twist: Twist2) {
        if let Some(last) = self.sent.back_mut() {
            last.1 = twist;
        }
    }

    /// `dt_s` passes; of what has taken hold only the newest still matters.
    pub fn pass(&mut self, dt_s: f64, latency_s: f64) {
        for (age_s, _) in &mut self.sent {
            *age_s += dt_s;
        }
        while self.sent.len() > 1 && self.sent[1].0 >= latency_s - DUE_S {
            self.sent.pop_front();
        }
    }

    /// Nothing is known of what was sent.
    pub fn forget(&mut self) {
        self.sent.clear();
    }

    /// Pose and twist after `latency_s + beyond_s`, for a robot now at `world_from_robot` moving with
    /// `current`; beyond the latency it goes on towards the command sent last. Exact arcs of
    /// `[Maalouf06 (1)]` on the ramp's speeds.
    pub fn predicted(
        &self,
        limits: &Limits,
        latency_s: f64,
        beyond_s: f64,
        world_from_robot: Pose2,
        current: Twist2,
    ) -> (Pose2, Twist2) {
        let horizon_s = latency_s + beyond_s;
        let (mut pose, mut twist) = (world_from_robot, current);
        let mut wanted = current;
        let mut now_s = 0.0;
        let mut drive = |until_s: f64, wanted: Twist2| {
            let span_s = until_s.min(horizon_s) - now_s;
            if span_s <= DUE_S {
                return;
            }
            let steps = (span_s / STEP_S - 1e-6).ceil().max(1.0);
            for _ in 0..steps as usize {
                twist = limits.reachable(twist, wanted, span_s / steps);
                pose = pose.moved(twist, span_s / steps);
            }
            now_s += span_s;
        };
        for &(age_s, command) in &self.sent {
            drive(latency_s - age_s, wanted);
            wanted = command;
        }
        drive(horizon_s, wanted);
        (pose, twist)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits =
        Limits { linear_mps: 0.7, angular_radps: 2.4, linear_mps2: 0.3, angular_radps2: 1.7 };

    fn robot_after(in_flight: &[Twist2], latency_s: f64, start: Twist2) -> Pose2 {
        // An independent robot: a queue of due times, steps of a millisecond.
        let (mut pose, mut twist, mut wanted) = (Pose2::IDENTITY, start, start);
        for k in 0..(latency_s * 1000.0).round() as usize {
            let now_s = k as f64 * 1e-3;
            for (i, &command) in in_flight.iter().enumerate() {
                let due_s = latency_s - 0.1 * (in_flight.len() - i) as f64;
                if due_s <= now_s + 1e-9 {
                    wanted = command;
                }
            }
            twist = LIMITS.reachable(twist, wanted, 1e-3);
            pose = pose.moved(twist, 1e-3);
        }
        pose
    }

    #[test]
    fn a_robot_is_where_the_commands_in_flight_will_have_taken_it() {
        let commands = [(0.43, 0.1), (0.46, 0.27), (0.49, 0.44)].map(|(v, w)| Twist2::new(v, w));
        let start = Twist2::new(0.4, 0.0);
        for (count, latency_s) in [(1, 0.1), (2, 0.2), (3, 0.25), (3, 0.3)] {
            let mut in_flight = InFlight::default();
            for &command in &commands[..count] {
                in_flight.send(command);
                in_flight.pass(0.1, latency_s);
            }
            let (found, _) = in_flight.predicted(&LIMITS, latency_s, 0.0, Pose2::IDENTITY, start);
            let expected = robot_after(&commands[..count], latency_s, start);
            assert!(found.position().distance(expected.position()) < 1e-3, "{found:?} {expected:?}");
            assert!((found.heading - expected.heading).abs() < 2e-3, "{found:?} {expected:?}");
        }
    }

    #[test]
    fn without_latency_the_robot_is_where_it_is() {
        let mut in_flight = InFlight::default();
        in_flight.send(Twist2::new(0.5, 1.0));
        in_flight.pass(0.1, 0.0);
        let here = Pose2::new(1.0, 2.0, 3.0);
        assert_eq!(in_flight.predicted(&LIMITS, 0.0, 0.0, here, Twist2::ZERO).0, here);
    }
}
