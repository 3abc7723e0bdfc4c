use serde::Serialize;
use thiserror::Error;

use crate::fuzzy::FuzzyError;

/// Why a path, a controller or a measurement was refused.
#[derive(Clone, Debug, PartialEq, Error, Serialize)]
pub enum TrackError {
    /// There is nothing to follow.
    #[error("the path has no points, must have at least one")]
    PathEmpty,
    /// A point of the path is not a pair of finite numbers.
    #[error("point {index} of the path is ({x}, {y}), must be finite")]
    PathPointNotFinite {
        /// Which point, counted from 0.
        index: usize,
        /// Its x \[m\].
        x: f64,
        /// Its y \[m\].
        y: f64,
    },
    /// A number of the tracker's or the waypoints' configuration cannot be used.
    #[error("{key} is {value}, must be a finite number {must_be}")]
    TrackValueOutOfRange {
        /// Dotted key.
        key: String,
        /// What was given.
        value: f64,
        /// The condition it breaks.
        must_be: String,
    },
    /// A fuzzy system of the controller does not have the inputs and outputs that tracking needs.
    #[error("controller system `{system}` has {kind} {found}, must have {needed}")]
    ControllerMismatch {
        /// `look_ahead` or `tracker`.
        system: String,
        /// `inputs` or `outputs`.
        kind: String,
        /// What it has.
        found: String,
        /// What it must have.
        needed: String,
    },
    /// A fuzzy system of the controller is wrong in itself.
    #[error("controller system `{system}`: {cause}")]
    ControllerInvalid {
        /// `look_ahead` or `tracker`.
        system: String,
        /// What is wrong with it.
        cause: FuzzyError,
    },
    /// A pose or a twist is not finite.
    #[error("{what} is {value}: it must be a finite number")]
    MeasurementNotFinite {
        /// Which number of it.
        what: String,
        /// What was given.
        value: f64,
    },
    /// A tick's duration is not positive.
    #[error("dt is {dt_s} s: it must be a finite number greater than 0")]
    TimeStepInvalid {
        /// What was given.
        dt_s: f64,
    },
}
