//! What a lidar adds: the pose by matching scans, the points around, the field over them.

use serde::{Deserialize, Serialize};

use super::error::NavigateError;
use super::local_field::{LocalField, LocalFieldConfig};
use crate::avoid::{AvoidanceRecord, Cvm, CvmConfig, Guide, Moving};
use crate::geometry::{Point2, Pose2, Twist2, wrap_angle};
use crate::locate::{ScanMatch, ScanMatchConfig, match_scan};
use crate::robot::{Footprint, Limits, RobotProfile, outside};
use crate::world::{Beams, LocalMap, LocalMapConfig, MotionConfig, MotionWatch};

/// How a robot with a lidar drives where no map is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LidarConfig {
    /// Drive by the field over what the lidar sees; otherwise as with sonars, on the map of cells.
    pub guide: bool,
    /// The points kept.
    pub map: LocalMapConfig,
    /// How scans correct the pose.
    pub matching: ScanMatchConfig,
    /// The field over the points.
    pub field: LocalFieldConfig,
    /// What is seen to move.
    pub motion: MotionConfig,
    /// The curvature velocity method that it guides; its latency is the profile's.
    pub avoidance: CvmConfig,
    /// Without getting nearer to the goal for this long, a plan on the map of cells is tried \[s\].
    pub patience_s: f64,
    /// The map of cells is added to this often while the field guides \[s\].
    pub map_every_s: f64,
}

impl Default for LidarConfig {
    fn default() -> Self {
        Self {
            guide: true,
            map: LocalMapConfig::default(),
            matching: ScanMatchConfig::default(),
            field: LocalFieldConfig::default(),
            motion: MotionConfig::default(),
            avoidance: CvmConfig {
                horizon_m: 2.2,
                obstacle_radius_m: 0.02,
                margin_m: 0.04,
                max_curvature_per_m: 5.0,
                curvature_step_per_m: 0.1,
                turn_rate_radps: 2.5,
                turning_room_m: 0.03,
                backing_speed_mps: 0.3,
                ..CvmConfig::default()
            },
            patience_s: 20.0,
            map_every_s: 0.25,
        }
    }
}

impl LidarConfig {
    /// Checks every number but those of the avoidance, which its method checks.
    fn checked(&self) -> Result<(), NavigateError> {
        let own = [("patience_s", self.patience_s, 1e-3, 1e9), ("map_every_s", self.map_every_s, 0.0, 1e9)];
        let parts = [
            ("", outside(own)),
            ("map.", outside(self.map.bounds())),
            ("matching.", outside(self.matching.bounds())),
            ("motion.", outside(self.motion.bounds())),
        ];
        match parts.into_iter().find_map(|(part, bad)| bad.map(|bad| (part, bad))) {
            Some((part, (key, value, least, most))) => {
                let key = format!("lidar.{part}{key}");
                Err(NavigateError::NavigatorValueOutOfRange { key, value, least, most })
            }
            None => self.field.checked(self.map.resolution_m),
        }
    }
}

/// Whether beams look at all that a robot backs into straight from where it stands, a metre behind it.
fn sees_behind(beams: &Beams, footprint: &Footprint) -> bool {
    let x = -footprint.length_m / 2.0 - 1.0;
    [-0.5, 0.0, 0.5].iter().all(|share| beams.looks_at(Point2::new(x, share * footprint.width_m)))
}

/// What one scan told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LidarRecord {
    /// What laying it on the points seen before did to the pose.
    pub matching: ScanMatch,
    /// Points kept now.
    pub points: usize,
    /// Things seen to move.
    pub moving: usize,
    /// True turn over the turn that wheels, and a gyroscope where there is one, tell, as estimated.
    pub turn_gain: f64,
    /// What was remembered but not seen was forgotten: nothing else was left to try.
    pub doubted: bool,
    /// No way was left but through what must not be.
    pub desperate: bool,
    /// Time since the least time to the goal last fell \[s\].
    pub without_progress_s: f64,
}

/// How fast the estimate of the turn gain follows \[1/rad²\], and what it begins with.
const GAIN_PRIOR_RAD2: f64 = 0.02;
const GAIN_MEMORY_RAD2: f64 = 1.5;
/// Nothing skids more than this.
const GAIN_RANGE: (f64, f64) = (0.7, 1.4);
/// So long without a motion, and what is only remembered is doubted \[s\].
const PATIENCE_S: f64 = 1.5;

/// The time to go falling by this is progress; rising by that, something new was learnt \[s\].
const FELL_S: f64 = 0.2;
const LEARNT_S: f64 = 2.0;

/// Everything that is kept from scan to scan.
#[derive(Clone, Debug)]
pub struct LidarSense {
    config: LidarConfig,
    footprint: Footprint,
    limits: Limits,
    cvm: Cvm,
    beams: Beams,
    map: LocalMap,
    field: LocalField,
    pose: Pose2,
    least_to_go_s: f64,
    /// Σ matched · told, Σ told².
    gain: (f64, f64),
    motion: MotionWatch,
    stuck_s: f64,
    record: LidarRecord,
}

