//! Among things that move: whole manoeuvres, followed in time beside everything that is seen to move.

use serde::{Deserialize, Serialize};

use super::cvm::{Cvm, Seen};
use super::guided::Guide;
use super::record::{AvoidanceRecord, Candidate, Why};
use crate::geometry::{Point2, Pose2, Twist2, wrap_angle};
use crate::robot::Bound;

/// A disc that moves straight on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Moving {
    /// Its centre now, robot frame \[m\].
    pub center: Point2,
    /// Its radius \[m\].
    pub radius_m: f64,
    /// Its velocity over the ground, along the axes of the robot frame as it lies now \[m/s\].
    pub velocity_mps: Point2,
}

/// How far ahead in time motions are followed, and what nearness costs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MovingConfig {
    /// Manoeuvres are followed for this long \[s\].
    pub foresight_s: f64,
    /// A second of foresight widens every disc by this: nobody moves straight for long \[m/s\].
    pub widening_mps: f64,
    /// Nearer than this costs \[m\] ...
    pub berth_m: f64,
    /// ... up to this for every second at a touch.
    pub nearness: f64,
    /// What touching at once costs \[s\]; later, less.
    pub touch_s: f64,
    /// Speeds that are tried \[m/s\].
    pub speeds_mps: Vec<f64>,
    /// Rates of turning that are tried, each to both sides \[rad/s\].
    pub rates_radps: Vec<f64>,
    /// How long the turn lasts before the robot goes straight on \[s\].
    pub bends_s: Vec<f64>,
}

impl Default for MovingConfig {
    fn default() -> Self {
        Self {
            foresight_s: 2.5,
            widening_mps: 0.1,
            berth_m: 0.5,
            nearness: 2.0,
            touch_s: 30.0,
            speeds_mps: vec![-0.8, 0.0, 0.5, 1.0, 1.5, 2.0],
            rates_radps: vec![0.0, 0.4, 1.0, 2.0, 3.0],
            bends_s: vec![0.4, 0.9],
        }
    }
}

impl MovingConfig {
    /// Every setting with its least and greatest usable value.
    pub(super) fn bounds(&self) -> Vec<Bound> {
        let mut bounds = vec![
            ("moving.foresight_s", self.foresight_s, STEP_S, 60.0),
            ("moving.widening_mps", self.widening_mps, 0.0, 100.0),
            ("moving.berth_m", self.berth_m, 1e-3, 100.0),
            ("moving.nearness", self.nearness, 0.0, 1e6),
            ("moving.touch_s", self.touch_s, 0.0, 1e6),
            ("length of moving.speeds_mps", self.speeds_mps.len() as f64, 1.0, 64.0),
            ("length of moving.rates_radps", self.rates_radps.len() as f64, 1.0, 64.0),
            ("length of moving.bends_s", self.bends_s.len() as f64, 1.0, 64.0),
        ];
        bounds.extend(self.speeds_mps.iter().map(|&speed| ("moving.speeds_mps", speed, -100.0, 100.0)));
        bounds.extend(self.rates_radps.iter().map(|&rate| ("moving.rates_radps", rate, -100.0, 100.0)));
        bounds.extend(self.bends_s.iter().map(|&bend_s| ("moving.bends_s", bend_s, 0.0, 100.0)));
        bounds
    }
}

/// Time step of following a manoeuvre \[s\].
const STEP_S: f64 = 0.1;

/// A turn at a speed for a while, then straight on.
#[derive(Clone, Copy)]
struct Manoeuvre {
    target: Twist2,
    bend_s: f64,
}

/// What following one told.
#[derive(Clone, Copy)]
struct Followed {
    cost_s: f64,
    touches_s: f64,
    nearest_m: f64,
}

