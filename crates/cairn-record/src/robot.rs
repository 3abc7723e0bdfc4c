//! One robot's part of a log: which messages a tick becomes.

use cairn::geometry::Pose2;
use cairn::navigate::{Decision, Mode, TaskStatus};
use cairn::robot::RobotProfile;
use serde::Serialize;

use crate::json::to_json;
use crate::recorder::{FieldSource, MapSnapshot, Step, Told};
use crate::ros::{self, MAP_FRAME, Stamp};
use crate::sink::{Output, SinkError};

/// A line of `/<robot>/inputs`.
#[derive(Serialize)]
#[serde(tag = "call", rename_all = "snake_case")]
enum Input<'a> {
    SetGoal {
        goal: [f64; 2],
        shared: bool,
        field: Option<&'a FieldSource>,
    },
    Explore,
    Cancel,
    Step {
        tick: u64,
        ranges_m: &'a [f64],
        wheels_m: [f64; 2],
        gyro_radps: Option<f64>,
        dt_s: f64,
        world_from_robot: Option<[f64; 3]>,
    },
}

#[derive(Serialize)]
struct InputLine<'a> {
    robot: &'a str,
    time_s: f64,
    #[serde(flatten)]
    input: Input<'a>,
}

/// A line of `/<robot>/decision`.
#[derive(Serialize)]
struct TickLine<'a> {
    time_s: f64,
    robot: &'a str,
    truth: Option<[f64; 3]>,
    clearance_m: Option<f64>,
    decision: &'a Decision,
}

pub struct RobotLog {
    name: String,
    topics: String,
    base: String,
    truth: String,
    sonars: Vec<(String, String)>,
    profile: RobotProfile,
    /// The last tick, until it is known what the judge saw of it.
    pending: Option<(Stamp, Box<Step>)>,
    mode: Option<Mode>,
    status: Option<TaskStatus>,
}

impl RobotLog {
    /// Writes where the robot's sensors sit. In the names of topics and frames it is called `topics`.
    pub fn begin(
        name: &str,
        topics: &str,
        profile: RobotProfile,
        out: &mut Output,
    ) -> Result<Self, SinkError> {
        let frame = |part: &str| format!("{topics}/{part}");
        let base = frame("base_link");
        let sonars: Vec<(String, String)> = (0..profile.sonars.len())
            .map(|i| (format!("/{topics}/sonar_{i}"), frame(&format!("sonar_{i}"))))
            .collect();
        let lidar = frame("lidar");
        let mut sensors: Vec<(&str, &str, Pose2)> = sonars
            .iter()
            .zip(&profile.sonars)
            .map(|((_, frame), sonar)| (base.as_str(), frame.as_str(), sonar.pose))
            .collect();
        sensors.extend(profile.lidar.iter().map(|seen| (base.as_str(), lidar.as_str(), seen.pose)));
        out.ros("/tf_static", &ros::TF, Stamp(0), &ros::transforms(Stamp(0), &sensors))?;
        Ok(Self {
            name: name.to_owned(),
            truth: frame("base_link_truth"),
            base,
            topics: format!("/{topics}"),
            sonars,
            profile,
            pending: None,
            mode: None,
            status: None,
        })
    }

    /// Has these topics, and is not the robot of this name.
    pub fn takes(&self, topics: &str, name: &str) -> bool {
        self.topics[1..] == *topics && self.name != name
    }

    fn topic(&self, name: &str) -> String {
        format!("{}/{name}", self.topics)
    }

    pub fn told(&mut self, time_s: f64, told: &Told, out: &mut Output) -> Result<(), SinkError> {
        let input = match told {
            Told::Goal { point, shared, source } => {
                Input::SetGoal { goal: [point.x, point.y], shared: *shared, field: source.as_ref() }
            }
            Told::Explore => Input::Explore,
            Told::Cancel => Input::Cancel,
        };
        self.input(time_s, input, out)
    }

    fn input(&self, time_s: f64, input: Input<'_>, out: &mut Output) -> Result<(), SinkError> {
        let at = Stamp::from_s(time_s);
        let line = to_json(&InputLine { robot: &self.name, time_s: rounded(time_s), input })?;
        Ok(out.json(&self.topic("inputs"), "cairn.Input", at, &line)?)
    }

    /// Keeps one tick; its stamp comes back.
    pub fn step(&mut self, step: Step, out: &mut Output) -> Result<Stamp, SinkError> {
        self.end(out)?;
        let decision = &*step.decision;
        let began_s = decision.time_s - step.dt_s;
        let at = Stamp::from_s(began_s);
        let input = Input::Step {
            tick: decision.tick,
            ranges_m: &step.ranges_m,
            wheels_m: [step.wheels.left_m, step.wheels.right_m],
            gyro_radps: step.gyro_radps,
            dt_s: step.dt_s,
            world_from_robot: step.world_from_robot.map(triple),
        };
        self.input(began_s, input, out)?;
        self.sensed(at, &step.ranges_m, out)?;
        self.moved(at, decision, out)?;
        if let Some(path) = &step.path {
            out.ros(&self.topic("path"), &ros::PATH, at, &ros::path(at, path))?;
        }
        if let Some(waypoints) = &step.waypoints {
            out.ros(&self.topic("waypoints"), &ros::PATH, at, &ros::path(at, waypoints))?;
        }
        if let Some(map) = &step.map {
            self.map(began_s, map, out)?;
        }
        self.said(at, decision, out)?;
        self.pending = Some((at, Box::new(step)));
        Ok(at)
    }

