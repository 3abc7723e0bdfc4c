//! The production solver for grids: square tiles, each settled by sweeps, that wake one another until
//! nothing changes. It is the paper's idea, layers that are worked on until no cost falls
//! [Maalouf06 §3.2], with tiles for layers.

#![allow(unsafe_code)] // vector instructions and tiles shared between threads

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "x86_64")]
mod avx512_wide;
mod bits;
mod board;
mod creep;
mod directed;
mod finish;
mod free;
mod lanes;
#[cfg(test)]
mod lanes_tests;
mod level;
mod mean;
mod open;
#[cfg(any(test, not(target_arch = "x86_64")))]
mod plain;
mod queue;
#[cfg(target_arch = "x86_64")]
mod registers;
mod repair;
mod run;
mod shadow;
mod sheet;
mod slopes;
#[cfg(target_arch = "x86_64")]
mod sse2;
mod sweep;
mod thin;
mod visit;

pub use bits::FreeBits;
pub use directed::DirectedGrid;
pub use free::FreeGrid;
pub use lanes::TileCost;
pub use level::{Loops, Simd, at_widest};
pub use mean::{CellNumber, MeanGrid};
pub use repair::{Repair, Repaired, repair};
pub use run::{Room, Solved, Task, solve};
pub use visit::Links;

/// Rows and columns of a tile.
const SIDE: usize = 64;
