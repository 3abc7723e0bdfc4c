//! One visit to a tile: take what neighbours offered, settle, and offer on.

use super::SIDE;
use super::board::{ALL_LINES, Board, News, Side};
use super::finish::Around;
use super::lanes::{LANES, Lanes, TileCost};
use super::sweep::{CELLS, Dirty, Line, LineLinks, Marks, load_line, settle, store_line};

/// The links of a grid, tile by tile.
pub trait Links: Sync {
    /// What links cost.
    type Number: TileCost;
    /// What a tile needs while it is visited, reused from visit to visit.
    type Desk<L: Lanes<Number = Self::Number>>;
    /// The links between the lines of a tile.
    type Lines<L: Lanes<Number = Self::Number>>: LineLinks<L>;

    /// An empty desk.
    fn desk<L: Lanes<Number = Self::Number>>(&self) -> Self::Desk<L>;
    /// Lays out the links of a tile.
    fn lay_out<L: Lanes<Number = Self::Number>>(&self, tile: usize, desk: &mut Self::Desk<L>);
    /// Links between the rows of the tile laid out.
    fn rows<L: Lanes<Number = Self::Number>>(desk: &Self::Desk<L>) -> &Self::Lines<L>;
    /// Links between its columns.
    fn cols<L: Lanes<Number = Self::Number>>(desk: &Self::Desk<L>) -> &Self::Lines<L>;
    /// Sweeps the tile laid out until nothing changes.
    ///
    /// # Safety
    /// As [`settle`].
    #[inline(always)]
    unsafe fn settle<L: Lanes<Number = Self::Number>>(
        &self,
        desk: &mut Self::Desk<L>,
        values: *mut L::Number,
        turned: *mut L::Number,
        dirty: Dirty,
    ) -> Marks {
        unsafe { settle::<L, _>(values, turned, Self::rows(desk), Self::cols(desk), dirty) }
    }
    /// Cost of the move with a code out of a cell; FAR if there is none.
    fn cost(&self, row: usize, col: usize, code: usize) -> Self::Number;
    /// Lays out what [`on_the_way`](Self::on_the_way) needs of a tile.
    fn lay_out_policy<L: Lanes<Number = Self::Number>>(&self, tile: usize, desk: &mut Self::Desk<L>);
    /// For each code of a move: which of sixteen cells, number `k * LANES` and on of a row of the tile
    /// laid out, have exactly the neighbour's number plus the link's cost.
    fn on_the_way<L: Lanes<Number = Self::Number>>(
        &self,
        desk: &Self::Desk<L>,
        row: usize,
        k: usize,
        around: &Around<L>,
    ) -> [u16; 8];
}

/// Tiles that were offered something better, with the sides concerned and the least number offered.
pub struct Wakes<T> {
    list: [Option<(usize, News, T)>; 8],
    count: usize,
}

impl<T> Default for Wakes<T> {
    fn default() -> Self {
        Self { list: [const { None }; 8], count: 0 }
    }
}

impl<T: Copy> Wakes<T> {
    fn add(&mut self, tile: usize, news: News, least: T) {
        self.list[self.count] = Some((tile, news, least));
        self.count += 1;
    }

    /// Takes them all.
    pub fn drain(&mut self) -> impl Iterator<Item = (usize, News, T)> + use<T> {
        let (list, count) = (self.list, std::mem::take(&mut self.count));
        list.into_iter().take(count).flatten()
    }
}

/// A tile turned about its diagonal.
#[repr(align(64))]
pub struct Turned<T>(pub [T; CELLS]);

/// The least of the numbers marked; FAR if none is.
#[inline(always)]
fn least<L: Lanes>(line: &Line<L>, marked: u64) -> L::Number {
    let far = L::splat(L::Number::FAR);
    let mut least = far;
    for (k, numbers) in line.iter().enumerate() {
        least = least.min(numbers.where_else((marked >> (k * LANES)) as u16, far));
    }
    let mut numbers = [L::Number::FAR; LANES];
    // SAFETY: the array has room for sixteen.
    unsafe { least.store(numbers.as_mut_ptr()) };
    numbers.into_iter().fold(L::Number::FAR, |a, b| if b < a { b } else { a })
}

/// Makes a tile's numbers FAR.
///
/// # Safety
/// Nobody else is at the tile; the level of `L` is enabled.
#[inline(always)]
unsafe fn fill<L: Lanes>(values: *mut L::Number) {
    let far = L::splat(L::Number::FAR);
    for at in (0..CELLS).step_by(LANES) {
        unsafe { far.store(values.add(at)) };
    }
}

