//! Is the robot going in circles, or stuck? `[Maalouf06 §6]`

use serde::{Deserialize, Serialize};

use crate::geometry::Point2;

/// When a robot counts as trapped.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrapConfig {
    /// Two positions nearer than this are the same region \[m\].
    pub region_radius_m: f64,
    /// Coming back counts only after driving this far in between \[m\].
    pub loop_length_m: f64,
    /// Progress is what is still to go falling by at least this: the field's value, or metres.
    pub progress_m: f64,
    /// No progress for this long is a local minimum \[s\].
    pub patience_s: f64,
    /// So is getting this much farther from an intermediate goal than the robot was already \[m\].
    pub stray_m: f64,
    /// Straight on is a dead end if the way by what is seen is longer by this \[m\] ...
    pub detour_m: f64,
    /// ... for this long \[s\].
    pub detour_s: f64,
}

impl Default for TrapConfig {
    fn default() -> Self {
        Self {
            region_radius_m: 0.35,
            loop_length_m: 3.0,
            progress_m: 0.2,
            patience_s: 8.0,
            stray_m: 1.5,
            detour_m: 4.0,
            detour_s: 1.0,
        }
    }
}

/// What speaks for a trap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrapEvidence {
    /// Driven since the watch began \[m\].
    pub driven_m: f64,
    /// The earlier position that was come back to, if any.
    pub revisited: Option<Point2>,
    /// Least that was still to go so far: the field's value, or metres where there is no field.
    pub least_to_go: Option<f64>,
    /// Time since it last fell \[s\].
    pub without_progress_s: f64,
    /// [`TrapConfig::patience_s`] has run out.
    pub stuck: bool,
    /// By how much the way by what is seen is longer than straight on \[m\], where there is no way to follow.
    pub detour_m: Option<f64>,
    /// For how long it has been too much longer \[s\].
    pub detour_s: f64,
    /// [`TrapConfig::detour_s`] has run out: straight on is a dead end.
    pub dead_end: bool,
}

/// Watches the way driven since the last plan.
#[derive(Clone, Debug)]
pub struct TrapWatch {
    config: TrapConfig,
    /// Positions every half region, with the way driven until there.
    trail: Vec<(Point2, f64)>,
    last: Option<Point2>,
    /// What is left of the time in which the robot may still be carried the old way \[s\].
    carried_s: f64,
    evidence: TrapEvidence,
}

/// A robot that was driving takes about this long to come to rest before it turns to another way \[s\].
const CARRIED_S: f64 = 2.5;

impl TrapWatch {
    /// A watch with nothing seen yet.
    pub fn new(config: TrapConfig) -> Self {
        Self { config, trail: Vec::new(), last: None, carried_s: 0.0, evidence: TrapEvidence::default() }
    }

    /// Forgets the trail: a new plan, or a new task.
    pub fn restart(&mut self) {
        *self = Self::new(self.config);
    }

    /// Forgets the trail of a robot that is driving: it has another way now, and what its momentum takes
    /// it away from that is no loss of progress.
    pub fn restart_under_way(&mut self) {
        self.restart();
        self.carried_s = CARRIED_S;
    }

    /// Driven since the watch began \[m\].
    pub fn driven_m(&self) -> f64 {
        self.evidence.driven_m
    }

    /// One tick at `position_in_world`, with `to_go` left to what is headed for.
    pub fn step(&mut self, position_in_world: Point2, to_go: f64, dt_s: f64) -> TrapEvidence {
        let step_m = self.last.map_or(0.0, |last| last.distance(position_in_world));
        self.last = Some(position_in_world);
        self.evidence.driven_m += step_m;
        self.evidence.revisited = self.revisited(position_in_world);
        let spacing_m = self.config.region_radius_m / 2.0;
        if self.trail.last().is_none_or(|(p, _)| p.distance(position_in_world) >= spacing_m) {
            self.trail.push((position_in_world, self.evidence.driven_m));
        }

        let carried = self.carried_s > 0.0;
        self.carried_s -= dt_s;
        let nearer = |least| to_go <= least - self.config.progress_m;
        let progressed = to_go.is_finite() && (carried || self.evidence.least_to_go.is_none_or(nearer));
        if progressed {
            self.evidence.least_to_go = Some(to_go);
            self.evidence.without_progress_s = 0.0;
        } else {
            self.evidence.without_progress_s += dt_s;
        }
        self.evidence.stuck = self.evidence.without_progress_s > self.config.patience_s;
        self.evidence
    }

    /// What is to go has risen by this where the robot stands, because the map changed: that is no loss of its.
    pub fn raise(&mut self, by: f64) {
        if let Some(least) = self.evidence.least_to_go.as_mut().filter(|_| by.is_finite() && by > 0.0) {
            *least += by;
        }
    }

    /// What the field says of the straight way to the goal: a way with this much more to pay \[m\]. To be
    /// told before [`Self::step`].
    pub fn see_detour(&mut self, detour_m: f64, dt_s: f64) {
        let is_trap = detour_m.is_finite() && detour_m >= self.config.detour_m;
        self.evidence.detour_m = Some(detour_m);
        self.evidence.detour_s = if is_trap { self.evidence.detour_s + dt_s } else { 0.0 };
        self.evidence.dead_end = self.evidence.detour_s >= self.config.detour_s;
    }

