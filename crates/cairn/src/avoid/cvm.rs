use super::backing::{BEYOND_M, Keep, WayBack, way_back};
use super::config::{AvoidError, CvmConfig, Shape, check_inputs};
use super::contact::GrownBox;
use super::intervals::Fan;
use super::leaving::leave;
use super::objective::{Objective, Window};
use super::record::{AvoidanceRecord, BrakeReason, Candidate, Refusal, Side, Why};
use super::stopping::BrakingMotion;
use super::turning::{Turn, choose_turn};
use crate::geometry::{Point2, Twist2, wrap_angle};
use crate::robot::{Footprint, Limits};

/// Slower than this is taken as standing \[m/s\].
pub(super) const AT_REST_MPS: f64 = 0.02;
/// From this speed on the robot is under way \[m/s\].
const UNDER_WAY_MPS: f64 = 0.2;
/// Faster than this is taken as turning \[rad/s\].
const TURNING_RADPS: f64 = 0.05;
/// A goal nearer than this is under the robot \[m\].
const AT_GOAL_M: f64 = 0.01;
/// Turned to a heading within this \[rad\].
const FACING_RAD: f64 = 0.1;
/// Nothing left to turn \[rad\].
pub(super) const AT_HEADING_RAD: f64 = 0.01;
/// Candidates whose braking motion is looked at before giving up.
const TRIES: usize = 24;
/// A goal farther to the side than this is turned to from rest; at twice this the robot is slow \[rad\].
const ASIDE_RAD: f64 = 1.0;
/// By how much a turn from rest must bring the robot nearer to the goal's direction \[rad\].
const GAINED_RAD: f64 = 0.5;
/// A goal farther round than this is behind: a slow robot stops and turns \[rad\].
const BEHIND_RAD: f64 = 2.0;
/// Slow is up to this much more than the speed near obstacles \[m/s\].
const SLOW_MPS: f64 = 0.05;
/// How far a motion that leaves or backs out is looked at, at most \[m\].
const LOOK_BACK_M: f64 = 1.7;

/// The curvature velocity method `[Maalouf06 §5, (7)]` `[Simmons96]`.
#[derive(Clone, Debug)]
pub struct Cvm {
    pub(super) config: CvmConfig,
    pub(super) limits: Limits,
    pub(super) body: GrownBox,
    pub(super) outline: GrownBox,
    pub(super) fan: Fan,
    /// The outline, and its arcs, where the margin cannot be kept and only the touch is kept off.
    pub(super) tight: GrownBox,
    pub(super) tight_fan: Fan,
}

impl Cvm {
    /// For a robot with these limits and this footprint.
    ///
    /// # Errors
    /// A setting that is out of range, or weights of (7) that do not sum to one.
    pub fn new(config: &CvmConfig, limits: &Limits, footprint: &Footprint) -> Result<Self, AvoidError> {
        let config = config.clone().validated()?;
        let body = match config.shape {
            Shape::Footprint => GrownBox {
                half_length_m: footprint.length_m / 2.0,
                half_width_m: footprint.width_m / 2.0,
                growth_m: 0.0,
            },
            Shape::Disc => GrownBox {
                half_length_m: 0.0,
                half_width_m: 0.0,
                growth_m: footprint.circumscribed_radius_m(),
            },
        };
        let outline = body.grown(config.growth_m());
        let fan = Fan::new(&config, &outline);
        let tight = body.grown(config.obstacle_radius_m + config.guided.tight_m.min(config.margin_m));
        let tight_fan = Fan::new(&config, &tight);
        Ok(Self { config, limits: *limits, body, outline, fan, tight, tight_fan })
    }

    /// The settings.
    pub fn config(&self) -> &CvmConfig {
        &self.config
    }

    /// Whether the inputs of [`Cvm::choose`] are usable numbers.
    ///
    /// # Errors
    /// The first that is not, by name.
    pub fn check(
        &self,
        current: Twist2,
        goal_bearing_rad: f64,
        goal_distance_m: f64,
        obstacles_in_robot: &[Point2],
        dt_s: f64,
    ) -> Result<(), AvoidError> {
        check_inputs(current, goal_bearing_rad, goal_distance_m, obstacles_in_robot, dt_s)
    }

