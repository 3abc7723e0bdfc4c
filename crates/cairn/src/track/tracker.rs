use serde::{Deserialize, Serialize};

use super::aim::Aim;
use super::lookahead::system_with;
use super::prediction::InFlight;
use super::{LookAhead, TrackError, Waypoints};
use crate::fuzzy::{Evaluation, FuzzyConfig, FuzzySystem};
use crate::geometry::{Point2, Pose2, Twist2};
use crate::robot::Limits;

/// The controller file: two fuzzy systems and what the tracker needs beside them.
///
/// The systems have no default: the numbers live in one readable file per robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrackerConfig {
    /// From a command to the motion that follows it, as the controller was tuned for \[s\].
    pub latency_s: f64,
    /// At rest within this distance of the goal, the robot has arrived \[m\].
    pub arrival_m: f64,
    /// Deceleration counted on for stopping at the goal, as a share of the limit, in (0, 1].
    pub braking_share: f64,
    /// Speed at which a robot off its path turns into it at a right angle \[m/s\].
    pub joining_mps: f64,
    /// Speed at which a right angle of the path is met that α1 and α2 do not show in time \[m/s\].
    pub corner_mps: f64,
    /// The robot is seen this share of a tick after a command takes hold: it holds for a whole one.
    pub hold_share: f64,
    /// `alpha1`, `alpha2` → `C`.
    pub look_ahead: FuzzyConfig,
    /// `C`, `dR`, `dtheta`, `Vc` → `V`, `omega`.
    pub tracker: FuzzyConfig,
}

/// What held a command back from what the rules asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cap {
    /// There is no path.
    NoPath,
    /// The robot stands at the goal.
    Arrived,
    /// So near to the goal that its bearing says nothing: straight on.
    AtGoal,
    /// V: the robot must be able to stop at the goal.
    BrakingDistance,
    /// V: the robot meets its path at an angle, and must be slow enough there to turn into it.
    JoiningPath,
    /// V: a sharp bend farther off than the look-ahead module sees, but within the braking distance.
    BendAhead,
    /// V is never negative.
    NoReversing,
    /// V: the speed that was asked for.
    CruiseSpeed,
    /// V: greatest speed of the robot.
    LinearSpeed,
    /// ω: greatest speed of the robot.
    AngularSpeed,
    /// V: what one tick can reach.
    LinearAcceleration,
    /// ω: what one tick can reach.
    AngularAcceleration,
    /// A pose, twist or duration was not a finite number: stop.
    MeasurementNotFinite,
}

/// One tick of tracking: what was seen, what the rules said, what was sent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrackingRecord {
    /// i of the current node N_i, counted from 0.
    pub waypoint_index: usize,
    /// What the robot heads for, one step ahead along the waypoints (N_{i+1} where that is a corner or
    /// the goal), world frame \[m\]; none without a path.
    pub target: Option<Point2>,
    /// Turn at N_{i+1} \[rad\].
    pub alpha1: f64,
    /// Turn at N_{i+2} \[rad\].
    pub alpha2: f64,
    /// Look-ahead curvature, in [0, 5].
    #[serde(rename = "C")]
    pub c: f64,
    /// Where the robot will be when the command takes hold: the pointer, dR and dθ are seen from there.
    pub world_from_robot_ahead: Pose2,
    /// Distance to the target \[m\].
    #[serde(rename = "dR")]
    pub dr_m: f64,
    /// Bearing of the target \[rad\].
    #[serde(rename = "dtheta")]
    pub dtheta_rad: f64,
    /// Current translational speed \[m/s\].
    #[serde(rename = "Vc")]
    pub vc_mps: f64,
    /// Way left to the goal along the waypoints \[m\].
    pub remaining_m: f64,
    /// Memberships and rule strengths of the first module.
    pub look_ahead: Option<Evaluation>,
    /// Memberships and rule strengths of the second module.
    pub tracker: Option<Evaluation>,
    /// V and ω as the rules gave them.
    pub raw: Twist2,
    /// What changed them, in order.
    pub caps: Vec<Cap>,
    /// The command.
    pub twist: Twist2,
    /// At rest at the goal.
    pub arrived: bool,
}

