//! Links of grids where every cell has a cost: a link costs its length times the mean of its two cells.
//!
//! c = (a + b) · h with h = 1/2 straight and √2/2 aslant, the sum rounded, then the product; the same
//! both ways.

use std::ops::Range;

use super::SIDE;
use super::bits::Lines;
use super::creep::{Creep, is_narrow};
use super::finish::Around;
use super::lanes::{LANES, Lanes, TileCost};
use super::sweep::{Dirty, Line, LineLinks, Marks, VECTORS, settle};
use super::visit::Links;
use crate::plan::moves::MOVES;

/// Numbers from one line of costs to the next: a tile's width and a vector of margin on both sides.
const PITCH: usize = SIDE + 2 * LANES;
/// Lines of a tile and one around it.
const LINES: usize = SIDE + 2;

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

/// Numbers of the cells of a tile and around it: cell (row, col) at `(row + 1) * PITCH + LANES + col`.
#[repr(align(64))]
struct Sheet<T>([T; LINES * PITCH]);

impl<T: TileCost> Sheet<T> {
    /// The sixteen numbers from `at` on, of which there must be as many.
    #[inline(always)]
    unsafe fn at<L: Lanes<Number = T>>(&self, at: usize) -> L {
        unsafe { L::load(self.0.as_ptr().add(at)) }
    }
}

/// What the links into each line from the line before it cost; number `LANES + col` of each line.
///
/// A link costs the same both ways, so those from the line behind are the next line's, moved.
#[repr(align(64))]
pub struct MeanLinks<T> {
    straight: [T; LINES * PITCH],
    /// From the column before.
    from_left: [T; LINES * PITCH],
    /// From the column behind.
    from_right: [T; LINES * PITCH],
}

/// What the diagonal links from `other` to `here` cost; none where a cell at their sides is blocked.
#[inline(always)]
fn aslant<L: Lanes, const CUT: bool>(here: L, other: L, sides: [L; 2]) -> L
where
    L::Number: CellNumber,
{
    let far = L::splat(L::Number::FAR);
    let cost = here.plus(other).times(L::splat(L::Number::HALF_LENGTHS[1]));
    if CUT { cost } else { cost.where_else(sides[0].max(sides[1]).less(far), far) }
}

impl<T: CellNumber> MeanLinks<T> {
    #[inline(always)]
    unsafe fn fill<L: Lanes<Number = T>, const CUT: bool>(&mut self, costs: &Sheet<T>, lines: Range<usize>) {
        let half = L::splat(T::HALF_LENGTHS[0]);
        for line in lines {
            // One vector more: the moved links reach one column out of the tile.
            for k in 1..VECTORS + 2 {
                let at = line * PITCH + k * LANES;
                unsafe {
                    let (here, above) = (costs.at::<L>(at), costs.at::<L>(at - PITCH));
                    let (left, above_left) = (costs.at::<L>(at - 1), costs.at::<L>(at - PITCH - 1));
                    let from_left = aslant::<L, CUT>(here, above_left, [above, left]);
                    // The other diagonal of the same square: from `above` to `left`.
                    let to_left = aslant::<L, CUT>(left, above, [above_left, here]);
                    here.plus(above).times(half).store(self.straight.as_mut_ptr().add(at));
                    from_left.store(self.from_left.as_mut_ptr().add(at));
                    to_left.store(self.from_right.as_mut_ptr().add(at - 1));
                }
            }
        }
    }
}

/// Sixteen costs from number `at` on.
#[inline(always)]
fn load_costs<L: Lanes>(costs: &[L::Number; LINES * PITCH], at: usize) -> L {
    debug_assert!(at + LANES <= costs.len());
    // SAFETY: lines and columns of a tile lie within.
    unsafe { L::load(costs.as_ptr().add(at)) }
}

impl<L: Lanes> LineLinks<L> for MeanLinks<L::Number>
where
    L::Number: CellNumber,
{
    #[inline(always)]
    fn lower<const FORWARD: bool>(&self, to: usize, before: &Line<L>, line: &mut Line<L>) -> u64 {
        let far = L::splat(L::Number::FAR);
        let line_of_costs = (if FORWARD { to } else { to + 1 }) * PITCH + LANES;
        // Backward, a link's cost stands at the end it leaves from: it is added before the numbers move.
        let (mut rightward, mut leftward) = (*before, *before);
        if !FORWARD {
            for k in 0..VECTORS {
                rightward[k] = before[k].plus(load_costs::<L>(&self.from_right, line_of_costs + k * LANES));
                leftward[k] = before[k].plus(load_costs::<L>(&self.from_left, line_of_costs + k * LANES));
            }
        }
        let mut changed = 0;
        for k in 0..VECTORS {
            let mut left = rightward[k].after(if k > 0 { rightward[k - 1] } else { far });
            let mut right = leftward[k].ahead(if k + 1 < VECTORS { leftward[k + 1] } else { far });
            if FORWARD {
                left = left.plus(load_costs::<L>(&self.from_left, line_of_costs + k * LANES));
                right = right.plus(load_costs::<L>(&self.from_right, line_of_costs + k * LANES));
            }
            let offered = before[k]
                .plus(load_costs::<L>(&self.straight, line_of_costs + k * LANES))
                .min(left.min(right));
            changed |= u64::from(offered.less(line[k])) << (k * LANES);
            line[k] = line[k].min(offered);
        }
        changed
    }
}

