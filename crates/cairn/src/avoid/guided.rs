//! The same arcs, judged by a cost-to-go field: one step of looking ahead, then the field
//! `[Brock99]` `[Bertsekas05]`. Everything is in seconds.

use serde::{Deserialize, Serialize};

use super::cvm::{AT_REST_MPS, Cvm, Seen, brake};
use super::moving::Moving;
use super::objective::Window;
use super::record::{AvoidanceRecord, BrakeReason, Candidate, Guidance, Refusal, Side, Why};
use super::turning::free_turn_rad;
use crate::geometry::{Point2, Pose2, Twist2, wrap_angle};
use crate::robot::Bound;

/// What a cost-to-go field says about the places around the robot.
pub trait Guide {
    /// Time still to go from a place, however the robot is turned there \[s\], and the direction to
    /// leave it in, both in the robot frame; an infinite time where the field knows no way.
    fn to_go(&self, point_in_robot: Point2) -> (f64, f64);
    /// Time that a metre takes at a place \[s/m\]; infinite where the robot's centre must not be.
    fn price(&self, point_in_robot: Point2) -> f64;
}

/// How arcs are judged by a field.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GuidedConfig {
    /// The command may head for a motion that is this far away by the accelerations \[s\].
    pub window_s: f64,
    /// Arcs are followed at least this far before the field takes over \[m\], or for `least_s`.
    pub least_m: f64,
    /// See `least_m` \[s\].
    pub least_s: f64,
    /// Sideways acceleration that an arc may ask for \[m/s²\].
    pub lateral_mps2: f64,
    /// Rate of turning that an arc may ask for \[rad/s\].
    pub arc_rate_radps: f64,
    /// What it costs to leave an arc's end in another direction \[s/rad\].
    pub bend_s_per_rad: f64,
    /// What a turn on the spot costs: a constant part \[s\] ...
    pub turn_s: f64,
    /// ... and a part for the angle \[s/rad\].
    pub turn_s_per_rad: f64,
    /// What changing the rate of turning costs \[s per rad/s\].
    pub steady_s_per_radps: f64,
    /// Speed allowed by the braking room counts this share of the deceleration.
    pub braking_share: f64,
    /// Way kept free ahead of the stopping place \[m\].
    pub keep_m: f64,
    /// With the mere touch kept off by this much, where the margin cannot be kept \[m\].
    pub tight_m: f64,
}

impl Default for GuidedConfig {
    fn default() -> Self {
        Self {
            window_s: 0.25,
            least_m: 0.2,
            least_s: 0.3,
            lateral_mps2: 2.0,
            arc_rate_radps: 2.5,
            bend_s_per_rad: 0.3,
            turn_s: 0.4,
            turn_s_per_rad: 0.6,
            steady_s_per_radps: 0.02,
            braking_share: 0.7,
            keep_m: 0.05,
            tight_m: 0.01,
        }
    }
}

impl GuidedConfig {
    /// Every setting with its least and greatest usable value.
    pub(super) fn bounds(&self) -> [Bound; 12] {
        [
            ("guided.window_s", self.window_s, 1e-3, 100.0),
            ("guided.least_m", self.least_m, 0.0, 100.0),
            ("guided.least_s", self.least_s, 0.0, 100.0),
            ("guided.lateral_mps2", self.lateral_mps2, 1e-3, 1e3),
            ("guided.arc_rate_radps", self.arc_rate_radps, 1e-3, 100.0),
            ("guided.bend_s_per_rad", self.bend_s_per_rad, 0.0, 1e3),
            ("guided.turn_s", self.turn_s, 0.0, 1e3),
            ("guided.turn_s_per_rad", self.turn_s_per_rad, 0.0, 1e3),
            ("guided.steady_s_per_radps", self.steady_s_per_radps, 0.0, 1e3),
            ("guided.braking_share", self.braking_share, 1e-3, 1.0),
            ("guided.keep_m", self.keep_m, 0.0, 10.0),
            ("guided.tight_m", self.tight_m, 0.0, 10.0),
        ]
    }
}

/// Arc lengths at which the field may take over \[m\].
const LENGTHS_M: [f64; 7] = [0.2, 0.3, 0.45, 0.65, 0.9, 1.2, 1.6];
/// The price is taken this often along an arc \[m\].
const STEP_M: f64 = 0.05;
/// Shares of an arc's greatest speed that are tried, the fastest first.
const SHARES: [f64; 5] = [1.0, 0.75, 0.5, 0.3, 0.15];
/// Arcs whose braking motion is looked at before giving up.
const ARCS: usize = 16;
/// The robot turns towards the field's direction when it is at least this far aside \[rad\].
const LEAST_TURN_RAD: f64 = 0.25;

