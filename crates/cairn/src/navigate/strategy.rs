//! The four modes and every transition between them `[Maalouf06 §6, Fig. 11]`.
//!
//! The machine is a table: one row for every pair of mode and event, each with its reason, checked
//! to be total. A further behaviour is a further mode with rows of its own; rows that stand stay.

use std::fmt::Debug;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// What the robot is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Standing still, or coming to rest, and waiting for a command.
    Stop,
    /// Computing the cost-to-go field; the robot is at rest.
    PathPlanning,
    /// Following the waypoints with the fuzzy controller.
    PathTracking,
    /// Driving by the curvature velocity method.
    ObstacleAvoidance,
}

/// What was perceived, reduced to the one thing that matters most in this tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Event {
    /// Nothing that asks for another mode.
    Nothing,
    /// The user cancelled what the robot was doing.
    Cancelled,
    /// The user gave a goal, or asked to explore.
    NewTask,
    /// At measured rest, with a task, a map, and a known pose in it.
    ReadyToPlan,
    /// At measured rest, with a task but no map, or no known pose in it.
    ReadyToAvoid,
    /// The field is there and the robot's place in it has finite cost.
    PlanFound,
    /// No path leads to the goal, or the goal itself cannot be occupied.
    GoalUnattainable,
    /// The destination is reached.
    Arrived,
    /// Something that the plan did not know stands on the way; a later waypoint is free.
    ObstacleAhead,
    /// Something stands on the way and no remaining waypoint is free.
    AllWaypointsBlocked,
    /// The intermediate goal is reached and nothing stands on the way.
    WayClear,
    /// The robot came back to where it had been since its last plan.
    RegionVisitedTwice,
    /// The robot makes no progress any more.
    LocalMinimum,
    /// The wheels turn, or should, and the robot does not move: something unseen holds it.
    Stalled,
}

/// Why the mode is what it is now.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// No task.
    Waiting,
    /// A task was taken; it begins at rest.
    TaskAccepted,
    /// A new task came while moving: first to rest.
    NewTaskWhileMoving,
    /// Cancelled by the user.
    Cancelled,
    /// Map and pose are known: plan.
    MapAndPoseKnown,
    /// No map, or no pose in it: head for the goal and map on the way.
    NoMapOrPose,
    /// The plan is being made.
    Planning,
    /// A path was found: follow it.
    PathFound,
    /// No path: say so and wait.
    GoalUnattainable,
    /// The path is clear.
    FollowingPath,
    /// Something unplanned is on the way to the next waypoints.
    ObstacleOnPath,
    /// No free waypoint remains: a new plan is needed.
    NoFreeWaypoint,
    /// Around the obstacle, or towards the goal without a map.
    Avoiding,
    /// The way is clear again.
    WayClear,
    /// The destination is reached.
    Arrived,
    /// Passed through the same region twice: plan on the map as it is now.
    RegionVisitedTwice,
    /// Stuck in a local minimum: plan on the map as it is now.
    LocalMinimum,
    /// Held by something unseen: back off, with it on the map.
    Stalled,
}

/// One row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row<M, E, R> {
    /// Mode before.
    pub mode: M,
    /// What was perceived.
    pub event: E,
    /// Mode after.
    pub next: M,
    /// Why.
    pub reason: R,
}

/// Why a table is no machine.
#[derive(Clone, Debug, PartialEq, Error, Serialize)]
pub enum StrategyError {
    /// A pair of mode and event has no row.
    #[error("no transition for event {event} in mode {mode}: add a row, even if the mode stays")]
    TransitionMissing {
        /// The mode.
        mode: String,
        /// The event.
        event: String,
    },
    /// A pair of mode and event has more than one row.
    #[error("more than one transition for event {event} in mode {mode}: keep one")]
    TransitionAmbiguous {
        /// The mode.
        mode: String,
        /// The event.
        event: String,
    },
}

/// A total function from (mode, event) to (mode, reason), held as a table.
///
/// A behaviour of your own is a mode with rows of its own; a pair that is forgotten is refused:
///
/// ```
/// use cairn::navigate::{Row, Strategy, StrategyError};
///
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// enum Mode { Drive, Dock }
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// enum Event { Nothing, BatteryLow, Charged }
/// use {Event::*, Mode::*};
///
/// let row = |mode, event, next, reason| Row { mode, event, next, reason };
/// let mut rows = vec![
///     row(Drive, Nothing, Drive, "on the way"),
///     row(Drive, BatteryLow, Dock, "the battery is low"),
///     row(Drive, Charged, Drive, "on the way"),
///     row(Dock, Nothing, Dock, "charging"),
///     row(Dock, BatteryLow, Dock, "charging"),
/// ];
/// let forgotten = Strategy::new(rows.clone()).unwrap_err();
/// assert!(matches!(forgotten, StrategyError::TransitionMissing { .. }));
///
/// rows.push(row(Dock, Charged, Drive, "charged"));
/// let machine = Strategy::new(rows)?;
/// assert_eq!(machine.next(Drive, BatteryLow), Some((Dock, "the battery is low")));
/// # Ok::<(), StrategyError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Strategy<M = Mode, E = Event, R = Reason> {
    rows: Vec<Row<M, E, R>>,
}

