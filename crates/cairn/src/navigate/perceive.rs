//! What is seen and known, reduced to the one event that matters most in this tick.

use super::backing::Backed;
use super::keeping::Minded;
use super::navigator::Navigator;
use super::record::Task;
use super::recovery::{Cause, Recovery};
use super::strategy::{Event, Mode};
use super::trap::TrapEvidence;
use super::way::{Look, WayAhead, first_free, look_ahead};
use crate::geometry::{Point2, Twist2};
use crate::locate::WheelTravel;

/// Slower than this in both speeds is at rest \[m/s, rad/s\].
const AT_REST: Twist2 = Twist2::new(0.02, 0.03);
/// A way is about this much longer than it is far, where nothing is known of it.
const WAY_PER_DISTANCE: f64 = 1.5;
/// Going around something on a way walked anew, the robot heads for a waypoint this far away \[m\].
const BEYOND_M: f64 = 1.6;
/// A way from cell to cell is at most this much longer than straight.
const DIAGONALS: f64 = 1.1;
/// A waypoint within this bearing is faced \[rad\].
const AHEAD_RAD: f64 = 0.6;

/// A robot that moved less than this since its motors were silent stands there still \[m\].
const SAME_STAND_M: f64 = 0.2;
/// The wait for the motors doubles so often.
const MOST_DOUBLINGS: u32 = 3;
/// Slower on than this, and turning faster, is a turn on the spot \[m/s, rad/s\].
const SPIN: Twist2 = Twist2::new(0.05, 0.3);

/// What the robot perceived this tick, before it is reduced to an event.
#[derive(Clone, Debug, Default)]
pub(super) struct Percept {
    pub way: Option<WayAhead>,
    pub trap: Option<TrapEvidence>,
    pub recovery: Option<Recovery>,
}

