use super::links::{LinkCosts, Number};
use crate::plan::MOVES;

/// The moves of a grid in one ring of blocked cells, so that no step can leave it.
#[derive(Default)]
pub struct Ground {
    pub rows: usize,
    pub cols: usize,
    pub stride: usize,
    pub offsets: [isize; 8],
    free: Vec<u8>,
    /// One bit per allowed move out of a cell, by code.
    open: Vec<u8>,
    /// Bit k: the neighbour that code k leads to may move here. Empty if moves may be undone.
    entered: Vec<u8>,
}

impl Ground {
    /// Lays out a grid; `free_row` writes 1 for every free cell of a row, 0 for the others; `moves` are those
    /// that cells allow, row-major, if that does not follow from which are free.
    pub fn lay(
        &mut self,
        rows: usize,
        cols: usize,
        free_row: impl Fn(usize, &mut [u8]),
        moves: Option<&[u8]>,
        cutting: bool,
    ) {
        let stride = pitch(cols + 2);
        (self.rows, self.cols, self.stride) = (rows, cols, stride);
        self.offsets = MOVES.map(|(down, right)| down * stride as isize + right);
        self.free.clear();
        self.free.resize((rows + 2) * stride, 0);
        self.open.clear();
        self.open.resize((rows + 2) * stride, 0);
        for row in 0..rows {
            let begin = self.index(row, 0);
            free_row(row, &mut self.free[begin..begin + cols]);
        }
        self.entered.clear();
        match moves {
            None => self.open_free(cutting),
            Some(moves) => self.open_given(moves),
        }
    }

    fn open_given(&mut self, moves: &[u8]) {
        let cols = self.cols;
        for (row, moves) in moves.chunks_exact(cols).enumerate() {
            let begin = self.index(row, 0);
            self.open[begin..begin + cols].copy_from_slice(moves);
        }
        self.entered.resize(self.open.len(), 0);
        for row in 0..self.rows {
            let here = self.index(row, 0);
            for code in 0..8_u8 {
                let there = self.beside(here, usize::from(code));
                let back = code ^ 4;
                let pairs = self.entered[here..here + cols].iter_mut().zip(&self.open[there..there + cols]);
                for (entered, open) in pairs {
                    *entered |= (open >> back & 1) << code;
                }
            }
        }
    }

    fn open_free(&mut self, cutting: bool) {
        let (rows, cols, stride) = (self.rows, self.cols, self.stride);
        let cut = u8::from(cutting);
        for row in 0..rows {
            let here = self.index(row, 0);
            let line = |start: usize| &self.free[start..start + cols];
            let (cell, right, left) = (line(here), line(here + 1), line(here - 1));
            let (down, down_right, down_left) =
                (line(here + stride), line(here + stride + 1), line(here + stride - 1));
            let (up, up_right, up_left) =
                (line(here - stride), line(here - stride + 1), line(here - stride - 1));
            let open = &mut self.open[here..here + cols];
            for i in 0..cols {
                let (r, d, l, u) = (right[i], down[i], left[i], up[i]);
                let mut bits = r | d << 2 | l << 4 | u << 6;
                bits |= (down_right[i] & (cut | (r & d))) << 1;
                bits |= (down_left[i] & (cut | (l & d))) << 3;
                bits |= (up_left[i] & (cut | (l & u))) << 5;
                bits |= (up_right[i] & (cut | (r & u))) << 7;
                open[i] = bits & 0_u8.wrapping_sub(cell[i]);
            }
        }
    }

    /// Number of padded cells.
    pub fn len(&self) -> usize {
        self.open.len()
    }

    /// Padded index of a cell.
    pub fn index(&self, row: usize, col: usize) -> usize {
        (row + 1) * self.stride + col + 1
    }

    /// Bit k: the neighbour that code k leads to may move to this cell.
    #[inline(always)]
    pub fn entered(&self, index: usize) -> u8 {
        if self.entered.is_empty() { self.open[index] } else { self.entered[index] }
    }

    pub fn is_free(&self, index: usize) -> bool {
        self.free[index] == 1
    }

    /// The cell one move on.
    #[inline(always)]
    pub fn beside(&self, index: usize, code: usize) -> usize {
        index.wrapping_add_signed(self.offsets[code & 7])
    }

    /// Takes values out of the ring and finds the policy: the lowest code that gives exactly the
    /// cost-to-go; -1 at goals and where there is no way.
    pub fn read_out<C: Number, L: LinkCosts<C>>(
        &self,
        links: &L,
        padded: &[C],
        values: &mut Vec<C>,
        next_codes: &mut Vec<i8>,
    ) {
        let (rows, cols) = (self.rows, self.cols);
        values.resize(rows * cols, C::ZERO);
        next_codes.resize(rows * cols, -1);
        let mut equal = vec![0_u8; cols];
        for row in 0..rows {
            let here = self.index(row, 0);
            let open = &self.open[here..here + cols];
            let codes = &mut next_codes[row * cols..(row + 1) * cols];
            codes.fill(-1);
            for code in (0..8_u8).rev() {
                let there = self.beside(here, usize::from(code));
                links.match_row(here, there, usize::from(code), padded, &mut equal);
                for ((found, &open), &equal) in codes.iter_mut().zip(open).zip(&equal) {
                    *found = if (open >> code) & equal == 1 { code as i8 } else { *found };
                }
            }
            values[row * cols..(row + 1) * cols].copy_from_slice(&padded[here..here + cols]);
        }
    }
}

/// Rows whose pitch is a multiple of 4 KiB fall onto the same lines of a cache.
fn pitch(least: usize) -> usize {
    let rounded = least.next_multiple_of(16);
    if rounded.is_multiple_of(1024) { rounded + 16 } else { rounded }
}
