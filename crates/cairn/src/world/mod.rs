//! Grids of the world: occupancy, costs, and what turns one into the other.

mod costmap;
mod distance;
mod evidence;
mod grid;
mod kept_costs;
mod local_map;
mod mapping;
mod marks;
mod maze;
mod motion;
mod random;
mod raycast;
mod shapes;
mod sonar_model;

pub use costmap::{CostLayer, CostmapConfig, UnknownCells, WorldError, costmap, costmap_with_layers};
pub use distance::{distance_to_occupied, distance_to_surface};
pub use grid::{Cell, Grid, GridGeometry, Occupancy, OccupancyGrid};
pub use kept_costs::{CostChanges, KeptCosts};
pub use local_map::{Beams, LocalMap, LocalMapConfig};
pub use mapping::{MappingConfig, MappingError, OccupancyMap};
pub use marks::CellSet;
pub use maze::perfect_maze;
pub use motion::{Followed, MotionConfig, MotionWatch};
pub(crate) use random::SplitMix;
pub use raycast::raycast;
pub use shapes::{Block, Circle, RayHit, ShapeError, Shapes, Touch, Touched, check_circles};
pub use sonar_model::{SonarEcho, sonar_echo, sonar_range};
