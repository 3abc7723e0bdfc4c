//! Which ways lead over forgotten cells: the part of the policy's tree above them, found for 64 cells of a
//! row at once.

use super::SIDE;
use crate::plan::moves::MOVES;

/// A word for each row of a tile; bit j is column j.
type Bits = [u64; SIDE];

/// A policy, row-major.
pub struct Policy<'a> {
    /// Codes of the next cell; -1 for none.
    pub codes: &'a [i8],
    /// Rows of the grid.
    pub rows: usize,
    /// Columns of the grid.
    pub cols: usize,
}

impl Policy<'_> {
    /// For each code, the cells of a tile that have it.
    fn cells_by_code(&self, tile: usize) -> [Bits; 8] {
        let across = self.cols.div_ceil(SIDE);
        let (first_row, first_col) = (tile / across * SIDE, tile % across * SIDE);
        let cols = (self.cols - first_col).min(SIDE);
        let mut cells = [[0; SIDE]; 8];
        let mut padded = [-1_i8; SIDE];
        for line in 0..(self.rows - first_row).min(SIDE) {
            let at = (first_row + line) * self.cols + first_col;
            padded[..cols].copy_from_slice(&self.codes[at..at + cols]);
            let [ones, twos, fours, none] = [0, 1, 2, 7].map(|bit| gathered(&padded, bit));
            for (code, cells) in cells.iter_mut().enumerate() {
                let where_set = |bits: u64, weight: usize| if code & weight == 0 { !bits } else { bits };
                cells[line] = !none & where_set(ones, 1) & where_set(twos, 2) & where_set(fours, 4);
            }
        }
        cells
    }
}

/// A bit of each of 64 codes, the first in bit 0.
fn gathered(codes: &[i8; SIDE], bit: u32) -> u64 {
    let mut word = 0;
    for (i, eight) in codes.as_chunks::<8>().0.iter().enumerate() {
        let bits = u64::from_le_bytes(eight.map(|code| code as u8)) >> bit & 0x0101_0101_0101_0101;
        // The product gathers the low bits of eight bytes, in order, in its top byte.
        word |= (bits.wrapping_mul(0x0102_0408_1020_4080) >> 56) << (8 * i);
    }
    word
}

/// What is known of a tile.
#[derive(Debug)]
struct Page {
    tile: usize,
    /// For each code, the cells that had it.
    cells: [Bits; 8],
    forgotten: Bits,
    waits: bool,
}

/// The forgotten cells of a grid.
#[derive(Debug, Default)]
pub struct Shadow {
    /// Per tile, one more than the number of its page; 0 without.
    page_of: Vec<u32>,
    pages: Vec<Page>,
    waiting: Vec<u32>,
    tile_cols: usize,
    tile_rows: usize,
}

impl Shadow {
    /// Forgets nothing yet.
    pub fn reset(&mut self, tile_rows: usize, tile_cols: usize) {
        for page in self.pages.drain(..) {
            if let Some(number) = self.page_of.get_mut(page.tile) {
                *number = 0;
            }
        }
        self.page_of.resize(tile_rows * tile_cols, 0);
        self.waiting.clear();
        (self.tile_rows, self.tile_cols) = (tile_rows, tile_cols);
    }

    /// Forgets one cell.
    pub fn forget(&mut self, policy: &Policy<'_>, row: usize, col: usize) {
        let page = self.page(policy, row / SIDE * self.tile_cols + col / SIDE);
        self.pages[page].forgotten[row % SIDE] |= 1 << (col % SIDE);
        self.wake(page);
    }

    /// Forgets every cell whose way leads over a forgotten one; returns how many are forgotten then. None if
    /// they are more than `most`.
    pub fn spread(&mut self, policy: &Policy<'_>, most: usize) -> Option<usize> {
        let mut count: usize = self.pages.iter().map(|page| ones(&page.forgotten)).sum();
        while let Some(page) = self.waiting.pop() {
            let page = page as usize;
            self.pages[page].waits = false;
            let before = ones(&self.pages[page].forgotten);
            let around = Around::new(self, self.pages[page].tile);
            let Page { cells, forgotten, tile, .. } = &mut self.pages[page];
            let tile = *tile;
            around.spread(cells, forgotten);
            count += ones(forgotten) - before;
            if count > most {
                return None;
            }
            // A cell beside the tile may rest on a forgotten one at the tile's edge.
            let (north, south) = (forgotten[0], forgotten[SIDE - 1]);
            let any = forgotten.iter().fold(0, |any, row| any | row);
            let edge = |down: isize, right: isize| {
                let rows = [north, any, south][(down + 1) as usize];
                rows & [1, !0, 1 << (SIDE - 1)][(right + 1) as usize] != 0
            };
            for (down, right) in MOVES {
                if edge(down, right)
                    && let Some(other) = self.beside(tile, down, right)
                {
                    let other = self.page(policy, other);
                    if Around::new(self, self.pages[other].tile).reaches(&self.pages[other]) {
                        self.wake(other);
                    }
                }
            }
        }
        Some(count)
    }