impl<M, E, R> Strategy<M, E, R>
where
    M: Copy + PartialEq + Debug,
    E: Copy + PartialEq + Debug,
    R: Copy,
{
    /// A machine of `rows`.
    ///
    /// # Errors
    /// [`StrategyError`] unless every mode and every event that any row names meet in exactly one row.
    pub fn new(rows: Vec<Row<M, E, R>>) -> Result<Self, StrategyError> {
        let mut modes: Vec<M> = Vec::new();
        let mut events: Vec<E> = Vec::new();
        for row in &rows {
            for mode in [row.mode, row.next] {
                if !modes.contains(&mode) {
                    modes.push(mode);
                }
            }
            if !events.contains(&row.event) {
                events.push(row.event);
            }
        }
        for &mode in &modes {
            for &event in &events {
                let named = || (format!("{mode:?}"), format!("{event:?}"));
                match rows.iter().filter(|row| row.mode == mode && row.event == event).count() {
                    1 => {}
                    0 => {
                        let (mode, event) = named();
                        return Err(StrategyError::TransitionMissing { mode, event });
                    }
                    _ => {
                        let (mode, event) = named();
                        return Err(StrategyError::TransitionAmbiguous { mode, event });
                    }
                }
            }
        }
        Ok(Self { rows })
    }

    /// The next mode and why; None only for a mode or event that the table does not name.
    pub fn next(&self, mode: M, event: E) -> Option<(M, R)> {
        let row = self.rows.iter().find(|row| row.mode == mode && row.event == event)?;
        Some((row.next, row.reason))
    }

    /// Every transition, in the table's order.
    pub fn rows(&self) -> &[Row<M, E, R>] {
        &self.rows
    }
}

impl Strategy {
    /// The paper's machine. `Stop` is the only way into `PathPlanning` `[Maalouf06 §6]`.
    pub fn paper() -> Self {
        Self { rows: PAPER.to_vec() }
    }

    /// The next mode and why, for the paper's modes, where every pair has its row.
    pub fn step(&self, mode: Mode, event: Event) -> (Mode, Reason) {
        self.next(mode, event).unwrap_or((Mode::Stop, Reason::Waiting))
    }
}

const fn row(mode: Mode, event: Event, next: Mode, reason: Reason) -> Row<Mode, Event, Reason> {
    Row { mode, event, next, reason }
}

use Mode::{ObstacleAvoidance as Avoid, PathPlanning as Plan, PathTracking as Track, Stop};

