use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::geometry::{Point2, Pose2, Twist2};

/// Everything the brain needs to know of a robot. Read from a profile file by the body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotProfile {
    /// Name a person would use.
    pub name: String,
    /// Outline on the ground.
    pub footprint: Footprint,
    /// Speeds and accelerations that commands keep to.
    pub limits: Limits,
    /// Wheels and delays.
    pub drive: Drive,
    /// Sonars in firing-number order; readings come in the same order.
    #[serde(default)]
    pub sonars: Vec<Sonar>,
    /// A planar scanner, if there is one; its beams follow the sonars in an array of ranges.
    #[serde(default)]
    pub lidar: Option<Lidar>,
}

/// A box on the ground, sides parallel to the robot's axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Footprint {
    /// Length along the robot's x axis \[m\].
    pub length_m: f64,
    /// Width along the robot's y axis \[m\].
    pub width_m: f64,
}

/// What the robot can do; commands never ask for more.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Greatest translational speed \[m/s\].
    pub linear_mps: f64,
    /// Greatest rotational speed \[rad/s\].
    pub angular_radps: f64,
    /// Greatest translational acceleration and deceleration \[m/s²\].
    pub linear_mps2: f64,
    /// Greatest rotational acceleration and deceleration \[rad/s²\].
    pub angular_radps2: f64,
}

/// Skid-steer drive: both wheels of a side turn as one `[Maalouf06 §2]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Effective track b: side speeds are V ∓ ω·b/2. Wider than the wheels stand, as they slip \[m\].
    pub effective_track_m: f64,
    /// From a command to the motion that follows it \[s\].
    pub latency_s: f64,
}

/// An ultrasonic ranger that sees the nearest surface inside a cone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sonar {
    /// Where it sits and looks, `robot_from_sonar`.
    pub pose: Pose2,
    /// Full opening angle of the cone \[rad\].
    pub beam_rad: f64,
    /// Nearest distance it can tell \[m\].
    pub min_range_m: f64,
    /// Farthest distance it can tell; no echo is given as infinity \[m\].
    pub max_range_m: f64,
}

/// A planar scanner: beam i looks along `first_rad + i · step_rad` in its own frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lidar {
    /// Where it sits and looks, `robot_from_lidar`.
    pub pose: Pose2,
    /// Number of beams.
    pub beams: usize,
    /// Direction of beam 0 \[rad\].
    pub first_rad: f64,
    /// From one beam to the next \[rad\].
    pub step_rad: f64,
    /// Nearest distance it can tell \[m\].
    pub min_range_m: f64,
    /// Farthest distance it can tell; no echo is given as infinity \[m\].
    pub max_range_m: f64,
}

