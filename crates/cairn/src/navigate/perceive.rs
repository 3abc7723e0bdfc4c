//! What is seen and known, reduced to the one event that matters most in this tick.

use super::navigator::Navigator;
use super::record::Task;
use super::strategy::{Event, Mode};
use super::trap::TrapEvidence;
use super::way::{Look, WayAhead, first_free, look_ahead};
use crate::geometry::{Point2, Twist2};

/// Slower than this in both speeds is at rest \[m/s, rad/s\].
const AT_REST: Twist2 = Twist2::new(0.02, 0.03);
/// A waypoint within this bearing is faced \[rad\].
const AHEAD_RAD: f64 = 0.6;

/// What the robot perceived this tick, before it is reduced to an event.
#[derive(Clone, Debug, Default)]
pub(super) struct Percept {
    pub way: Option<WayAhead>,
    pub trap: Option<TrapEvidence>,
}

impl Navigator {
    /// Reduces what is known now to the event that matters most in this mode.
    pub(super) fn perceive(&mut self, dt_s: f64) -> (Event, Percept) {
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
            Some(_) if self.settling() => Event::Nothing,
            Some(_) if self.plan_wanted => Event::ReadyToPlan,
            Some(_) => Event::ReadyToAvoid,
        }
    }

    /// Nothing but the gyroscope will hold the heading, and standing still teaches its bias.
    pub(super) fn settling(&self) -> bool {
        let resting_s = self.odometry.resting_s();
        let seeing = self.pose_given || (self.map_given && self.pose_known);
        let unsure = self.odometry.gyro_bias_sigma_radps() > self.config.settle_radps;
        !seeing && unsure && resting_s > 0.0 && resting_s < self.config.settle_most_s
    }

    fn perceive_tracking(&mut self, dt_s: f64, percept: &mut Percept) -> Event {
        let position = self.odometry.pose().position();
        self.tracker.advance_pointer(position);
        let trap = self.trap.step(position, self.to_go(position), dt_s);
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
                _ => -self.trap.driven_m(),
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
        self.intermediate = Some(free);
        let trap = self.trap.step(position, self.to_go(position), dt_s);
        percept.trap = Some(trap);
        if self.reached(position, free) || self.sees_straight_to(position, free) {
            let way = self.look(position, (free + 1).min(self.waypoints.len() - 1));
            let event = match (way.blocked, way.free_beyond) {
                (None, _) => Event::WayClear,
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

    /// What is left to pay from `position`: the field's value, whatever waypoint is headed for. Where
    /// the field says nothing (inside a margin) nothing is gained either.
    fn to_go(&self, position: Point2) -> f64 {
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