impl LidarSense {
    /// At `world_from_robot`, with nothing seen. None for a robot without a lidar.
    ///
    /// # Errors
    /// [`NavigateError::NavigatorValueOutOfRange`], or a setting of the curvature velocity method that is
    /// not usable.
    pub fn new(
        config: &LidarConfig,
        profile: &RobotProfile,
        world_from_robot: Pose2,
    ) -> Result<Option<Self>, NavigateError> {
        let Some(lidar) = &profile.lidar else { return Ok(None) };
        config.checked()?;
        let beams = Beams::new(lidar);
        let mut avoidance = CvmConfig { latency_s: profile.drive.latency_s, ..config.avoidance.clone() };
        if !sees_behind(&beams, &profile.footprint) {
            for speed_mps in &mut avoidance.moving.speeds_mps {
                *speed_mps = speed_mps.max(-avoidance.backing_speed_mps);
            }
        }
        Ok(Some(Self {
            cvm: Cvm::new(&avoidance, &profile.limits, &profile.footprint)?,
            footprint: profile.footprint,
            limits: profile.limits,
            beams,
            map: LocalMap::new(&config.map),
            field: LocalField::new(&config.field),
            config: config.clone(),
            pose: world_from_robot,
            least_to_go_s: f64::INFINITY,
            gain: (GAIN_PRIOR_RAD2, GAIN_PRIOR_RAD2),
            motion: MotionWatch::new(&config.motion),
            stuck_s: 0.0,
            record: LidarRecord::default(),
        }))
    }

    /// Forgets the task, not what was seen.
    pub fn restart(&mut self) {
        self.least_to_go_s = f64::INFINITY;
        self.record.without_progress_s = 0.0;
        self.stuck_s = 0.0;
    }

    /// Lays a scan on what was seen before and adds it; the robot's pose comes back.
    ///
    /// `step` is the motion since the last scan that wheels and gyroscope tell; `known` the pose,
    /// where something else knows it: then nothing is matched; `dt_s` the time since.
    pub fn observe(&mut self, step: Pose2, ranges_m: &[f64], known: Option<Pose2>, dt_s: f64) -> Pose2 {
        let ends = self.beams.ends(ranges_m);
        let last = self.pose;
        let gain = if known.is_some() { 1.0 } else { self.turn_gain() };
        let told = wrap_angle(step.heading);
        let predicted = last * Pose2::new(step.x, step.y, told * gain);
        let moves = self.motion.of_moving(known.unwrap_or(predicted), &ends, dt_s);
        let (pose, matching) = match known {
            Some(pose) => (pose, ScanMatch::default()),
            None => {
                let driven_m = step.position().norm();
                let still: Vec<Option<Point2>> =
                    ends.iter().zip(&moves).map(|(end, &moves)| end.filter(|_| !moves)).collect();
                match_scan(&self.config.matching, &self.map, predicted, &still, driven_m, told)
            }
        };
        if matching.matched >= self.config.matching.least_returns {
            let matched = wrap_angle(pose.heading - last.heading);
            let kept = (1.0 - told * told / GAIN_MEMORY_RAD2).clamp(0.0, 1.0);
            self.gain = (self.gain.0 * kept + matched * told, self.gain.1 * kept + told * told);
        }
        self.pose = pose;
        self.motion.step(pose, &ends, &self.map, dt_s);
        self.map.integrate(pose, &self.beams, ranges_m, &ends, |beam| moves[beam]);
        // Nothing but the robot stands where the robot stands.
        let robot_from_world = pose.inverse();
        let reach = self.footprint.circumscribed_radius_m();
        let footprint = self.footprint;
        self.map.forget(|point| {
            let away = point - pose.position();
            away.dot(away) < reach * reach && footprint.distance(robot_from_world * point) == 0.0
        });
        self.record = LidarRecord {
            matching,
            points: self.map.len(),
            moving: self.motion.moving().count(),
            turn_gain: self.turn_gain(),
            doubted: false,
            ..self.record
        };
        pose
    }

    /// True turn over the turn that wheels, and a gyroscope where there is one, tell, as estimated.
    pub fn turn_gain(&self) -> f64 {
        (self.gain.0 / self.gain.1).clamp(GAIN_RANGE.0, GAIN_RANGE.1)
    }

    /// What the last scan told.
    pub fn record(&self) -> LidarRecord {
        self.record
    }

    /// The points around.
    pub fn map(&self) -> &LocalMap {
        &self.map
    }

    /// The field last solved.
    pub fn field(&self) -> &LocalField {
        &self.field
    }

