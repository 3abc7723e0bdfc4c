//! A field made right again after costs changed, without solving it anew.
//!
//! What rested on a link that became dearer is forgotten: the part of the policy's tree above it. What is
//! left is no less than the new field, so the solver takes it from there: forgotten cells take what their
//! neighbours offer, cheaper links offer more, and tiles wake one another until nothing changes.

use super::SIDE;
use super::board::Board;
use super::board::{ALL_LINES, Side};
use super::finish::{Patch, Sheet, finish};
use super::lanes::{Lanes, TileCost};
use super::level::{Job, Simd, at_level};
use super::queue::Next;
use super::run::Room;
use super::shadow::{Policy, Shadow};
use super::sweep::{CELLS, LineLinks, load_line, store_line};
use super::thin::is_thin;
use super::visit::{Links, Turned, Wakes, visit};
use crate::plan::Cost;
use crate::plan::moves::MOVES;

/// The tile's own numbers are on the board.
const TILE: u8 = 1 << 4;
/// The tile is to be written out.
const CHANGED: u8 = 1 << 5;

/// What a repair works with, kept from one to the next.
#[derive(Debug, Default)]
pub struct RepairRoom {
    /// Per tile: a bit per [`Side`] whose record is on the board, [`TILE`], [`CHANGED`].
    on_board: Vec<u8>,
    /// Tiles with any of these.
    touched: Vec<u32>,
    shadow: Shadow,
}

impl RepairRoom {
    fn reset(&mut self, tile_rows: usize, tile_cols: usize) {
        self.shadow.reset(tile_rows, tile_cols);
        for tile in self.touched.drain(..) {
            if let Some(flags) = self.on_board.get_mut(tile as usize) {
                *flags = 0;
            }
        }
        self.on_board.resize(tile_rows * tile_cols, 0);
    }

    /// Sets flags; returns those that were set before.
    fn set(&mut self, tile: usize, flags: u8) -> u8 {
        set(&mut self.on_board, &mut self.touched, tile, flags)
    }

    /// The tiles marked [`CHANGED`].
    fn changed(&self) -> Vec<u32> {
        let is_changed = |&tile: &u32| self.on_board[tile as usize] & CHANGED != 0;
        self.touched.iter().copied().filter(is_changed).collect()
    }
}

fn set(on_board: &mut [u8], touched: &mut Vec<u32>, tile: usize, flags: u8) -> u8 {
    let before = on_board[tile];
    if before == 0 {
        touched.push(tile as u32);
    }
    on_board[tile] |= flags;
    before
}

/// A field being repaired: row-major.
pub struct Repair<'a, K: Links> {
    /// The links as they are now.
    pub links: &'a K,
    /// Rows of the grid.
    pub rows: usize,
    /// Columns of the grid.
    pub cols: usize,
    /// Cells whose cost changed: row and column.
    pub changed: &'a [(usize, usize)],
    /// Cost-to-go before, and after.
    pub values: &'a mut [K::Number],
    /// Codes of the next cell before, and after.
    pub codes: &'a mut [i8],
    /// Give up when more work than this was done: visits to tiles, and a tile's worth of forgotten cells for one.
    pub most_work: usize,
}

/// What a repair came to.
pub struct Repaired<T> {
    /// The largest cost-to-go among the cells looked at.
    pub largest: T,
    /// Cells that were forgotten.
    pub forgotten: usize,
    /// Visits to tiles.
    pub visits: usize,
}

/// Repairs a field in which every link cost more than nothing, before and now. None if that takes more than
/// `most_work`; then the field is spoilt and must be solved anew.
pub fn repair<K: Links>(
    room: &mut Room<K::Number>,
    simd: Simd,
    mut repair: Repair<'_, K>,
) -> Option<Repaired<K::Number>> {
    if is_thin(repair.rows, repair.cols) {
        return None;
    }
    let (tile_rows, tile_cols) = (repair.rows.div_ceil(SIDE), repair.cols.div_ceil(SIDE));
    room.board.make_room(tile_rows, tile_cols);
    room.queue.reset(tile_rows, tile_cols);
    room.repair.reset(tile_rows, tile_cols);
    let forgotten = repair.forget(&mut room.repair)?;
    at_level(simd, Run { room, repair, forgotten })
}