/// Below this speed the robot counts as at rest \[m/s\].
const AT_REST_MPS: f64 = 0.05;

/// Bends are looked for as far as a robot needs that brakes with this share of its deceleration.
const SHORTEST_BRAKING_SHARE: f64 = 0.5;

/// From the first of these bends on, joining a path costs speed; at the second, all it can \[rad\].
const JOINING_BENDS_RAD: [f64; 2] = [0.6, 1.2];

/// The path tracker: (V, ω) = f(C, dR, dθ, Vc) `[Maalouf06 (6)]`, along waypoints that may be
/// exchanged at any tick.
#[derive(Clone, Debug)]
pub struct Tracker {
    limits: Limits,
    latency_s: f64,
    arrival_m: f64,
    braking_mps2: f64,
    joining_mps: f64,
    corner_mps: f64,
    hold_share: f64,
    look_ahead: LookAhead,
    system: FuzzySystem,
    cruise_mps: f64,
    waypoints: Option<Waypoints>,
    index: usize,
    in_flight: InFlight,
    /// The command sent at the tick before; none when something else drove.
    last: Option<Twist2>,
}

/// Inputs and outputs of the second module in order of name.
const INPUTS: [&str; 4] = ["C", "Vc", "dR", "dtheta"];
const OUTPUTS: [&str; 2] = ["V", "omega"];

impl Tracker {
    /// A tracker without a path.
    ///
    /// # Errors
    /// [`TrackError`] names what is wrong with the controller.
    pub fn new(controller: &TrackerConfig, limits: &Limits) -> Result<Self, TrackError> {
        let check = |key: &str, value: f64, holds: bool, must_be: &str| {
            if value.is_finite() && holds {
                return Ok(());
            }
            Err(TrackError::TrackValueOutOfRange { key: key.to_owned(), value, must_be: must_be.to_owned() })
        };
        let &TrackerConfig {
            latency_s, arrival_m, braking_share, joining_mps, corner_mps, hold_share, ..
        } = controller;
        check("latency_s", latency_s, latency_s >= 0.0, "of at least 0")?;
        check("arrival_m", arrival_m, arrival_m > 0.0, "above 0")?;
        check("braking_share", braking_share, braking_share > 0.0 && braking_share <= 1.0, "in (0, 1]")?;
        check("joining_mps", joining_mps, joining_mps > 0.0, "above 0")?;
        check("corner_mps", corner_mps, corner_mps > 0.0, "above 0")?;
        check("hold_share", hold_share, (0.0..=1.0).contains(&hold_share), "in [0, 1]")?;
        Ok(Self {
            limits: *limits,
            latency_s,
            arrival_m,
            braking_mps2: limits.linear_mps2 * braking_share,
            joining_mps,
            corner_mps,
            hold_share,
            look_ahead: LookAhead::new(&controller.look_ahead)?,
            system: system_with("tracker", &controller.tracker, &INPUTS, &OUTPUTS)?,
            cruise_mps: f64::INFINITY,
            waypoints: None,
            index: 0,
            in_flight: InFlight::default(),
            last: None,
        })
    }

    /// The same tracker for a robot with another delay from command to motion \[s\].
    ///
    /// # Errors
    /// [`TrackError::TrackValueOutOfRange`] when it is negative or not finite.
    pub fn with_latency(mut self, latency_s: f64) -> Result<Self, TrackError> {
        if !(latency_s.is_finite() && latency_s >= 0.0) {
            return Err(TrackError::TrackValueOutOfRange {
                key: "latency_s".to_owned(),
                value: latency_s,
                must_be: "of at least 0".to_owned(),
            });
        }
        self.latency_s = latency_s;
        Ok(self)
    }

