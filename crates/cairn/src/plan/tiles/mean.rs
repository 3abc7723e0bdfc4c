//! Links of grids where every cell has a cost: a link costs its length times the mean of its two cells.
//!
//! c = (a + b) · h with h = 1/2 straight and √2/2 aslant, the sum rounded, then the product; the same
//! both ways.

use super::SIDE;
use super::bits::Lines;
use super::creep::{Creep, is_narrow};
use super::finish::Around;
use super::lanes::{LANES, Lanes, TileCost};
use super::sheet::{LINES, PITCH, Sheet};
use super::sweep::{Dirty, Line, LineLinks, Marks, VECTORS, moved_down, moved_up, settle};
use super::visit::Links;
use crate::plan::moves::MOVES;

/// A float that cells may cost.
pub trait CellNumber: TileCost {
    /// Half the length of a straight move and of a diagonal one.
    const HALF_LENGTHS: [Self; 2];
    /// The cost of a move between cells of costs `self` and `other`.
    fn link(self, other: Self, diagonal: bool) -> Self;
}

macro_rules! cell_number {
    ($type:ident) => {
        impl CellNumber for $type {
            const HALF_LENGTHS: [Self; 2] = [0.5, std::f64::consts::FRAC_1_SQRT_2 as $type];
            #[inline(always)]
            fn link(self, other: Self, diagonal: bool) -> Self {
                (self + other) * Self::HALF_LENGTHS[usize::from(diagonal)]
            }
        }
    };
}
cell_number!(f32);
cell_number!(f64);

/// A grid of costs per unit length, infinite where blocked.
pub struct MeanGrid<'a, T, const CUT: bool> {
    /// Row-major.
    pub costs: &'a [T],
    /// Rows.
    pub rows: usize,
    /// Columns.
    pub cols: usize,
}

impl<T: CellNumber, const CUT: bool> MeanGrid<'_, T, CUT> {
    fn at(&self, row: isize, col: isize) -> T {
        let inside = (0..self.rows as isize).contains(&row) && (0..self.cols as isize).contains(&col);
        if inside { self.costs[row as usize * self.cols + col as usize] } else { T::FAR }
    }

    fn tile_corner(&self, tile: usize) -> (usize, usize) {
        let across = self.cols.div_ceil(SIDE);
        (tile / across * SIDE, tile % across * SIDE)
    }

    /// Copies the costs of a tile and of the cells around it; infinite outside the grid.
    fn copy_costs(&self, tile: usize, to: &mut Sheet<T>) {
        let (first_row, first_col) = self.tile_corner(tile);
        for line in 0..LINES {
            let numbers = &mut to.0[line * PITCH..(line + 1) * PITCH];
            let row = (first_row + line).wrapping_sub(1);
            if row >= self.rows {
                numbers.fill(T::FAR);
                continue;
            }
            let costs = &self.costs[row * self.cols..(row + 1) * self.cols];
            let inside = &costs[first_col..(first_col + SIDE + 1).min(self.cols)];
            numbers[LANES..LANES + inside.len()].copy_from_slice(inside);
            numbers[LANES + inside.len()..].fill(T::FAR);
            numbers[LANES - 1] = if first_col > 0 { costs[first_col - 1] } else { T::FAR };
        }
    }
}

/// The links between the lines of a tile, priced as they are swept: laid out, they would not stay in the
/// nearest cache.
pub struct MeanLinks<T, const CUT: bool> {
    costs: Box<Sheet<T>>,
    /// Free columns of the lines.
    free: Lines,
}

impl<T: CellNumber, const CUT: bool> MeanLinks<T, CUT> {
    fn new() -> Self {
        Self { costs: Sheet::all(T::FAR), free: [0; LINES] }
    }

    /// Notes which columns are free.
    #[inline(always)]
    fn note_free<L: Lanes<Number = T>>(&mut self) {
        for line in 0..LINES {
            self.free[line] = free_columns::<L>(&self.costs, line);
        }
    }
}

