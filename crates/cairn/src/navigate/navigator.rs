//! The navigator: one call per tick, locate → map → mode → track or avoid, one record out.

use serde::Serialize;
use thiserror::Error;

use super::caution::{Caution, cautious};
use super::config::NavigatorConfig;
use super::planning::{Planner, Refusal, WorldField};
use super::record::{Decision, PlanRecord, Story, Task, TaskStatus};
use super::strategy::{Event, Mode, Reason, Strategy};
use super::trap::{TrapEvidence, TrapWatch};
use super::way::{Look, WayAhead, first_free, look_ahead};
use crate::avoid::{AvoidError, AvoidanceRecord, Cvm};
use crate::geometry::{Point2, Pose2, Twist2};
use crate::locate::{MapMatcher, MatchReport, MatchingError, Odometry, OdometryError, WheelTravel};
use crate::robot::{Footprint, Limits, RobotProfile};
use crate::track::{TrackError, Tracker, TrackerConfig, TrackingRecord, Waypoints};
use crate::world::{Grid, GridGeometry, MappingError, Occupancy, OccupancyGrid, OccupancyMap};

/// What the robot measured since the last tick.
#[derive(Clone, Copy, Debug)]
pub struct TickInput<'a> {
    /// One reading per sonar, then per lidar beam \[m\]; infinite for no echo, NaN for not measured.
    pub ranges_m: &'a [f64],
    /// Way of each side's wheels since the last tick.
    pub wheels: WheelTravel,
    /// Mean yaw rate since the last tick \[rad/s\], if there is a gyroscope.
    pub gyro_radps: Option<f64>,
    /// Time since the last tick \[s\].
    pub dt_s: f64,
    /// The pose, where something else knows it better.
    pub world_from_robot: Option<Pose2>,
}