    /// The same tracker, never faster than `cruise_mps`.
    ///
    /// # Errors
    /// [`TrackError::TrackValueOutOfRange`] when it is not a finite number above 0.
    pub fn with_cruise(mut self, cruise_mps: f64) -> Result<Self, TrackError> {
        if !(cruise_mps.is_finite() && cruise_mps > 0.0) {
            return Err(TrackError::TrackValueOutOfRange {
                key: "cruise_mps".to_owned(),
                value: cruise_mps,
                must_be: "above 0".to_owned(),
            });
        }
        self.cruise_mps = cruise_mps;
        Ok(self)
    }

    /// Something else changed the last command before the robot got it.
    pub fn overridden(&mut self, sent: Twist2) {
        if self.last.is_some() {
            self.last = Some(sent);
            self.in_flight.replace_last(sent);
        }
    }

    /// Takes up `waypoints` from the first one on, now or while driving.
    pub fn follow(&mut self, waypoints: Waypoints) {
        self.waypoints = Some(waypoints);
        self.index = 0;
    }

    /// Forgets the path; the next steps brake.
    pub fn clear(&mut self) {
        self.waypoints = None;
        self.index = 0;
        self.rests();
    }

    /// The robot came to rest meanwhile: no command is in flight.
    pub fn rests(&mut self) {
        self.last = None;
        self.in_flight.forget();
    }

    /// The path being followed.
    pub fn waypoints(&self) -> Option<&Waypoints> {
        self.waypoints.as_ref()
    }

    /// i of the current node N_i, counted from 0.
    pub fn index(&self) -> usize {
        self.index
    }

    /// Makes waypoint `index` current, as after an avoidance; beyond the end, the goal.
    pub fn set_index(&mut self, index: usize) {
        self.last = None;
        self.in_flight.forget();
        self.index = self.waypoints.as_ref().map_or(0, |waypoints| index.min(waypoints.last_index()));
    }

    /// The pointer rule: forward while `position` is nearer to N_{i+1} than to N_i.
    pub fn advance_pointer(&mut self, position: Point2) {
        if let Some(waypoints) = &self.waypoints {
            self.index = waypoints.pointer_from(self.index, position);
        }
    }

    /// The first module.
    pub fn look_ahead(&self) -> &LookAhead {
        &self.look_ahead
    }

    /// The second module: inputs `C`, `Vc`, `dR`, `dtheta`, outputs `V`, `omega`.
    pub fn system(&self) -> &FuzzySystem {
        &self.system
    }

    /// The command for the next `dt_s`, and how it came about. `current` is the measured twist.
    ///
    /// With a measurement that is not a finite number the command is to stand still, and the record
    /// says so; [`Self::try_step`] gives an error instead.
    pub fn step(&mut self, world_from_robot: Pose2, current: Twist2, dt_s: f64) -> TrackingRecord {
        self.try_step(world_from_robot, current, dt_s).unwrap_or_else(|_| {
            self.last = Some(Twist2::ZERO);
            self.in_flight.send(Twist2::ZERO);
            let mut record = TrackingRecord::blank(self.index, world_from_robot, current);
            record.caps.push(Cap::MeasurementNotFinite);
            record
        })
    }