    /// The motion to drive for the next tick of `dt_s`.
    ///
    /// `obstacles_in_robot` are centres of occupied map cells, robot frame \[m\]; `current` is the
    /// measured twist. The goal is given by its bearing θ_g and distance; an infinite distance
    /// means a direction only. A pure function of its arguments: while the robot turns in place,
    /// `current` itself tells which way, and that way is kept until a forward arc is free.
    /// Inputs that are not usable numbers make it brake, with the reason.
    pub fn choose(
        &self,
        current: Twist2,
        goal_bearing_rad: f64,
        goal_distance_m: f64,
        obstacles_in_robot: &[Point2],
        dt_s: f64,
    ) -> AvoidanceRecord {
        self.choose_after(current, None, goal_bearing_rad, goal_distance_m, obstacles_in_robot, dt_s)
    }

    /// As [`Cvm::choose`], knowing the command given before this one, `pending`: while the latency
    /// lasts the robot still changes towards it. The window and the braking motion are then exact;
    /// without it the robot is taken to keep its twist for the latency.
    pub fn choose_after(
        &self,
        current: Twist2,
        pending: Option<Twist2>,
        goal_bearing_rad: f64,
        goal_distance_m: f64,
        obstacles_in_robot: &[Point2],
        dt_s: f64,
    ) -> AvoidanceRecord {
        if let Err(e) = self.check(current, goal_bearing_rad, goal_distance_m, obstacles_in_robot, dt_s) {
            return self.refused(&e, goal_bearing_rad, goal_distance_m);
        }
        let goal_bearing_rad = wrap_angle(goal_bearing_rad);
        let pending = pending.filter(|twist| twist.is_finite());
        let (start, window) = match pending {
            Some(pending) => {
                let start = self.limits.reachable(current, pending, self.config.latency_s);
                let mut window = Window::reachable(&self.limits, start, dt_s);
                // A robot that lags behind its command brakes as hard as the command falls.
                let falling_mps = pending.linear_mps - self.limits.linear_mps2 * dt_s;
                window.linear_lo_mps = window.linear_lo_mps.min(falling_mps.max(0.0));
                (start, window)
            }
            None => (current, Window::reachable(&self.limits, current, self.config.latency_s + dt_s)),
        };
        let nearest_first = self.nearest_first(obstacles_in_robot);
        let clearance_m =
            nearest_first.iter().map(|&(_, p)| self.clearance_m(p)).fold(f64::INFINITY, f64::min);
        let mut record = AvoidanceRecord {
            window,
            goal_bearing_rad,
            goal_distance_m,
            clearance_m,
            weights: self.config.weights(),
            guided: None,
            intervals: Vec::new(),
            candidates: Vec::new(),
            chosen: None,
            twist: brake(&window, start),
            why: Why::Braking { reason: BrakeReason::AtGoal },
        };
        if goal_distance_m < AT_GOAL_M {
            return record;
        }
        let seen = Seen {
            current,
            pending: pending.unwrap_or(current),
            start,
            dt_s,
            window,
            nearest_first: &nearest_first,
        };
        if nearest_first.iter().any(|&(_, p)| self.outline.contains(p)) {
            self.leave_obstacle(&mut record, &seen);
        } else {
            self.drive_or_turn(&mut record, &seen);
        }
        record
    }

    /// Whether `command`, as the last one before braking, keeps the body off every obstacle.
    ///
    /// `pending` is the command given before it, `obstacles_in_robot` as in [`Cvm::choose`]; any
    /// controller's command may be asked about. It is held to the margin twice, once for what it does
    /// not know of how the robot lags; where the robot stands nearer than that already, as [`Cvm::keeps_off`].
    pub fn keeps_clear(
        &self,
        current: Twist2,
        pending: Twist2,
        command: Twist2,
        obstacles_in_robot: &[Point2],
        dt_s: f64,
    ) -> bool {
        let held_to = self.outline.grown(self.config.margin_m);
        let near = self.nearest_to_stop(&held_to, [current, pending, command], obstacles_in_robot, dt_s);
        self.keeps_clear_of(current, pending, command, &near, dt_s)
    }

