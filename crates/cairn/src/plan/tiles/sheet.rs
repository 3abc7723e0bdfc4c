//! Numbers of the cells of a tile and around it, and the same turned about the diagonal.

use super::SIDE;
use super::lanes::{LANES, Lanes};

/// Numbers from one line to the next: a tile's width and a vector of margin on both sides.
pub const PITCH: usize = SIDE + 2 * LANES;
/// Lines of a tile and one around it.
pub const LINES: usize = SIDE + 2;

/// A number for each cell of a tile and around it: that of cell (row, col) at
/// `(row + 1) * PITCH + LANES + col`.
#[repr(align(64))]
#[derive(Clone)]
pub struct Sheet<T>(pub [T; LINES * PITCH]);

impl<T: Copy> Sheet<T> {
    /// The same number everywhere.
    pub fn all(number: T) -> Box<Self> {
        Box::new(Self([number; LINES * PITCH]))
    }

    /// The sixteen numbers from `at` on.
    ///
    /// # Safety
    /// There are as many, and the caller's function has the level of L enabled.
    #[inline(always)]
    pub unsafe fn at<L: Lanes<Number = T>>(&self, at: usize) -> L {
        unsafe { L::load(self.0.as_ptr().add(at)) }
    }

    /// Writes the tile, turned, to `to`; what is around it stays there.
    ///
    /// # Safety
    /// The caller's function has the level of L enabled.
    #[inline(always)]
    pub unsafe fn turn_tile<L: Lanes<Number = T>>(&self, to: &mut Self) {
        let inside = |row: usize, col: usize| (row + 1) * PITCH + LANES + col;
        for row in (0..SIDE).step_by(LANES) {
            for col in (0..SIDE).step_by(LANES) {
                // SAFETY: both sheets hold the tile.
                unsafe {
                    let from = self.0.as_ptr().add(inside(row, col));
                    L::transpose(from, PITCH, to.0.as_mut_ptr().add(inside(col, row)), PITCH);
                }
            }
        }
    }

    /// Writes the tile and the cells around it, turned, to `to`.
    ///
    /// # Safety
    /// The caller's function has the level of L enabled.
    #[inline(always)]
    pub unsafe fn turn<L: Lanes<Number = T>>(&self, to: &mut Self) {
        // SAFETY: the caller's.
        unsafe { self.turn_tile::<L>(to) };
        for i in 0..LINES {
            let (first, last) = (LANES - 1, LANES + SIDE); // columns just outside the tile
            to.0[LANES - 1 + i] = self.0[i * PITCH + first];
            to.0[(LINES - 1) * PITCH + LANES - 1 + i] = self.0[i * PITCH + last];
            to.0[i * PITCH + first] = self.0[LANES - 1 + i];
            to.0[i * PITCH + last] = self.0[(LINES - 1) * PITCH + LANES - 1 + i];
        }
    }
}
