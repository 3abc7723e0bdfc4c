//! From goals to a field: visits until no tile waits, then the field is written out.

use std::mem::MaybeUninit;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use super::SIDE;
use super::board::{ALL_LINES, Board};
use super::finish::{Patch, Sheet, finish, leave_out};
use super::lanes::{Lanes, TileCost};
use super::level::{Job, Simd, at_level};
use super::queue::{Next, Queue};
use super::repair::RepairRoom;
use super::sweep::CELLS;
use super::thin::{is_thin, solve_thin};
use super::visit::{Links, Turned, Wakes, visit};
use crate::plan::Cost;

/// What a solver of one number type works with, kept from one field to the next.
#[derive(Debug, Default)]
pub struct Room<T: TileCost> {
    pub(super) board: Board<T>,
    pub(super) queue: Queue<T>,
    pub(super) repair: RepairRoom,
}

/// A grid to be solved.
pub struct Task<'a> {
    /// Rows of the grid.
    pub rows: usize,
    /// Columns of the grid.
    pub cols: usize,
    /// Row-major indices of the goals, which can be entered.
    pub goals: &'a [u32],
    /// Row-major index of the one cell whose way is wanted; nothing farther is finished.
    pub start: Option<u32>,
    /// Threads to use, at least 1.
    pub threads: usize,
    /// Instructions to use.
    pub simd: Simd,
}

/// A field written out.
pub struct Solved<T> {
    /// Cost-to-go, row-major.
    pub values: Vec<T>,
    /// Codes of the next cell, row-major.
    pub codes: Vec<i8>,
    /// The largest cost-to-go of a cell that has one.
    pub largest: T,
    /// Visits to tiles, and tiles written out.
    pub work: usize,
}

/// Solves a grid with links `links`; `values` and `codes` are buffers to write to, of any length.
pub fn solve<K: Links>(
    room: &mut Room<K::Number>,
    links: &K,
    task: &Task<'_>,
    values: Vec<K::Number>,
    codes: Vec<i8>,
) -> Solved<K::Number> {
    if is_thin(task.rows, task.cols) {
        return solve_thin(links, task, values, codes);
    }
    let (tile_rows, tile_cols) = (task.rows.div_ceil(SIDE), task.cols.div_ceil(SIDE));
    let place = |cell: u32| {
        let (row, col) = (cell as usize / task.cols, cell as usize % task.cols);
        (row / SIDE * tile_cols + col / SIDE, row % SIDE * SIDE + col % SIDE)
    };
    let Room { board, queue, .. } = room;
    board.reset(tile_rows, tile_cols);
    queue.reset(tile_rows, tile_cols);
    for &goal in task.goals {
        let (tile, cell) = place(goal);
        // SAFETY: nobody else is at the board; a tile is filled before it is read.
        unsafe {
            let numbers = board.tile(tile);
            if !std::mem::replace(&mut queue.visited[tile], true) {
                std::slice::from_raw_parts_mut(numbers.cast::<MaybeUninit<K::Number>>(), CELLS)
                    .fill(MaybeUninit::new(K::Number::FAR));
            }
            *numbers.add(cell) = K::Number::ZERO;
        }
        queue.add(tile, ALL_LINES, K::Number::ZERO);
    }
    let start = task.start.map(place);
    let shared = Mutex::new(&mut *queue);
    on_threads(task.threads, |_| at_level(task.simd, Visits { board, links, queue: &shared, start }));
    let most = match start {
        // SAFETY: the visits have ended.
        Some((tile, cell)) if queue.visited[tile] => unsafe { *board.tile(tile).add(cell) },
        _ => K::Number::FAR,
    };
    write(board, links, task, queue, most, values, codes)
}