    pub(super) fn keeps_clear_of(
        &self,
        current: Twist2,
        pending: Twist2,
        command: Twist2,
        nearest_first: &[(f64, Point2)],
        dt_s: f64,
    ) -> bool {
        let held_to = self.outline.grown(self.config.margin_m);
        let already_nearer = nearest_first.iter().any(|&(_, p)| held_to.contains(p));
        let outline = if already_nearer { self.held_off(nearest_first) } else { held_to };
        self.braking(current, pending, command, dt_s).is_clear(&outline, nearest_first)
    }

    /// As [`Cvm::keeps_clear`], held to hardly more than no touch: for motions worked out with their margin. Where
    /// the robot stands nearer than that already, to coming no nearer.
    pub fn keeps_off(
        &self,
        current: Twist2,
        pending: Twist2,
        command: Twist2,
        obstacles_in_robot: &[Point2],
        dt_s: f64,
    ) -> bool {
        let nearest_first = self.nearest_first(obstacles_in_robot);
        self.braking(current, pending, command, dt_s).is_clear(&self.held_off(&nearest_first), &nearest_first)
    }

    /// The body, grown to hardly more than no touch, or to just short of what it is nearest to.
    fn held_off(&self, nearest_first: &[(f64, Point2)]) -> GrownBox {
        let now_m = nearest_first.iter().map(|&(_, p)| self.body.distance(p)).fold(f64::INFINITY, f64::min);
        let least_m = self.config.obstacle_radius_m + self.config.least_clearance_m / 2.0;
        self.body.grown(least_m.min(now_m - BrakingMotion::SLACK_M).max(0.0))
    }

    fn drive_or_turn(&self, record: &mut AvoidanceRecord, seen: &Seen) {
        let Seen { current, dt_s, window, nearest_first, .. } = *seen;
        record.intervals = self.fan.free_arcs(nearest_first).intervals;
        let objective = Objective {
            config: &self.config,
            limits: &self.limits,
            window: self.slower_near(window, record),
            goal_bearing_rad: record.goal_bearing_rad,
            goal_distance_m: record.goal_distance_m,
            dt_s,
        };
        let turning = turning_side(current);
        let enough_m = self.enough_m(current, record.goal_distance_m);
        for (interval, arc) in record.intervals.iter().enumerate() {
            if let Some((twist, terms)) = objective.best_in(arc) {
                let [speed, distance, heading] = terms;
                let refused = (arc.distance_m < enough_m).then_some(Refusal::TooShort);
                let total = objective.total(terms);
                record.candidates.push(Candidate {
                    twist,
                    interval,
                    speed,
                    distance,
                    heading,
                    total,
                    refused,
                });
            }
        }
        // A robot that still runs back comes to rest first.
        let rolls_back = current.linear_mps.min(seen.start.linear_mps) < -AT_REST_MPS;
        if !rolls_back && (self.turn_first(record, seen, turning) || self.take_best(record, seen)) {
            return;
        }
        let drivable = record.intervals.iter().any(|arc| {
            arc.distance_m >= enough_m && objective.speed_cap_mps(arc) >= objective.least_speed_mps()
        });
        let turn = self.wanted_turn(record, seen, turning);
        if !rolls_back && turn.is_some_and(|t| t.angle_rad < FACING_RAD) {
            // It faces the best way already: a shorter arc has to do.
            for candidate in &mut record.candidates {
                let distance_m = record.intervals[candidate.interval].distance_m;
                if candidate.refused == Some(Refusal::TooShort) && distance_m >= self.config.turn_below_m {
                    candidate.refused = None;
                }
            }
            if self.take_best(record, seen) {
                return;
            }
        }
        self.turn_in_place(record, seen, turn, drivable);
    }

