//! The navigator: one call per tick, locate → map → mode → track or avoid, one record out.

use super::act::braking;
use super::approach::Approach;
use super::backing::Backing;
use super::config::{NavigatorConfig, PathShape};
use super::echoes::Echo;
use super::error::NavigateError;
use super::keeping::Keeper;
use super::lidar::LidarSense;
use super::locating::Locating;
use super::planning::{Refusal, WorldField};
use super::record::{BackingRecord, Decision, PlanRecord, Story, Task, TaskStatus};
use super::recovery::{Recovery, Remedy};
use super::stall::StallWatch;
use super::strategy::{Event, Mode, Strategy};
use super::trap::TrapWatch;
use super::wedged::{Manoeuvre, StandWatch};
use crate::avoid::{AvoidanceRecord, Cvm, CvmConfig};
use crate::geometry::{Point2, Pose2, Twist2};
use crate::locate::{MapMatcher, Odometry, WheelTravel};
use crate::robot::{Footprint, RobotProfile};
use crate::track::{Tracker, TrackerConfig, TrackingRecord};
use crate::world::{OccupancyGrid, OccupancyMap};

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

/// The parts of a tick, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TickPart {
    /// Wheels, gyroscope and ranges into a pose.
    Locate,
    /// Ranges into the map.
    Map,
    /// Changed cells priced, the field repaired; wheels watched.
    Keep,
    /// What is perceived, the mode, and the plan where one is made.
    Mode,
    /// Tracking or avoiding.
    Act,
    /// The sentence and the record.
    Record,
}

/// Plans, tracks, avoids and arrives.
#[derive(Clone, Debug)]
pub struct Navigator {
    pub(super) profile: RobotProfile,
    pub(super) config: NavigatorConfig,
    pub(super) body: Footprint,
    pub(super) strategy: Strategy,
    pub(super) odometry: Odometry,
    pub(super) map: OccupancyMap,
    pub(super) matcher: Option<MapMatcher>,
    pub(super) locating: Option<Locating>,
    pub(super) map_given: bool,
    /// The given map as it was, where the pose in it is not known, or may get lost.
    pub(super) prior: Option<OccupancyGrid>,
    /// Cells of the given map.
    pub(super) given_cells: usize,
    pub(super) ground: Option<Vec<f32>>,
    pub(super) pose_known: bool,
    /// The pose came with the last tick's measurements.
    pub(super) pose_given: bool,
    pub(super) tracker: Tracker,
    pub(super) cvm: Cvm,
    pub(super) cvm_on_way: Cvm,
    /// What a lidar sees, where it guides.
    pub(super) lidar: Option<LidarSense>,
    /// Since the map of cells was last added to \[s\].
    pub(super) unmapped_s: f64,
    pub(super) trap: TrapWatch,
    pub(super) mode: Mode,
    pub(super) task: Option<Task>,
    pub(super) status: TaskStatus,
    pub(super) asked: Option<Event>,
    pub(super) field: Option<WorldField>,
    pub(super) shared: bool,
    pub(super) path: Vec<Point2>,
    pub(super) waypoints: Vec<Point2>,
    pub(super) intermediate: Option<usize>,
    /// Waypoint headed for while avoiding, and the least distance to it so far.
    pub(super) nearest: Option<(usize, f64)>,
    pub(super) outcome: Option<Result<(), Refusal>>,
    pub(super) plan_wanted: bool,
    pub(super) avoiding_s: f64,
    pub(super) unsafe_command: bool,
    pub(super) unsafe_for_s: f64,
    pub(super) keeper: Keeper,
    pub(super) stall: StallWatch,
    pub(super) backing: Option<Backing>,
    pub(super) stands: StandWatch,
    pub(super) manoeuvre: Option<Manoeuvre>,
    /// Heard now, or just before, and not explained by the given map.
    pub(super) echoes: Vec<Echo>,
    pub(super) approach: Approach,
    /// Where its motors were silent last, and how often in a row.
    pub(super) silent: Option<(Point2, u32)>,
    /// Where its wheels stood, and turned backwards then.
    pub(super) held_at: Option<Point2>,
    /// At rest, the motors, or what shuts the way, are waited for this long \[s\].
    pub(super) waiting_s: f64,
    pub(super) waiting_for_way: bool,
    pub(super) plan_count: u32,
    /// How often the map may still be doubted before a goal is refused.
    pub(super) doubts: u32,
    pub(super) fruitless: u32,
    pub(super) planned_at: Option<Point2>,
    pub(super) last_plan: Option<PlanRecord>,
    pub(super) commanded: Twist2,
    pub(super) tick: u64,
    pub(super) time_s: f64,
}

