use serde::Serialize;
use thiserror::Error;

/// What can go wrong with a log.
#[derive(Clone, Debug, PartialEq, Error, Serialize)]
pub enum RecordError {
    /// The file cannot be written, or no longer.
    #[error("the log {path} cannot be written: {reason}")]
    LogUnwritable {
        /// The file.
        path: String,
        /// What the system says.
        reason: String,
    },
    /// No robot has this number.
    #[error("the log records {robots} robots: there is none of number {number}, counted from 0")]
    RecordedRobotUnknown {
        /// What was given.
        number: usize,
        /// How many there are.
        robots: usize,
    },
    /// The file cannot be read, or is no log.
    #[error("{path} cannot be read as a log: {reason}")]
    LogUnreadable {
        /// The file.
        path: String,
        /// What is wrong with it.
        reason: String,
    },
}