    /// The earlier position in this region, if the robot left the region in between and drove a loop.
    fn revisited(&self, position: Point2) -> Option<Point2> {
        let long_ago = self.evidence.driven_m - self.config.loop_length_m;
        let candidate = self.trail.iter().position(|(p, driven)| {
            *driven <= long_ago && p.distance(position) < self.config.region_radius_m
        })?;
        let left = self.trail[candidate..]
            .iter()
            .any(|(p, _)| p.distance(position) > 2.0 * self.config.region_radius_m);
        left.then(|| self.trail[candidate].0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn drive(watch: &mut TrapWatch, way: impl Iterator<Item = Point2>) -> TrapEvidence {
        way.map(|p| watch.step(p, 10.0 - p.x, 0.1)).last().unwrap()
    }

    #[test]
    fn a_circle_driven_once_is_a_region_visited_twice() {
        let mut watch = TrapWatch::new(TrapConfig::default());
        let circle = (0..=100).map(|i| f64::from(i) / 100.0 * TAU).map(|a| Point2::new(a.cos(), a.sin()));
        assert!(drive(&mut watch, circle).revisited.is_some());
    }

    #[test]
    fn what_momentum_takes_away_from_a_new_way_is_no_loss_but_driving_on_is() {
        let mut watch = TrapWatch::new(TrapConfig::default());
        watch.restart_under_way();
        // On for 0.8 m at 0.4 m/s, away from where the new way leads, then back as slowly as it takes.
        let on = (0..20).map(|i| Point2::new(-0.04 * f64::from(i), 0.0));
        let back = (0..70).map(|i| Point2::new(-0.8 + 0.004 * f64::from(i), 0.0));
        assert!(!drive(&mut watch, on.chain(back)).stuck);
        watch.restart_under_way();
        assert!(drive(&mut watch, (0..120).map(|i| Point2::new(-0.04 * f64::from(i), 0.0))).stuck);
    }

    #[test]
    fn a_straight_way_and_a_turn_on_the_spot_revisit_nothing() {
        let mut watch = TrapWatch::new(TrapConfig::default());
        let straight = (0..200).map(|i| Point2::new(f64::from(i) * 0.05, 0.0));
        assert_eq!(drive(&mut watch, straight).revisited, None);
        let jitter = (0..200).map(|i| Point2::new(9.95 + 0.03 * f64::from(i % 2), 0.0));
        assert_eq!(drive(&mut watch, jitter).revisited, None);
    }

    #[test]
    fn standing_before_a_wall_is_stuck_after_the_patience_and_not_before() {
        let config = TrapConfig::default();
        let mut watch = TrapWatch::new(config);
        let ticks = (config.patience_s / 0.1) as usize;
        for tick in 0..=ticks + 2 {
            let seen = watch.step(Point2::new(1.0, 1.0), 5.0, 0.1);
            assert_eq!(seen.stuck, seen.without_progress_s > config.patience_s, "tick {tick}");
        }
        assert!(watch.step(Point2::new(1.0, 1.0), 5.0, 0.1).stuck);
    }

    #[test]
    fn where_nothing_says_what_is_to_go_nothing_is_gained() {
        let config = TrapConfig::default();
        let mut watch = TrapWatch::new(config);
        let ticks = (config.patience_s / 0.1) as usize;
        assert!(
            (0..=ticks + 2)
                .map(|_| watch.step(Point2::new(1.0, 1.0), f64::INFINITY, 0.1))
                .last()
                .unwrap()
                .stuck
        );
    }

    #[test]
    fn a_map_that_shows_the_way_to_be_longer_takes_no_progress_away() {
        let config = TrapConfig::default();
        let mut watch = TrapWatch::new(config);
        let mut to_go = 20.0;
        let stuck = (0..200).any(|tick| {
            to_go -= 0.04;
            if tick % 20 == 0 {
                to_go += 2.0;
                watch.raise(2.0);
            }
            watch.step(Point2::new(0.04 * f64::from(tick), 0.0), to_go, 0.1).stuck
        });
        assert!(!stuck);
    }

    #[test]
    fn a_detour_that_lasts_is_a_dead_end_and_one_that_passes_is_not() {
        let config = TrapConfig::default();
        let mut watch = TrapWatch::new(config);
        let (ticks, dt_s) = (8, config.detour_s / 8.0); // which add up without rounding
        let mut see = |detour_m: f64| {
            watch.see_detour(detour_m, dt_s);
            watch.step(Point2::new(1.0, 1.0), 5.0, dt_s).dead_end
        };
        assert!((0..ticks - 1).all(|_| !see(config.detour_m + 0.1)));
        assert!(!see(0.3));
        assert!((0..ticks - 1).all(|_| !see(config.detour_m + 0.1)));
        assert!(see(config.detour_m + 0.1));
        assert!(!see(f64::INFINITY));
    }

    #[test]
    fn progress_or_a_new_plan_resets_the_patience() {
        let mut watch = TrapWatch::new(TrapConfig::default());
        for _ in 0..200 {
            watch.step(Point2::new(1.0, 1.0), 5.0, 0.1);
        }
        assert!(!watch.step(Point2::new(1.3, 1.0), 4.7, 0.1).stuck);
        for _ in 0..200 {
            watch.step(Point2::new(1.3, 1.0), 4.7, 0.1);
        }
        watch.restart();
        assert!(!watch.step(Point2::new(1.3, 1.0), 9.0, 0.1).stuck);
    }
}