impl<K: Links> Repair<'_, K> {
    /// Forgets every cell whose way leads over a link that became dearer, and marks the tiles with such
    /// cells and with links that changed. Returns how many were forgotten; None if they are too many.
    fn forget(&mut self, room: &mut RepairRoom) -> Option<usize> {
        let tile_cols = self.cols.div_ceil(SIDE);
        let unreachable = K::Number::UNREACHABLE;
        let policy = Policy { codes: self.codes, rows: self.rows, cols: self.cols };
        for &(row, col) in self.changed {
            // The links of a cell, and those that pass its corners, end within one cell of it.
            for row in row.saturating_sub(1)..(row + 2).min(self.rows) {
                for col in col.saturating_sub(1)..(col + 2).min(self.cols) {
                    room.set(row / SIDE * tile_cols + col / SIDE, TILE | CHANGED);
                    let index = row * self.cols + col;
                    let Ok(code) = usize::try_from(self.codes[index]) else { continue };
                    let cost = self.links.cost(row, col, code);
                    let holds = cost < K::Number::FAR && {
                        let ahead = self.values[index.wrapping_add_signed(self.step(code))];
                        // Not above what it was; FAR is far below the largest number of integers.
                        ahead < unreachable && ahead.sum(cost) <= self.values[index]
                    };
                    if !holds {
                        room.shadow.forget(&policy, row, col);
                    }
                }
            }
        }
        let policy = Policy { codes: self.codes, rows: self.rows, cols: self.cols };
        let forgotten = room.shadow.spread(&policy, self.most_work.saturating_mul(CELLS))?;
        let RepairRoom { shadow, on_board, touched } = room;
        for (tile, line, mut cells) in shadow.forgotten() {
            set(on_board, touched, tile, TILE | CHANGED);
            let (row, first_col) = (tile / tile_cols * SIDE + line, tile % tile_cols * SIDE);
            while cells != 0 {
                let index = row * self.cols + first_col + cells.trailing_zeros() as usize;
                cells &= cells - 1;
                self.values[index] = unreachable;
                self.codes[index] = -1;
            }
        }
        Some(forgotten)
    }

    fn step(&self, code: usize) -> isize {
        let (down, right) = MOVES[code];
        down * self.cols as isize + right
    }

    /// The number of a cell as tiles hold it; FAR outside.
    fn number(&self, row: usize, col: usize) -> K::Number {
        if row >= self.rows || col >= self.cols {
            return K::Number::FAR;
        }
        inner(self.values[row * self.cols + col])
    }
}

/// A number as tiles hold it.
#[inline(always)]
fn inner<T: TileCost>(value: T) -> T {
    if value < T::FAR { value } else { T::FAR }
}

struct Run<'a, 'r, K: Links> {
    room: &'r mut Room<K::Number>,
    repair: Repair<'a, K>,
    forgotten: usize,
}

impl<K: Links> Job for Run<'_, '_, K> {
    type Number = K::Number;
    type Result = Option<Repaired<K::Number>>;