    /// The forgotten cells, a word of a tile's row each: the tile, the row in it, and the cells.
    pub fn forgotten(&self) -> impl Iterator<Item = (usize, usize, u64)> {
        self.pages.iter().flat_map(|page| {
            let rows = page.forgotten.iter().enumerate().filter(|&(_, &cells)| cells != 0);
            rows.map(|(row, &cells)| (page.tile, row, cells))
        })
    }

    fn page(&mut self, policy: &Policy<'_>, tile: usize) -> usize {
        if self.page_of[tile] == 0 {
            let cells = policy.cells_by_code(tile);
            self.pages.push(Page { tile, cells, forgotten: [0; SIDE], waits: false });
            self.page_of[tile] = self.pages.len() as u32;
        }
        self.page_of[tile] as usize - 1
    }

    fn wake(&mut self, page: usize) {
        if !std::mem::replace(&mut self.pages[page].waits, true) {
            self.waiting.push(page as u32);
        }
    }

    fn beside(&self, tile: usize, down: isize, right: isize) -> Option<usize> {
        let row = (tile / self.tile_cols).checked_add_signed(down).filter(|&row| row < self.tile_rows)?;
        let col = (tile % self.tile_cols).checked_add_signed(right).filter(|&col| col < self.tile_cols)?;
        Some(row * self.tile_cols + col)
    }

    /// The forgotten cells of a row of the tile beside; none without a page.
    fn row_beside(&self, tile: usize, down: isize, right: isize, row: usize) -> u64 {
        let page = self.beside(tile, down, right).map_or(0, |other| self.page_of[other] as usize);
        if page == 0 { 0 } else { self.pages[page - 1].forgotten[row] }
    }
}

fn ones(bits: &Bits) -> usize {
    bits.iter().map(|row| row.count_ones() as usize).sum()
}

/// The forgotten cells around a tile.
struct Around {
    /// The row before the tile's first and the one behind its last.
    beyond: [u64; 2],
    /// In bit 0, for the row before, the tile's rows and the row behind: the cell left of the tile.
    west: [u64; SIDE + 2],
    /// In bit 63: the cell right of it.
    east: [u64; SIDE + 2],
}

impl Around {
    fn new(shadow: &Shadow, tile: usize) -> Self {
        const LAST: usize = SIDE - 1;
        let [mut west, mut east] = [[0; SIDE + 2]; 2];
        for (line, (down, row)) in [(0, (-1, LAST)), (SIDE + 1, (1, 0))] {
            west[line] = shadow.row_beside(tile, down, -1, row) >> LAST;
            east[line] = shadow.row_beside(tile, down, 1, row) << LAST;
        }
        for row in 0..SIDE {
            west[row + 1] = shadow.row_beside(tile, 0, -1, row) >> LAST;
            east[row + 1] = shadow.row_beside(tile, 0, 1, row) << LAST;
        }
        let beyond = [shadow.row_beside(tile, -1, 0, LAST), shadow.row_beside(tile, 1, 0, 0)];
        Self { beyond, west, east }
    }

    /// The cells of a row whose next cell is in the line before it (`up`) or behind it, and forgotten.
    #[inline(always)]
    fn resting(&self, cells: &[Bits; 8], forgotten: &Bits, row: usize, up: bool) -> u64 {
        let line = if up { row } else { row + 2 }; // of `west` and `east`
        let next = match line {
            0 => self.beyond[0],
            line if line == SIDE + 1 => self.beyond[1],
            line => forgotten[line - 1],
        };
        let (to_left, to_right) = (next << 1 | self.west[line], next >> 1 | self.east[line]);
        let [left, straight, right] = if up { [5, 6, 7] } else { [3, 2, 1] };
        cells[left][row] & to_left | cells[straight][row] & next | cells[right][row] & to_right
    }

