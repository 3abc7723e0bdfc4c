use serde::Serialize;
use thiserror::Error;

use crate::avoid::AvoidError;
use crate::locate::{LocaliserError, MatchingError, OdometryError};
use crate::track::TrackError;
use crate::world::{MappingError, WorldError};

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
    /// Costs of the ground do not fit the map.
    #[error("{given} costs of the ground given, the map has {expected} cells: give one for each cell")]
    GroundShapeWrong {
        /// Number given.
        given: usize,
        /// Cells of the map.
        expected: usize,
    },
    /// A setting is out of range.
    #[error("navigator setting {key} is {value}: it must be a finite number greater than 0")]
    NavigatorSettingInvalid {
        /// Dotted key.
        key: String,
        /// What was given.
        value: f64,
    },
    /// A setting is outside its range.
    #[error("navigator setting {key} is {value}: it must be a finite number from {least} to {most}")]
    NavigatorValueOutOfRange {
        /// Dotted key.
        key: String,
        /// What was given.
        value: f64,
        /// Least usable value.
        least: f64,
        /// Greatest usable value.
        most: f64,
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
    /// The localiser refused its part.
    #[error(transparent)]
    #[serde(untagged)]
    Localiser(#[from] LocaliserError),
    /// The cost map refused its part.
    #[error(transparent)]
    #[serde(untagged)]
    Costmap(#[from] WorldError),
    /// The mapper refused its part.
    #[error(transparent)]
    #[serde(untagged)]
    Mapping(#[from] MappingError),
}