    #[inline(always)]
    unsafe fn run<L: Lanes<Number = K::Number>>(self) -> Self::Result {
        let Self { room, repair, forgotten } = self;
        let Room { board, queue, repair: marks } = room;
        let mut desk = repair.links.desk::<L>();
        let mut turned = Box::new(Turned([K::Number::FAR; CELLS]));
        let mut wakes = Wakes::default();

        for i in 0..marks.touched.len() {
            let tile = marks.touched[i] as usize;
            repair.copy_tile(board, tile);
            repair.links.lay_out::<L>(tile, &mut desk);
            // SAFETY: one thread; the tile is on the board; the level is enabled.
            let least = unsafe { repair.take_offers::<L>(board, tile, &desk) };
            if least < K::Number::FAR {
                queue.add(tile, ALL_LINES, least);
            }
            queue.visited[tile] = true;
        }
        let done = forgotten / CELLS;
        while let Next::Visit { tile, news, .. } = queue.take(None) {
            if done + queue.visits > repair.most_work {
                return None;
            }
            if marks.set(tile, TILE | CHANGED) & TILE == 0 {
                repair.copy_tile(board, tile);
            }
            repair.copy_records(board, marks, tile);
            // SAFETY: one thread; the tile and its neighbours' records are on the board; the level is enabled.
            unsafe {
                visit::<L, K>(board, repair.links, tile, news, false, &mut desk, &mut turned, &mut wakes);
            }
            queue.ended(tile);
            for (tile, news, least) in wakes.drain() {
                queue.add(tile, news, least);
            }
        }

        // The policy looks one cell beyond each tile: neighbours are written out too.
        let changed = marks.changed();
        for &tile in &changed {
            for (down, right) in MOVES {
                let Some(other) = board.beside(tile as usize, down, right) else { continue };
                if marks.set(other, TILE | CHANGED) & TILE == 0 {
                    repair.copy_tile(board, other);
                }
            }
        }
        let Repair { links, rows, cols, .. } = repair;
        let written = marks.changed();
        for &tile in &written {
            repair.copy_records(board, marks, tile as usize);
        }
        let sheet =
            Sheet { values: repair.values.as_mut_ptr(), codes: repair.codes.as_mut_ptr(), rows, cols };
        let mut patch = Patch::new();
        let mut largest = K::Number::ZERO;
        for &tile in &written {
            // SAFETY: one thread; the tile and the records around it are on the board; the level is enabled.
            let of_tile = unsafe {
                finish::<L, K>(board, links, tile as usize, K::Number::FAR, &mut desk, &mut patch, &sheet)
            };
            largest = if of_tile > largest { of_tile } else { largest };
        }
        Some(Repaired { largest, forgotten, visits: queue.visits })
    }
}