    /// As [`Self::step`].
    ///
    /// # Errors
    /// [`TrackError::MeasurementNotFinite`] names the first number that is not finite;
    /// [`TrackError::TimeStepInvalid`]: the duration is not above 0.
    pub fn try_step(
        &mut self,
        world_from_robot: Pose2,
        current: Twist2,
        dt_s: f64,
    ) -> Result<TrackingRecord, TrackError> {
        check_measured(world_from_robot, current, dt_s)?;

        // The command sent last, as far as the robot can still be on its way to it: what is measured
        // lags behind by the latency and a tick or two.
        let lag_s = self.latency_s + 2.0 * dt_s;
        let base = self.last.map_or(current, |last| self.limits.reachable(current, last, lag_s));
        self.in_flight.pass(dt_s, self.latency_s);
        // A command holds for a tick: it is aimed at the middle of that.
        let (ahead, _) = self.in_flight.predicted(
            &self.limits,
            self.latency_s,
            self.hold_share * dt_s,
            world_from_robot,
            current,
        );

        self.advance_pointer(ahead.position());
        let mut record = TrackingRecord::blank(self.index, ahead, current);
        let mut wanted = Twist2::ZERO;
        if let Some(waypoints) = &self.waypoints {
            let Aim { target, left_m } = waypoints.aim(self.index, ahead.position());
            record.target = Some(target);
            (record.alpha1, record.alpha2) = LookAhead::angles(waypoints, self.index);
            let (c, look_ahead) = self.look_ahead.curvature(record.alpha1, record.alpha2)?;
            record.c = c;
            record.look_ahead = Some(look_ahead);
            record.dr_m = ahead.position().distance(target);
            record.dtheta_rad = ahead.bearing_to(target);
            record.remaining_m = record.dr_m + left_m;
            let inputs = [c, record.vc_mps, record.dr_m, record.dtheta_rad];
            let said = self
                .system
                .evaluate(&inputs)
                .map_err(|cause| TrackError::ControllerInvalid { system: "tracker".to_owned(), cause })?;
            record.raw = Twist2::new(said.outputs["V"], said.outputs["omega"]);
            record.tracker = Some(said);
            let last_leg = left_m == 0.0;
            let (bending, why) = self.bending_speed(waypoints, ahead.position());
            wanted = self.arriving(&mut record, last_leg, dt_s);
            if wanted.linear_mps > bending {
                wanted.linear_mps = bending;
                record.caps.push(why);
            }
            if wanted.linear_mps > self.cruise_mps {
                wanted.linear_mps = self.cruise_mps;
                record.caps.push(Cap::CruiseSpeed);
            }
        } else {
            record.caps.push(Cap::NoPath);
        }
        record.twist = self.within_limits(&mut record.caps, base, wanted, dt_s);
        self.last = Some(record.twist);
        self.in_flight.send(record.twist);
        Ok(record)
    }

    /// What the rules asked for, held to what lets the robot come to rest at the goal.
    fn arriving(&self, record: &mut TrackingRecord, last_leg: bool, dt_s: f64) -> Twist2 {
        let mut wanted = record.raw;
        let mut left_m = record.remaining_m;
        if last_leg && record.dr_m <= self.arrival_m {
            left_m = record.dr_m * record.dtheta_rad.cos().max(0.0);
            wanted.angular_radps = 0.0;
            record.arrived = record.vc_mps.abs() < AT_REST_MPS;
            record.caps.push(if record.arrived { Cap::Arrived } else { Cap::AtGoal });
        }
        // v·T + v²/2a = way left: one tick at v until the next command, then braking.
        let (a, tick_s) = (self.braking_mps2, 1.5 * dt_s);
        let stoppable = a * ((tick_s * tick_s + 2.0 * left_m / a).sqrt() - tick_s);
        if wanted.linear_mps > stoppable {
            wanted.linear_mps = stoppable;
            record.caps.push(Cap::BrakingDistance);
        }
        wanted
    }