impl Navigator {
    /// A navigator at rest in Stop.
    ///
    /// `world` is the map to plan on, if there is one; `start` the pose in it, `world_from_robot`, if
    /// known. Without a start the frame begins at the robot and a given map is not used until
    /// [`TickInput::world_from_robot`] tells the pose, or the robot finds it (`localise`).
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
        config.waypoints.checked()?;
        config.costmap.validated()?;
        let path_shape = if world.is_some() { config.path_shape } else { PathShape::Octile };
        let config = NavigatorConfig { path_shape, ..config };
        let map = match world {
            Some(prior) => OccupancyMap::from_occupancy(&config.mapping, prior)?,
            None => OccupancyMap::new(&config.unmapped(), config.resolution_m)?,
        };
        let matcher = match world {
            Some(prior) if config.match_map && !config.localise => {
                Some(MapMatcher::new(&config.matching, prior)?)
            }
            _ => None,
        };
        let body = Footprint {
            length_m: profile.footprint.length_m + 2.0 * config.clearance_m,
            width_m: profile.footprint.width_m + 2.0 * config.clearance_m,
        };
        let avoidance = CvmConfig { latency_s: profile.drive.latency_s, ..config.avoidance.clone() };
        let on_way = CvmConfig {
            speed_weight: config.on_way.speed_weight,
            distance_weight: config.on_way.distance_weight,
            heading_weight: config.on_way.heading_weight,
            ..avoidance.clone()
        };
        let lidar = if world.is_none() && config.lidar.guide {
            LidarSense::new(&config.lidar, &profile, start.unwrap_or_default())?
        } else {
            None
        };
        let mut navigator = Self {
            lidar,
            unmapped_s: f64::INFINITY,
            odometry: Odometry::new(&config.odometry, &profile.drive, start.unwrap_or_default())?,
            tracker: Tracker::new(controller, &profile.limits)?.with_latency(profile.drive.latency_s)?,
            cvm_on_way: Cvm::new(&on_way, &profile.limits, &profile.footprint)?,
            cvm: Cvm::new(&avoidance, &profile.limits, &profile.footprint)?,
            trap: TrapWatch::new(config.trap),
            body,
            strategy: Strategy::paper(),
            map,
            matcher,
            locating: None,
            map_given: world.is_some(),
            prior: world.filter(|_| config.localise || start.is_none()).cloned(),
            given_cells: world.map_or(0, |prior| prior.values.len()),
            ground: None,
            pose_known: start.is_some(),
            pose_given: false,
            mode: Mode::Stop,
            task: None,
            status: TaskStatus::Idle,
            asked: None,
            field: None,
            shared: false,
            path: Vec::new(),
            waypoints: Vec::new(),
            intermediate: None,
            nearest: None,
            outcome: None,
            plan_wanted: false,
            avoiding_s: 0.0,
            unsafe_command: false,
            unsafe_for_s: 0.0,
            keeper: Keeper::default(),
            stall: StallWatch::new(config.stall, &profile),
            backing: None,
            stands: StandWatch::default(),
            manoeuvre: None,
            echoes: Vec::new(),
            approach: Approach::default(),
            silent: None,
            held_at: None,
            waiting_s: 0.0,
            waiting_for_way: false,
            plan_count: 0,
            doubts: 0,
            fruitless: 0,
            planned_at: None,
            last_plan: None,
            commanded: Twist2::ZERO,
            tick: 0,
            time_s: 0.0,
            profile,
            config,
        };
        if let Some(prior) = world {
            navigator.locating = Locating::new(&navigator, prior)?;
            if !navigator.pose_known {
                navigator.lose_pose()?;
            }
        }
        if navigator.map_given && navigator.pose_known {
            // Priced once; from then on only what changes. Costs that cannot be are refused with a goal.
            let _ = navigator.price(&[]);
        }
        Ok(navigator)
    }

    /// The same navigator on a map whose cells cost `ground` per metre, row-major; an infinite cell is
    /// forbidden to the robot's centre, though nothing stands there.
    ///
    /// # Errors
    /// [`NavigateError::GroundShapeWrong`] unless there is one number for every cell of the map.
    pub fn with_ground(mut self, ground: Vec<f32>) -> Result<Self, NavigateError> {
        let expected = self.given_cells;
        if ground.len() != expected {
            return Err(NavigateError::GroundShapeWrong { given: ground.len(), expected });
        }
        self.ground = Some(ground);
        self.keeper.costs = None;
        let _ = self.price(&[]);
        Ok(self)
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
        if self.pose_known || self.locating.is_none() {
            self.shared = field.is_some();
            self.field = field;
        }
        Ok(())
    }

    /// Asks to see what is unknown, without a goal `[Maalouf06 §1]`.
    pub fn explore(&mut self) {
        self.begin(Task::Explore);
    }

    /// Ends the task, if there is one; the robot brakes to rest.
    pub fn cancel(&mut self) {
        self.drop_held();
        if self.task.is_some() {
            self.asked = Some(Event::Cancelled);
        }
    }

    fn begin(&mut self, task: Task) {
        self.begin_now(task);
        self.hold_while_lost();
    }

    pub(super) fn begin_now(&mut self, task: Task) {
        self.asked = Some(Event::NewTask);
        self.task = Some(task);
        self.status = TaskStatus::Driving;
        self.plan_wanted = false;
        self.doubts = self.config.doubts;
        self.stands.forget();
        self.fruitless = 0;
        self.planned_at = None;
        self.waiting_s = 0.0;
        self.waiting_for_way = false;
        self.keeper.switches = 0;
        self.held_at = None;
        self.silent = None;
        self.path.clear();
        self.waypoints.clear();
        self.tracker.clear();
        self.drop_field();
    }

    /// One tick: what was measured in, everything decided out.
    ///
    /// # Errors
    /// [`NavigateError`] for input that cannot be a measurement; nothing has changed then. A map that would
    /// grow beyond its most cells ([`crate::world::MappingError::MappingTooLarge`]) is left as it was, but
    /// time has passed and the robot has moved: the tick counts, and gives no command.
    pub fn step(&mut self, input: &TickInput<'_>) -> Result<Decision, NavigateError> {
        self.step_probed(input, |_| {})
    }

    /// As [`Self::step`]; `probe` is told as each part of the tick is done, to be timed by who has a clock.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn step_probed(
        &mut self,
        input: &TickInput<'_>,
        mut probe: impl FnMut(TickPart),
    ) -> Result<Decision, NavigateError> {
        self.check(input)?;
        self.tick += 1;
        self.time_s += input.dt_s;
        let located = self.locate(input)?;
        probe(TickPart::Locate);
        let pose = self.odometry.pose();
        self.unmapped_s += input.dt_s;
        if !self.guided() || self.unmapped_s >= self.config.lidar.map_every_s {
            self.unmapped_s = 0.0;
            self.map.integrate(pose, &self.profile, input.ranges_m)?;
            self.free_own_place(pose);
        }
        probe(TickPart::Map);
        let (mut repair, mut stalled) = (None, None);
        if !self.guided() {
            repair = self.keep_field();
            stalled = self.watch_for_stall(input.wheels, input.gyro_radps, input.ranges_m, input.dt_s);
        }
        probe(TickPart::Keep);
        let pose = self.odometry.pose();
        self.listen(pose, input.ranges_m, input.dt_s);

        let mode_before = self.mode;
        let (event, mut percept) = self.perceive(stalled, input.wheels, input.dt_s);
        self.waiting_s = (self.waiting_s - input.dt_s).max(0.0);
        let (mode, reason) = self.strategy.step(mode_before, event);
        let plan = self.enter(mode, reason);
        self.avoiding_s = if mode == Mode::ObstacleAvoidance { self.avoiding_s + input.dt_s } else { 0.0 };

        probe(TickPart::Mode);
        let mut tracking: Option<TrackingRecord> = None;
        let mut avoidance: Option<AvoidanceRecord> = None;
        let mut backing: Option<BackingRecord> = None;
        let measured = self.odometry.twist();
        let twist = match mode {
            Mode::Stop | Mode::PathPlanning => braking(&self.profile.limits, self.commanded, input.dt_s),
            Mode::PathTracking => {
                percept.recovery = self.rewalk_if_off_path(pose).or(percept.recovery);
                let record = self.tracker.step(pose, measured, input.dt_s);
                let obstacles = self.obstacles_in_robot(pose);
                self.unsafe_command = !self.has_room_for(record.twist, &obstacles)
                    || !self.cvm.keeps_clear(measured, self.commanded, record.twist, &obstacles, input.dt_s);
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
            Mode::ObstacleAvoidance => match self.back_off(pose, input.dt_s) {
                Some((twist, record)) => {
                    backing = Some(record);
                    twist
                }
                None => match self.manoeuvre_on(pose, measured, input.dt_s) {
                    Some(twist) => twist,
                    None => {
                        let record = self.avoid(pose, measured, input.dt_s);
                        let twist = record.twist;
                        avoidance = Some(record);
                        twist
                    }
                },
            },
        };

        let (twist, caution) =
            if self.guided() { (twist, None) } else { self.within_sight(pose, twist, input.dt_s) };
        let (twist, held) = self.within_hearing(pose, twist, input.dt_s);
        let caution = held.or(caution);
        self.commanded = twist;
        self.tracker.overridden(twist);

        probe(TickPart::Act);
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
            recovery: percept.recovery.as_ref(),
            waiting: (self.waiting_s > 0.0).then_some(self.waiting_for_way),
            settling: self.settling(),
            manoeuvring: self.manoeuvre.is_some(),
            position: pose.position(),
            waypoint_index,
            intermediate,
        }
        .sentence();
        let decision = Decision {
            tick: self.tick - 1,
            time_s: self.time_s,
            pose,
            covariance: self.odometry.covariance(),
            measured,
            matching: located.matching,
            localisation: located.localisation,
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
            rewalked: matches!(percept.recovery, Some(Recovery { remedy: Remedy::WalkAnew, .. })),
            recovery: percept.recovery,
            repair,
            cost_to_go: self.field.as_ref().and_then(|field| field.cost_to_go(pose.position())),
            plan,
            tracking,
            avoidance,
            lidar: self.lidar.as_ref().map(LidarSense::record),
            backing,
            caution,
            limits: self.profile.limits,
            twist,
        };
        probe(TickPart::Record);
        Ok(decision)
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

    /// Nothing but the robot stands where the robot stands, whatever an echo's arc said.
    fn free_own_place(&mut self, pose: Pose2) {
        let Footprint { length_m, width_m } = self.profile.footprint;
        let cell_m = self.map.geometry().resolution_m;
        let along = |length: f64| (length / cell_m).ceil() as i32;
        let (n, m) = (along(length_m), along(width_m));
        let world_from_robot = pose.turned();
        let places = (0..=n).flat_map(|i| {
            (0..=m).map(move |j| {
                let x = length_m * (f64::from(i) / f64::from(n) - 0.5);
                let y = width_m * (f64::from(j) / f64::from(m) - 0.5);
                world_from_robot * Point2::new(x, y)
            })
        });
        self.map.clear_discs(places, cell_m / 2.0);
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

    /// What the lidar has seen and not seen through again, world frame \[m\]; empty where none guides.
    pub fn lidar_points(&self) -> Vec<Point2> {
        self.lidar.as_ref().map_or_else(Vec::new, |lidar| lidar.map().points().collect())
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