    /// Solves the field to `goal` and chooses the next motion.
    ///
    /// `measured` is the twist that the odometry tells, `commanded` the last command, and `slip` the turn
    /// that the odometry tells over the one that the wheels were commanded (1 where nothing but they
    /// tells of it). The choice is made among true motions, and the command that makes the chosen one
    /// comes back in the record, slowed along its curvature where it would be beyond the limits.
    pub fn drive(
        &mut self,
        goal: Point2,
        measured: Twist2,
        commanded: Twist2,
        slip: f64,
        dt_s: f64,
    ) -> AvoidanceRecord {
        let pose = self.pose;
        let told = self.turn_gain();
        let made = (told * slip).clamp(GAIN_RANGE.0, GAIN_RANGE.1);
        let turned_by = |gain: f64, twist: Twist2| Twist2::new(twist.linear_mps, twist.angular_radps * gain);
        let (measured, pending) = (turned_by(told, measured), turned_by(made, commanded));
        let points: Vec<Point2> = self.map.points().collect();
        let resolution_m = self.map.config().resolution_m;
        let solved = self.field.solve(&points, resolution_m, &self.footprint, pose.position(), goal);
        self.record.desperate = !solved || self.field.is_desperate();
        let (sin, cos) = pose.heading.sin_cos();
        let turned = |p: Point2| Point2::new(cos * p.x + sin * p.y, -sin * p.x + cos * p.y);
        let reach_m = self.cvm.config().horizon_m + self.footprint.circumscribed_radius_m() + 0.5;
        let points: Vec<Point2> = points
            .into_iter()
            .map(|p| p - pose.position())
            .filter(|away| away.dot(*away) < reach_m * reach_m)
            .map(turned)
            .collect();
        let goal_m = pose.position().distance(goal);
        let moving: Vec<Moving> = self
            .motion
            .moving()
            .map(|thing| Moving {
                center: turned(thing.center - pose.position()),
                radius_m: thing.radius_m,
                velocity_mps: turned(thing.velocity_mps),
            })
            .collect();
        let mut record = match self.field.seen_from(pose) {
            Some(guide) => {
                let (to_go_s, _) = guide.to_go(Point2::default());
                self.record.without_progress_s = progress(&mut self.least_to_go_s, to_go_s)
                    .map_or(self.record.without_progress_s + dt_s, |()| 0.0);
                self.cvm.choose_guided(measured, pending, &guide, &points, &moving, goal_m, dt_s)
            }
            None => {
                let bearing_rad = pose.bearing_to(goal);
                self.cvm.choose_after(measured, Some(pending), bearing_rad, goal_m, &points, dt_s)
            }
        };
        let still = record.twist.linear_mps.abs() < 0.02 && record.twist.angular_radps.abs() < 0.02;
        self.stuck_s = if still { self.stuck_s + dt_s } else { 0.0 };
        if self.stuck_s > PATIENCE_S {
            self.stuck_s = 0.0;
            self.map.forget(|point| (point - pose.position()).norm() < reach_m);
            self.record.doubted = true;
        }
        record.twist = commandable(record.twist, made, &self.limits);
        record
    }
}

/// The command that makes the true motion `real` of a robot that turns `gain` times what it is told:
/// where the limits do not allow it, the same curvature, slower.
fn commandable(real: Twist2, gain: f64, limits: &Limits) -> Twist2 {
    let angular_radps = real.angular_radps / gain;
    let share = (limits.angular_radps / angular_radps.abs()).min(1.0);
    Twist2::new(real.linear_mps * share, angular_radps * share)
}

/// Whether the time to go fell, or rose so much that something new was learnt.
fn progress(least_s: &mut f64, to_go_s: f64) -> Option<()> {
    let learnt = to_go_s.is_finite() && to_go_s > *least_s + LEARNT_S;
    let fell = to_go_s < *least_s - FELL_S;
    (learnt || fell).then(|| *least_s = to_go_s)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::robot::Lidar;

    const BOX: Footprint = Footprint { length_m: 0.46, width_m: 0.42 };

    fn beams(span_rad: f64) -> Beams {
        let (beams, first_rad) = (361, -span_rad / 2.0);
        let step_rad = span_rad / (beams - 1) as f64;
        let pose = Pose2::new(0.05, 0.0, 0.0);
        Beams::new(&Lidar { pose, beams, first_rad, step_rad, min_range_m: 0.1, max_range_m: 30.0 })
    }

    #[test]
    fn a_lidar_sees_behind_only_if_beams_look_at_all_the_robot_backs_into() {
        assert!(sees_behind(&beams(TAU), &BOX));
        assert!(!sees_behind(&beams(1.5 * PI), &BOX));
        assert!(!sees_behind(&beams(1.95 * PI), &BOX));
    }

    #[test]
    fn a_command_of_a_robot_that_turns_less_than_told_keeps_the_limits_and_the_curvature() {
        let limits = Limits { linear_mps: 2.0, angular_radps: 4.0, linear_mps2: 5.0, angular_radps2: 20.0 };
        for real in [Twist2::new(1.0, 3.5), Twist2::new(-0.3, -4.0), Twist2::new(0.0, 4.0)] {
            let told = commandable(real, 0.7, &limits);
            assert!(told.angular_radps.abs() <= limits.angular_radps && told.linear_mps.abs() <= 2.0);
            let same = 0.7 * told.angular_radps * real.linear_mps - real.angular_radps * told.linear_mps;
            assert!(same.abs() < 1e-12, "{told:?}");
        }
        let straight = Twist2::new(2.0, 0.0);
        assert_eq!(commandable(straight, 0.7, &limits), straight);
    }
}
