//! From settled tiles to the field: numbers row by row, and the policy by equality.

use super::SIDE;
use super::board::{Board, Side};
use super::lanes::{LANES, Lanes, TileCost};
use super::sweep::{CELLS, Line, VECTORS, load_line, moved_down, moved_up};
use super::visit::Links;
use crate::plan::Cost;

/// The numbers of sixteen cells and of their neighbours by code of the move.
pub struct Around<L> {
    /// The cells' own.
    pub here: L,
    /// Those of the neighbours in the order of [`MOVES`](crate::plan::MOVES).
    pub there: [L; 8],
}

/// Where a field is written: row-major, `cols` numbers and codes a row.
pub struct Sheet<T> {
    /// First number.
    pub values: *mut T,
    /// First code.
    pub codes: *mut i8,
    /// Rows of the grid.
    pub rows: usize,
    /// Columns of the grid.
    pub cols: usize,
}

// SAFETY: threads write to different rows.
unsafe impl<T: TileCost> Sync for Sheet<T> {}

/// A tile's numbers and codes, before the part inside the grid is copied.
#[repr(align(64))]
pub struct Patch<T> {
    values: [T; CELLS],
    codes: [i8; CELLS],
}

impl<T: Cost> Patch<T> {
    /// An empty one.
    pub fn new() -> Box<Self> {
        Box::new(Self { values: [T::UNREACHABLE; CELLS], codes: [-1; CELLS] })
    }
}

/// Writes a tile to the sheet; returns the largest number of a reachable cell.
///
/// Numbers above `most` count as no way: they are not final when the solver stopped early.
///
/// # Safety
/// The tile was visited and nobody changes it or its neighbours' records; the sheet has room for the grid; the
/// level of `L` is enabled.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub unsafe fn finish<L: Lanes, K: Links<Number = L::Number>>(
    board: &Board<L::Number>,
    links: &K,
    tile: usize,
    most: L::Number,
    desk: &mut K::Desk<L>,
    patch: &mut Patch<L::Number>,
    sheet: &Sheet<L::Number>,
) -> L::Number {
    let far = L::Number::FAR;
    links.lay_out_policy::<L>(tile, desk);
    let (first_row, first_col) = (tile / board.tile_cols * SIDE, tile % board.tile_cols * SIDE);
    let (rows, cols) = ((sheet.rows - first_row).min(SIDE), (sheet.cols - first_col).min(SIDE));
    let whole = cols == SIDE;
    let (values_at, codes_at, pitch) = if whole {
        let at = first_row * sheet.cols + first_col;
        unsafe { (sheet.values.add(at), sheet.codes.add(at), sheet.cols) }
    } else {
        (patch.values.as_mut_ptr(), patch.codes.as_mut_ptr(), SIDE)
    };

    // The numbers just outside the tile.
    let column = |right: isize, facing: Side| -> [L::Number; SIDE + 2] {
        let mut numbers = [far; SIDE + 2];
        if let Some(other) = board.beside(tile, 0, right) {
            let record = unsafe { std::slice::from_raw_parts(board.border(other, facing), SIDE) };
            numbers[1..=SIDE].copy_from_slice(record);
        }
        let nearest = if facing == Side::East { SIDE - 1 } else { 0 };
        if let Some(other) = board.beside(tile, -1, right) {
            numbers[0] = unsafe { *board.border(other, Side::South).add(nearest) };
        }
        if let Some(other) = board.beside(tile, 1, right) {
            numbers[SIDE + 1] = unsafe { *board.border(other, Side::North).add(nearest) };
        }
        numbers
    };
    let (west, east) = (column(-1, Side::East), column(1, Side::West));
    let far_line: Line<L> = [L::splat(far); VECTORS];
    let beyond = |down: isize| board.beside(tile, down, 0);

    let values = board.tile(tile);
    let (most, far, unreachable) = (L::splat(most), L::splat(far), L::splat(L::Number::UNREACHABLE));
    let zero = L::splat(L::Number::ZERO);
    let mut largest = zero;
    let mut above = match beyond(-1) {
        Some(other) => unsafe { load_line::<L>(board.border(other, Side::South), 0) },
        None => far_line,
    };
    let mut here = unsafe { load_line::<L>(values, 0) };
    for row in 0..rows {
        let below = match beyond(1) {
            _ if row + 1 < SIDE => unsafe { load_line::<L>(values, row + 1) },
            Some(other) => unsafe { load_line::<L>(board.border(other, Side::North), 0) },
            None => far_line,
        };
        for k in 0..VECTORS {
            let around = Around {
                here: here[k],
                there: [
                    moved_down(&here, k, east[row + 1]),
                    moved_down(&below, k, east[row + 2]),
                    below[k],
                    moved_up(&below, k, west[row + 2]),
                    moved_up(&here, k, west[row + 1]),
                    moved_up(&above, k, west[row]),
                    above[k],
                    moved_down(&above, k, east[row]),
                ],
            };
            let mut masks = links.on_the_way(desk, row, k, &around);
            let beyond = most.less(here[k]) | here[k].equal(far);
            for mask in &mut masks {
                *mask &= !beyond;
            }
            let shown = unreachable.where_else(beyond, here[k]);
            largest = largest.max(zero.where_else(beyond, here[k]));
            let at = row * pitch + k * LANES;
            unsafe {
                shown.store(values_at.add(at));
                L::store_codes(masks, codes_at.add(at));
                // The same row of the next tile: pages apart from this one's other rows.
                L::prefetch_for_writing(values_at.wrapping_add(at + SIDE));
                if k == 0 {
                    L::prefetch_for_writing(codes_at.wrapping_add(at + SIDE));
                }
            }
        }
        (above, here) = (here, below);
    }
    if !whole {
        for row in 0..rows {
            let at = (first_row + row) * sheet.cols + first_col;
            unsafe {
                std::ptr::copy_nonoverlapping(values_at.add(row * SIDE), sheet.values.add(at), cols);
                std::ptr::copy_nonoverlapping(codes_at.add(row * SIDE), sheet.codes.add(at), cols);
            }
        }
    }
    let mut numbers = [L::Number::ZERO; LANES];
    unsafe { largest.store(numbers.as_mut_ptr()) };
    numbers.into_iter().fold(L::Number::ZERO, |a, b| if b > a { b } else { a })
}

/// Writes a tile that nothing reached.
///
/// # Safety
/// The sheet has room for the grid.
pub unsafe fn leave_out<T: TileCost>(tile_cols: usize, tile: usize, sheet: &Sheet<T>) {
    let (first_row, first_col) = (tile / tile_cols * SIDE, tile % tile_cols * SIDE);
    let cols = (sheet.cols - first_col).min(SIDE);
    for row in first_row..(first_row + SIDE).min(sheet.rows) {
        let at = row * sheet.cols + first_col;
        unsafe {
            std::slice::from_raw_parts_mut(sheet.values.add(at), cols).fill(T::UNREACHABLE);
            std::slice::from_raw_parts_mut(sheet.codes.add(at), cols).fill(-1);
        }
    }
}
