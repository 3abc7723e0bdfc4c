//! The tiles of a grid: their numbers, and what their borders have been offered.

use super::SIDE;
use super::lanes::{Lanes, TileCost};
use super::sweep::CELLS;

/// Numbers from one tile to the next: a little more than a tile, so that the tiles of a column do not
/// all fall into the same sets of the cache.
const STRIDE: usize = CELLS + 32;
/// Bytes of a line of the cache.
const LINE: usize = 64;
/// Numbers of the border record of a tile.
const BORDER: usize = 4 * SIDE;

/// A side of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Lower rows.
    North,
    /// Higher rows.
    South,
    /// Lower columns.
    West,
    /// Higher columns.
    East,
}

/// Bits of what a tile has not looked at yet: one per [`Side`] whose record fell, and one for a tile
/// of which every line must be carried on.
pub type News = u8;

impl Side {
    /// Its bit in [`News`].
    pub const fn bit(self) -> News {
        1 << self as u8
    }
}

/// Every line of the tile must be carried on.
pub const ALL_LINES: News = 1 << 4;

/// Room for the tiles of a grid, kept from one solution to the next; memory is touched when a tile is.
#[derive(Debug)]
pub struct Board<T> {
    /// Tiles down.
    pub tile_rows: usize,
    /// Tiles across.
    pub tile_cols: usize,
    numbers: Vec<T>,
    aligned: usize,
    /// The numbers of the four border lines of each tile, or less where a neighbour offers less.
    borders: Vec<T>,
}

impl<T: TileCost> Default for Board<T> {
    fn default() -> Self {
        Self { tile_rows: 0, tile_cols: 0, numbers: Vec::new(), aligned: 0, borders: Vec::new() }
    }
}

impl<T: TileCost> Board<T> {
    /// Makes room for a grid of so many tiles, nothing offered.
    pub fn reset(&mut self, tile_rows: usize, tile_cols: usize) {
        self.make_room(tile_rows, tile_cols);
        self.borders.clear();
        self.borders.resize(tile_rows * tile_cols * BORDER, T::FAR);
    }

    /// Makes room for a grid of so many tiles; their border records hold anything.
    pub fn make_room(&mut self, tile_rows: usize, tile_cols: usize) {
        let tiles = tile_rows * tile_cols;
        (self.tile_rows, self.tile_cols) = (tile_rows, tile_cols);
        self.numbers.reserve_exact(tiles * STRIDE + CELLS); // these stay empty: only the room is used
        self.aligned = self.numbers.as_ptr().align_offset(64);
        self.borders.reserve_exact((tiles * BORDER).saturating_sub(self.borders.len()));
    }

    /// The numbers of a tile, row by row, once it was visited.
    pub fn tile(&self, tile: usize) -> *mut T {
        assert!(tile < self.tile_rows * self.tile_cols);
        // SAFETY: `reset` reserved a stride for each tile behind the aligned start.
        unsafe { self.numbers.as_ptr().cast_mut().add(self.aligned + tile * STRIDE) }
    }

    /// Says that a tile will soon be visited.
    #[inline(always)]
    pub fn prefetch<L: Lanes<Number = T>>(&self, tile: usize) {
        let (numbers, record) = (self.tile(tile), self.border(tile, Side::North));
        for at in (0..CELLS).step_by(LINE / size_of::<T>()) {
            L::prefetch_for_writing(numbers.wrapping_add(at));
        }
        for at in (0..BORDER).step_by(LINE / size_of::<T>()) {
            L::prefetch_for_writing(record.wrapping_add(at));
        }
    }

    /// The border record of a tile along `side`.
    pub fn border(&self, tile: usize, side: Side) -> *mut T {
        assert!(tile < self.tile_rows * self.tile_cols);
        // SAFETY: `reset` reserved a record for each tile.
        unsafe { self.borders.as_ptr().cast_mut().add(tile * BORDER + side as usize * SIDE) }
    }

    /// The tile beside `tile`, if there is one.
    pub fn beside(&self, tile: usize, down: isize, right: isize) -> Option<usize> {
        let row = (tile / self.tile_cols).checked_add_signed(down).filter(|&row| row < self.tile_rows)?;
        let col = (tile % self.tile_cols).checked_add_signed(right).filter(|&col| col < self.tile_cols)?;
        Some(row * self.tile_cols + col)
    }
}

// SAFETY: threads share a board only through pointers, and keep apart from each other.
unsafe impl<T: TileCost> Sync for Board<T> {}