/// The field's direction is behind when it is this far aside \[rad\].
const BEHIND_RAD: f64 = 1.8;
/// A greater change of direction is no bend any more \[rad\].
const BEND_RAD: f64 = 1.2;

/// An arc, with how soon the goal is reached over it.
struct Arc {
    curvature: f64,
    distance_m: f64,
    to_go_s: f64,
    speed_mps: f64,
}

impl Cvm {
    /// The motion for the next tick of `dt_s`, guided by a field instead of the goal's direction.
    ///
    /// Arcs, free lengths and braking check are those of [`Cvm::choose_after`]; here they begin where
    /// the robot will be when the command takes effect. An arc is worth the time to go over it
    /// and on from where the field takes over best; a turn on the spot is judged in the same
    /// currency. `guide` tells of the robot frame as it is now, and so do `obstacles_in_robot` and
    /// `moving`. Nothing is returned whose braking motion meets an obstacle, unless there is no such.
    #[allow(clippy::too_many_arguments)]
    pub fn choose_guided(
        &self,
        current: Twist2,
        pending: Twist2,
        guide: &dyn Guide,
        obstacles_in_robot: &[Point2],
        moving: &[Moving],
        goal_distance_m: f64,
        dt_s: f64,
    ) -> AvoidanceRecord {
        if let Err(e) = self.check(current, 0.0, goal_distance_m, obstacles_in_robot, dt_s) {
            return self.refused(&e, 0.0, goal_distance_m);
        }
        let pending = if pending.is_finite() { pending } else { current };
        let (now_from_then, start) = self.when_it_takes_effect(current, pending);
        let window = Window::reachable(&self.limits, start, dt_s);
        let wide = Window::reachable(&self.limits, start, self.config.guided.window_s.max(dt_s));
        let nearest_first = self.nearest_first(obstacles_in_robot);
        let then_from_now = now_from_then.inverse();
        let moved: Vec<Point2> = nearest_first.iter().map(|&(_, p)| then_from_now * p).collect();
        let nearest_then = self.nearest_first(&moved);
        let clearance_m =
            nearest_first.iter().map(|&(_, p)| self.clearance_m(p)).fold(f64::INFINITY, f64::min);
        let (to_go_s, direction_rad) = guide.to_go(now_from_then.position());
        let bearing_rad = wrap_angle(direction_rad - now_from_then.heading);
        let mut record = AvoidanceRecord {
            window,
            goal_bearing_rad: wrap_angle(direction_rad),
            goal_distance_m,
            clearance_m,
            weights: self.config.weights(),
            guided: Some(Guidance { to_go_s, tight: false, moving: moving.len() }),
            intervals: Vec::new(),
            candidates: Vec::new(),
            chosen: None,
            twist: brake(&window, start),
            why: Why::Braking { reason: BrakeReason::AtGoal },
        };
        let seen = Seen { current, pending, start, dt_s, window, nearest_first: &nearest_first };
        // Where the margin is broken already, only the touch itself is kept off.
        let inside = |outline: &super::GrownBox| nearest_then.iter().any(|&(_, p)| outline.contains(p));
        let tight = inside(&self.outline);
        if tight && inside(&self.tight) {
            self.leave_obstacle(&mut record, &seen);
            return record;
        }
        let fan = if tight { &self.tight_fan } else { &self.fan };
        let outline = if tight { &self.tight } else { &self.outline };
        if let Some(guidance) = &mut record.guided {
            guidance.tight = tight;
        }
        if !moving.is_empty() {
            // The ways below know nothing of what moves.
            if !self.give_way(&mut record, &seen, guide, now_from_then, moving, goal_distance_m) {
                self.come_to_rest(&mut record, &seen);
            }
            return record;
        }
        let (intervals, pieces) = fan.free_arcs_and_pieces(&nearest_then);
        record.intervals = intervals.intervals;

        let place = Place { guide, now_from_then, start, wide, goal_m: goal_distance_m, dt_s };
        let mut arcs: Vec<Arc> = pieces
            .iter()
            .filter_map(|&(lo, hi, distance_m)| self.judged((lo + hi) / 2.0, distance_m, &place))
            .collect();
        arcs.sort_by(|a, b| a.to_go_s.total_cmp(&b.to_go_s));
        let best_s = arcs.first().map_or(f64::INFINITY, |arc| arc.to_go_s);
        record.candidates = arcs.iter().map(|arc| self.as_candidate(arc, &record.intervals)).collect();

        // A turn on the spot, the shorter way round or the longer one, in the same currency.
        let turns = [bearing_rad, bearing_rad - std::f64::consts::TAU.copysign(bearing_rad)];
        let turns = turns.map(|angle_rad| {
            let side = if angle_rad > 0.0 { Side::Left } else { Side::Right };
            (angle_rad, free_turn_rad(outline, &nearest_then, side))
        });
        let turn = turns
            .into_iter()
            .find(|&(angle_rad, free_rad)| bearing_rad.abs() > LEAST_TURN_RAD && free_rad > angle_rad.abs());
        if let Some((angle_rad, free_rad)) = turn {
            let turn_s = self.turn_s(to_go_s, angle_rad, &seen);
            if turn_s < best_s && self.turn_towards(&mut record, &seen, angle_rad, free_rad) {
                return record;
            }
        } else if bearing_rad.abs() > BEHIND_RAD && self.back_out(&mut record, &seen) {
            return record;
        }
        for (i, arc) in arcs.iter().enumerate().take(ARCS) {
            for share in SHARES {
                let speed_mps = arc.speed_mps * share;
                if speed_mps < self.config.min_speed_mps.min(arc.speed_mps) {
                    break;
                }
                let target = Twist2::new(speed_mps, speed_mps * arc.curvature);
                let twist = self.limits.reachable(start, target, dt_s);
                if self.can_stop(twist, &seen) {
                    record.chosen = Some(i);
                    record.candidates[i].twist = twist;
                    record.twist = twist;
                    record.why = Why::BestArc;
                    return record;
                }
            }
            record.candidates[i].refused = Some(Refusal::StoppingMeetsObstacle);
        }
        // No arc: the turn all the same, else back, else rest.
        if let Some((angle_rad, free_rad)) = turn
            && self.turn_towards(&mut record, &seen, angle_rad, free_rad)
        {
            return record;
        }
        if self.back_out(&mut record, &seen) {
            return record;
        }
        self.come_to_rest(&mut record, &seen);
        record
    }