impl<L: Lanes, const CUT: bool> LineLinks<L> for MeanLinks<L::Number, CUT>
where
    L::Number: CellNumber,
{
    #[inline(always)]
    fn lower<const FORWARD: bool>(&self, to: usize, before: &Line<L>, line: &mut Line<L>) -> u64 {
        let far = L::splat(L::Number::FAR);
        let half = L::splat(L::Number::HALF_LENGTHS[0]);
        let slant = L::splat(L::Number::HALF_LENGTHS[1]);
        let from = if FORWARD { to - 1 } else { to + 1 };
        // Aslant, the cell ahead of the one left and the one beside the one entered are free.
        let (sides, beside) = (self.free[from], self.free[to]);
        let (left_passes, right_passes) = (sides & beside << 1, sides & beside >> 1);
        let mut changed = 0;
        for k in 0..VECTORS {
            let (to, from) = (to * PITCH + (k + 1) * LANES, from * PITCH + (k + 1) * LANES);
            // SAFETY: the sheet holds LINES lines of PITCH numbers, a margin around them among these.
            let (here, ahead, ahead_left, ahead_right) = unsafe {
                let costs = &self.costs;
                (costs.at::<L>(to), costs.at::<L>(from), costs.at::<L>(from - 1), costs.at::<L>(from + 1))
            };
            let left = before[k].after(if k > 0 { before[k - 1] } else { far });
            let right = before[k].ahead(if k + 1 < VECTORS { before[k + 1] } else { far });
            let mut left = left.plus(here.plus(ahead_left).times(slant));
            let mut right = right.plus(here.plus(ahead_right).times(slant));
            if !CUT {
                left = left.where_else((left_passes >> (k * LANES)) as u16, far);
                right = right.where_else((right_passes >> (k * LANES)) as u16, far);
            }
            let offered = before[k].plus(here.plus(ahead).times(half)).min(left.min(right));
            changed |= u64::from(offered.less(line[k])) << (k * LANES);
            line[k] = line[k].min(offered);
        }
        if changed == 0 {
            return 0;
        }
        // One cell along the line as well: cheap ways wind, and each bend would otherwise wait for a sweep
        // across.
        let settled = *line;
        for (k, numbers) in line.iter_mut().enumerate() {
            let at = to * PITCH + (k + 1) * LANES;
            // SAFETY: as above.
            let (here, to_left, to_right) =
                unsafe { (self.costs.at::<L>(at), self.costs.at::<L>(at - 1), self.costs.at::<L>(at + 1)) };
            let left = moved_up(&settled, k, L::Number::FAR).plus(here.plus(to_left).times(half));
            let right = moved_down(&settled, k, L::Number::FAR).plus(here.plus(to_right).times(half));
            let offered = left.min(right);
            changed |= u64::from(offered.less(*numbers)) << (k * LANES);
            *numbers = numbers.min(offered);
        }
        changed
    }
}

/// The links of a tile.
pub struct MeanDesk<T, const CUT: bool> {
    rows: MeanLinks<T, CUT>,
    cols: MeanLinks<T, CUT>,
    narrow: bool,
    creep: Box<Creep>,
}

/// The columns of a tile that are free in a line of its costs.
#[inline(always)]
fn free_columns<L: Lanes>(costs: &Sheet<L::Number>, line: usize) -> u64 {
    let far = L::splat(L::Number::FAR);
    let mut free = 0;
    for k in 0..VECTORS {
        // SAFETY: the sheet holds LINES lines of PITCH numbers.
        let costs = unsafe { L::load(costs.0.as_ptr().add(line * PITCH + (k + 1) * LANES)) };
        free |= u64::from(costs.less(far)) << (k * LANES);
    }
    free
}