/// Writes out the field of a settled board.
fn write<K: Links>(
    board: &Board<K::Number>,
    links: &K,
    task: &Task<'_>,
    queue: &Queue<K::Number>,
    most: K::Number,
    mut values: Vec<K::Number>,
    mut codes: Vec<i8>,
) -> Solved<K::Number> {
    let cells = task.rows * task.cols;
    values.clear();
    values.reserve_exact(cells);
    codes.clear();
    codes.reserve_exact(cells);
    let sheet =
        Sheet { values: values.as_mut_ptr(), codes: codes.as_mut_ptr(), rows: task.rows, cols: task.cols };
    let largest = Mutex::new(K::Number::ZERO);
    on_threads(task.threads, |thread| {
        let band = |thread: usize| board.tile_rows * thread / task.threads * board.tile_cols;
        let tiles = band(thread)..band(thread + 1);
        let write = Write { board, links, visited: &queue.visited, most, sheet: &sheet, tiles };
        let of_band = at_level(task.simd, write);
        let mut largest = largest.lock().unwrap_or_else(PoisonError::into_inner);
        *largest = if of_band > *largest { of_band } else { *largest };
    });
    // SAFETY: every cell of the grid was written.
    unsafe {
        values.set_len(cells);
        codes.set_len(cells);
    }
    let largest = largest.into_inner().unwrap_or_else(PoisonError::into_inner);
    Solved { values, codes, largest, work: queue.visits + queue.visited.len() }
}

/// Visits until there is nothing to do; several threads may do this at once.
struct Visits<'a, 'q, K: Links> {
    board: &'a Board<K::Number>,
    links: &'a K,
    queue: &'a Mutex<&'q mut Queue<K::Number>>,
    start: Option<(usize, usize)>,
}

impl<K: Links> Job for Visits<'_, '_, K> {
    type Number = K::Number;
    type Result = ();

    #[inline(always)]
    unsafe fn run<L: Lanes<Number = K::Number>>(self) {
        let Self { board, links, queue, start } = self;
        let mut desk = links.desk::<L>();
        let mut turned = Box::new(Turned([K::Number::FAR; CELLS]));
        let mut wakes = Wakes::default();
        let mut ended = None;
        loop {
            let (next, soon) = {
                let mut queue = queue.lock().unwrap_or_else(PoisonError::into_inner);
                for (tile, news, least) in wakes.drain() {
                    queue.add(tile, news, least);
                }
                if let Some(tile) = ended.take() {
                    queue.ended(tile);
                }
                let start = start.filter(|&(tile, _)| queue.visited[tile] && !queue.is_in_flight(tile));
                // SAFETY: the tile was filled and nobody is at it.
                let bound = start.map(|(tile, cell)| unsafe { *board.tile(tile).add(cell) }.key());
                (queue.take(bound), queue.soon())
            };
            if let Some(soon) = soon {
                board.prefetch::<L>(soon);
            }
            match next {
                // SAFETY: the queue keeps tiles in flight apart; the level is enabled.
                Next::Visit { tile, news, first } => unsafe {
                    visit::<L, K>(board, links, tile, news, first, &mut desk, &mut turned, &mut wakes);
                    ended = Some(tile);
                },
                Next::Wait => std::thread::yield_now(),
                Next::Done => return,
            }
        }
    }
}

/// Writes out some tiles; yields the largest number of a reachable cell.
struct Write<'a, K: Links> {
    board: &'a Board<K::Number>,
    links: &'a K,
    visited: &'a [bool],
    most: K::Number,
    sheet: &'a Sheet<K::Number>,
    tiles: Range<usize>,
}

impl<K: Links> Job for Write<'_, K> {
    type Number = K::Number;
    type Result = K::Number;

    #[inline(always)]
    unsafe fn run<L: Lanes<Number = K::Number>>(self) -> K::Number {
        let Self { board, links, visited, most, sheet, tiles } = self;
        let mut desk = links.desk::<L>();
        let mut patch = Patch::new();
        let mut largest = K::Number::ZERO;
        for tile in tiles {
            if visited[tile] {
                // SAFETY: the visits have ended; threads write to different rows of the sheet.
                let of_tile =
                    unsafe { finish::<L, K>(board, links, tile, most, &mut desk, &mut patch, sheet) };
                largest = if of_tile > largest { of_tile } else { largest };
            } else {
                // SAFETY: as above.
                unsafe { leave_out(board.tile_cols, tile, sheet) };
            }
        }
        largest
    }
}

/// Does the same on several threads, this one among them, numbered from 0.
fn on_threads(threads: usize, job: impl Fn(usize) + Sync) {
    std::thread::scope(|scope| {
        for thread in 1..threads {
            let job = &job;
            scope.spawn(move || job(thread));
        }
        job(0);
    });
}
