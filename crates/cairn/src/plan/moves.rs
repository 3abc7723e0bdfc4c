use crate::world::GridGeometry;

/// (Δrow, Δcol) of the moves to the eight neighbours, by `next_node` code: odd codes are diagonal.
pub const MOVES: [(isize, isize); 8] = [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)];

/// The moves that each cell of a grid allows, one bit per code. Every allowed move may be undone.
///
/// A move joins two free cells. A diagonal one needs the two cells beside it free as well, unless
/// corners may be cut: then these are not looked at.
pub struct Moves {
    open: Vec<u8>,
    offsets: [isize; 8],
}

impl Moves {
    /// The moves of a grid where `free[index]` says which cells may be entered.
    pub fn new(geometry: &GridGeometry, free: &[bool], corner_cutting: bool) -> Self {
        let (rows, cols) = (geometry.rows as isize, geometry.cols as isize);
        let is_free = |row: isize, col: isize| {
            (0..rows).contains(&row) && (0..cols).contains(&col) && free[(row * cols + col) as usize]
        };
        let mut open = vec![0_u8; free.len()];
        for row in 0..rows {
            for col in 0..cols {
                let index = (row * cols + col) as usize;
                if !free[index] {
                    continue;
                }
                for (code, &(down, right)) in MOVES.iter().enumerate() {
                    let sides_matter = code % 2 == 1 && !corner_cutting;
                    let sides_free = !sides_matter || (is_free(row, col + right) && is_free(row + down, col));
                    if sides_free && is_free(row + down, col + right) {
                        open[index] |= 1 << code;
                    }
                }
            }
        }
        Self { open, offsets: MOVES.map(|(down, right)| down * cols + right) }
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.open.len()
    }

    /// Number of moves out of a cell.
    pub fn count(&self, index: usize) -> usize {
        self.open[index].count_ones() as usize
    }

    /// (code, neighbour) of the moves out of a cell, in the order of their codes.
    #[inline]
    pub fn from(&self, index: usize) -> impl Iterator<Item = (usize, usize)> + use<'_> {
        let mut left = self.open[index];
        std::iter::from_fn(move || {
            if left == 0 {
                return None;
            }
            let code = left.trailing_zeros() as usize;
            left &= left - 1;
            Some((code, index.wrapping_add_signed(self.offsets[code])))
        })
    }
}
