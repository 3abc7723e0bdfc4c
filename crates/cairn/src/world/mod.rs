//! Grids of the world: occupancy, costs, and what turns one into the other.

mod costmap;
mod distance;
mod grid;

pub use costmap::{CostLayer, CostmapConfig, UnknownCells, WorldError, costmap, costmap_with_layers};
pub use distance::{distance_to_occupied, distance_to_surface};
pub use grid::{Cell, Grid, GridGeometry, Occupancy, OccupancyGrid};
