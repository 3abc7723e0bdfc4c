use super::config::CvmConfig;
use super::contact::GrownBox;
use super::objective::Window;
use crate::geometry::{Point2, Twist2, wrap_angle};

/// How much clearance the far end of the body may lose while the near end gains it \[m\].
const SWING_M: f64 = 0.01;
/// Clearance that must be gained for a motion to count as leaving \[m\].
const GAIN_M: f64 = 0.005;
/// How far a leaving motion is looked at \[m\] or, turning, in tenths of that \[rad\].
const REACH: f64 = 0.8;
const SAMPLES: usize = 32;
/// Way that must stay clear beyond the grown outline for a motion to leave it wholly \[m\].
const ONWARD: f64 = 0.3;

/// The motion that gains clearance soonest; `None` if none does.
///
/// `body` is the outline without growth, `clearance_m` its distance to the nearest obstacle point,
/// which is less than the wanted `growth_m`. A motion counts if on its way the clearance never
/// falls more than [`SWING_M`] below what it is now, nor below the obstacle's own radius (if it is
/// below that already: never at all), and it ends with more clearance than now. Forward arcs,
/// turning in place and, if configured, backward arcs. With `wholly`, only motions count that leave
/// the grown outline for good; `keeps` tells whether the braking motion of a command is safe.
#[allow(clippy::too_many_arguments)]
pub(super) fn leave(
    config: &CvmConfig,
    window: &Window,
    body: &GrownBox,
    clearance_m: f64,
    goal_bearing_rad: f64,
    nearest_first: &[(f64, Point2)],
    wholly: bool,
    keeps: impl Fn(Twist2) -> bool,
) -> Option<Twist2> {
    let least_m = if clearance_m > config.obstacle_radius_m {
        (clearance_m - SWING_M).max(config.obstacle_radius_m)
    } else {
        clearance_m - 1e-9
    };
    let target_m =
        if wholly { config.growth_m() + GAIN_M } else { config.growth_m().min(clearance_m + GAIN_M) };
    let onward = if wholly { (ONWARD / REACH * SAMPLES as f64) as usize } else { 0 };
    let near: Vec<Point2> = nearest_first
        .iter()
        .take_while(|(d, _)| *d <= body.radius_m() + config.growth_m() + REACH)
        .map(|&(_, p)| p)
        .collect();
    // Share of the reach after which the target clearance is won.
    let gained_after = |unit: Twist2| -> Option<f64> {
        let mut gained: Option<usize> = None;
        for i in 1..=SAMPLES + onward {
            let share = i as f64 / SAMPLES as f64;
            let robot_from_start = unit.displacement(share * REACH).inverse().turned();
            let clearance =
                near.iter().map(|&p| body.distance(robot_from_start * p)).fold(f64::INFINITY, f64::min);
            let least_m = if gained.is_some() { target_m - GAIN_M } else { least_m };
            if clearance < least_m {
                return None;
            }
            if clearance >= target_m {
                gained = gained.or(Some(i));
            }
            match gained {
                Some(first) if i >= first + onward => return Some(first as f64 / SAMPLES as f64),
                None if i >= SAMPLES => return None,
                _ => {}
            }
        }
        None
    };
    let mut best: Vec<(f64, Twist2)> = Vec::new();
    let mut offer = |unit: Twist2, twist: Twist2, penalty: f64| {
        let reachable = (window.angular_lo_radps..=window.angular_hi_radps).contains(&twist.angular_radps);
        if !reachable {
            return;
        }
        if let Some(share) = gained_after(unit) {
            let error = wrap_angle(goal_bearing_rad - twist.angular_radps * config.heading_time_s).abs();
            let cost = share + 0.3 * error / std::f64::consts::PI + penalty;
            best.push((cost, twist));
        }
    };
    let speed = config.leaving_speed_mps.clamp(window.linear_lo_mps, window.linear_hi_mps);
    const ARCS: i32 = 12;
    for i in -ARCS..=ARCS {
        let curvature = config.max_curvature_per_m * (f64::from(i) / f64::from(ARCS)).powi(3);
        let unit = Twist2::new(1.0, curvature);
        if speed > 0.0 {
            offer(unit, unit_times(unit, speed), 0.0);
        }
        if config.reverse_to_leave && !wholly && window.linear_lo_mps == 0.0 {
            let back = Twist2::new(-1.0, curvature);
            offer(back, unit_times(back, config.leaving_speed_mps / 2.0), 0.5);
        }
    }
    if window.linear_lo_mps == 0.0 && !wholly {
        let rate = config.turn_rate_radps / 2.0;
        offer(Twist2::new(0.0, 1.0), Twist2::new(0.0, rate.min(window.angular_hi_radps)), 0.1);
        offer(Twist2::new(0.0, -1.0), Twist2::new(0.0, (-rate).max(window.angular_lo_radps)), 0.1);
    }
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    best.into_iter().map(|(_, twist)| twist).find(|&twist| keeps(twist))
}

fn unit_times(unit: Twist2, factor: f64) -> Twist2 {
    Twist2::new(unit.linear_mps * factor, unit.angular_radps * factor)
}