/// What a navigator refuses, and why.
#[derive(Clone, Debug, PartialEq, Error, Serialize)]
pub enum NavigateError {
    /// The array of ranges has another length than the profile.
    #[error(
        "{given} ranges given, the profile has {expected} sensors: give one reading for each, NaN where there is none"
    )]
    RangeCountWrong {
        /// Number given.
        given: usize,
        /// Number of sensors.
        expected: usize,
    },
    /// A range is negative.
    #[error(
        "range {index} is {value} m: ranges are metres from the sensor, inf for no echo, NaN for not measured"
    )]
    RangeNegative {
        /// Which.
        index: usize,
        /// What was given.
        value: f64,
    },
    /// A tick's duration is not positive.
    #[error("dt is {dt_s} s: it must be a finite number greater than 0")]
    TimeStepInvalid {
        /// What was given.
        dt_s: f64,
    },
    /// A measurement is not a number.
    #[error("{what} is {value}: it must be a finite number")]
    MeasurementNotFinite {
        /// Which.
        what: String,
        /// What was given.
        value: f64,
    },
    /// A goal is not a place.
    #[error("goal ({x_m}, {y_m}) m is no place: both must be finite numbers")]
    GoalNotFinite {
        /// What was given \[m\].
        x_m: f64,
        /// What was given \[m\].
        y_m: f64,
    },
    /// A setting is out of range.
    #[error("navigator setting {key} is {value}: it must be a finite number greater than 0")]
    NavigatorSettingInvalid {
        /// Dotted key.
        key: String,
        /// What was given.
        value: f64,
    },
    /// The tracker refused its part.
    #[error(transparent)]
    #[serde(untagged)]
    Track(#[from] TrackError),
    /// The avoider refused its part.
    #[error(transparent)]
    #[serde(untagged)]
    Avoid(#[from] AvoidError),
    /// The odometry refused its part.
    #[error(transparent)]
    #[serde(untagged)]
    Odometry(#[from] OdometryError),
    /// The map matcher refused its part.
    #[error(transparent)]
    #[serde(untagged)]
    Matching(#[from] MatchingError),
    /// The mapper refused its part.
    #[error(transparent)]
    #[serde(untagged)]
    Mapping(#[from] MappingError),
}

/// What the robot perceived this tick, before it is reduced to an event.
#[derive(Clone, Debug, Default)]
struct Percept {
    way: Option<WayAhead>,
    trap: Option<TrapEvidence>,
}

/// Plans, tracks, avoids and arrives.
#[derive(Clone, Debug)]
pub struct Navigator {
    profile: RobotProfile,
    config: NavigatorConfig,
    body: Footprint,
    strategy: Strategy,
    odometry: Odometry,
    map: OccupancyMap,
    matcher: Option<MapMatcher>,
    map_given: bool,
    pose_known: bool,
    tracker: Tracker,
    cvm: Cvm,
    trap: TrapWatch,
    mode: Mode,
    task: Option<Task>,
    status: TaskStatus,
    asked: Option<Event>,
    field: Option<WorldField>,
    shared: bool,
    path: Vec<Point2>,
    waypoints: Vec<Point2>,
    intermediate: Option<usize>,
    outcome: Option<Result<(), Refusal>>,
    refusal: Option<Refusal>,
    plan_wanted: bool,
    avoiding_s: f64,
    unsafe_command: bool,
    plan_count: u32,
    fruitless: u32,
    planned_at: Option<Point2>,
    last_plan: Option<PlanRecord>,
    commanded: Twist2,
    tick: u64,
    time_s: f64,
}

/// Slower than this in both speeds is at rest \[m/s, rad/s\].
const AT_REST: Twist2 = Twist2::new(0.02, 0.03);
/// A robot that moved less than this since its last plan gained nothing by it \[m\].
const FRUITLESS_M: f64 = 0.3;

impl Navigator {
    /// A navigator at rest in Stop.
    ///
    /// `world` is the map to plan on, if there is one; `start` the pose in it, `world_from_robot`, if
    /// known. Without a start the frame begins at the robot and a given map is not used until
    /// [`TickInput::world_from_robot`] tells the pose.
    ///
    /// # Errors
    /// [`NavigateError`] names the first setting that is not usable.
    pub fn new(
        profile: RobotProfile,
        controller: &TrackerConfig,
        config: NavigatorConfig,
        world: Option<&OccupancyGrid>,
        start: Option<Pose2>,
    ) -> Result<Self, NavigateError> {
        if let Some((key, value)) = config.bad_length() {
            return Err(NavigateError::NavigatorSettingInvalid { key: key.to_owned(), value });
        }
        let map = match world {
            Some(prior) => OccupancyMap::from_occupancy(&config.mapping, prior)?,
            None => OccupancyMap::new(&config.mapping, config.resolution_m)?,
        };
        let matcher = match world {
            Some(prior) if config.match_map => Some(MapMatcher::new(&config.matching, prior)?),
            _ => None,
        };
        let body = Footprint {
            length_m: profile.footprint.length_m + 2.0 * config.clearance_m,
            width_m: profile.footprint.width_m + 2.0 * config.clearance_m,
        };
        Ok(Self {
            odometry: Odometry::new(&config.odometry, &profile.drive, start.unwrap_or_default())?,
            tracker: Tracker::new(controller, &profile.limits)?.with_latency(profile.drive.latency_s)?,
            cvm: Cvm::new(&config.avoidance, &profile.limits, &profile.footprint)?,
            trap: TrapWatch::new(config.trap),
            body,
            strategy: Strategy::paper(),
            map,
            matcher,
            map_given: world.is_some(),
            pose_known: start.is_some(),
            mode: Mode::Stop,
            task: None,
            status: TaskStatus::Idle,
            asked: None,
            field: None,
            shared: false,
            path: Vec::new(),
            waypoints: Vec::new(),
            intermediate: None,
            outcome: None,
            refusal: None,
            plan_wanted: false,
            avoiding_s: 0.0,
            unsafe_command: false,
            plan_count: 0,
            fruitless: 0,
            planned_at: None,
            last_plan: None,
            commanded: Twist2::ZERO,
            tick: 0,
            time_s: 0.0,
            profile,
            config,
        })
    }

    /// Asks for a point of the world. While moving, the robot first comes to rest.
    ///
    /// `field` is a field for the same goal that another navigator solved; then none is solved here
    /// until something unknown to it forces a new plan.
    ///
    /// # Errors
    /// [`NavigateError::GoalNotFinite`].
    pub fn set_goal(&mut self, goal: Point2, field: Option<WorldField>) -> Result<(), NavigateError> {
        if !goal.is_finite() {
            return Err(NavigateError::GoalNotFinite { x_m: goal.x, y_m: goal.y });
        }
        self.begin(Task::Goal { point: goal });
        self.shared = field.is_some();
        self.field = field;
        Ok(())
    }

    /// Asks to see what is unknown, without a goal `[Maalouf06 §1]`.
    pub fn explore(&mut self) {
        self.begin(Task::Explore);
    }

    /// Ends the task; the robot brakes to rest.
    pub fn cancel(&mut self) {
        self.asked = Some(Event::Cancelled);
    }

    fn begin(&mut self, task: Task) {
        self.asked = Some(Event::NewTask);
        self.task = Some(task);
        self.status = TaskStatus::Driving;
        self.plan_wanted = false;
        self.fruitless = 0;
        self.planned_at = None;
        self.field = None;
        self.shared = false;
    }

    /// One tick: what was measured in, everything decided out.
    ///
    /// # Errors
    /// [`NavigateError`] for input that cannot be a measurement; nothing has changed then.
    pub fn step(&mut self, input: &TickInput<'_>) -> Result<Decision, NavigateError> {
        self.check(input)?;
        self.tick += 1;
        self.time_s += input.dt_s;
        let matching = self.locate(input)?;
        let pose = self.odometry.pose();
        self.map.integrate(pose, &self.profile, input.ranges_m)?;
        self.free_own_place(pose);

        let mode_before = self.mode;
        let (event, percept) = self.perceive(input.dt_s);
        let (mode, reason) = self.strategy.step(mode_before, event);
        let plan = self.enter(mode, reason);
        self.avoiding_s = if mode == Mode::ObstacleAvoidance { self.avoiding_s + input.dt_s } else { 0.0 };

        let mut rewalked = false;
        let mut tracking: Option<TrackingRecord> = None;
        let mut avoidance: Option<AvoidanceRecord> = None;
        let measured = self.odometry.twist();
        let twist = match mode {
            Mode::Stop | Mode::PathPlanning => braking(&self.profile.limits, self.commanded, input.dt_s),
            Mode::PathTracking => {
                rewalked = self.rewalk_if_off_path(pose);
                let record = self.tracker.step(pose, measured, input.dt_s);
                let obstacles = self.obstacles_in_robot(pose);
                self.unsafe_command =
                    !self.cvm.keeps_clear(measured, self.commanded, record.twist, &obstacles, input.dt_s);
                let twist = if self.unsafe_command {
                    let bearing_rad = record.target.map_or(0.0, |target| pose.bearing_to(target));
                    let instead = self.cvm.choose_after(
                        measured,
                        Some(self.commanded),
                        bearing_rad,
                        f64::INFINITY,
                        &obstacles,
                        input.dt_s,
                    );
                    let twist = instead.twist;
                    avoidance = Some(instead);
                    twist
                } else {
                    record.twist
                };
                tracking = Some(record);
                twist
            }
            Mode::ObstacleAvoidance => {
                let record = self.avoid(pose, measured, input.dt_s);
                let twist = record.twist;
                avoidance = Some(record);
                twist
            }
        };

        let (twist, caution) = self.within_sight(pose, twist, input.dt_s);
        self.commanded = twist;

        let waypoint_index = (!self.waypoints.is_empty()).then(|| self.tracker.index());
        let intermediate = if mode == Mode::ObstacleAvoidance { self.intermediate } else { None };
        let sentence = Story {
            mode,
            reason,
            task: self.task,
            status: self.status,
            way: percept.way.as_ref(),
            trap: percept.trap.as_ref(),
            plan: plan.as_ref().or(self.last_plan.as_ref()),
            position: pose.position(),
            waypoint_index,
            intermediate,
        }
        .sentence();
        Ok(Decision {
            tick: self.tick - 1,
            time_s: self.time_s,
            pose,
            covariance: self.odometry.covariance(),
            measured,
            matching,
            mode_before,
            event,
            mode,
            reason,
            sentence,
            task: self.task,
            status: self.status,
            waypoint_index,
            intermediate,
            way: percept.way,
            trap: percept.trap,
            rewalked,
            cost_to_go: self.field.as_ref().and_then(|field| field.cost_to_go(pose.position())),
            plan,
            tracking,
            avoidance,
            caution,
            limits: self.profile.limits,
            twist,
        })
    }

    fn check(&self, input: &TickInput<'_>) -> Result<(), NavigateError> {
        let expected = self.profile.range_count();
        if input.ranges_m.len() != expected {
            return Err(NavigateError::RangeCountWrong { given: input.ranges_m.len(), expected });
        }
        if let Some((index, &value)) = input.ranges_m.iter().enumerate().find(|(_, r)| **r < 0.0) {
            return Err(NavigateError::RangeNegative { index, value });
        }
        if !(input.dt_s.is_finite() && input.dt_s > 0.0) {
            return Err(NavigateError::TimeStepInvalid { dt_s: input.dt_s });
        }
        let pose = input.world_from_robot.unwrap_or_default();
        let measurements = [
            ("left wheels' way", input.wheels.left_m),
            ("right wheels' way", input.wheels.right_m),
            ("gyro rate", input.gyro_radps.unwrap_or(0.0)),
            ("pose x", pose.x),
            ("pose y", pose.y),
            ("pose heading", pose.heading),
        ];
        match measurements.into_iter().find(|(_, value)| !value.is_finite()) {
            Some((what, value)) => Err(NavigateError::MeasurementNotFinite { what: what.to_owned(), value }),
            None => Ok(()),
        }
    }

    /// Encoders and gyroscope, then the given pose, or else the given map, correct the estimate.
    fn locate(&mut self, input: &TickInput<'_>) -> Result<Option<MatchReport>, NavigateError> {
        self.odometry.predict(input.wheels, input.gyro_radps, input.dt_s)?;
        if let Some(pose) = input.world_from_robot {
            self.odometry.set_pose(pose)?;
            self.pose_known = true;
            return Ok(None);
        }
        Ok(match &self.matcher {
            Some(matcher) if self.pose_known => {
                Some(matcher.correct(&mut self.odometry, &self.profile, input.ranges_m)?)
            }
            _ => None,
        })
    }

    /// Nothing but the robot stands where the robot stands, whatever an echo's arc said.
    fn free_own_place(&mut self, pose: Pose2) {
        let Footprint { length_m, width_m } = self.profile.footprint;
        let cell_m = self.map.geometry().resolution_m;
        let along = |length: f64| (length / cell_m).ceil() as i32;
        let (n, m) = (along(length_m), along(width_m));
        for i in 0..=n {
            for j in 0..=m {
                let x = length_m * (f64::from(i) / f64::from(n) - 0.5);
                let y = width_m * (f64::from(j) / f64::from(m) - 0.5);
                self.map.clear_disc(pose * Point2::new(x, y), cell_m / 2.0);
            }
        }
    }

    /// Reduces what is known now to the event that matters most in this mode.
    fn perceive(&mut self, dt_s: f64) -> (Event, Percept) {
        let mut percept = Percept::default();
        if let Some(event) = self.asked.take() {
            return (event, percept);
        }
        let event = match self.mode {
            Mode::Stop => self.perceive_at_rest(),
            Mode::PathPlanning => match self.outcome.take() {
                Some(Ok(())) => Event::PlanFound,
                Some(Err(_)) => Event::GoalUnattainable,
                None => Event::Nothing,
            },
            Mode::PathTracking => self.perceive_tracking(dt_s, &mut percept),
            Mode::ObstacleAvoidance => self.perceive_avoiding(dt_s, &mut percept),
        };
        (event, percept)
    }

    fn perceive_at_rest(&self) -> Event {
        let measured = self.odometry.twist();
        let at_rest = measured.linear_mps.abs() < AT_REST.linear_mps
            && measured.angular_radps.abs() < AT_REST.angular_radps;
        match self.task {
            None => Event::Nothing,
            Some(_) if !at_rest => Event::Nothing,
            Some(Task::Goal { .. }) if self.map_given && self.pose_known => Event::ReadyToPlan,
            Some(_) if self.plan_wanted => Event::ReadyToPlan,
            Some(_) => Event::ReadyToAvoid,
        }
    }

    fn perceive_tracking(&mut self, dt_s: f64, percept: &mut Percept) -> Event {
        let position = self.odometry.pose().position();
        self.tracker.advance_pointer(position);
        let trap = self.trap.step(position, self.way_to_go_m(position, self.next_waypoint()), dt_s);
        percept.trap = Some(trap);
        if self.arrived(position) {
            return Event::Arrived;
        }
        let way = self.look(position, self.next_waypoint());
        let event = match (way.blocked, way.free_beyond) {
            (Some(_), Some(free)) => {
                self.intermediate = Some(free);
                Event::ObstacleAhead
            }
            (Some(_), None) => Event::AllWaypointsBlocked,
            (None, _) if std::mem::take(&mut self.unsafe_command) => {
                let ahead = self.first_beyond(position, 2.0 * self.config.intermediate_reach_m);
                self.intermediate = Some(ahead);
                Event::ObstacleAhead
            }
            (None, _) if trap.revisited.is_some() => Event::RegionVisitedTwice,
            (None, _) if trap.stuck => Event::LocalMinimum,
            (None, _) => Event::Nothing,
        };
        percept.way = Some(way);
        event
    }

    fn perceive_avoiding(&mut self, dt_s: f64, percept: &mut Percept) -> Event {
        let position = self.odometry.pose().position();
        if self.arrived(position) {
            return Event::Arrived;
        }
        let Some(intermediate) = self.intermediate else {
            // No path: towards the goal, or exploring, where driving on is the progress.
            let to_go_m = match self.task {
                Some(Task::Goal { point }) => position.distance(point),
                _ => -percept.trap.map_or(0.0, |trap| trap.driven_m),
            };
            let trap = self.trap.step(position, to_go_m, dt_s);
            percept.trap = Some(trap);
            return if trap.revisited.is_some() {
                Event::RegionVisitedTwice
            } else if trap.stuck {
                Event::LocalMinimum
            } else {
                Event::Nothing
            };
        };

        let unplanned = self.unplanned_near(position);
        let Some(free) = first_free(&self.waypoints, intermediate, &unplanned, self.free_radius_m()) else {
            return Event::AllWaypointsBlocked;
        };
        if free != intermediate {
            self.intermediate = Some(free);
            self.trap.restart_progress();
        }
        let trap = self.trap.step(position, self.way_to_go_m(position, free), dt_s);
        percept.trap = Some(trap);
        if self.reached(position, free) || self.sees_straight_to(position, free) {
            let way = self.look(position, (free + 1).min(self.waypoints.len() - 1));
            let event = match (way.blocked, way.free_beyond) {
                (None, _) => Event::WayClear,
                (Some(_), Some(next)) => {
                    self.intermediate = Some(next);
                    self.trap.restart_progress();
                    Event::ObstacleAhead
                }
                (Some(_), None) => Event::AllWaypointsBlocked,
            };
            percept.way = Some(way);
            return event;
        }
        if trap.revisited.is_some() {
            Event::RegionVisitedTwice
        } else if trap.stuck {
            Event::LocalMinimum
        } else {
            Event::Nothing
        }
    }

    /// What changes when `mode` is entered for `reason`.
    fn enter(&mut self, mode: Mode, reason: Reason) -> Option<PlanRecord> {
        let entered = mode != self.mode;
        self.mode = mode;
        match reason {
            Reason::Cancelled => {
                self.task = None;
                self.status = TaskStatus::Cancelled;
            }
            Reason::GoalUnattainable if entered => {
                self.task = None;
                if let Some(refusal) = self.refusal.take() {
                    self.status = TaskStatus::Refused { refusal };
                }
            }
            Reason::Arrived if entered && matches!(self.task, Some(Task::Goal { .. })) => {
                self.task = None;
                self.status = TaskStatus::Reached;
            }
            Reason::Arrived if entered => self.plan_wanted = false,
            Reason::RegionVisitedTwice | Reason::LocalMinimum | Reason::NoFreeWaypoint if entered => {
                self.plan_wanted = true;
                self.field = None;
                self.shared = false;
            }
            Reason::NoMapOrPose if entered => {
                self.intermediate = None;
                self.trap.restart();
            }
            Reason::PathFound if entered => self.trap.restart(),
            Reason::ObstacleOnPath if entered => self.trap.restart_progress(),
            Reason::WayClear if entered => {
                if let Some(index) = self.intermediate.take() {
                    self.tracker.set_index(index);
                }
                self.trap.restart_progress();
            }
            _ => {}
        }
        if mode == Mode::Stop {
            self.intermediate = None;
        }
        (mode == Mode::PathPlanning && entered).then(|| self.plan())
    }

    /// Solves a field, or takes the shared one, and walks it from where the robot is.
    fn plan(&mut self) -> PlanRecord {
        let shared = self.field.is_some() && self.shared;
        let result = self.solve_or_share().and_then(|field| {
            self.field = Some(field);
            self.walk(self.odometry.pose())
        });
        let refusal = result.as_ref().err().copied();
        if let Some(refusal) = refusal {
            self.refusal = Some(refusal);
            self.path.clear();
            self.waypoints.clear();
        }
        self.outcome = Some(result);
        let position = self.odometry.pose().position();
        let record = PlanRecord {
            plan_count: self.plan_count,
            shared,
            cost_to_go: self.field.as_ref().and_then(|field| field.cost_to_go(position)),
            path_length_m: refusal.is_none().then(|| length_m(&self.path)),
            waypoints: self.waypoints.len(),
            refusal,
        };
        self.last_plan = Some(record.clone());
        record
    }

    fn solve_or_share(&mut self) -> Result<WorldField, Refusal> {
        if let (Some(field), true) = (&self.field, self.shared) {
            return Ok(field.clone());
        }
        let pose = self.odometry.pose();
        let moved = self.planned_at.is_none_or(|last| last.distance(pose.position()) >= FRUITLESS_M);
        self.fruitless = if moved { 0 } else { self.fruitless + 1 };
        self.planned_at = Some(pose.position());
        if self.fruitless >= self.config.fruitless_plans {
            return Err(Refusal::NoProgress { plans: self.fruitless + 1 });
        }
        self.plan_count += 1;
        let planner =
            Planner { footprint: self.body, config: &self.config.costmap, escape_m: self.config.escape_m };
        match self.task {
            Some(Task::Goal { point }) => {
                let occupancy = self.map_around(&[pose.position(), point]);
                planner.solve(&occupancy, point)
            }
            _ => planner.solve_frontiers(&self.map_around(&[pose.position()]), pose.position()),
        }
    }

    /// The map as it is now; with none given, it reaches at least a margin around `points`.
    fn map_around(&self, points: &[Point2]) -> OccupancyGrid {
        let occupancy = self.map.occupancy();
        if self.map_given && self.pose_known {
            return occupancy;
        }
        padded(&occupancy, points, self.config.open_margin_m)
    }

    /// Walks the field from `pose` and hands the waypoints to the tracker.
    fn walk(&mut self, pose: Pose2) -> Result<(), Refusal> {
        let Some(field) = &self.field else { return Err(Refusal::NoPath) };
        let path = field.path(pose, &self.profile.footprint, self.config.escape_m)?;
        let waypoints = Waypoints::from_path(&path, &self.config.waypoints, |a, b| field.is_clear(a, b))
            .map_err(|_| Refusal::NoPath)?;
        self.path = path;
        self.waypoints = waypoints.points().to_vec();
        self.tracker.follow(waypoints);
        Ok(())
    }

    /// Far off the path: the pointers of the field are walked anew, without a new plan.
    fn rewalk_if_off_path(&mut self, pose: Pose2) -> bool {
        let position = pose.position();
        let index = self.tracker.index();
        let around = index.saturating_sub(3)..(index + 4).min(self.waypoints.len());
        let off_m = self.waypoints[around]
            .windows(2)
            .map(|pair| position.distance_to_segment(pair[0], pair[1]))
            .fold(f64::INFINITY, f64::min);
        let off = self.waypoints.len() > 1 && off_m > self.config.off_path_m;
        off && self.walk(pose).is_ok()
    }

    /// The curvature velocity method towards the intermediate goal, the goal, or straight on.
    fn avoid(&mut self, pose: Pose2, measured: Twist2, dt_s: f64) -> AvoidanceRecord {
        let position = pose.position();
        let final_index = self.waypoints.len().saturating_sub(1);
        let (bearing_rad, distance_m) = match (self.intermediate, self.task) {
            (Some(index), _) if index < final_index => {
                (pose.bearing_to(self.waypoints[index]), f64::INFINITY)
            }
            (_, Some(Task::Goal { point })) => (pose.bearing_to(point), position.distance(point)),
            _ => (0.0, f64::INFINITY),
        };
        let obstacles = self.obstacles_in_robot(pose);
        self.cvm.choose_after(measured, Some(self.commanded), bearing_rad, distance_m, &obstacles, dt_s)
    }

    /// Centres of the occupied cells that any motion could meet, robot frame \[m\].
    fn obstacles_in_robot(&self, pose: Pose2) -> Vec<Point2> {
        let robot_from_world = pose.inverse();
        let reach_m = self.config.avoidance.horizon_m + self.profile.footprint.circumscribed_radius_m();
        self.map.occupied_near(pose.position(), reach_m).into_iter().map(|p| robot_from_world * p).collect()
    }

    /// `twist`, no faster than can be stopped inside what was seen.
    fn within_sight(&self, pose: Pose2, twist: Twist2, dt_s: f64) -> (Twist2, Option<Caution>) {
        let delay_s = self.profile.drive.latency_s + dt_s;
        let Self { config, profile, map, .. } = self;
        let geometry = map.geometry();
        let is_seen = |point: Point2| {
            geometry.cell_at(point).is_some_and(|c| map.classes()[geometry.index(c)] != Occupancy::Unknown)
        };
        cautious(&config.caution, &profile.limits, &profile.footprint, delay_s, is_seen, pose, twist)
    }

    /// Occupied now, near the robot, and not so when the plan was made.
    fn unplanned_near(&self, position: Point2) -> Vec<Point2> {
        let near = self.map.occupied_near(position, 5.0);
        match &self.field {
            Some(field) => near
                .into_iter()
                .filter(|&p| !field.occupied.at_point(p).is_some_and(|known| *known))
                .collect(),
            None => near,
        }
    }

    fn look(&self, position: Point2, next: usize) -> WayAhead {
        let speed_mps = self.odometry.twist().linear_mps;
        let limits = &self.profile.limits;
        let look = Look {
            waypoints: 3,
            length_m: limits.braking_distance_m(speed_mps)
                + speed_mps * (self.profile.drive.latency_s + 0.1)
                + self.profile.footprint.length_m,
            half_width_m: self.profile.footprint.width_m / 2.0 + self.config.clearance_m,
            free_radius_m: self.free_radius_m(),
        };
        look_ahead(position, &self.waypoints, next, &self.unplanned_near(position), &look)
    }

    /// Nothing at all, planned or not, stands between `position` and waypoint `index`, and the robot
    /// has been avoiding long enough to have seen what there is.
    fn sees_straight_to(&self, position: Point2, index: usize) -> bool {
        if self.avoiding_s < self.config.least_avoidance_s {
            return false;
        }
        let to = self.waypoints[index];
        let half_width_m = self.profile.footprint.width_m / 2.0 + self.config.clearance_m;
        let reach_m = position.distance(to) + half_width_m;
        let near = self.map.occupied_near(position, reach_m);
        near.iter().all(|obstacle| obstacle.distance_to_segment(position, to) >= half_width_m)
    }

    fn free_radius_m(&self) -> f64 {
        self.profile.footprint.circumscribed_radius_m() + self.config.clearance_m
    }

    /// The first waypoint from the next on that is at least `distance_m` away, or the last one.
    fn first_beyond(&self, position: Point2, distance_m: f64) -> usize {
        let next = self.next_waypoint();
        (next..self.waypoints.len())
            .find(|&i| position.distance(self.waypoints[i]) >= distance_m)
            .unwrap_or(self.waypoints.len() - 1)
    }

    fn next_waypoint(&self) -> usize {
        (self.tracker.index() + 1).min(self.waypoints.len().saturating_sub(1))
    }

    /// From `position` over waypoint `next` to the end of the way \[m\].
    fn way_to_go_m(&self, position: Point2, next: usize) -> f64 {
        self.waypoints
            .get(next)
            .map_or(0.0, |&first| position.distance(first) + length_m(&self.waypoints[next..]))
    }

    fn arrived(&self, position: Point2) -> bool {
        let destination = match self.task {
            Some(Task::Goal { point }) => Some(point),
            Some(Task::Explore) => self.intermediate.map_or(
                (self.mode == Mode::PathTracking).then(|| self.waypoints.last().copied()).flatten(),
                |_| self.waypoints.last().copied(),
            ),
            None => None,
        };
        destination.is_some_and(|goal| position.distance(goal) <= self.config.arrival_m)
    }

    /// Near waypoint `index`, or past it: nearer to the one after.
    fn reached(&self, position: Point2, index: usize) -> bool {
        let distance_m = position.distance(self.waypoints[index]);
        let past = self.waypoints.get(index + 1).is_some_and(|&after| {
            position.distance(after) < distance_m && distance_m < 2.0 * self.config.intermediate_reach_m
        });
        distance_m <= self.config.intermediate_reach_m || past
    }

    /// The robot this navigator drives.
    pub fn profile(&self) -> &RobotProfile {
        &self.profile
    }

    /// Estimated pose, `world_from_robot`.
    pub fn pose(&self) -> Pose2 {
        self.odometry.pose()
    }

    /// Mode after the last tick.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// How it stands with the task.
    pub fn status(&self) -> TaskStatus {
        self.status
    }

    /// The path last walked down the field, world frame \[m\].
    pub fn path(&self) -> &[Point2] {
        &self.path
    }

    /// The waypoints that the tracker follows, world frame \[m\].
    pub fn waypoints(&self) -> &[Point2] {
        &self.waypoints
    }

    /// The map as it is now.
    pub fn map(&self) -> &OccupancyMap {
        &self.map
    }

    /// The field in use, to be shared with others that want the same goal.
    pub fn field(&self) -> Option<&WorldField> {
        self.field.as_ref()
    }

    /// Fields solved so far.
    pub fn plan_count(&self) -> u32 {
        self.plan_count
    }
}

/// The next command on the way to rest: both speeds fall together, along one curvature, as fast as
/// the slower one can.
fn braking(limits: &Limits, commanded: Twist2, dt_s: f64) -> Twist2 {
    let Twist2 { linear_mps, angular_radps } = commanded;
    let left_s = (linear_mps.abs() / limits.linear_mps2).max(angular_radps.abs() / limits.angular_radps2);
    if left_s <= dt_s {
        return Twist2::ZERO;
    }
    let share = 1.0 - dt_s / left_s;
    Twist2::new(linear_mps * share, angular_radps * share)
}

fn length_m(path: &[Point2]) -> f64 {
    path.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// `occupancy` grown by unknown cells until it holds `margin_m` around every one of `points`.
fn padded(occupancy: &OccupancyGrid, points: &[Point2], margin_m: f64) -> OccupancyGrid {
    let old = occupancy.geometry;
    let grid_from_world = old.world_from_grid.inverse();
    let (mut row_lo, mut col_lo, mut row_hi, mut col_hi) = (0i64, 0i64, old.rows as i64, old.cols as i64);
    for &point in points {
        let in_grid = grid_from_world * point;
        let cell = |metres: f64| (metres / old.resolution_m).floor() as i64;
        row_lo = row_lo.min(cell(in_grid.y - margin_m));
        col_lo = col_lo.min(cell(in_grid.x - margin_m));
        row_hi = row_hi.max(cell(in_grid.y + margin_m) + 1);
        col_hi = col_hi.max(cell(in_grid.x + margin_m) + 1);
    }
    let (rows, cols) = ((row_hi - row_lo) as usize, (col_hi - col_lo) as usize);
    let corner =
        old.world_from_grid * Point2::new(col_lo as f64 * old.resolution_m, row_lo as f64 * old.resolution_m);
    let geometry = GridGeometry {
        rows,
        cols,
        resolution_m: old.resolution_m,
        world_from_grid: Pose2::new(corner.x, corner.y, old.world_from_grid.heading),
    };
    let mut grown = Grid::filled(geometry, Occupancy::Unknown);
    for row in 0..old.rows {
        let from = row * old.cols;
        let to = (row as i64 - row_lo) as usize * cols + (-col_lo) as usize;
        grown.values[to..to + old.cols].copy_from_slice(&occupancy.values[from..from + old.cols]);
    }
    grown
}