    /// From rest with the goal far to the side, or slow with the goal behind, and a way out towards
    /// it: (stops and) turns there first, instead of being carried away by the arcs ahead.
    fn turn_first(&self, record: &mut AvoidanceRecord, seen: &Seen, turning: Option<Side>) -> bool {
        let bearing_rad = record.goal_bearing_rad;
        let speed_mps = seen.current.linear_mps.abs().max(seen.start.linear_mps.abs());
        let rests = speed_mps <= AT_REST_MPS && bearing_rad.abs() > ASIDE_RAD;
        let slow = speed_mps <= self.config.near_speed_mps + SLOW_MPS && bearing_rad.abs() > BEHIND_RAD;
        if !rests && !slow {
            return false;
        }
        let Some(turn) = self.wanted_turn(record, seen, turning).filter(|turn| turn.open) else {
            return false;
        };
        let angle_rad = if turn.side == Side::Left { turn.angle_rad } else { -turn.angle_rad };
        if wrap_angle(bearing_rad - angle_rad).abs() > bearing_rad.abs() - GAINED_RAD {
            return false;
        }
        let before = (record.twist, record.why.clone());
        self.turn_in_place(record, seen, Some(turn), false);
        let stops = Why::Braking { reason: BrakeReason::StopsToTurn };
        let turns = matches!(record.why, Why::TurningInPlace { .. }) || (!rests && record.why == stops);
        if !turns {
            (record.twist, record.why) = before;
        }
        turns
    }

    /// Takes the candidate of the greatest total whose braking motion is clear.
    fn take_best(&self, record: &mut AvoidanceRecord, seen: &Seen) -> bool {
        let mut order: Vec<usize> =
            (0..record.candidates.len()).filter(|&i| record.candidates[i].refused.is_none()).collect();
        order.sort_by(|&a, &b| record.candidates[b].total.total_cmp(&record.candidates[a].total));
        for i in order.into_iter().take(TRIES) {
            if self.can_stop(record.candidates[i].twist, seen) {
                record.chosen = Some(i);
                record.twist = record.candidates[i].twist;
                record.why = Why::BestArc;
                return true;
            }
            record.candidates[i].refused = Some(Refusal::StoppingMeetsObstacle);
        }
        false
    }

    fn wanted_turn(&self, record: &AvoidanceRecord, seen: &Seen, keep: Option<Side>) -> Option<Turn> {
        let (wanted_m, corridor) = self.way_out(record.goal_distance_m);
        let bearing = record.goal_bearing_rad;
        choose_turn(&self.outline, &corridor, seen.nearest_first, bearing, wanted_m, keep)
    }

    /// Length of straight way that a turn must lead to, and what has to fit through it.
    fn way_out(&self, goal_distance_m: f64) -> (f64, GrownBox) {
        let wanted_m = self.enough_m(Twist2::ZERO, goal_distance_m);
        // Wide enough that a fan of arcs there counts as free too, and not only the one line.
        let body_m = self.outline.radius_m() - self.outline.growth_m;
        let fan_m = self.config.curvature_step_per_m / 2.0 * (wanted_m * wanted_m / 2.0 + body_m * wanted_m);
        (wanted_m + 0.05, self.outline.grown(2.0 * fan_m + 0.01))
    }

    /// The window without the speeds that are too great so near to an obstacle, or with the goal
    /// behind.
    fn slower_near(&self, window: Window, record: &AvoidanceRecord) -> Window {
        let near_mps = self.config.near_speed_mps;
        let free_m = (record.clearance_m - self.config.growth_m()).max(0.0);
        let aside = ((record.goal_bearing_rad.abs() - ASIDE_RAD) / ASIDE_RAD).clamp(0.0, 1.0);
        let facing_mps = near_mps + (1.0 - aside) * (self.limits.linear_mps - near_mps).max(0.0);
        let cap_mps = (near_mps + free_m / self.config.clearance_time_s).min(facing_mps);
        let linear_hi_mps = window.linear_hi_mps.min(cap_mps.max(window.linear_lo_mps));
        Window { linear_hi_mps, ..window }
    }

