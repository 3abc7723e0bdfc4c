//! The field inside one tile: sweeps over its lines until nothing changes.
//!
//! A line (a row, or a column where the tile is turned about its diagonal) takes over what its
//! neighbour line offers, straight and aslant. The four sweeps (rows down, rows up, columns right,
//! columns left) cover all eight moves; each update is one link, added once, as Dijkstra adds it.

use super::board::News;
use super::lanes::{LANES, Lanes, TileCost};
use super::{SIDE, bits::Lines};

/// Vectors in a line of a tile.
pub const VECTORS: usize = SIDE / LANES;
/// A line of a tile.
pub type Line<L> = [L; VECTORS];
/// Numbers of a tile.
pub const CELLS: usize = SIDE * SIDE;

/// What the links between neighbouring lines of a tile cost.
pub trait LineLinks<L: Lanes> {
    /// Lowers `line`, which is line `to - 1` of the tile, to what `before` offers: the line before it
    /// (`FORWARD`) or behind it, and perhaps what its own cells offer one another then. Lines 0 and SIDE + 1 are those outside the tile. Returns the columns
    /// that fell.
    fn lower<const FORWARD: bool>(&self, to: usize, before: &Line<L>, line: &mut Line<L>) -> u64;
}

/// Links between free cells, of two lengths.
pub struct FreeLinks<L, const CUT: bool> {
    /// Free cells of the lines.
    pub free: Lines,
    /// Cost of a straight link.
    pub straight: L,
    /// Cost of a diagonal link.
    pub diagonal: L,
}

impl<L: Lanes, const CUT: bool> LineLinks<L> for FreeLinks<L, CUT> {
    #[inline(always)]
    fn lower<const FORWARD: bool>(&self, to: usize, before: &Line<L>, line: &mut Line<L>) -> u64 {
        let free = self.free[to];
        // A diagonal move needs, unless corners are cut, both cells free in the column that it leaves and
        // in the one that it enters.
        let both = free & self.free[if FORWARD { to - 1 } else { to + 1 }];
        let far = L::splat(L::Number::FAR);
        let mut aslant = *before;
        if !CUT {
            for k in 0..VECTORS {
                aslant[k] = before[k].where_else((both >> (k * LANES)) as u16, far);
            }
        }
        let mut changed = 0;
        for k in 0..VECTORS {
            let left = aslant[k].after(if k > 0 { aslant[k - 1] } else { far });
            let right = aslant[k].ahead(if k + 1 < VECTORS { aslant[k + 1] } else { far });
            let mut slant = left.min(right).plus(self.diagonal);
            if !CUT {
                slant = slant.where_else((both >> (k * LANES)) as u16, far);
            }
            let offered = before[k].plus(self.straight).min(slant);
            let offered = offered.where_else((free >> (k * LANES)) as u16, far);
            changed |= u64::from(offered.less(line[k])) << (k * LANES);
            line[k] = line[k].min(offered);
        }
        // A cell or two along the line as well: ways around single cells wind, and each bend would otherwise
        // wait for a sweep across.
        for _ in 0..if CUT { 1 } else { 2 } {
            if changed == 0 {
                break;
            }
            let settled = *line;
            let mut fell = 0;
            for (k, numbers) in line.iter_mut().enumerate() {
                let beside =
                    moved_up(&settled, k, L::Number::FAR).min(moved_down(&settled, k, L::Number::FAR));
                let offered = beside.plus(self.straight).where_else((free >> (k * LANES)) as u16, far);
                fell |= u64::from(offered.less(*numbers)) << (k * LANES);
                *numbers = numbers.min(offered);
            }
            changed |= fell;
            if fell == 0 {
                break;
            }
        }
        changed
    }
}

/// # Safety
/// `values` holds a tile; the level of `L` is enabled.
#[inline(always)]
pub unsafe fn load_line<L: Lanes>(values: *const L::Number, line: usize) -> Line<L> {
    // No closures here or wherever vectors are at work: only what is always inlined has the instructions.
    let mut numbers = [L::splat(L::Number::FAR); VECTORS];
    for (k, numbers) in numbers.iter_mut().enumerate() {
        *numbers = unsafe { L::load(values.add(line * SIDE + k * LANES)) };
    }
    numbers
}

/// Vector `k` of a line moved up one place, `outside` before the line's first number.
#[inline(always)]
pub fn moved_up<L: Lanes>(line: &Line<L>, k: usize, outside: L::Number) -> L {
    line[k].after(if k > 0 { line[k - 1] } else { L::splat(outside) })
}

/// Vector `k` of a line moved down one place, `outside` behind the line's last number.
#[inline(always)]
pub fn moved_down<L: Lanes>(line: &Line<L>, k: usize, outside: L::Number) -> L {
    line[k].ahead(if k + 1 < VECTORS { line[k + 1] } else { L::splat(outside) })
}

/// # Safety
/// `values` holds a tile; the level of `L` is enabled.
#[inline(always)]
pub unsafe fn store_line<L: Lanes>(values: *mut L::Number, line: usize, numbers: &Line<L>) {
    for (k, numbers) in numbers.iter().enumerate() {
        unsafe { numbers.store(values.add(line * SIDE + k * LANES)) };
    }
}