    /// Nothing may be driven: brakes.
    fn come_to_rest(&self, record: &mut AvoidanceRecord, seen: &Seen) {
        let clear = self.brake_clear(record, seen);
        let rolls = record.twist.linear_mps.abs() > AT_REST_MPS;
        let reason = if !clear && rolls { BrakeReason::TooFast } else { BrakeReason::NothingFree };
        record.why = Why::Braking { reason };
    }

    /// Pose and twist of the robot when a command given now takes effect.
    fn when_it_takes_effect(&self, current: Twist2, pending: Twist2) -> (Pose2, Twist2) {
        let (mut pose, mut twist) = (Pose2::IDENTITY, current);
        let steps = (self.config.latency_s / 0.02).ceil().max(1.0);
        let step_s = self.config.latency_s / steps;
        for _ in 0..steps as usize {
            let (next, mean) = self.limits.ramped(twist, pending, step_s);
            pose = pose.moved(mean, step_s);
            twist = next;
        }
        (pose, twist)
    }

    /// The time to the goal over the arc, and how fast it may be driven; None if it cannot be.
    fn judged(&self, curvature: f64, distance_m: f64, place: &Place) -> Option<Arc> {
        let config = &self.config.guided;
        let Place { guide, now_from_then, start, wide, dt_s, .. } = *place;
        // Reachable speeds on this arc.
        let (mut lo, mut hi) = (wide.linear_lo_mps, wide.linear_hi_mps);
        if curvature.abs() > 1e-9 {
            let ends = [wide.angular_lo_radps / curvature, wide.angular_hi_radps / curvature];
            (lo, hi) = (lo.max(ends[0].min(ends[1])), hi.min(ends[0].max(ends[1])));
            let bend_mps =
                (config.arc_rate_radps / curvature.abs()).min((config.lateral_mps2 / curvature.abs()).sqrt());
            hi = hi.min(bend_mps.max(lo));
        }
        if lo > hi {
            return None;
        }
        let room_m = distance_m - config.keep_m;
        let a = self.limits.linear_mps2 * config.braking_share;
        // What lies beyond the goal is nobody's concern: the robot stops there.
        let goal_mps = (2.0 * a * place.goal_m).sqrt().max(self.config.min_speed_mps);
        let delay = a * dt_s;
        let stop_mps = if room_m > 0.0 { (delay * delay + 2.0 * a * room_m).sqrt() - delay } else { 0.0 };
        let least_m = config.least_m.max(start.linear_mps * config.least_s).min(1.0);
        if room_m < config.least_m || stop_mps < lo {
            return None;
        }
        let mut speed_mps = hi.min(stop_mps).min(goal_mps.max(lo));
        let bend_price = curvature.abs() / config.arc_rate_radps;
        let (mut passed_s, mut along_m, mut best_s) = (0.0, 0.0, f64::INFINITY);
        let braking_m = start.linear_mps * start.linear_mps / (2.0 * a) + 0.1;
        for (k, &length_m) in LENGTHS_M.iter().enumerate() {
            if length_m > room_m {
                break;
            }
            while along_m < length_m - 1e-9 {
                let step_m = STEP_M.min(length_m - along_m);
                let pose = Twist2::new(1.0, curvature).displacement(along_m + step_m / 2.0);
                let price = guide.price(now_from_then * pose.position());
                // Where the field would not go, the exact contacts still may: slowly.
                let price = if price.is_finite() { price } else { 1.0 / self.config.min_speed_mps };
                passed_s += step_m * price.max(bend_price);
                along_m += step_m;
                // The field's own speeds hold on the way as far as braking reaches.
                let left_m = (along_m - step_m).max(0.0);
                if left_m <= braking_m {
                    let there = 1.0 / price;
                    speed_mps = speed_mps.min((there * there + 2.0 * a * left_m).sqrt());
                }
            }
            if length_m + 1e-9 < least_m && k + 1 < LENGTHS_M.len() && LENGTHS_M[k + 1] <= room_m {
                continue;
            }
            let end = now_from_then * Twist2::new(1.0, curvature).displacement(length_m);
            let (to_go_s, direction_rad) = guide.to_go(end.position());
            let bend_rad = wrap_angle(direction_rad - end.heading).abs();
            best_s = best_s.min(passed_s + to_go_s + self.bend_s(bend_rad));
        }
        let speed_mps = speed_mps.max(self.config.min_speed_mps.min(hi)).max(lo).min(hi);
        let change = (speed_mps * curvature - start.angular_radps).abs();
        let to_go_s = best_s + config.steady_s_per_radps * change;
        if !to_go_s.is_finite() {
            return None;
        }
        Some(Arc { curvature, distance_m, to_go_s, speed_mps })
    }