/// Every transition of Fig. 11, and for every other pair what it means that the mode stays. `Stalled` is ours:
/// the paper's robot is never held by what it does not see.
pub const PAPER: [Row<Mode, Event, Reason>; 56] = [
    row(Stop, Event::Nothing, Stop, Reason::Waiting),
    row(Stop, Event::Cancelled, Stop, Reason::Cancelled),
    row(Stop, Event::NewTask, Stop, Reason::TaskAccepted),
    row(Stop, Event::ReadyToPlan, Plan, Reason::MapAndPoseKnown),
    row(Stop, Event::ReadyToAvoid, Avoid, Reason::NoMapOrPose),
    row(Stop, Event::PlanFound, Stop, Reason::Waiting),
    row(Stop, Event::GoalUnattainable, Stop, Reason::GoalUnattainable),
    row(Stop, Event::Arrived, Stop, Reason::Arrived),
    row(Stop, Event::ObstacleAhead, Stop, Reason::Waiting),
    row(Stop, Event::AllWaypointsBlocked, Stop, Reason::Waiting),
    row(Stop, Event::WayClear, Stop, Reason::Waiting),
    row(Stop, Event::RegionVisitedTwice, Stop, Reason::Waiting),
    row(Stop, Event::LocalMinimum, Stop, Reason::Waiting),
    row(Stop, Event::Stalled, Stop, Reason::Waiting),
    row(Plan, Event::Nothing, Plan, Reason::Planning),
    row(Plan, Event::Cancelled, Stop, Reason::Cancelled),
    row(Plan, Event::NewTask, Stop, Reason::TaskAccepted),
    row(Plan, Event::ReadyToPlan, Plan, Reason::Planning),
    row(Plan, Event::ReadyToAvoid, Plan, Reason::Planning),
    row(Plan, Event::PlanFound, Track, Reason::PathFound),
    row(Plan, Event::GoalUnattainable, Stop, Reason::GoalUnattainable),
    row(Plan, Event::Arrived, Stop, Reason::Arrived),
    row(Plan, Event::ObstacleAhead, Plan, Reason::Planning),
    row(Plan, Event::AllWaypointsBlocked, Plan, Reason::Planning),
    row(Plan, Event::WayClear, Plan, Reason::Planning),
    row(Plan, Event::RegionVisitedTwice, Plan, Reason::Planning),
    row(Plan, Event::LocalMinimum, Plan, Reason::Planning),
    row(Plan, Event::Stalled, Plan, Reason::Planning),
    row(Track, Event::Nothing, Track, Reason::FollowingPath),
    row(Track, Event::Cancelled, Stop, Reason::Cancelled),
    row(Track, Event::NewTask, Stop, Reason::NewTaskWhileMoving),
    row(Track, Event::ReadyToPlan, Track, Reason::FollowingPath),
    row(Track, Event::ReadyToAvoid, Track, Reason::FollowingPath),
    row(Track, Event::PlanFound, Track, Reason::FollowingPath),
    row(Track, Event::GoalUnattainable, Stop, Reason::GoalUnattainable),
    row(Track, Event::Arrived, Stop, Reason::Arrived),
    row(Track, Event::ObstacleAhead, Avoid, Reason::ObstacleOnPath),
    row(Track, Event::AllWaypointsBlocked, Stop, Reason::NoFreeWaypoint),
    row(Track, Event::WayClear, Track, Reason::FollowingPath),
    row(Track, Event::RegionVisitedTwice, Stop, Reason::RegionVisitedTwice),
    row(Track, Event::LocalMinimum, Stop, Reason::LocalMinimum),
    row(Track, Event::Stalled, Avoid, Reason::Stalled),
    row(Avoid, Event::Nothing, Avoid, Reason::Avoiding),
    row(Avoid, Event::Cancelled, Stop, Reason::Cancelled),
    row(Avoid, Event::NewTask, Stop, Reason::NewTaskWhileMoving),
    row(Avoid, Event::ReadyToPlan, Avoid, Reason::Avoiding),
    row(Avoid, Event::ReadyToAvoid, Avoid, Reason::Avoiding),
    row(Avoid, Event::PlanFound, Avoid, Reason::Avoiding),
    row(Avoid, Event::GoalUnattainable, Stop, Reason::GoalUnattainable),
    row(Avoid, Event::Arrived, Stop, Reason::Arrived),
    row(Avoid, Event::ObstacleAhead, Avoid, Reason::Avoiding),
    row(Avoid, Event::AllWaypointsBlocked, Stop, Reason::NoFreeWaypoint),
    row(Avoid, Event::WayClear, Track, Reason::WayClear),
    row(Avoid, Event::RegionVisitedTwice, Stop, Reason::RegionVisitedTwice),
    row(Avoid, Event::LocalMinimum, Stop, Reason::LocalMinimum),
    row(Avoid, Event::Stalled, Avoid, Reason::Stalled),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_table_is_total_and_unambiguous() {
        assert!(Strategy::new(PAPER.to_vec()).is_ok());
    }

    #[test]
    fn path_planning_is_entered_only_from_stop() {
        for row in PAPER.iter().filter(|row| row.next == Mode::PathPlanning && row.mode != row.next) {
            assert_eq!((row.mode, row.event), (Mode::Stop, Event::ReadyToPlan));
        }
    }

    #[test]
    fn cancel_stops_from_every_mode() {
        let machine = Strategy::paper();
        for mode in [Mode::Stop, Mode::PathPlanning, Mode::PathTracking, Mode::ObstacleAvoidance] {
            assert_eq!(machine.step(mode, Event::Cancelled), (Mode::Stop, Reason::Cancelled));
        }
    }

    macro_rules! transition {
        ($name:ident: $mode:ident on $event:ident => $next:ident because $reason:ident) => {
            #[test]
            fn $name() {
                let seen = Strategy::paper().step(Mode::$mode, Event::$event);
                assert_eq!(seen, (Mode::$next, Reason::$reason));
            }
        };
    }

    transition!(a_goal_with_map_and_pose_is_planned: Stop on ReadyToPlan => PathPlanning because MapAndPoseKnown);
    transition!(a_goal_without_map_is_headed_for: Stop on ReadyToAvoid => ObstacleAvoidance because NoMapOrPose);
    transition!(a_found_path_is_tracked: PathPlanning on PlanFound => PathTracking because PathFound);
    transition!(an_unattainable_goal_stops: PathPlanning on GoalUnattainable => Stop because GoalUnattainable);
    transition!(an_obstacle_on_the_path_is_avoided: PathTracking on ObstacleAhead => ObstacleAvoidance because ObstacleOnPath);
    transition!(no_free_waypoint_stops_tracking: PathTracking on AllWaypointsBlocked => Stop because NoFreeWaypoint);
    transition!(no_free_waypoint_stops_avoiding: ObstacleAvoidance on AllWaypointsBlocked => Stop because NoFreeWaypoint);
    transition!(a_clear_way_is_tracked_again: ObstacleAvoidance on WayClear => PathTracking because WayClear);
    transition!(arriving_while_tracking_stops: PathTracking on Arrived => Stop because Arrived);
    transition!(arriving_while_avoiding_stops: ObstacleAvoidance on Arrived => Stop because Arrived);
    transition!(a_region_seen_twice_while_tracking_stops: PathTracking on RegionVisitedTwice => Stop because RegionVisitedTwice);
    transition!(a_region_seen_twice_while_avoiding_stops: ObstacleAvoidance on RegionVisitedTwice => Stop because RegionVisitedTwice);
    transition!(a_local_minimum_while_tracking_stops: PathTracking on LocalMinimum => Stop because LocalMinimum);
    transition!(a_local_minimum_while_avoiding_stops: ObstacleAvoidance on LocalMinimum => Stop because LocalMinimum);
    transition!(a_robot_held_by_the_unseen_backs_off: PathTracking on Stalled => ObstacleAvoidance because Stalled);
    transition!(a_new_goal_while_tracking_stops_first: PathTracking on NewTask => Stop because NewTaskWhileMoving);
    transition!(a_new_goal_while_avoiding_stops_first: ObstacleAvoidance on NewTask => Stop because NewTaskWhileMoving);
    transition!(a_new_goal_while_planning_stops_first: PathPlanning on NewTask => Stop because TaskAccepted);
    transition!(a_new_goal_at_rest_is_accepted: Stop on NewTask => Stop because TaskAccepted);

    #[test]
    fn a_table_with_a_hole_is_refused_with_the_pair_that_is_missing() {
        let mut rows = PAPER.to_vec();
        rows.retain(|row| !(row.mode == Mode::PathTracking && row.event == Event::Arrived));
        let refused = Strategy::new(rows).unwrap_err();
        let expected =
            StrategyError::TransitionMissing { mode: "PathTracking".into(), event: "Arrived".into() };
        assert_eq!(refused, expected);
    }

    #[test]
    fn a_fifth_mode_is_added_without_editing_an_existing_row() {
        #[derive(Clone, Copy, Debug, PartialEq)]
        enum Modes {
            Paper(Mode),
            Docking,
        }
        #[derive(Clone, Copy, Debug, PartialEq)]
        enum Events {
            Paper(Event),
            DockInSight,
        }
        #[derive(Clone, Copy, Debug, PartialEq)]
        enum Reasons {
            Paper(Reason),
            Dock,
        }
        let mut rows: Vec<_> = PAPER
            .iter()
            .map(|old| Row {
                mode: Modes::Paper(old.mode),
                event: Events::Paper(old.event),
                next: Modes::Paper(old.next),
                reason: Reasons::Paper(old.reason),
            })
            .collect();
        let unchanged = rows.clone();
        for mode in [Mode::Stop, Mode::PathPlanning, Mode::PathTracking, Mode::ObstacleAvoidance] {
            let next = if mode == Mode::PathTracking { Modes::Docking } else { Modes::Paper(mode) };
            rows.push(Row {
                mode: Modes::Paper(mode),
                event: Events::DockInSight,
                next,
                reason: Reasons::Dock,
            });
        }
        let events: Vec<Events> =
            PAPER[..14].iter().map(|r| Events::Paper(r.event)).chain([Events::DockInSight]).collect();
        for event in events {
            let ends = matches!(event, Events::Paper(Event::Arrived | Event::Cancelled));
            let next = if ends { Modes::Paper(Mode::Stop) } else { Modes::Docking };
            rows.push(Row { mode: Modes::Docking, event, next, reason: Reasons::Dock });
        }
        let machine = Strategy::new(rows).unwrap();
        assert_eq!(machine.rows()[..PAPER.len()], unchanged[..]);
        let seen = machine.next(Modes::Paper(Mode::PathTracking), Events::DockInSight);
        assert_eq!(seen, Some((Modes::Docking, Reasons::Dock)));
        let docked = machine.next(Modes::Docking, Events::Paper(Event::Arrived));
        assert_eq!(docked, Some((Modes::Paper(Mode::Stop), Reasons::Dock)));
    }
}
