//! Grids of the world: occupancy, costs, and what turns one into the other.

mod grid;

pub use grid::{Cell, Grid, GridGeometry, Occupancy, OccupancyGrid};