/// Lines and columns of a tile, a bit each.
#[derive(Clone, Copy, Default)]
pub struct Marks {
    /// Lines with a cell that fell.
    pub lines: u64,
    /// Columns with a cell that fell.
    pub across: u64,
}

impl Marks {
    /// Every line and column.
    pub const ALL: Self = Self { lines: !0, across: !0 };

    /// Marks those of `other` too.
    #[inline(always)]
    pub fn add(&mut self, other: Self) {
        self.lines |= other.lines;
        self.across |= other.across;
    }

    /// The same of the tile turned about its diagonal.
    #[inline(always)]
    pub fn turned(self) -> Self {
        Self { lines: self.across, across: self.lines }
    }
}

/// Carries the marked lines of a tile forward (or backward) as far as anything falls.
///
/// # Safety
/// `values` holds a tile; the level of `L` is enabled.
#[inline(always)]
pub unsafe fn sweep<const FORWARD: bool, L: Lanes, K: LineLinks<L>>(
    values: *mut L::Number,
    links: &K,
    mut dirty: u64,
) -> Marks {
    let last = if FORWARD { SIDE - 1 } else { 0 };
    let mut fell = Marks::default();
    dirty &= !(1 << last);
    while dirty != 0 {
        let mut at = if FORWARD { dirty.trailing_zeros() } else { 63 - dirty.leading_zeros() } as usize;
        let mut before = unsafe { load_line::<L>(values, at) };
        loop {
            dirty &= !(1 << at);
            if at == last {
                break;
            }
            at = if FORWARD { at + 1 } else { at - 1 };
            let mut line = unsafe { load_line::<L>(values, at) };
            let changed = links.lower::<FORWARD>(at + 1, &before, &mut line);
            if changed != 0 {
                unsafe { store_line(values, at, &line) };
                fell.lines |= 1 << at;
                fell.across |= changed;
            } else if dirty & 1 << at == 0 {
                break;
            }
            before = line;
        }
    }
    fell
}

/// What still has to be carried on, by direction of the sweep.
#[derive(Clone, Copy, Default)]
pub struct Dirty {
    /// Rows, downward (to higher rows).
    pub down: u64,
    /// Rows, upward.
    pub up: u64,
    /// Columns, to the right.
    pub right: u64,
    /// Columns, to the left.
    pub left: u64,
    /// The sides whose line fell, if nothing else did.
    pub sides: News,
}

impl Dirty {
    /// Everything.
    pub const ALL: Self = Self { down: !0, up: !0, right: !0, left: !0, sides: 0 };

    /// Marks the rows and columns that fell.
    #[inline(always)]
    pub fn mark(&mut self, rows: u64, cols: u64) {
        self.down |= rows;
        self.up |= rows;
        self.right |= cols;
        self.left |= cols;
    }
}

/// Copies a tile turned about its diagonal, as far as it changed in the marked lines and columns.
///
/// # Safety
/// Both hold a tile, apart from each other; the level of `L` is enabled.
#[inline(always)]
pub unsafe fn turn<L: Lanes>(from: *const L::Number, to: *mut L::Number, of: Marks) {
    for row in (0..SIDE).step_by(LANES) {
        if (of.lines >> row) as u16 == 0 {
            continue;
        }
        for col in (0..SIDE).step_by(LANES) {
            if (of.across >> col) as u16 == 0 {
                continue;
            }
            unsafe { L::transpose(from.add(row * SIDE + col), SIDE, to.add(col * SIDE + row), SIDE) };
        }
    }
}

/// Sweeps until nothing is dirty; returns every row and column with a cell that fell.
///
/// # Safety
/// `values` and `turned` hold a tile each; the level of `L` is enabled.
#[inline(always)]
pub unsafe fn settle<L: Lanes, K: LineLinks<L>>(
    values: *mut L::Number,
    turned: *mut L::Number,
    rows: &K,
    cols: &K,
    mut dirty: Dirty,
) -> Marks {
    let (mut fell, mut unturned) = (Marks::default(), Marks::ALL);
    loop {
        let mut along = unsafe { sweep::<true, L, K>(values, rows, std::mem::take(&mut dirty.down)) };
        dirty.up |= along.lines;
        let up = unsafe { sweep::<false, L, K>(values, rows, std::mem::take(&mut dirty.up)) };
        dirty.down |= up.lines;
        along.add(up);
        dirty.right |= along.across;
        dirty.left |= along.across;
        fell.add(along);
        unturned.add(along);
        if dirty.right & !(1 << (SIDE - 1)) | dirty.left & !1 == 0 {
            if dirty.down & !(1 << (SIDE - 1)) | dirty.up & !1 == 0 {
                return fell;
            }
            continue;
        }
        unsafe { turn::<L>(values, turned, std::mem::take(&mut unturned)) };
        let mut along = unsafe { sweep::<true, L, K>(turned, cols, std::mem::take(&mut dirty.right)) };
        dirty.left |= along.lines;
        let left = unsafe { sweep::<false, L, K>(turned, cols, std::mem::take(&mut dirty.left)) };
        dirty.right |= left.lines;
        along.add(left);
        if along.lines != 0 {
            unsafe { turn::<L>(turned, values, along) };
            dirty.down |= along.across;
            dirty.up |= along.across;
            fell.add(along.turned());
        }
    }
}
