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
    /// A pose, a twist or a duration is not a finite number.
    #[error("{quantity} is {value}, must be a finite number{more}")]
    MeasurementNotFinite {
        /// Which one.
        quantity: String,
        /// What was given.
        value: f64,
        /// What else it must be.
        more: String,
    },
}
