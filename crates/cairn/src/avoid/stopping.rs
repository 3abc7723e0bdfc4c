use super::contact::GrownBox;
use crate::geometry::{Point2, Pose2, Twist2};
use crate::robot::Limits;

/// Bound on how far any point of the outline moves between two poses that are looked at \[m\].
const STRIDE_M: f64 = 0.02;

/// The exact braking motion of a command: what the robot does if this is its last one.
///
/// For the latency it changes from its `current` twist towards the `pending` command; then both
/// speeds change towards `command` at the limits until the tick is over; then both fall to zero together, along one curvature.
#[derive(Clone, Copy, Debug)]
pub(super) struct BrakingMotion<'a> {
    pub limits: &'a Limits,
    pub current: Twist2,
    pub pending: Twist2,
    pub command: Twist2,
    pub latency_s: f64,
    pub dt_s: f64,
}

impl BrakingMotion<'_> {
    /// An outline grown to this less than an obstacle's distance is clear of it for as long as it comes no nearer \[m\].
    pub const SLACK_M: f64 = STRIDE_M / 2.0 + 1e-6;

    /// Whether the outline stays off every obstacle from now until rest.
    ///
    /// Poses are looked at so densely that no point of the outline moves more than [`STRIDE_M`]
    /// from one to the next, with the outline grown by half of it: nothing between is missed.
    pub fn is_clear(&self, outline: &GrownBox, nearest_first: &[(f64, Point2)]) -> bool {
        let grown = outline.grown(STRIDE_M / 2.0);
        let radius_m = grown.radius_m();
        self.all(outline.radius_m(), |robot_from_start, travelled_m| {
            let robot_from_start = robot_from_start.turned();
            nearest_first
                .iter()
                .take_while(|(distance_m, _)| *distance_m <= radius_m + travelled_m)
                .all(|&(_, point)| !grown.contains(robot_from_start * point))
        })
    }

    /// Whether `holds` of every pose looked at, told as `robot_from_start` and the way so far \[m\].
    pub fn all(&self, body_m: f64, holds: impl Fn(Pose2, f64) -> bool) -> bool {
        let (mut pose, mut twist, mut travelled_m) = (Pose2::IDENTITY, self.current, 0.0);
        let mut stretch = |pose: &mut Pose2, twist: &mut Twist2, wanted: Twist2, seconds: f64, keep: bool| {
            let mut left_s = seconds;
            while left_s > 1e-9 {
                let speed = twist.linear_mps.abs().max(wanted.linear_mps.abs())
                    + body_m * twist.angular_radps.abs().max(wanted.angular_radps.abs());
                let dt = left_s.min(0.05).min(STRIDE_M / speed.max(1e-9));
                let (next, mean) =
                    if keep { (*twist, *twist) } else { self.limits.ramped(*twist, wanted, dt) };
                *pose = pose.moved(mean, dt);
                travelled_m += mean.linear_mps.abs() * dt;
                *twist = next;
                left_s -= dt;
                if !holds(pose.inverse(), travelled_m) {
                    return false;
                }
            }
            true
        };
        if !stretch(&mut pose, &mut twist, self.pending, self.latency_s, false)
            || !stretch(&mut pose, &mut twist, self.command, self.dt_s, false)
        {
            return false;
        }
        // Both fall to zero in the time that the slower one needs.
        let from = twist;
        let seconds = (from.linear_mps.abs() / self.limits.linear_mps2)
            .max(from.angular_radps.abs() / self.limits.angular_radps2);
        let steps = 12;
        for i in 0..steps {
            let (a, b) = (1.0 - f64::from(i) / f64::from(steps), 1.0 - f64::from(i + 1) / f64::from(steps));
            let mut mean = Twist2::new(from.linear_mps * (a + b) / 2.0, from.angular_radps * (a + b) / 2.0);
            let wanted = mean;
            if !stretch(&mut pose, &mut mean, wanted, seconds / f64::from(steps), true) {
                return false;
            }
        }
        true
    }
}