impl Navigator {
    /// Reduces what is known now to the event that matters most in this mode.
    pub(super) fn perceive(
        &mut self,
        stalled: Option<Cause>,
        wheels: WheelTravel,
        dt_s: f64,
    ) -> (Event, Percept) {
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
            Mode::PathTracking | Mode::ObstacleAvoidance => {
                if let Some(event) = self.perceive_hold(stalled, wheels, dt_s, &mut percept) {
                    return (event, percept);
                }
                if self.mode == Mode::PathTracking {
                    self.perceive_tracking(dt_s, &mut percept)
                } else {
                    self.perceive_avoiding(dt_s, &mut percept)
                }
            }
        };
        self.explain(event, &mut percept);
        (event, percept)
    }

    /// Held by something unseen, or still backing off from it.
    fn perceive_hold(
        &mut self,
        stalled: Option<Cause>,
        wheels: WheelTravel,
        dt_s: f64,
        percept: &mut Percept,
    ) -> Option<Event> {
        if let Some(cause) = stalled {
            self.begin_backing(self.odometry.pose(), cause);
            if self.mode == Mode::PathTracking && !self.waypoints.is_empty() {
                self.head_beyond(self.odometry.pose().position());
            }
            self.manoeuvre = None;
            percept.recovery = Some(cause.remedied());
            return Some(Event::Stalled);
        }
        if self.manoeuvre.is_some() && self.mode == Mode::ObstacleAvoidance {
            let position = self.odometry.pose().position();
            return Some(if self.arrived(position) { Event::Arrived } else { Event::Nothing });
        }
        if self.backing.is_none() && !self.waypoints.is_empty() && !self.guided() {
            let cause = self.wedged(dt_s)?;
            percept.recovery = Some(cause.remedied());
            if self.mode == Mode::ObstacleAvoidance {
                return Some(Event::Nothing);
            }
            self.head_beyond(self.odometry.pose().position());
            return Some(Event::ObstacleAhead);
        }
        self.backing?;
        match self.back_on(wheels, dt_s) {
            Backed::Goes => Some(Event::Nothing),
            Backed::Done => {
                self.trap.restart();
                None
            }
            Backed::Silent(recovery) => {
                percept.recovery = Some(recovery);
                self.waiting_s = self.wait_for_motors_s();
                self.waiting_for_way = false;
                self.planned_at = None;
                Some(Event::LocalMinimum)
            }
        }
    }

    /// Motors that are silent again, where they were before, are waited for twice as long.
    fn wait_for_motors_s(&mut self) -> f64 {
        let at = self.odometry.pose().position();
        let times = match self.silent {
            Some((before, times)) if before.distance(at) < SAME_STAND_M => times + 1,
            _ => 0,
        };
        self.silent = Some((at, times));
        self.config.stall.wait_s * f64::from(1u32 << times.min(MOST_DOUBLINGS))
    }

    /// The cause of an event that asks for a recovery.
    fn explain(&self, event: Event, percept: &mut Percept) {
        let cause = match (event, percept.trap) {
            _ if percept.recovery.is_some() => None,
            (Event::AllWaypointsBlocked, _) => Some(Cause::NoFreeWaypoint),
            (Event::RegionVisitedTwice, Some(TrapEvidence { revisited: Some(at), .. })) => {
                Some(Cause::Circling { at })
            }
            (Event::LocalMinimum, Some(TrapEvidence { dead_end: true, detour_m: Some(detour_m), .. })) => {
                Some(Cause::DeadEnd { detour_m })
            }
            (Event::LocalMinimum, Some(trap)) => Some(Cause::NoGain { seconds: trap.without_progress_s }),
            _ => None,
        };
        percept.recovery = cause.map(Cause::remedied).or(percept.recovery);
    }

    fn perceive_at_rest(&self) -> Event {
        let measured = self.odometry.twist();
        let at_rest = measured.linear_mps.abs() < AT_REST.linear_mps
            && measured.angular_radps.abs() < AT_REST.angular_radps;
        match self.task {
            None => Event::Nothing,
            Some(_) if !at_rest || self.waits() => Event::Nothing,
            Some(Task::Goal { .. }) if self.map_given && self.pose_known => Event::ReadyToPlan,
            Some(_) if self.settling() => Event::Nothing,
            Some(_) if self.plan_wanted => Event::ReadyToPlan,
            Some(_) => Event::ReadyToAvoid,
        }
    }

    /// For the motors, or for what shuts the way to leave.
    fn waits(&self) -> bool {
        let opened = self.waiting_for_way && self.to_go(self.odometry.pose().position()).is_finite();
        self.waiting_s > 0.0 && !opened
    }

    /// Nothing but the gyroscope will hold the heading, and standing still teaches its bias.
    pub(super) fn settling(&self) -> bool {
        let resting_s = self.odometry.resting_s();
        let seeing = self.pose_given || self.lidar.is_some() || (self.map_given && self.pose_known);
        let unsure = self.odometry.gyro_bias_sigma_radps() > self.bias_wanted_radps();
        !seeing && unsure && resting_s > 0.0 && resting_s < self.config.settle_most_s
    }

    /// How well the gyroscope's bias must be known for what lies ahead: a heading that drifts at σ for the
    /// time T of a way of length d leads astray by σ·T·d/2.
    fn bias_wanted_radps(&self) -> f64 {
        let least = self.config.settle_radps;
        let Some(Task::Goal { point }) = self.task else { return least };
        let way_m = WAY_PER_DISTANCE * self.odometry.pose().position().distance(point);
        let time_s = way_m / (self.profile.limits.linear_mps / 2.0);
        least.max(2.0 * self.config.settle_drift_m / (time_s * way_m))
    }

    fn perceive_tracking(&mut self, dt_s: f64, percept: &mut Percept) -> Event {
        let position = self.odometry.pose().position();
        self.tracker.advance_pointer(position);
        let trap = self.trap.step(position, self.to_go(position), dt_s);
        percept.trap = Some(trap);
        if self.arrived(position) {
            return Event::Arrived;
        }
        if let Some(event) = self.mind(dt_s, percept) {
            return event;
        }
        let way = self.look(position, self.next_waypoint());
        let is_unsafe = std::mem::take(&mut self.unsafe_command);
        // A safe command now and then does not make a safe way.
        let change_s = if is_unsafe { dt_s } else { -dt_s / 2.0 };
        self.unsafe_for_s = (self.unsafe_for_s + change_s).max(0.0);
        let event = match (way.blocked, way.free_beyond) {
            (Some(_), Some(free)) => {
                self.intermediate = Some(free);
                Event::ObstacleAhead
            }
            (Some(_), None) => Event::AllWaypointsBlocked,
            (None, _) if self.unsafe_for_s >= self.config.unsafe_s => {
                self.head_beyond(position);
                Event::ObstacleAhead
            }
            (None, _) if trap.revisited.is_some() => Event::RegionVisitedTwice,
            (None, _) if trap.stuck => Event::LocalMinimum,
            (None, _) => Event::Nothing,
        };
        percept.way = Some(way);
        event
    }

    /// Looks after the way; an event only if nothing leads on.
    fn mind(&mut self, dt_s: f64, percept: &mut Percept) -> Option<Event> {
        match self.mind_the_way(self.odometry.pose(), dt_s) {
            Minded::Stays => None,
            Minded::Walked(recovery) => {
                percept.recovery = Some(recovery);
                None
            }
            Minded::NoWay(recovery) => {
                percept.recovery = Some(recovery);
                Some(Event::AllWaypointsBlocked)
            }
        }
    }

    fn perceive_avoiding(&mut self, dt_s: f64, percept: &mut Percept) -> Event {
        let position = self.odometry.pose().position();
        if self.arrived(position) {
            return Event::Arrived;
        }
        let Some(intermediate) = self.intermediate else {
            if let (true, Some(lidar)) = (self.guided(), &self.lidar) {
                let stuck = lidar.record().without_progress_s > self.config.lidar.patience_s;
                return if stuck { Event::LocalMinimum } else { Event::Nothing };
            }
            // No path: towards the goal, or exploring, where driving on is the progress.
            self.keep_lookout();
            let to_go_m = match self.task {
                Some(Task::Goal { point }) => {
                    let straight_m = position.distance(point);
                    if self.field.is_some() {
                        let detour_m = self.to_go(position) - DIAGONALS * straight_m;
                        self.trap.see_detour(detour_m, dt_s);
                    }
                    straight_m
                }
                _ => -self.trap.driven_m(),
            };
            let trap = self.trap.step(position, to_go_m, dt_s);
            percept.trap = Some(trap);
            return if trap.revisited.is_some() {
                Event::RegionVisitedTwice
            } else if trap.stuck || trap.dead_end {
                Event::LocalMinimum
            } else {
                Event::Nothing
            };
        };

        self.tracker.advance_pointer(position);
        if let Some(event) = self.mind(dt_s, percept) {
            return event;
        }
        let intermediate = if percept.recovery.is_some() {
            self.nearest = None;
            self.first_beyond(position, BEYOND_M)
        } else {
            intermediate
        };
        let unplanned = self.unplanned_near(position);
        let Some(free) = first_free(&self.waypoints, intermediate, &unplanned, self.free_radius_m()) else {
            return Event::AllWaypointsBlocked;
        };
        self.intermediate = Some(free);
        let trap = self.trap.step(position, self.to_go(position), dt_s);
        percept.trap = Some(trap);
        if self.reached(position, free) || self.sees_straight_to(position, free) {
            let way = self.look(position, (free + 1).min(self.waypoints.len() - 1));
            let event = match (way.blocked, way.free_beyond) {
                (None, _) if self.can_track_from(free, dt_s) => Event::WayClear,
                (None, _) => Event::Nothing,
                (Some(_), Some(next)) => {
                    self.intermediate = Some(next);
                    Event::ObstacleAhead
                }
                (Some(_), None) => Event::AllWaypointsBlocked,
            };
            percept.way = Some(way);
            return event;
        }
        let strayed = self.strayed(position, free);
        if trap.revisited.is_some() {
            Event::RegionVisitedTwice
        } else if trap.stuck || strayed {
            Event::LocalMinimum
        } else {
            Event::Nothing
        }
    }

    /// Going around has taken the robot away again from the waypoint it heads for.
    fn strayed(&mut self, position: Point2, heading_for: usize) -> bool {
        let distance_m = position.distance(self.waypoints[heading_for]);
        let nearest_m = match self.nearest {
            Some((waypoint, nearest_m)) if waypoint == heading_for => nearest_m.min(distance_m),
            _ => distance_m,
        };
        self.nearest = Some((heading_for, nearest_m));
        distance_m > nearest_m + self.config.trap.stray_m
    }

    /// Occupied now, near the robot, and not so when the plan was made.
    fn unplanned_near(&self, position: Point2) -> Vec<Point2> {
        match &self.field {
            Some(field) => self.map.occupied_near_but(position, 5.0, &field.occupied),
            None => self.map.occupied_near(position, 5.0),
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

    /// Nothing at all, planned or not, stands between `position` and waypoint `index`, the robot faces
    /// it or has room to, and has been avoiding long enough to have seen what there is.
    fn sees_straight_to(&self, position: Point2, index: usize) -> bool {
        if self.avoiding_s < self.config.least_avoidance_s {
            return false;
        }
        let to = self.waypoints[index];
        let half_width_m = self.profile.footprint.width_m / 2.0 + self.config.clearance_m;
        let turning_m = self.profile.footprint.circumscribed_radius_m();
        let near = self.map.occupied_near(position, position.distance(to) + turning_m);
        let straight = near.iter().all(|obstacle| obstacle.distance_to_segment(position, to) >= half_width_m);
        let ahead = self.odometry.pose().bearing_to(to).abs() < AHEAD_RAD;
        straight && (ahead || near.iter().all(|obstacle| obstacle.distance(position) >= turning_m))
    }

    /// The tracker could take over: its first command could be stopped from with the room it asks for, and
    /// there is room for the turn if it begins with one.
    fn can_track_from(&self, index: usize, dt_s: f64) -> bool {
        let pose = self.odometry.pose();
        let measured = self.odometry.twist();
        let obstacles = self.obstacles_in_robot(pose);
        let mut trial = self.tracker.clone();
        trial.set_index(index);
        let first = trial.step(pose, measured, dt_s);
        let turns = first.dtheta_rad.abs() > AHEAD_RAD;
        let turning_m = self.profile.footprint.circumscribed_radius_m() + self.config.clearance_m;
        let has_room = !turns || obstacles.iter().all(|obstacle| obstacle.norm() >= turning_m);
        has_room && self.cvm.keeps_clear(measured, self.commanded, first.twist, &obstacles, dt_s)
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

    /// Heads for a waypoint that is not quite near.
    pub(super) fn head_beyond(&mut self, position: Point2) {
        self.intermediate = Some(self.first_beyond(position, 2.0 * self.config.intermediate_reach_m));
    }

    /// A turn on the spot needs room for the corners.
    pub(super) fn has_room_for(&self, twist: Twist2, obstacles_in_robot: &[Point2]) -> bool {
        let turns =
            twist.linear_mps.abs() < SPIN.linear_mps && twist.angular_radps.abs() > SPIN.angular_radps;
        let turning_m = self.profile.footprint.circumscribed_radius_m() + self.config.clearance_m;
        !turns || obstacles_in_robot.iter().all(|obstacle| obstacle.norm() >= turning_m)
    }

    pub(super) fn next_waypoint(&self) -> usize {
        (self.tracker.index() + 1).min(self.waypoints.len().saturating_sub(1))
    }

    /// What is left to pay from `position`: the field's value, whatever waypoint is headed for. Where
    /// the field says nothing (inside a margin) nothing is gained either.
    pub(super) fn to_go(&self, position: Point2) -> f64 {
        self.field.as_ref().and_then(|field| field.cost_to_go(position)).unwrap_or(f64::INFINITY)
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
}