/// Visits a tile; the `first` visit fills it.
///
/// # Safety
/// Nobody else is at the tile or one of its neighbours; the level of `L` is enabled.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub unsafe fn visit<L: Lanes, K: Links<Number = L::Number>>(
    board: &Board<L::Number>,
    links: &K,
    tile: usize,
    news: News,
    first: bool,
    desk: &mut K::Desk<L>,
    turned: &mut Turned<L::Number>,
    wakes: &mut Wakes<L::Number>,
) {
    const LAST: usize = SIDE - 1;
    let values = board.tile(tile);
    if first {
        unsafe { fill::<L>(values) };
    }
    let (mut rows, mut cols) = (0_u64, 0_u64);
    let mut dirty = Dirty::default();
    if news & ALL_LINES != 0 {
        (rows, cols, dirty) = (!0, !0, Dirty::ALL);
    }
    for (side, row) in [(Side::North, 0), (Side::South, LAST)] {
        if news & side.bit() == 0 {
            continue;
        }
        let mut line = unsafe { load_line::<L>(values, row) };
        let mut fell = 0;
        for (k, numbers) in line.iter_mut().enumerate() {
            let offered = unsafe { L::load(board.border(tile, side).add(k * LANES)) };
            fell |= u64::from(offered.less(*numbers)) << (k * LANES);
            *numbers = numbers.min(offered);
        }
        if fell != 0 {
            unsafe { store_line(values, row, &line) };
            rows |= 1 << row;
            cols |= fell;
        }
    }
    for (side, col) in [(Side::West, 0), (Side::East, LAST)] {
        if news & side.bit() == 0 {
            continue;
        }
        let mut fell = 0_u64;
        for row in 0..SIDE {
            let (offered, at) = unsafe { (*board.border(tile, side).add(row), values.add(row * SIDE + col)) };
            unsafe {
                if offered < *at {
                    *at = offered;
                    fell |= 1 << row;
                }
            }
        }
        if fell != 0 {
            cols |= 1 << col;
            rows |= fell;
        }
    }
    dirty.mark(rows, cols);
    dirty.sides = if news & ALL_LINES == 0 { news } else { 0 };
    links.lay_out::<L>(tile, desk);
    let fell = unsafe { links.settle::<L>(desk, values, turned.0.as_mut_ptr(), dirty) };
    rows |= fell.lines;
    cols |= fell.across;

    let (row_links, col_links) = (K::rows::<L>(desk), K::cols::<L>(desk));
    for (row, side, facing, down) in [(0, Side::North, Side::South, -1), (LAST, Side::South, Side::North, 1)]
    {
        if rows & 1 << row == 0 {
            continue;
        }
        let line = unsafe { load_line::<L>(values, row) };
        unsafe { store_line(board.border(tile, side), 0, &line) };
        if let Some(other) = board.beside(tile, down, 0) {
            unsafe { offer::<L, _>(board, row_links, &line, other, facing, down > 0, wakes) };
        }
    }
    for (col, side, facing, right) in [(0, Side::West, Side::East, -1), (LAST, Side::East, Side::West, 1)] {
        if cols & 1 << col == 0 {
            continue;
        }
        let record = board.border(tile, side);
        for row in 0..SIDE {
            unsafe { *record.add(row) = *values.add(row * SIDE + col) };
        }
        let line = unsafe { load_line::<L>(record, 0) };
        if let Some(other) = board.beside(tile, 0, right) {
            unsafe { offer::<L, _>(board, col_links, &line, other, facing, right > 0, wakes) };
        }
    }
    for (down, right, back) in [(false, false, 1), (false, true, 3), (true, true, 5), (true, false, 7)] {
        let (row, col) = (if down { LAST } else { 0 }, if right { LAST } else { 0 });
        if rows & 1 << row == 0 || cols & 1 << col == 0 {
            continue;
        }
        let (by_row, by_col) = (if down { 1 } else { -1 }, if right { 1 } else { -1 });
        let Some(other) = board.beside(tile, by_row, by_col) else { continue };
        // The cell beyond the corner: the move from there to here has code `back`.
        let beyond_row = (tile / board.tile_cols * SIDE + row).wrapping_add_signed(by_row);
        let beyond_col = (tile % board.tile_cols * SIDE + col).wrapping_add_signed(by_col);
        let link = links.cost(beyond_row, beyond_col, back);
        let offered = unsafe { (*values.add(row * SIDE + col)).sum(link) };
        let facing = if down { Side::North } else { Side::South };
        let record = unsafe { board.border(other, facing).add(LAST - col) };
        unsafe {
            if offered < *record {
                *record = offered;
                wakes.add(other, facing.bit(), offered);
            }
        }
    }
}

/// Offers a border line to the tile behind it.
#[inline(always)]
unsafe fn offer<L: Lanes, K: LineLinks<L>>(
    board: &Board<L::Number>,
    links: &K,
    line: &Line<L>,
    other: usize,
    facing: Side,
    forward: bool,
    wakes: &mut Wakes<L::Number>,
) {
    let record = board.border(other, facing);
    let mut theirs = unsafe { load_line::<L>(record, 0) };
    let fell = if forward {
        links.lower::<true>(SIDE + 1, line, &mut theirs)
    } else {
        links.lower::<false>(0, line, &mut theirs)
    };
    if fell != 0 {
        unsafe { store_line(record, 0, &theirs) };
        wakes.add(other, facing.bit(), least(&theirs, fell));
    }
}