impl<K: Links> Repair<'_, K> {
    /// Puts a tile's numbers on the board.
    #[inline(always)]
    fn copy_tile(&self, board: &Board<K::Number>, tile: usize) {
        let (first_row, first_col) = (tile / board.tile_cols * SIDE, tile % board.tile_cols * SIDE);
        let cols = (self.cols - first_col).min(SIDE);
        // SAFETY: one thread; a tile has CELLS numbers, all written here.
        let numbers = unsafe {
            let room = board.tile(tile).cast::<std::mem::MaybeUninit<K::Number>>();
            let room = std::slice::from_raw_parts_mut(room, CELLS);
            room.fill(std::mem::MaybeUninit::new(K::Number::FAR));
            std::slice::from_raw_parts_mut(board.tile(tile), CELLS)
        };
        for row in 0..(self.rows - first_row).min(SIDE) {
            let at = (first_row + row) * self.cols + first_col;
            for (to, &value) in
                numbers[row * SIDE..row * SIDE + cols].iter_mut().zip(&self.values[at..at + cols])
            {
                *to = inner(value);
            }
        }
    }

    /// Puts on the board the records of a tile, and of those around it along the sides that face it.
    #[inline(always)]
    fn copy_records(&self, board: &Board<K::Number>, marks: &mut RepairRoom, tile: usize) {
        for side in [Side::North, Side::South, Side::West, Side::East] {
            self.copy_record(board, marks, tile, side);
        }
        for (down, right) in MOVES {
            let Some(other) = board.beside(tile, down, right) else { continue };
            let facing = match (down, right) {
                (-1, _) => Side::South,
                (1, _) => Side::North,
                (_, 1) => Side::West,
                _ => Side::East,
            };
            self.copy_record(board, marks, other, facing);
        }
    }

    #[inline(always)]
    fn copy_record(&self, board: &Board<K::Number>, marks: &mut RepairRoom, tile: usize, side: Side) {
        if marks.set(tile, side.bit()) & side.bit() != 0 {
            return;
        }
        let (row, col) = (tile / board.tile_cols * SIDE, tile % board.tile_cols * SIDE);
        let record = board.border(tile, side);
        for i in 0..SIDE {
            let number = match side {
                Side::North => self.number(row, col + i),
                Side::South => self.number(row + SIDE - 1, col + i),
                Side::West => self.number(row + i, col),
                Side::East => self.number(row + i, col + SIDE - 1),
            };
            // SAFETY: one thread; a record has SIDE numbers.
            unsafe { record.add(i).write(number) };
        }
    }

    /// Lowers the border of a tile on the board to what the cells around it offer; returns its least number.
    #[inline(always)]
    unsafe fn take_offers<L: Lanes<Number = K::Number>>(
        &self,
        board: &Board<K::Number>,
        tile: usize,
        desk: &K::Desk<L>,
    ) -> K::Number {
        const LAST: usize = SIDE - 1;
        let numbers = board.tile(tile);
        let (row, col) = (tile / board.tile_cols * SIDE, tile % board.tile_cols * SIDE);
        let line = |at: &dyn Fn(usize) -> K::Number| -> [K::Number; SIDE] { std::array::from_fn(at) };
        let lower =
            |outside: [K::Number; SIDE], inside: &mut [K::Number; SIDE], forward: bool, across: bool| {
                let links = if across { K::cols::<L>(desk) } else { K::rows::<L>(desk) };
                // SAFETY: both arrays hold a line; the level is enabled.
                unsafe {
                    let before = load_line::<L>(outside.as_ptr(), 0);
                    let mut line = load_line::<L>(inside.as_ptr(), 0);
                    if forward {
                        links.lower::<true>(1, &before, &mut line);
                    } else {
                        links.lower::<false>(SIDE, &before, &mut line);
                    }
                    store_line(inside.as_mut_ptr(), 0, &line);
                }
            };
        for (edge, beyond, forward) in [(0, row.wrapping_sub(1), true), (LAST, row + SIDE, false)] {
            let outside = line(&|i| self.number(beyond, col + i));
            let mut inside = line(&|i| unsafe { *numbers.add(edge * SIDE + i) });
            lower(outside, &mut inside, forward, false);
            for (i, &number) in inside.iter().enumerate() {
                unsafe { *numbers.add(edge * SIDE + i) = number };
            }
        }
        for (edge, beyond, forward) in [(0, col.wrapping_sub(1), true), (LAST, col + SIDE, false)] {
            let outside = line(&|i| self.number(row + i, beyond));
            let mut inside = line(&|i| unsafe { *numbers.add(i * SIDE + edge) });
            lower(outside, &mut inside, forward, true);
            for (i, &number) in inside.iter().enumerate() {
                unsafe { *numbers.add(i * SIDE + edge) = number };
            }
        }
        for (code, down, right) in [(1, LAST, LAST), (3, LAST, 0), (5, 0, 0), (7, 0, LAST)] {
            let (from_row, from_col) = (row + down, col + right);
            let (step_down, step_right) = MOVES[code];
            let (to_row, to_col) =
                (from_row.wrapping_add_signed(step_down), from_col.wrapping_add_signed(step_right));
            let ahead = self.number(to_row, to_col);
            if ahead < K::Number::FAR && from_row < self.rows && from_col < self.cols {
                let offered = ahead.sum(self.links.cost(from_row, from_col, code));
                let number = unsafe { &mut *numbers.add(down * SIDE + right) };
                *number = if offered < *number { offered } else { *number };
            }
        }
        // SAFETY: the tile is on the board.
        let all = unsafe { std::slice::from_raw_parts(numbers, CELLS) };
        all.iter().fold(K::Number::FAR, |least, &number| if number < least { number } else { least })
    }
}
