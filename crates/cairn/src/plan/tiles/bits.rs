//! Which cells are free, one bit each, in words of a tile's width, along rows and along columns.

use super::SIDE;

/// Free cells of a grid. Whatever lies outside is not free.
#[derive(Clone, Debug, Default)]
pub struct FreeBits {
    /// Tiles down and across.
    pub tile_rows: usize,
    /// Tiles across.
    pub tile_cols: usize,
    /// Word of row `tile_row * SIDE + i` in `tile_col` at `(tile * SIDE) + i`; bit j is column j of the tile.
    along_rows: Vec<u64>,
    /// The same turned about the diagonal of each tile.
    along_cols: Vec<u64>,
}

/// The free cells of one tile and of the lines around it: word 0 is the line before the tile's first,
/// word `SIDE + 1` the line behind its last.
pub type Lines = [u64; SIDE + 2];

impl FreeBits {
    /// Packs `free(row, 0..cols)` given row by row.
    pub fn pack(&mut self, rows: usize, cols: usize, free: &[bool]) {
        self.tile_rows = rows.div_ceil(SIDE);
        self.tile_cols = cols.div_ceil(SIDE);
        let words = self.tile_rows * self.tile_cols * SIDE;
        self.along_rows.clear();
        self.along_rows.resize(words, 0);
        self.along_cols.resize(words, 0);
        for (row, cells) in free.chunks_exact(cols).enumerate() {
            let first = (row / SIDE * self.tile_cols) * SIDE + row % SIDE;
            for (tile_col, cells) in cells.chunks(SIDE).enumerate() {
                self.along_rows[first + tile_col * SIDE] = packed(cells);
            }
        }
        let tiles =
            self.along_rows.as_chunks::<SIDE>().0.iter().zip(self.along_cols.as_chunks_mut::<SIDE>().0);
        for (rows, cols) in tiles {
            *cols = *rows;
            turn(cols);
        }
    }

    /// Fills the lines of a tile along rows and along columns; bits are the tile's own columns or rows.
    #[inline]
    pub fn lines(&self, tile: usize, rows: &mut Lines, cols: &mut Lines) {
        let (tile_row, tile_col) = (tile / self.tile_cols, tile % self.tile_cols);
        let base = tile * SIDE;
        rows[1..=SIDE].copy_from_slice(&self.along_rows[base..base + SIDE]);
        cols[1..=SIDE].copy_from_slice(&self.along_cols[base..base + SIDE]);
        let across = self.tile_cols * SIDE;
        rows[0] = if tile_row > 0 { self.along_rows[base - across + SIDE - 1] } else { 0 };
        rows[SIDE + 1] = if tile_row + 1 < self.tile_rows { self.along_rows[base + across] } else { 0 };
        cols[0] = if tile_col > 0 { self.along_cols[base - 1] } else { 0 };
        cols[SIDE + 1] = if tile_col + 1 < self.tile_cols { self.along_cols[base + SIDE] } else { 0 };
    }

    /// Makes a cell free, or not.
    pub fn set(&mut self, row: usize, col: usize, free: bool) {
        let words = (row / SIDE * self.tile_cols + col / SIDE) * SIDE;
        for (word, bit) in [
            (&mut self.along_rows[words + row % SIDE], 1_u64 << (col % SIDE)),
            (&mut self.along_cols[words + col % SIDE], 1_u64 << (row % SIDE)),
        ] {
            *word = if free { *word | bit } else { *word & !bit };
        }
    }

    /// Whether a cell is free; false outside.
    #[inline]
    pub fn is_free(&self, row: usize, col: usize) -> bool {
        let (tile_row, tile_col) = (row / SIDE, col / SIDE);
        tile_row < self.tile_rows
            && tile_col < self.tile_cols
            && self.along_rows[(tile_row * self.tile_cols + tile_col) * SIDE + row % SIDE] >> (col % SIDE) & 1
                == 1
    }
}

/// At most 64 cells as one word, the first in bit 0.
#[inline]
fn packed(cells: &[bool]) -> u64 {
    let (eights, rest) = cells.as_chunks::<8>();
    let mut word = 0;
    for (i, eight) in eights.iter().enumerate() {
        // Eight bytes of 0 or 1: the product gathers their low bits, in order, in the top byte.
        let bytes = u64::from_le_bytes(eight.map(u8::from));
        word |= (bytes.wrapping_mul(0x0102_0408_1020_4080) >> 56) << (8 * i);
    }
    for (i, &cell) in rest.iter().enumerate() {
        word |= u64::from(cell) << (8 * eights.len() + i);
    }
    word
}

/// Turns a 64 × 64 bit matrix about its diagonal [Warren, Hacker's Delight §7-3].
fn turn(rows: &mut [u64; SIDE]) {
    let mut half = 32;
    let mut mask = 0x0000_0000_ffff_ffff_u64;
    while half != 0 {
        let mut row = 0;
        while row < SIDE {
            let swap = (rows[row] >> half ^ rows[row + half]) & mask;
            rows[row] ^= swap << half;
            rows[row + half] ^= swap;
            row = (row + half + 1) & !half;
        }
        half >>= 1;
        mask ^= mask << half;
    }
}