    /// Spreads inside the tile until nothing is added.
    fn spread(&self, cells: &[Bits; 8], forgotten: &mut Bits) {
        loop {
            let mut added = 0;
            for up in [true, false] {
                for i in 0..SIDE {
                    let row = if up { i } else { SIDE - 1 - i };
                    let before = forgotten[row];
                    let mut bits = before | self.resting(cells, forgotten, row, up);
                    bits |= cells[4][row] & self.west[row + 1] | cells[0][row] & self.east[row + 1];
                    bits = along(bits, cells[4][row], cells[0][row]);
                    forgotten[row] = bits;
                    added |= bits & !before;
                }
            }
            if added == 0 {
                return;
            }
        }
    }

    /// Whether a cell of the page rests on one around it, and is not forgotten yet.
    fn reaches(&self, page: &Page) -> bool {
        let nothing = [0; SIDE];
        let mut resting = self.resting(&page.cells, &nothing, 0, true) & !page.forgotten[0];
        resting |= self.resting(&page.cells, &nothing, SIDE - 1, false) & !page.forgotten[SIDE - 1];
        for row in 0..SIDE {
            let (up, down) = (row, row + 2);
            let left = page.cells[4][row] & self.west[row + 1]
                | page.cells[5][row] & self.west[up]
                | page.cells[3][row] & self.west[down];
            let right = page.cells[0][row] & self.east[row + 1]
                | page.cells[7][row] & self.east[up]
                | page.cells[1][row] & self.east[down];
            resting |= (left | right) & !page.forgotten[row];
        }
        resting != 0
    }
}

/// Adds to the cells of a row those that lead to one of them along the row: to the left, or to the right.
#[inline(always)]
fn along(mut bits: u64, mut to_left: u64, mut to_right: u64) -> u64 {
    let mut step = 1;
    while step < SIDE {
        bits |= to_left & bits << step | to_right & bits >> step;
        to_left &= to_left << step;
        to_right &= to_right >> step;
        step *= 2;
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(state: &mut u64) -> u64 {
        *state ^= *state << 13;
        *state ^= *state >> 7;
        *state ^= *state << 17;
        *state >> 33
    }

    #[test]
    fn forgets_exactly_the_cells_whose_way_leads_over_a_forgotten_one() {
        let mut state = 7;
        for (rows, cols) in [(1, 1), (1, 200), (200, 1), (64, 64), (65, 130), (150, 190)] {
            for bias in [0, 3, 6] {
                // Mostly one way, so that ways are long; other codes, none and cycles among them.
                let codes: Vec<i8> = (0..rows * cols)
                    .map(|_| match random(&mut state) % 16 {
                        0 => -1,
                        1..=4 => (random(&mut state) % 8) as i8,
                        _ => bias + (random(&mut state) % 2) as i8,
                    })
                    .collect();
                let policy = Policy { codes: &codes, rows, cols };
                let seeds: Vec<usize> = (0..3).map(|_| random(&mut state) as usize % (rows * cols)).collect();
                let mut shadow = Shadow::default();
                shadow.reset(rows.div_ceil(SIDE), cols.div_ceil(SIDE));
                for &seed in &seeds {
                    shadow.forget(&policy, seed / cols, seed % cols);
                }
                let count = shadow.spread(&policy, usize::MAX).unwrap();
                let mut found = vec![false; rows * cols];
                for (tile, row, cells) in shadow.forgotten() {
                    let across = cols.div_ceil(SIDE);
                    for col in (0..SIDE).filter(|col| cells >> col & 1 == 1) {
                        found[(tile / across * SIDE + row) * cols + tile % across * SIDE + col] = true;
                    }
                }

                let mut expected = vec![false; rows * cols];
                let mut stack = seeds.clone();
                seeds.iter().for_each(|&seed| expected[seed] = true);
                while let Some(cell) = stack.pop() {
                    for (code, (down, right)) in MOVES.iter().enumerate() {
                        let row = (cell / cols).checked_add_signed(-down).filter(|&row| row < rows);
                        let col = (cell % cols).checked_add_signed(-right).filter(|&col| col < cols);
                        let Some((row, col)) = row.zip(col) else { continue };
                        let behind = row * cols + col;
                        if codes[behind] == code as i8 && !std::mem::replace(&mut expected[behind], true) {
                            stack.push(behind);
                        }
                    }
                }
                assert!(found == expected, "{rows} x {cols}, bias {bias}");
                assert_eq!(count, expected.iter().filter(|&&cell| cell).count());
                let few = count.saturating_sub(1);
                shadow.reset(rows.div_ceil(SIDE), cols.div_ceil(SIDE));
                seeds.iter().for_each(|&seed| shadow.forget(&policy, seed / cols, seed % cols));
                let seeded = shadow.pages.iter().map(|page| ones(&page.forgotten)).sum::<usize>();
                assert!(seeded > few || shadow.spread(&policy, few).is_none());
            }
        }
    }
}