    /// What every sensor that was asked said.
    fn sensed(&self, at: Stamp, ranges_m: &[f64], out: &mut Output) -> Result<(), SinkError> {
        let (sonars, beams) = ranges_m.split_at(self.profile.sonars.len().min(ranges_m.len()));
        for ((&range_m, (topic, frame)), sonar) in sonars.iter().zip(&self.sonars).zip(&self.profile.sonars) {
            if !range_m.is_nan() {
                out.ros(topic, &ros::RANGE, at, &ros::range(at, frame, sonar, range_m))?;
            }
        }
        if let Some(lidar) = self.profile.lidar.as_ref().filter(|_| beams.iter().any(|beam| !beam.is_nan())) {
            let frame = format!("{}/lidar", &self.topics[1..]);
            out.ros(&self.topic("scan"), &ros::LASER_SCAN, at, &ros::scan(at, &frame, lidar, beams))?;
        }
        Ok(())
    }

    /// Where it believes to be, how it moves, what it is told.
    fn moved(&self, at: Stamp, decision: &Decision, out: &mut Output) -> Result<(), SinkError> {
        let Decision { pose, covariance, measured, twist, .. } = decision;
        let here = [(MAP_FRAME, self.base.as_str(), *pose)];
        out.ros("/tf", &ros::TF, at, &ros::transforms(at, &here))?;
        let estimate = ros::pose_with_covariance(at, *pose, covariance);
        out.ros(&self.topic("pose"), &ros::POSE_COVARIANCE_STAMPED, at, &estimate)?;
        let odometry = ros::odometry(at, &self.base, *pose, covariance, *measured);
        out.ros(&self.topic("odom"), &ros::ODOMETRY, at, &odometry)?;
        let command = ros::twist_stamped(at, &self.base, *twist);
        Ok(out.ros(&self.topic("cmd_vel"), &ros::TWIST_STAMPED, at, &command)?)
    }

    pub fn map(&self, time_s: f64, map: &MapSnapshot, out: &mut Output) -> Result<(), SinkError> {
        let at = Stamp::from_s(time_s);
        Ok(out.ros(&self.topic("map"), &ros::OCCUPANCY_GRID, at, &ros::occupancy_grid(at, map))?)
    }

    /// A line of text where the mode or the task changed, or something went wrong.
    fn said(&mut self, at: Stamp, decision: &Decision, out: &mut Output) -> Result<(), SinkError> {
        let (mode, status) = (Some(decision.mode), Some(decision.status));
        let wrong = decision.recovery.is_some() || matches!(decision.status, TaskStatus::Refused { .. });
        if mode != self.mode || status != self.status || decision.recovery.is_some() {
            let line = ros::log(at, wrong, &self.name, &decision.sentence);
            out.ros("/rosout", &ros::LOG, at, &line)?;
        }
        (self.mode, self.status) = (mode, status);
        Ok(())
    }

    /// What the judge saw at the last tick.
    pub fn judged(
        &mut self,
        time_s: f64,
        truth: Pose2,
        clearance_m: f64,
        out: &mut Output,
    ) -> Result<(), SinkError> {
        let Some((at, step)) = self.pending.take() else { return Ok(()) };
        out.ros(&self.topic("truth"), &ros::POSE_STAMPED, at, &ros::pose_stamped(at, truth))?;
        let really = [(MAP_FRAME, self.truth.as_str(), truth)];
        out.ros("/tf", &ros::TF, at, &ros::transforms(at, &really))?;
        self.decided(at, time_s, Some((truth, clearance_m)), &step.decision, out)
    }

    /// Nobody judged the last tick, or nobody will.
    pub fn end(&mut self, out: &mut Output) -> Result<(), SinkError> {
        match self.pending.take() {
            Some((at, step)) => {
                let time_s = rounded(step.decision.time_s - step.dt_s);
                self.decided(at, time_s, None, &step.decision, out)
            }
            None => Ok(()),
        }
    }

    fn decided(
        &self,
        at: Stamp,
        time_s: f64,
        judged: Option<(Pose2, f64)>,
        decision: &Decision,
        out: &mut Output,
    ) -> Result<(), SinkError> {
        let line = to_json(&TickLine {
            time_s,
            robot: &self.name,
            truth: judged.map(|(truth, _)| triple(truth)),
            clearance_m: judged.map(|(_, clearance_m)| clearance_m),
            decision,
        })?;
        Ok(out.json(&self.topic("decision"), "cairn.Tick", at, &line)?)
    }
}

fn triple(pose: Pose2) -> [f64; 3] {
    [pose.x, pose.y, pose.heading]
}

/// To the microsecond: sums of ticks come out round.
fn rounded(time_s: f64) -> f64 {
    (time_s * 1e6).round() / 1e6
}
