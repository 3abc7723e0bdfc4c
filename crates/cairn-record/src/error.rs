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
    /// The file cannot be read, or is no log.
    #[error("{path} cannot be read as a log: {reason}")]
    LogUnreadable {
        /// The file.
        path: String,
        /// What is wrong with it.
        reason: String,
    },
}