    /// Runs back towards the nearest place with room to turn, if the way there is clear.
    ///
    /// The measured speed itself tells whether it does so already: then it goes on until there is
    /// some room to spare.
    pub(super) fn back_out(&self, record: &mut AvoidanceRecord, seen: &Seen) -> bool {
        let start_mps = seen.start.linear_mps;
        if !self.config.back_out || start_mps > AT_REST_MPS {
            return false;
        }
        let (wanted_m, corridor) = self.way_out(record.goal_distance_m);
        let keep = self.keep(seen);
        let points = seen.nearest_first;
        let bearing = record.goal_bearing_rad;
        let backing = start_mps < -AT_REST_MPS;
        let Some(way) = way_back(&keep, &self.outline, &corridor, points, bearing, wanted_m, backing) else {
            return false;
        };
        let WayBack { curvature_per_m, length_m, clear_m } = way;
        if length_m == 0.0 {
            return false;
        }
        // Stops within what is clear, and by the place to turn or a little beyond.
        let room_m = (length_m + BEYOND_M / 2.0).min(clear_m);
        let decelerated = self.limits.linear_mps2 * (self.config.latency_s + seen.dt_s);
        let most_mps =
            (decelerated * decelerated + 2.0 * self.limits.linear_mps2 * room_m).sqrt() - decelerated;
        let slowest_mps = start_mps - self.limits.linear_mps2 * seen.dt_s;
        let linear = (-most_mps.min(self.config.backing_speed_mps)).max(slowest_mps.min(0.0));
        let window = &seen.window;
        let angular = (linear * curvature_per_m).clamp(window.angular_lo_radps, window.angular_hi_radps);
        let twist = Twist2::new(linear, angular);
        if !self.keeps(&keep, twist, seen) {
            return false;
        }
        record.twist = twist;
        record.why = Why::BackingOut { to_room_m: length_m, clear_m };
        true
    }

