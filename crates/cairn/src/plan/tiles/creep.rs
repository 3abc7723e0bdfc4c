//! The field inside a tile of narrow corridors, cell by cell: sweeps would turn round at every bend.

use super::SIDE;
use super::bits::Lines;
use super::lanes::TileCost;
use super::sweep::{CELLS, Dirty, Marks};

/// Moves between free cells of one tile, by the nine cells around: bit 3 i + j for row i - 1 and column
/// j - 1 from the cell; bit k of the entry for the move with code k.
type Table = [u8; 512];

const fn table(cut: bool) -> Table {
    let mut table = [0; 512];
    let mut around = 0;
    while around < 512 {
        let mut code = 0;
        while code < 8 {
            let (down, right) = crate::plan::moves::MOVES[code];
            let to = around >> ((down + 1) * 3 + right + 1) & 1 == 1;
            let beside = around >> (3 + right + 1) & 1 == 1 && around >> ((down + 1) * 3 + 1) & 1 == 1;
            if to && (cut || code % 2 == 0 || beside) {
                table[around] |= 1 << code;
            }
            code += 1;
        }
        around += 1;
    }
    table
}

static ALLOWED: [Table; 2] = [table(false), table(true)];

/// Room for the cells that wait: each waits once.
pub struct Creep {
    waiting: [u16; CELLS],
    is_waiting: [u64; SIDE],
}

impl Default for Creep {
    fn default() -> Self {
        Self { waiting: [0; CELLS], is_waiting: [0; SIDE] }
    }
}

/// Whether a tile is of narrow corridors: there are few squares of four free cells.
#[inline(always)]
pub fn is_narrow(free: &Lines) -> bool {
    let (mut cells, mut squares) = (0, 0);
    for row in 1..=SIDE {
        let both = free[row] & free[row + 1];
        cells += free[row].count_ones();
        squares += (both & both >> 1).count_ones();
    }
    squares * 8 < cells
}

impl Creep {
    /// Carries on from the cells in dirty rows and dirty columns until nothing falls. `through` is the
    /// number offered to a cell with the number of another, from that one, with the code of the move there.
    ///
    /// # Safety
    /// `values` holds a tile.
    #[inline(always)]
    pub unsafe fn settle<T: TileCost, const CUT: bool>(
        &mut self,
        values: *mut T,
        free: &Lines,
        through: impl Fn(T, usize, usize, usize) -> T,
        dirty: Dirty,
    ) -> Marks {
        let allowed = &ALLOWED[usize::from(CUT)];
        let (mut first, mut behind) = (0_usize, 0_usize); // of the cells that wait, modulo their room
        let mut fell = Marks::default();
        let (mut rows, cols) = (dirty.down | dirty.up, dirty.left | dirty.right);
        while rows != 0 {
            let row = rows.trailing_zeros() as usize;
            rows &= rows - 1;
            let mut cells = cols & free[row + 1];
            while cells != 0 {
                let cell = row * SIDE + cells.trailing_zeros() as usize;
                cells &= cells - 1;
                // SAFETY: a cell of the tile.
                if unsafe { *values.add(cell) } < T::FAR {
                    self.is_waiting[row] |= 1 << (cell % SIDE);
                    self.waiting[behind % CELLS] = cell as u16;
                    behind += 1;
                }
            }
        }
        while first != behind {
            let cell = usize::from(self.waiting[first % CELLS]);
            first += 1;
            let (row, col) = (cell / SIDE, cell % SIDE);
            self.is_waiting[row] &= !(1 << col);
            // Lines outside the tile count as blocked: nothing is carried there.
            let three = |line: usize| (u128::from(free[line]) << 1 >> col) as usize & 7;
            let above = if row > 0 { three(row) } else { 0 };
            let below = if row + 1 < SIDE { three(row + 2) } else { 0 };
            let mut moves = allowed[above | three(row + 1) << 3 | below << 6];
            // SAFETY: a cell of the tile.
            let here = unsafe { *values.add(cell) };
            while moves != 0 {
                let code = moves.trailing_zeros() as usize;
                moves &= moves - 1;
                let (down, right) = crate::plan::moves::MOVES[code];
                let to = cell.wrapping_add_signed(down * SIDE as isize + right);
                let offered = through(here, cell, to, code);
                // SAFETY: moves end at cells of the tile.
                let there = unsafe { &mut *values.add(to) };
                if offered < *there {
                    *there = offered;
                    let (row, bit) = (to / SIDE, 1_u64 << (to % SIDE));
                    fell.lines |= 1 << row;
                    fell.across |= bit;
                    if self.is_waiting[row] & bit == 0 {
                        self.is_waiting[row] |= bit;
                        self.waiting[behind % CELLS] = to as u16;
                        behind += 1;
                    }
                }
            }
        }
        fell
    }
}