    /// Speed from which a robot at `position` can brake for every sharp bend that α1 and α2 do not
    /// show: the one at N_{i+1} where it joins its path, and those beyond N_{i+2}.
    ///
    /// A right angle has to be met at [`TrackerConfig::joining_mps`] or [`TrackerConfig::corner_mps`]
    /// half a step before it, where the pointer moves on.
    fn bending_speed(&self, waypoints: &Waypoints, position: Point2) -> (f64, Cap) {
        let (target, beyond) = (waypoints.at(self.index + 1), waypoints.at(self.index + 2));
        let (arriving, leaving) = (target - position, beyond - target);
        let mut along_m = arriving.norm();
        let bend = arriving.cross(leaving).atan2(arriving.dot(leaving)).abs();
        let joining = self.speed_before(self.joining_mps, bend, along_m - leaving.norm() / 2.0);
        let mut least = (joining, Cap::JoiningPath);
        let in_sight_m = self.limits.braking_distance_m(self.limits.linear_mps) / SHORTEST_BRAKING_SHARE;
        let mut from = target;
        for index in self.index + 2..waypoints.last_index() {
            let to = waypoints.at(index);
            along_m += from.distance(to);
            if along_m > in_sight_m {
                break;
            }
            if index > self.index + 2 {
                let half_step_m = to.distance(waypoints.at(index + 1)) / 2.0;
                let turn = waypoints.turn_rad(index);
                let speed = self.speed_before(self.corner_mps, turn, along_m - half_step_m);
                if speed < least.0 {
                    least = (speed, Cap::BendAhead);
                }
            }
            from = to;
        }
        least
    }

    /// Speed from which the robot can brake, on `free_m`, to what a bend allows: `right_angle_mps` where
    /// it is a right angle, more where it is less.
    fn speed_before(&self, right_angle_mps: f64, bend_rad: f64, free_m: f64) -> f64 {
        let [slight, full] = JOINING_BENDS_RAD;
        if bend_rad <= slight {
            return f64::INFINITY;
        }
        let share = ((bend_rad - slight) / (full - slight)).min(1.0);
        let there = self.limits.linear_mps + (right_angle_mps - self.limits.linear_mps) * share;
        (there * there + 2.0 * self.braking_mps2 * free_m.max(0.0)).sqrt()
    }

    fn within_limits(&self, caps: &mut Vec<Cap>, base: Twist2, mut wanted: Twist2, dt_s: f64) -> Twist2 {
        if wanted.linear_mps < 0.0 {
            wanted.linear_mps = 0.0;
            caps.push(Cap::NoReversing);
        }
        if wanted.linear_mps > self.limits.linear_mps {
            caps.push(Cap::LinearSpeed);
        }
        if wanted.angular_radps.abs() > self.limits.angular_radps {
            caps.push(Cap::AngularSpeed);
        }
        let sent = self.limits.reachable(base, wanted, dt_s);
        let limited = self.limits.reachable(base, wanted, f64::INFINITY);
        if sent.linear_mps != limited.linear_mps {
            caps.push(Cap::LinearAcceleration);
        }
        if sent.angular_radps != limited.angular_radps {
            caps.push(Cap::AngularAcceleration);
        }
        Twist2::new(sent.linear_mps.max(0.0), sent.angular_radps)
    }
}

impl TrackingRecord {
    fn blank(waypoint_index: usize, world_from_robot_ahead: Pose2, current: Twist2) -> Self {
        Self {
            waypoint_index,
            target: None,
            alpha1: 0.0,
            alpha2: 0.0,
            c: 0.0,
            world_from_robot_ahead,
            dr_m: 0.0,
            dtheta_rad: 0.0,
            vc_mps: current.linear_mps,
            remaining_m: 0.0,
            look_ahead: None,
            tracker: None,
            raw: Twist2::ZERO,
            caps: Vec::new(),
            twist: Twist2::ZERO,
            arrived: false,
        }
    }
}

fn check_measured(world_from_robot: Pose2, current: Twist2, dt_s: f64) -> Result<(), TrackError> {
    for (what, value) in [
        ("x of the pose", world_from_robot.x),
        ("y of the pose", world_from_robot.y),
        ("heading of the pose", world_from_robot.heading),
        ("linear speed", current.linear_mps),
        ("angular speed", current.angular_radps),
    ] {
        if !value.is_finite() {
            return Err(TrackError::MeasurementNotFinite { what: what.to_owned(), value });
        }
    }
    if dt_s.is_finite() && dt_s > 0.0 { Ok(()) } else { Err(TrackError::TimeStepInvalid { dt_s }) }
}