impl<T: CellNumber, const CUT: bool> Links for MeanGrid<'_, T, CUT> {
    type Number = T;
    type Desk<L: Lanes<Number = T>> = MeanDesk<T, CUT>;
    type Lines<L: Lanes<Number = T>> = MeanLinks<T, CUT>;

    fn desk<L: Lanes<Number = T>>(&self) -> Self::Desk<L> {
        let (rows, cols) = (MeanLinks::new(), MeanLinks::new());
        MeanDesk { rows, cols, narrow: false, creep: Box::default() }
    }

    #[inline(always)]
    fn lay_out<L: Lanes<Number = T>>(&self, tile: usize, desk: &mut Self::Desk<L>) {
        self.copy_costs(tile, &mut desk.rows.costs);
        // SAFETY: tiles are laid out at the level of L.
        unsafe { desk.rows.costs.turn::<L>(&mut desk.cols.costs) };
        desk.rows.note_free::<L>();
        desk.cols.note_free::<L>();
        desk.narrow = is_narrow(&desk.rows.free);
    }

    #[inline(always)]
    fn rows<L: Lanes<Number = T>>(desk: &Self::Desk<L>) -> &Self::Lines<L> {
        &desk.rows
    }

    #[inline(always)]
    fn cols<L: Lanes<Number = T>>(desk: &Self::Desk<L>) -> &Self::Lines<L> {
        &desk.cols
    }

    #[inline(always)]
    unsafe fn settle<L: Lanes<Number = T>>(
        &self,
        desk: &mut Self::Desk<L>,
        values: *mut T,
        turned: *mut T,
        dirty: Dirty,
    ) -> Marks {
        if desk.narrow {
            let costs = &desk.rows.costs.0;
            let at = |cell: usize| (cell / SIDE + 1) * PITCH + LANES + cell % SIDE;
            let through = |here: T, from: usize, to: usize, code: usize| {
                here.sum(costs[at(to)].link(costs[at(from)], code % 2 == 1))
            };
            // SAFETY: the caller's.
            return unsafe { desk.creep.settle::<T, CUT>(values, &desk.rows.free, through, dirty) };
        }
        // SAFETY: the caller's.
        unsafe { settle::<L, _>(values, turned, &desk.rows, &desk.cols, dirty) }
    }

    fn cost(&self, row: usize, col: usize, code: usize) -> T {
        let (down, right) = MOVES[code];
        let (row, col) = (row as isize, col as isize);
        let aslant = code % 2 == 1;
        let passes =
            !aslant || CUT || self.at(row, col + right) < T::FAR && self.at(row + down, col) < T::FAR;
        if passes { self.at(row, col).link(self.at(row + down, col + right), aslant) } else { T::FAR }
    }

    #[inline(always)]
    fn lay_out_policy<L: Lanes<Number = T>>(&self, tile: usize, desk: &mut Self::Desk<L>) {
        self.copy_costs(tile, &mut desk.rows.costs);
    }

    #[inline(always)]
    fn on_the_way<L: Lanes<Number = T>>(
        &self,
        desk: &Self::Desk<L>,
        row: usize,
        k: usize,
        around: &Around<L>,
    ) -> [u16; 8] {
        let far = L::splat(T::FAR);
        let lengths = [L::splat(T::HALF_LENGTHS[0]), L::splat(T::HALF_LENGTHS[1])];
        let at = (row + 1) * PITCH + (k + 1) * LANES;
        // SAFETY: the sheet holds the tile and a margin around it.
        let costs = &desk.rows.costs;
        let (here, there) = unsafe {
            let there = [
                costs.at::<L>(at + 1),
                costs.at::<L>(at + PITCH + 1),
                costs.at::<L>(at + PITCH),
                costs.at::<L>(at + PITCH - 1),
                costs.at::<L>(at - 1),
                costs.at::<L>(at - PITCH - 1),
                costs.at::<L>(at - PITCH),
                costs.at::<L>(at - PITCH + 1),
            ];
            (costs.at::<L>(at), there)
        };
        let mut masks = [0; 8];
        for code in 0..8 {
            let link = here.plus(there[code]).times(lengths[code % 2]);
            masks[code] = around.there[code].plus(link).equal(around.here);
            if code % 2 == 1 && !CUT {
                masks[code] &= there[code - 1].max(there[(code + 1) % 8]).less(far);
            }
        }
        masks
    }
}