    /// What leaving and backing out must keep true of every obstacle.
    fn keep<'a>(&self, seen: &Seen<'a>) -> Keep<'a> {
        let least_m = self.config.obstacle_radius_m + self.config.least_clearance_m;
        Keep::new(self.body, seen.nearest_first, least_m, LOOK_BACK_M)
    }

    /// Whether the exact braking motion of `command` keeps it so.
    fn keeps(&self, keep: &Keep, command: Twist2, seen: &Seen) -> bool {
        self.motion(command, seen).all(self.body.radius_m(), |robot_from_start, travelled_m| {
            keep.holds(robot_from_start, travelled_m)
        })
    }

    /// Least free length of an arc that is driven on. A robot that hardly moves asks for more than
    /// one under way: what made it stop does not look free again at the next tick.
    fn enough_m(&self, current: Twist2, goal_distance_m: f64) -> f64 {
        let (least, most) = (self.config.turn_below_m, self.config.resume_above_m);
        let share = (current.linear_mps / UNDER_WAY_MPS).clamp(0.0, 1.0);
        (most + (least - most) * share)
            .min(goal_distance_m + self.config.turning_room_m)
            .min(self.config.horizon_m)
    }

    fn turn_in_place(&self, record: &mut AvoidanceRecord, seen: &Seen, turn: Option<Turn>, drivable: bool) {
        let Seen { current, dt_s, window, .. } = *seen;
        let brake_for = |reason| Why::Braking { reason };
        if seen.start.linear_mps < -AT_REST_MPS && self.back_out(record, seen) {
            return;
        }
        if current.linear_mps.abs() > AT_REST_MPS || window.linear_lo_mps > 0.0 {
            let clear = self.brake_clear(record, seen);
            record.why = brake_for(if clear { BrakeReason::StopsToTurn } else { BrakeReason::TooFast });
            return;
        }
        let finds_way = turn.is_some_and(|turn| turn.open);
        if !finds_way && !drivable && self.back_out(record, seen) {
            return;
        }
        if drivable && current.angular_radps.abs() > TURNING_RADPS {
            record.why = brake_for(BrakeReason::EndsTurn);
            return;
        }
        let Some(turn) = turn else {
            record.why = brake_for(BrakeReason::NoRoomToTurn);
            return;
        };
        if turn.angle_rad < AT_HEADING_RAD {
            record.why = brake_for(BrakeReason::NothingFree);
            return;
        }
        // As fast as still stops at the heading wanted: ω·tick + ω²/2α ≤ what is left of the angle
        // when the command takes effect.
        let side = if turn.side == Side::Left { 1.0 } else { -1.0 };
        let ahead_rad = (side * current.angular_radps).max(0.0) * self.config.latency_s;
        let left_rad = (turn.angle_rad.min(turn.free_rad) - ahead_rad).max(0.0);
        let delay = self.limits.angular_radps2 * dt_s;
        let room = 2.0 * self.limits.angular_radps2 * left_rad;
        let rate = (room / (delay + (delay * delay + room).sqrt()))
            .min(self.config.turn_rate_radps)
            .min(self.limits.angular_radps);
        let angular = (side * rate).clamp(window.angular_lo_radps, window.angular_hi_radps);
        let twist = Twist2::new(0.0, angular);
        if !self.can_stop(twist, seen) {
            record.why = brake_for(BrakeReason::NoRoomToTurn);
            return;
        }
        let to_heading_rad = side * turn.angle_rad;
        record.twist = twist;
        record.why = Why::TurningInPlace { direction: turn.side, to_heading_rad };
    }

    /// Brakes along the present arc if that is clear, else in the clear way nearest to it; false if
    /// there is none.
    pub(super) fn brake_clear(&self, record: &mut AvoidanceRecord, seen: &Seen) -> bool {
        let Seen { window, .. } = *seen;
        let (linear, angular) = (record.twist.linear_mps, record.twist.angular_radps);
        let spread = window.angular_hi_radps - window.angular_lo_radps;
        let clear = [0.0, 0.25, -0.25, 0.5, -0.5, 0.75, -0.75, 1.0, -1.0]
            .map(|share| angular + share * spread)
            .map(|w| Twist2::new(linear, w.clamp(window.angular_lo_radps, window.angular_hi_radps)))
            .into_iter()
            .find(|&twist| self.can_stop(twist, seen));
        record.twist = clear.unwrap_or(record.twist);
        clear.is_some()
    }

    pub(super) fn leave_obstacle(&self, record: &mut AvoidanceRecord, seen: &Seen) {
        let keep = self.keep(seen);
        let backs = seen.start.linear_mps < -AT_REST_MPS;
        if backs && self.back_out(record, seen) {
            return;
        }
        let body = GrownBox { growth_m: 0.0, ..self.body };
        let disc_m = self.body.growth_m;
        let clearance_m = record.clearance_m;
        // The round robot's clearance counts from its edge.
        let config =
            CvmConfig { obstacle_radius_m: self.config.obstacle_radius_m + disc_m, ..self.config.clone() };
        let bearing = record.goal_bearing_rad;
        let leave = |wholly| {
            let keeps = |twist| self.keeps(&keep, twist, seen);
            let clearance_m = clearance_m + disc_m;
            leave(&config, &seen.window, &body, clearance_m, bearing, seen.nearest_first, wholly, keeps)
        };
        let wholly = leave(true);
        if wholly.is_none() && self.back_out(record, seen) {
            return;
        }
        match wholly.or_else(|| leave(false)) {
            Some(twist) => {
                record.twist = twist;
                record.why = Why::LeavingObstacle { clearance_m };
            }
            None => record.why = Why::Braking { reason: BrakeReason::CannotGainClearance },
        }
    }

    /// Whether the exact braking motion of `command` keeps the body off every obstacle.
    pub(super) fn can_stop(&self, command: Twist2, seen: &Seen) -> bool {
        let outline = self.body.grown(self.config.obstacle_radius_m);
        self.motion(command, seen).is_clear(&outline, seen.nearest_first)
    }

    fn motion(&self, command: Twist2, seen: &Seen) -> BrakingMotion<'_> {
        self.braking(seen.current, seen.pending, command, seen.dt_s)
    }

    fn braking(&self, current: Twist2, pending: Twist2, command: Twist2, dt_s: f64) -> BrakingMotion<'_> {
        BrakingMotion {
            limits: &self.limits,
            current,
            pending,
            command,
            latency_s: self.config.latency_s,
            dt_s,
        }
    }

    pub(super) fn clearance_m(&self, point_in_robot: Point2) -> f64 {
        (self.body.distance(point_in_robot) - self.body.growth_m).max(0.0)
    }

    /// Of [`Self::nearest_first`], at least what `outline` could meet before rest, driven at any of `twists` and
    /// then braked.
    fn nearest_to_stop(
        &self,
        outline: &GrownBox,
        twists: [Twist2; 3],
        obstacles_in_robot: &[Point2],
        dt_s: f64,
    ) -> Vec<(f64, Point2)> {
        let speed_mps = twists.iter().map(|twist| twist.linear_mps.abs()).fold(0.0, f64::max);
        let rate_radps = twists.iter().map(|twist| twist.angular_radps.abs()).fold(0.0, f64::max);
        let rests_s = (speed_mps / self.limits.linear_mps2).max(rate_radps / self.limits.angular_radps2);
        // While it brakes it is half as fast as before, in the mean.
        let travels_m = speed_mps * (self.config.latency_s + dt_s + rests_s / 2.0);
        // And a little more: the outline is looked at grown, and numbers are rounded.
        let reach_m = outline.radius_m() + travels_m + 0.1;
        let near: Vec<Point2> =
            obstacles_in_robot.iter().copied().filter(|&p| p.dot(p) <= reach_m * reach_m).collect();
        self.nearest_first(&near)
    }

    /// Obstacles that any motion could meet, with their distances, nearest first.
    pub(super) fn nearest_first(&self, obstacles_in_robot: &[Point2]) -> Vec<(f64, Point2)> {
        let reach_m = self.config.horizon_m + self.outline.radius_m() + 0.5;
        let mut near: Vec<(f64, Point2)> =
            obstacles_in_robot.iter().map(|&p| (p.norm(), p)).filter(|&(d, _)| d <= reach_m).collect();
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        near
    }

    pub(super) fn refused(
        &self,
        error: &AvoidError,
        goal_bearing_rad: f64,
        goal_distance_m: f64,
    ) -> AvoidanceRecord {
        let window =
            Window { linear_lo_mps: 0.0, linear_hi_mps: 0.0, angular_lo_radps: 0.0, angular_hi_radps: 0.0 };
        AvoidanceRecord {
            window,
            goal_bearing_rad,
            goal_distance_m,
            clearance_m: f64::NAN,
            weights: self.config.weights(),
            guided: None,
            intervals: Vec::new(),
            candidates: Vec::new(),
            chosen: None,
            twist: Twist2::ZERO,
            why: Why::Braking { reason: BrakeReason::InputRefused { message: error.to_string() } },
        }
    }
}

/// What one choice looks at.
pub(super) struct Seen<'a> {
    pub current: Twist2,
    /// What the robot drives towards until this choice takes effect.
    pub pending: Twist2,
    /// How fast it runs when this choice takes effect.
    pub start: Twist2,
    pub dt_s: f64,
    pub window: Window,
    pub nearest_first: &'a [(f64, Point2)],
}

/// The side to which the robot turns in place now.
fn turning_side(current: Twist2) -> Option<Side> {
    let turns = current.linear_mps.abs() <= AT_REST_MPS && current.angular_radps.abs() > TURNING_RADPS;
    turns.then_some(if current.angular_radps > 0.0 { Side::Left } else { Side::Right })
}

/// As slow as the window allows, along the present arc: what was found clear before stays clear.
pub(super) fn brake(window: &Window, current: Twist2) -> Twist2 {
    let linear = window.linear_lo_mps;
    let arc = if current.linear_mps.abs() > AT_REST_MPS { linear / current.linear_mps.abs() } else { 0.0 };
    let angular = current.angular_radps * arc.min(1.0);
    Twist2::new(linear, angular.clamp(window.angular_lo_radps, window.angular_hi_radps))
}
