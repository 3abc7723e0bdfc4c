//! Where the robot is: encoders and gyro, ranges matched to a known map, and, where nothing is known
//! of the pose, a search of the whole map.

mod beams;
mod field;
mod history;
mod localiser;
mod matching;
mod modes;
mod monte_carlo;
mod odometry;
mod scan;
mod scan_matching;
mod slip;
mod survey;

pub use localiser::{LocaliseReport, LocaliseState, Localiser, LocaliserConfig, LocaliserError};
pub use matching::{MapMatcher, MatchReport, MatchingConfig, MatchingError};
pub use monte_carlo::{LocaliseError, MonteCarlo, MonteCarloConfig, PoseEstimate};
pub use odometry::{Odometry, OdometryConfig, OdometryError, WheelTravel};
pub use scan::Explained;
pub use scan_matching::{ScanMatch, ScanMatchConfig, match_scan};