/// A setting's key, its value, and the least and the greatest that are usable.
pub(crate) type Bound = (&'static str, f64, f64, f64);

/// The first setting that is not a finite number in its range.
pub(crate) fn outside(bounds: impl IntoIterator<Item = Bound>) -> Option<Bound> {
    bounds
        .into_iter()
        .find(|&(_, value, least, most)| !(value.is_finite() && least <= value && value <= most))
}

/// Why a profile was refused.
#[derive(Clone, Debug, PartialEq, Error, Serialize)]
pub enum ProfileError {
    /// A quantity is not what physics allows.
    #[error("profile `{profile}`: {key} is {value}, must be a finite number greater than {least}")]
    ProfileValueOutOfRange {
        /// Name of the profile.
        profile: String,
        /// Dotted key in the file.
        key: String,
        /// What the file says.
        value: f64,
        /// Exclusive lower bound.
        least: f64,
    },
}

impl RobotProfile {
    /// Number of readings in one array of ranges: the sonars, then the lidar's beams.
    pub fn range_count(&self) -> usize {
        self.sonars.len() + self.lidar.map_or(0, |lidar| lidar.beams)
    }

    /// Checks every number once.
    ///
    /// # Errors
    /// [`ProfileError::ProfileValueOutOfRange`] names the first key that is not usable.
    pub fn validated(self) -> Result<Self, ProfileError> {
        let mut checks = vec![
            ("footprint.length_m".to_owned(), self.footprint.length_m, 0.0),
            ("footprint.width_m".to_owned(), self.footprint.width_m, 0.0),
            ("limits.linear_mps".to_owned(), self.limits.linear_mps, 0.0),
            ("limits.angular_radps".to_owned(), self.limits.angular_radps, 0.0),
            ("limits.linear_mps2".to_owned(), self.limits.linear_mps2, 0.0),
            ("limits.angular_radps2".to_owned(), self.limits.angular_radps2, 0.0),
            ("drive.effective_track_m".to_owned(), self.drive.effective_track_m, 0.0),
            ("drive.latency_s".to_owned(), self.drive.latency_s, -f64::MIN_POSITIVE),
        ];
        for (i, sonar) in self.sonars.iter().enumerate() {
            checks.push((format!("sonars[{i}].beam_rad"), sonar.beam_rad, 0.0));
            checks.push((format!("sonars[{i}].min_range_m"), sonar.min_range_m, -f64::MIN_POSITIVE));
            checks.push((format!("sonars[{i}].max_range_m"), sonar.max_range_m, sonar.min_range_m));
            for (key, value) in [("x", sonar.pose.x), ("y", sonar.pose.y), ("heading", sonar.pose.heading)] {
                checks.push((format!("sonars[{i}].pose.{key}"), value, f64::NEG_INFINITY));
            }
        }
        if let Some(lidar) = &self.lidar {
            checks.push(("lidar.min_range_m".to_owned(), lidar.min_range_m, -f64::MIN_POSITIVE));
            checks.push(("lidar.max_range_m".to_owned(), lidar.max_range_m, lidar.min_range_m));
            for (key, value) in [
                ("pose.x", lidar.pose.x),
                ("pose.y", lidar.pose.y),
                ("pose.heading", lidar.pose.heading),
                ("first_rad", lidar.first_rad),
                ("step_rad", lidar.step_rad),
            ] {
                checks.push((format!("lidar.{key}"), value, f64::NEG_INFINITY));
            }
        }
        for (key, value, least) in checks {
            if !(value.is_finite() && value > least) {
                return Err(ProfileError::ProfileValueOutOfRange { profile: self.name, key, value, least });
            }
        }
        Ok(self)
    }
}

impl Footprint {
    /// Radius of the largest disc about the robot's centre inside the outline \[m\].
    pub fn inscribed_radius_m(&self) -> f64 {
        self.length_m.min(self.width_m) / 2.0
    }

    /// Radius of the smallest disc about the robot's centre around the outline \[m\].
    pub fn circumscribed_radius_m(&self) -> f64 {
        (self.length_m / 2.0).hypot(self.width_m / 2.0)
    }

    /// The four corners in the robot frame \[m\], counter-clockwise from front left.
    pub fn corners(&self) -> [Point2; 4] {
        let (x, y) = (self.length_m / 2.0, self.width_m / 2.0);
        [Point2::new(x, y), Point2::new(-x, y), Point2::new(-x, -y), Point2::new(x, -y)]
    }

    /// Distance from `point_in_robot` to the outline \[m\]; zero inside.
    pub fn distance(&self, point_in_robot: Point2) -> f64 {
        let dx = (point_in_robot.x.abs() - self.length_m / 2.0).max(0.0);
        let dy = (point_in_robot.y.abs() - self.width_m / 2.0).max(0.0);
        dx.hypot(dy)
    }
}

impl Limits {
    /// `wanted`, brought inside the speed limits and what `dt_s` can reach from `current`.
    pub fn reachable(&self, current: Twist2, wanted: Twist2, dt_s: f64) -> Twist2 {
        let linear = wanted.linear_mps.clamp(-self.linear_mps, self.linear_mps);
        let angular = wanted.angular_radps.clamp(-self.angular_radps, self.angular_radps);
        let dv = self.linear_mps2 * dt_s;
        let dw = self.angular_radps2 * dt_s;
        Twist2::new(
            linear.clamp(current.linear_mps - dv, current.linear_mps + dv),
            angular.clamp(current.angular_radps - dw, current.angular_radps + dw),
        )
    }

    /// The twist after `dt_s` towards `wanted`, and the mean one on the way there.
    pub(crate) fn ramped(&self, current: Twist2, wanted: Twist2, dt_s: f64) -> (Twist2, Twist2) {
        let next = self.reachable(current, wanted, dt_s);
        let mean = Twist2::new(
            (current.linear_mps + next.linear_mps) / 2.0,
            (current.angular_radps + next.angular_radps) / 2.0,
        );
        (next, mean)
    }

    /// Distance needed to stop from `speed_mps` \[m\], without latency.
    pub fn braking_distance_m(&self, speed_mps: f64) -> f64 {
        speed_mps * speed_mps / (2.0 * self.linear_mps2)
    }

    /// Speed from which the robot stops within `distance_m` though braking begins `delay_s` late \[m/s\]:
    /// v·T + v²/2a = d.
    pub fn stoppable_mps(&self, distance_m: f64, delay_s: f64) -> f64 {
        let (a, t) = (self.linear_mps2, delay_s);
        a * ((t * t + 2.0 * distance_m / a).sqrt() - t)
    }
}
