//! The brain of Cairn, the navigation system of Maalouf, Saad, Saliah and Mnif (2006) `[Maalouf06]`.
//!
//! No files, clocks, screens or wires live here: time and seeds are arguments, so a run replays to
//! the bit. Units are SI and radians; frames are named `a_from_b` (transforms) and `x_in_a` (points).
//!
//! Arrows between the rooms: `geometry ← world ← {plan, track, avoid, locate} ← navigate`;
//! `robot` needs only `geometry`; `fuzzy` needs nothing.
//!
//! ```
//! use cairn::geometry::Pose2;
//! use cairn::plan::{PlanOptions, plan_free};
//! use cairn::world::{Cell, Grid, GridGeometry};
//!
//! let geometry = GridGeometry { rows: 3, cols: 4, resolution_m: 0.5, world_from_grid: Pose2::default() };
//! let mut free = Grid::filled(geometry, true);
//! free.values[geometry.index(Cell::new(1, 1))] = false;
//! let field = plan_free(&free, &[Cell::new(0, 0)], &PlanOptions::default())?;
//! assert_eq!(field.cost_to_go(Cell::new(0, 3)), 3.0); // straight steps, times 0.5 m
//! assert_eq!(field.path(Cell::new(2, 2)).map(|way| way.len()), Some(5)); // no corner is cut
//! # Ok::<(), cairn::plan::PlanError>(())
//! ```

// Tests within share files with those beside the crate.
#[cfg(test)]
extern crate self as cairn;

pub mod avoid;
pub mod fuzzy;
pub mod geometry;
pub mod locate;
pub mod navigate;
pub mod plan;
pub mod robot;
pub mod track;
pub mod world;
