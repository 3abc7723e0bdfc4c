//! The brain of Cairn, the navigation system of Maalouf, Saad, Saliah and Mnif (2006) `[Maalouf06]`.
//!
//! No files, clocks, screens or wires live here: time and seeds are arguments, so a run replays to
//! the bit. Units are SI and radians; frames are named `a_from_b` (transforms) and `x_in_a` (points).
//!
//! Arrows between the rooms: `geometry ← world ← {plan, track, avoid, locate} ← navigate`;
//! `robot` needs only `geometry`; `fuzzy` needs nothing.

pub mod avoid;
pub mod fuzzy;
pub mod geometry;
pub mod locate;
pub mod navigate;
pub mod plan;
pub mod robot;
pub mod track;
pub mod world;
