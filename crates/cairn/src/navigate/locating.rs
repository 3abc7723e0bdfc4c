//! Where the robot is: given, matched to the map, or searched for. While the pose is not known, the
//! task waits and the robot looks around, on a map of its own.

use super::error::NavigateError;
use super::navigator::{Navigator, TickInput};
use super::record::Task;
use super::strategy::Event;
use crate::geometry::Pose2;
use crate::locate::{LocaliseReport, LocaliseState, Localiser, MatchReport};
use crate::world::{OccupancyGrid, OccupancyMap};

/// A jump that turns the pose by more leaves what was seen in the wrong place \[rad\].
const TURNED_RAD: f64 = 0.2;

/// A localiser, and what waits for it.
#[derive(Clone, Debug)]
pub(super) struct Locating {
    localiser: Localiser,
    /// What the user wants, once the pose is known.
    held: Option<Task>,
}

/// What a tick did to the pose.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Located {
    pub matching: Option<MatchReport>,
    pub localisation: Option<LocaliseReport>,
}

impl Locating {
    /// None where the settings do not ask for it.
    pub(super) fn new(navigator: &Navigator, prior: &OccupancyGrid) -> Result<Option<Self>, NavigateError> {
        let config = &navigator.config;
        if !config.localise {
            return Ok(None);
        }
        let localiser = Localiser::new(
            &config.localiser,
            &config.matching,
            &navigator.profile,
            prior,
            navigator.pose_known,
        )?;
        Ok(Some(Self { localiser, held: None }))
    }
}

impl Navigator {
    /// Encoders and gyroscope, then the given pose, or else the given map, correct the estimate.
    pub(super) fn locate(&mut self, input: &TickInput<'_>) -> Result<Located, NavigateError> {
        let before = self.odometry.pose();
        self.odometry.predict(self.believed(input.wheels), input.gyro_radps, input.dt_s)?;
        self.pose_given = input.world_from_robot.is_some();
        if let Some(lidar) = &mut self.lidar {
            let step = before.inverse() * self.odometry.pose();
            let ranges_m = &input.ranges_m[self.profile.sonars.len()..];
            let pose = lidar.observe(step, ranges_m, input.world_from_robot, input.dt_s);
            match input.world_from_robot {
                Some(pose) => self.odometry.set_pose(pose)?,
                None => self.odometry.settle_at(pose)?,
            }
            self.pose_known |= self.pose_given;
            return Ok(Located::default());
        }
        if let Some(pose) = input.world_from_robot {
            self.odometry.set_pose(pose)?;
            if let Some(locating) = &mut self.locating {
                locating.localiser.believe();
            }
            self.know_pose()?;
            return Ok(Located::default());
        }
        if let Some(locating) = &mut self.locating {
            let report =
                locating.localiser.correct(&mut self.odometry, &self.profile, input.ranges_m, input.dt_s)?;
            match report.state {
                LocaliseState::Tracking if !self.pose_known => self.know_pose()?,
                LocaliseState::Tracking => self.take_jump(report.jump)?,
                LocaliseState::Searching if self.pose_known => self.lose_pose()?,
                LocaliseState::Searching => {}
            }
            return Ok(Located { matching: report.matching, localisation: Some(report) });
        }
        let matching = match &self.matcher {
            Some(matcher) if self.pose_known => {
                Some(matcher.correct(&mut self.odometry, &self.profile, input.ranges_m)?)
            }
            _ => None,
        };
        Ok(Located { matching, localisation: None })
    }

    /// The map is of no use until the pose is known: what is seen goes onto an empty one, and the
    /// task waits while the robot looks around.
    pub(super) fn lose_pose(&mut self) -> Result<(), NavigateError> {
        self.pose_known = false;
        self.map = OccupancyMap::new(&self.config.unmapped(), self.map.geometry().resolution_m)?;
        if self.task.is_some() {
            self.hold_while_lost();
        }
        Ok(())
    }

    /// Puts a task that has just begun aside where the pose is not known.
    pub(super) fn hold_while_lost(&mut self) {
        let cancelled = self.asked == Some(Event::Cancelled);
        let Some(locating) = &mut self.locating else { return };
        if self.pose_known || cancelled {
            return;
        }
        if let Some(task) = self.task {
            locating.held = Some(task);
            self.begin_now(Task::Explore);
        }
    }

    /// Nothing waits for the pose any more.
    pub(super) fn drop_held(&mut self) {
        if let Some(locating) = &mut self.locating {
            locating.held = None;
        }
    }

    /// The pose is known: back to the given map, and to the task that waited, or that was begun without.
    fn know_pose(&mut self) -> Result<(), NavigateError> {
        let was_known = std::mem::replace(&mut self.pose_known, true);
        let Some(prior) = self.prior.as_ref().filter(|_| !was_known) else { return Ok(()) };
        self.map = OccupancyMap::from_occupancy(&self.config.mapping, prior)?;
        let task = match &mut self.locating {
            Some(locating) => locating.held.take().filter(|_| self.task.is_some()),
            None => self.task.filter(|_| self.asked.is_none()),
        };
        if let Some(task) = task {
            self.begin_now(task);
        }
        Ok(())
    }

    /// What was seen from a pose that was off by a jump stands in the wrong place.
    fn take_jump(&mut self, jump: Option<Pose2>) -> Result<(), NavigateError> {
        let far_m = self.config.off_path_m;
        let far = |jump: Pose2| jump.x.hypot(jump.y) > far_m || jump.heading.abs() > TURNED_RAD;
        let (true, Some(prior)) = (jump.is_some_and(far), &self.prior) else { return Ok(()) };
        self.map = OccupancyMap::from_occupancy(&self.config.mapping, prior)?;
        if let Some(task) = self.task.filter(|_| self.asked != Some(Event::Cancelled)) {
            self.begin_now(task);
        }
        Ok(())
    }
}
