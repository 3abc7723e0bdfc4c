use std::f64::consts::{PI, TAU};

use serde::Serialize;

use super::config::CvmConfig;
use super::record::ArcInterval;
use crate::geometry::{Twist2, wrap_angle};
use crate::robot::Limits;

/// Radius of a turn that the robot makes at an easy speed \[m\].
const TURNING_RADIUS_M: f64 = 0.5;

/// Speeds that limits and accelerations allow until the end of the tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Window {
    /// Least translational speed \[m/s\].
    pub linear_lo_mps: f64,
    /// Greatest translational speed \[m/s\].
    pub linear_hi_mps: f64,
    /// Least rotational speed \[rad/s\].
    pub angular_lo_radps: f64,
    /// Greatest rotational speed \[rad/s\].
    pub angular_hi_radps: f64,
}

impl Window {
    /// What can be reached from `current` within `dt_s`, never backwards.
    ///
    /// With a latency, `dt_s` is latency + tick: the measured twist is that much older than the
    /// end of the tick, and the command before this one is still changing it. (A window of one tick
    /// about a measured twist would halve every acceleration and make braking too late.)
    pub fn reachable(limits: &Limits, current: Twist2, dt_s: f64) -> Self {
        let (v, w) = (current.linear_mps, current.angular_radps);
        let (dv, dw) = (limits.linear_mps2 * dt_s, limits.angular_radps2 * dt_s);
        let (v_max, w_max) = (limits.linear_mps, limits.angular_radps);
        Self {
            linear_lo_mps: (v - dv).clamp(0.0, v_max),
            linear_hi_mps: (v + dv).clamp(0.0, v_max),
            angular_lo_radps: (w - dw).clamp(-w_max, w_max),
            angular_hi_radps: (w + dw).clamp(-w_max, w_max),
        }
    }
}

/// Equation (7) for one tick, with the speeds it is maximised over.
#[derive(Clone, Copy, Debug)]
pub struct Objective<'a> {
    /// Weights and constants.
    pub config: &'a CvmConfig,
    /// Limits of the robot.
    pub limits: &'a Limits,
    /// Reachable speeds.
    pub window: Window,
    /// θ_g \[rad\].
    pub goal_bearing_rad: f64,
    /// Distance to the goal \[m\].
    pub goal_distance_m: f64,
    /// Length of a tick \[s\].
    pub dt_s: f64,
}

impl Objective<'_> {
    /// The three terms of (7), each in \[0, 1\]: speed, distance, heading.
    ///
    /// The distance is judged up to L, and no farther than the goal: what lies behind it is no hindrance.
    pub fn terms(&self, twist: Twist2, distance_m: f64) -> [f64; 3] {
        let error = wrap_angle(self.goal_bearing_rad - twist.angular_radps * self.config.heading_time_s);
        let horizon_m = self.horizon_m();
        [
            twist.linear_mps / self.limits.linear_mps,
            distance_m.min(horizon_m) / horizon_m,
            1.0 - error.abs() / PI,
        ]
    }

    /// The weighted sum (7) of `terms`.
    pub fn total(&self, terms: [f64; 3]) -> f64 {
        self.config.speed_weight * terms[0]
            + self.config.distance_weight * terms[1]
            + self.config.heading_weight * terms[2]
    }

    /// How far arcs are judged: L, or the goal's distance plus the room kept ahead if that is nearer.
    fn horizon_m(&self) -> f64 {
        let beyond_goal_m = self.goal_distance_m + self.config.turn_below_m + self.config.turning_room_m;
        self.config.horizon_m.min(beyond_goal_m).max(1e-3)
    }

    /// Greatest speed from which the robot stops within the interval's free length and before the
    /// goal: v·(latency + tick) + v²/2a ≤ D \[m/s\]. Speeds fall together, so on tight arcs the
    /// rotational deceleration bounds the translational one: a = min(a_v, a_ω/|c|).
    pub fn speed_cap_mps(&self, interval: &ArcInterval) -> f64 {
        let tightest = interval.curvature_lo.abs().max(interval.curvature_hi.abs());
        let a = self.limits.linear_mps2.min(self.limits.angular_radps2 / tightest.max(1e-9));
        let room_m = (interval.distance_m - self.config.turning_room_m).min(self.goal_room_m());
        if room_m <= 0.0 {
            return 0.0;
        }
        let delay = a * (self.config.latency_s + self.dt_s);
        // The stable form of −delay + √(delay² + 2 a D).
        2.0 * a * room_m / (delay + (delay * delay + 2.0 * a * room_m).sqrt())
    }

    /// How far the robot may run before it must be able to stop for the goal: as far ahead as the
    /// goal is, or up to a turning circle's width from it. Beside a near goal it slows down and
    /// turns to it, instead of circling round it.
    fn goal_room_m(&self) -> f64 {
        let circle_m = 2.0 * TURNING_RADIUS_M;
        (self.goal_distance_m * self.goal_bearing_rad.cos()).max(self.goal_distance_m - circle_m).max(0.0)
    }

    /// Least forward speed that counts as driving \[m/s\].
    pub fn least_speed_mps(&self) -> f64 {
        self.window.linear_lo_mps.max(self.config.min_speed_mps.min(self.window.linear_hi_mps))
    }

    /// The motion of this interval with the greatest (7), exactly; `None` if none is reachable.
    ///
    /// Within an interval (7) is linear on either side of the kink rv = θ_g/T_c, so a vertex of the
    /// polygon (interval wedge) ∩ (window) ∩ (speed cap), or its crossing with the kink, is best.
    pub fn best_in(&self, interval: &ArcInterval) -> Option<(Twist2, [f64; 3])> {
        let w = &self.window;
        let tv_lo = self.least_speed_mps();
        let tv_hi = w.linear_hi_mps.min(self.speed_cap_mps(interval));
        if !(tv_lo <= tv_hi && tv_hi > 0.0) {
            return None;
        }
        let (c_lo, c_hi) = (interval.curvature_lo, interval.curvature_hi);
        // The goal's direction, and the same direction a full turn on.
        let kinks = [0.0, -TAU, TAU]
            .map(|turn| (wrap_angle(self.goal_bearing_rad) + turn) / self.config.heading_time_s);
        let mut best: Option<(f64, Twist2, [f64; 3])> = None;
        let mut offer = |tv: f64, rv: f64| {
            let inside = (tv_lo..=tv_hi).contains(&tv)
                && (w.angular_lo_radps..=w.angular_hi_radps).contains(&rv)
                && rv >= c_lo * tv - 1e-12
                && rv <= c_hi * tv + 1e-12;
            if inside {
                let twist = Twist2::new(tv, rv);
                let terms = self.terms(twist, interval.distance_m);
                let total = self.total(terms);
                if best.is_none_or(|(b, ..)| total > b) {
                    best = Some((total, twist, terms));
                }
            }
        };
        for tv in [tv_hi, tv_lo] {
            for rv in [c_lo * tv, c_hi * tv, w.angular_lo_radps, w.angular_hi_radps] {
                offer(tv, rv);
            }
            kinks.into_iter().for_each(|rv| offer(tv, rv));
        }
        for rv in kinks.into_iter().chain([w.angular_lo_radps, w.angular_hi_radps]) {
            for c in [c_lo, c_hi] {
                if c != 0.0 {
                    offer(rv / c, rv);
                }
            }
        }
        best.map(|(_, twist, terms)| (twist, terms))
    }
}