/// The links of a tile.
pub struct MeanDesk<T> {
    costs: Box<Sheet<T>>,
    turned: Box<Sheet<T>>,
    rows: Box<MeanLinks<T>>,
    cols: Box<MeanLinks<T>>,
    free: Lines,
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
    type Desk<L: Lanes<Number = T>> = MeanDesk<T>;
    type Lines<L: Lanes<Number = T>> = MeanLinks<T>;

    fn desk<L: Lanes<Number = T>>(&self) -> Self::Desk<L> {
        let far = [T::FAR; LINES * PITCH];
        let links = || Box::new(MeanLinks { straight: far, from_left: far, from_right: far });
        let (free, narrow, creep) = ([0; LINES], false, Box::default());
        let (costs, turned) = (Box::new(Sheet(far)), Box::new(Sheet(far)));
        MeanDesk { costs, turned, rows: links(), cols: links(), free, narrow, creep }
    }

    #[inline(always)]
    fn lay_out<L: Lanes<Number = T>>(&self, tile: usize, desk: &mut Self::Desk<L>) {
        self.copy_costs(tile, &mut desk.costs);
        let (costs, turned) = (&desk.costs.0, &mut desk.turned.0);
        let inside = |row: usize, col: usize| (row + 1) * PITCH + LANES + col;
        for row in (0..SIDE).step_by(LANES) {
            for col in (0..SIDE).step_by(LANES) {
                // SAFETY: both sheets hold the tile.
                unsafe {
                    let (from, to) =
                        (costs.as_ptr().add(inside(row, col)), turned.as_mut_ptr().add(inside(col, row)));
                    L::transpose(from, PITCH, to, PITCH);
                }
            }
        }
        for i in 0..LINES {
            let (first, last) = (LANES - 1, LANES + SIDE); // columns just outside the tile
            turned[LANES - 1 + i] = costs[i * PITCH + first];
            turned[(LINES - 1) * PITCH + LANES - 1 + i] = costs[i * PITCH + last];
            turned[i * PITCH + first] = costs[LANES - 1 + i];
            turned[i * PITCH + last] = costs[(LINES - 1) * PITCH + LANES - 1 + i];
        }
        for (row, line) in desk.free.iter_mut().enumerate() {
            *line = free_columns::<L>(&desk.costs, row);
        }
        desk.narrow = is_narrow(&desk.free);
        // Cell by cell, only what lies between this tile and the next is asked of the lines.
        let lines = if desk.narrow { [1..2, SIDE + 1..LINES] } else { [1..LINES, 0..0] };
        for lines in lines {
            unsafe {
                desk.rows.fill::<L, CUT>(&desk.costs, lines.clone());
                desk.cols.fill::<L, CUT>(&desk.turned, lines);
            }
        }
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
            let costs = &desk.costs.0;
            let at = |cell: usize| (cell / SIDE + 1) * PITCH + LANES + cell % SIDE;
            let through = |here: T, from: usize, to: usize, code: usize| {
                here.sum(costs[at(to)].link(costs[at(from)], code % 2 == 1))
            };
            // SAFETY: the caller's.
            return unsafe { desk.creep.settle::<T, CUT>(values, &desk.free, through, dirty) };
        }
        // SAFETY: the caller's.
        unsafe { settle::<L, _>(values, turned, &*desk.rows, &*desk.cols, dirty) }
    }

    fn corner(&self, tile: usize, down: bool, right: bool) -> T {
        let (row, col) = self.tile_corner(tile);
        let row = (if down { row + SIDE - 1 } else { row }) as isize;
        let col = (if right { col + SIDE - 1 } else { col }) as isize;
        let (beyond_row, beyond_col) =
            (if down { row + 1 } else { row - 1 }, if right { col + 1 } else { col - 1 });
        let far = T::FAR;
        let sides = CUT || self.at(row, beyond_col) < far && self.at(beyond_row, col) < far;
        if sides { self.at(row, col).link(self.at(beyond_row, beyond_col), true) } else { far }
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
        self.copy_costs(tile, &mut desk.costs);
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
        let costs = &desk.costs;
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