impl Cvm {
    /// Chooses among whole manoeuvres, each followed in time beside all that moves; false if none may
    /// be driven. What stands is kept off by the braking check, as ever.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn give_way(
        &self,
        record: &mut AvoidanceRecord,
        seen: &Seen,
        guide: &dyn Guide,
        now_from_then: Pose2,
        moving: &[Moving],
        goal_m: f64,
    ) -> bool {
        let config = &self.config.moving;
        let limits = &self.limits;
        let mut judged: Vec<(Manoeuvre, Followed)> = Vec::new();
        for &speed in &config.speeds_mps {
            let speed = speed.clamp(-limits.linear_mps, limits.linear_mps);
            for &rate in &config.rates_radps {
                for rate in [rate, -rate] {
                    if rate == 0.0 && rate.is_sign_negative() {
                        continue;
                    }
                    for (k, &bend_s) in config.bends_s.iter().enumerate() {
                        if rate == 0.0 && k > 0 {
                            continue;
                        }
                        let lateral = self.config.guided.lateral_mps2 * 2.0;
                        if (speed * rate).abs() > lateral {
                            continue;
                        }
                        let manoeuvre = Manoeuvre { target: Twist2::new(speed, rate), bend_s };
                        let followed = self.follow(manoeuvre, seen, guide, now_from_then, moving, goal_m);
                        judged.push((manoeuvre, followed));
                    }
                }
            }
        }
        judged.sort_by(|a, b| a.1.cost_s.total_cmp(&b.1.cost_s));
        for (manoeuvre, followed) in &judged {
            let twist = limits.reachable(seen.start, manoeuvre.target, seen.dt_s);
            if self.can_stop(twist, seen) {
                record.candidates.push(Candidate {
                    twist,
                    interval: 0,
                    speed: twist.linear_mps / limits.linear_mps,
                    distance: 0.0,
                    heading: 0.0,
                    total: -followed.cost_s,
                    refused: None,
                });
                record.chosen = Some(record.candidates.len() - 1);
                record.twist = twist;
                record.why = Why::GivingWay {
                    things: moving.len(),
                    touches_s: followed.touches_s.is_finite().then_some(followed.touches_s),
                    nearest_m: followed.nearest_m,
                };
                return true;
            }
        }
        false
    }

    fn follow(
        &self,
        manoeuvre: Manoeuvre,
        seen: &Seen,
        guide: &dyn Guide,
        now_from_then: Pose2,
        moving: &[Moving],
        goal_m: f64,
    ) -> Followed {
        let config = &self.config.moving;
        let (mut pose, mut twist) = (now_from_then, seen.start);
        let mut told = Followed { cost_s: 0.0, touches_s: f64::INFINITY, nearest_m: f64::INFINITY };
        let body_m = self.body.radius_m();
        let steps = (config.foresight_s / STEP_S).round() as usize;
        for step in 1..=steps {
            let along_s = step as f64 * STEP_S;
            let straight = Twist2::new(manoeuvre.target.linear_mps, 0.0);
            let target = if along_s <= manoeuvre.bend_s { manoeuvre.target } else { straight };
            let (next, mean) = self.limits.ramped(twist, target, STEP_S);
            pose = pose.moved(mean, STEP_S);
            twist = next;
            let early = 1.0 - 0.8 * along_s / config.foresight_s;
            let (sin, cos) = pose.heading.sin_cos();
            let at = pose.position();
            if guide.price(at).is_infinite() && mean.linear_mps.abs() > 0.05 {
                told.cost_s += config.touch_s * early;
                told.touches_s = along_s;
                break;
            }
            let after_s = along_s + self.config.latency_s;
            let mut nearest_m = f64::INFINITY;
            for thing in moving {
                let away = thing.center + thing.velocity_mps * after_s - at;
                let radius_m = thing.radius_m + config.widening_mps * after_s;
                let reach_m = body_m + radius_m + config.berth_m;
                if away.dot(away) < reach_m * reach_m {
                    let seen = Point2::new(cos * away.x + sin * away.y, -sin * away.x + cos * away.y);
                    nearest_m = nearest_m.min(self.clearance_m(seen) - radius_m);
                }
            }
            told.nearest_m = told.nearest_m.min(nearest_m);
            if nearest_m <= 0.0 {
                told.cost_s += config.touch_s * early;
                told.touches_s = along_s;
                break;
            }
            if nearest_m < config.berth_m {
                told.cost_s += config.nearness * early * (1.0 - nearest_m / config.berth_m) * STEP_S / 0.1;
            }
            if goal_m < 3.0 && (at - now_from_then.position()).norm() > goal_m {
                // Over the goal: what comes after does not count.
                told.cost_s += 0.2 * along_s;
                return told;
            }
        }
        let (to_go_s, direction_rad) = guide.to_go(pose.position());
        let bend_rad = wrap_angle(direction_rad - pose.heading).abs();
        let to_go_s = if to_go_s.is_finite() { to_go_s } else { config.touch_s };
        told.cost_s += to_go_s + self.bend_s(bend_rad) + 0.05 * manoeuvre.target.angular_radps.abs();
        told
    }
}