    fn as_candidate(&self, arc: &Arc, intervals: &[super::ArcInterval]) -> Candidate {
        let inside =
            |i: &super::ArcInterval| i.curvature_lo <= arc.curvature && arc.curvature <= i.curvature_hi;
        Candidate {
            twist: Twist2::new(arc.speed_mps, arc.speed_mps * arc.curvature),
            interval: intervals.iter().position(inside).unwrap_or(0),
            speed: arc.speed_mps / self.limits.linear_mps,
            distance: arc.distance_m / self.config.horizon_m,
            heading: 0.0,
            total: -arc.to_go_s,
            refused: None,
        }
    }

    /// What leaving an arc's end by an angle costs: a bend under way up to a right angle or so, beyond
    /// it a stop and a turn \[s\].
    pub(super) fn bend_s(&self, bend_rad: f64) -> f64 {
        let config = &self.config.guided;
        let beyond_rad = (bend_rad - BEND_RAD).max(0.0);
        config.bend_s_per_rad * bend_rad.min(BEND_RAD)
            + 2.0 * (config.turn_s + config.turn_s_per_rad) * beyond_rad
    }

    /// The time to the goal after a turn on the spot \[s\].
    fn turn_s(&self, to_go_s: f64, bearing_rad: f64, seen: &Seen) -> f64 {
        let config = &self.config.guided;
        let side = bearing_rad.signum();
        // Who turns that way on the spot already has paid for beginning.
        let turning = seen.start.linear_mps.abs() < 0.1 && side * seen.start.angular_radps > 0.2;
        let begin_s = if turning { 0.0 } else { config.turn_s };
        let stop_s = seen.start.linear_mps.abs() / self.limits.linear_mps2;
        to_go_s + begin_s + stop_s + config.turn_s_per_rad * bearing_rad.abs()
    }

    /// Turns (once at rest) by `angle_rad`, left positive, as fast as it can stop there.
    fn turn_towards(&self, record: &mut AvoidanceRecord, seen: &Seen, angle_rad: f64, free_rad: f64) -> bool {
        let Seen { start, dt_s, window, .. } = *seen;
        let side = angle_rad.signum();
        let left_rad = angle_rad.abs().min(free_rad);
        let acceleration = self.limits.angular_radps2 * self.config.guided.braking_share;
        let delay = acceleration * dt_s;
        let rate = ((delay * delay + 2.0 * acceleration * left_rad).sqrt() - delay)
            .min(self.config.turn_rate_radps)
            .min(self.limits.angular_radps);
        let linear = if start.linear_mps >= 0.0 { window.linear_lo_mps } else { 0.0 };
        let angular = (side * rate).clamp(window.angular_lo_radps, window.angular_hi_radps);
        let twist = Twist2::new(linear, angular);
        if !self.can_stop(twist, seen) {
            return false;
        }
        record.twist = twist;
        let direction = if side > 0.0 { Side::Left } else { Side::Right };
        record.why = Why::TurningInPlace { direction, to_heading_rad: angle_rad };
        true
    }
}

/// Where and when an arc begins.
#[derive(Clone, Copy)]
struct Place<'a> {
    guide: &'a dyn Guide,
    now_from_then: Pose2,
    start: Twist2,
    wide: Window,
    goal_m: f64,
    dt_s: f64,
}
