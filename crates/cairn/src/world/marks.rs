//! A bit for each cell of a grid, so that the few cells that matter are found without looking at the others.

use super::{Cell, GridGeometry};
use crate::geometry::Point2;

/// Bits, row by row; every row begins with a new word.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Marks {
    words: Vec<u64>,
    words_per_row: usize,
    rows: usize,
}

/// Half the side of a [`Marks::window`].
pub(super) const WINDOW: usize = 4;

impl Marks {
    /// No cell is marked.
    pub fn new(rows: usize, cols: usize) -> Self {
        let words_per_row = cols.div_ceil(64);
        Self { words: vec![0; rows * words_per_row], words_per_row, rows }
    }

    /// The cells, row-major, for which `is_marked`.
    pub fn of<T>(rows: usize, cols: usize, cells: &[T], is_marked: impl Fn(&T) -> bool) -> Self {
        let mut marks = Self::new(rows, cols);
        if marks.words.is_empty() {
            return marks;
        }
        let lines = cells.chunks_exact(cols).zip(marks.words.chunks_exact_mut(marks.words_per_row));
        for (line, words) in lines {
            for (cells, word) in line.chunks(64).zip(words) {
                *word = cells.iter().rev().fold(0, |bits, cell| bits << 1 | u64::from(is_marked(cell)));
            }
        }
        marks
    }

    /// Whether a cell is marked.
    pub fn holds(&self, row: usize, col: usize) -> bool {
        self.words[row * self.words_per_row + col / 64] >> (col % 64) & 1 == 1
    }

    /// Marks a cell, or not.
    pub fn set(&mut self, row: usize, col: usize, marked: bool) {
        let word = &mut self.words[row * self.words_per_row + col / 64];
        let bit = 1 << (col % 64);
        *word = if marked { *word | bit } else { *word & !bit };
    }

    /// Calls `seen` with the columns of a row from `first` to `last` that are marked here and not in `but`, a
    /// grid of the same shape; in order.
    #[inline]
    pub fn each_in(
        &self,
        row: usize,
        first: usize,
        last: usize,
        but: Option<&Self>,
        mut seen: impl FnMut(usize),
    ) {
        let from = row * self.words_per_row;
        for word in first / 64..=last / 64 {
            let mut bits = self.words[from + word] & !but.map_or(0, |but| but.words[from + word]);
            if word == first / 64 {
                bits &= !0 << (first % 64);
            }
            if word == last / 64 {
                bits &= !0 >> (63 - last % 64);
            }
            while bits != 0 {
                seen(word * 64 + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        }
    }

    /// The square of cells around one, [`WINDOW`] to each side: a number per row, the leftmost cell in bit 0.
    /// Nothing is marked outside the grid.
    pub fn window(&self, row: usize, col: usize) -> [u16; 2 * WINDOW + 1] {
        const MASK: u64 = (1 << (2 * WINDOW + 1)) - 1;
        std::array::from_fn(|i| {
            let Some(row) = (row + i).checked_sub(WINDOW).filter(|&row| row < self.rows) else { return 0 };
            let words = &self.words[row * self.words_per_row..][..self.words_per_row];
            let Some(first) = col.checked_sub(WINDOW) else {
                return (words[0] << (WINDOW - col) & MASK) as u16;
            };
            let (word, bit) = (first / 64, first % 64);
            let mut bits = words[word] >> bit;
            if bit > 0 {
                bits |= words.get(word + 1).copied().unwrap_or(0) << (64 - bit);
            }
            (bits & MASK) as u16
        })
    }
}

/// Some cells of a grid.
#[derive(Clone, Debug)]
pub struct CellSet {
    geometry: GridGeometry,
    marks: Marks,
}

impl CellSet {
    /// The cells that are marked.
    pub(super) fn new(geometry: GridGeometry, marks: Marks) -> Self {
        Self { geometry, marks }
    }

    /// Shape and place of the grid.
    pub fn geometry(&self) -> GridGeometry {
        self.geometry
    }

    /// Whether `cell`, which must be inside, is one of them.
    pub fn holds(&self, cell: Cell) -> bool {
        self.marks.holds(cell.row, cell.col)
    }

    /// Whether the cell at `point_in_world` is one of them; false outside.
    pub fn holds_at(&self, point_in_world: Point2) -> bool {
        self.geometry.cell_at(point_in_world).is_some_and(|cell| self.holds(cell))
    }

    pub(super) fn marks(&self) -> &Marks {
        &self.marks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn marks_tell_the_cells_that_are_marked_in_a_row_and_around_a_cell(
            rows in 1usize..20,
            cols in 1usize..150,
            seed in any::<u64>(),
            at in (0usize..20, 0usize..150),
            span in (0usize..150, 0usize..150),
        ) {
            let cells: Vec<bool> = (0..rows * cols)
                .map(|i| (i as u64 + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 62 == 0)
                .collect();
            let marks = Marks::of(rows, cols, &cells, |&cell| cell);
            let is_marked = |row: i64, col: i64| {
                let inside = row >= 0 && col >= 0 && row < rows as i64 && col < cols as i64;
                inside && cells[(row * cols as i64 + col) as usize]
            };
            let (row, col) = (at.0 % rows, at.1 % cols);
            prop_assert_eq!(marks.holds(row, col), is_marked(row as i64, col as i64));
            let mut one_by_one = Marks::new(rows, cols);
            (0..cells.len()).for_each(|i| one_by_one.set(i / cols, i % cols, cells[i]));
            prop_assert_eq!(&one_by_one, &marks);
            let (first, last) = ((span.0 % cols).min(span.1 % cols), (span.0 % cols).max(span.1 % cols));
            let mut told = Vec::new();
            marks.each_in(row, first, last, None, |col| told.push(col));
            let expected: Vec<usize> =
                (first..=last).filter(|&col| is_marked(row as i64, col as i64)).collect();
            prop_assert_eq!(told, expected);
            let every_other = Marks::of(rows, cols, &(0..rows * cols).collect::<Vec<_>>(), |i| i % cols % 2 == 0);
            let mut told = Vec::new();
            marks.each_in(row, first, last, Some(&every_other), |col| told.push(col));
            let expected: Vec<usize> =
                (first..=last).filter(|&col| is_marked(row as i64, col as i64) && col % 2 == 1).collect();
            prop_assert_eq!(told, expected);
            for (i, bits) in marks.window(row, col).into_iter().enumerate() {
                for j in 0..=2 * WINDOW {
                    let there = (row as i64 + i as i64 - WINDOW as i64, col as i64 + j as i64 - WINDOW as i64);
                    prop_assert_eq!(bits >> j & 1 == 1, is_marked(there.0, there.1), "{:?}", there);
                }
            }
        }
    }
}
