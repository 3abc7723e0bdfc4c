//! Links of grids whose cells are free, at unit cost, or blocked.

use super::SIDE;
use super::bits::FreeBits;
use super::creep::{Creep, is_narrow};
use super::finish::Around;
use super::lanes::{LANES, Lanes, TileCost};
use super::open::OpenLinks;
use super::sweep::{Dirty, FreeLinks, Marks, settle};
use super::visit::Links;
use crate::plan::moves::MOVES;

/// The links of a free grid.
pub struct FreeGrid<'a, T, const CUT: bool> {
    /// Its free cells.
    pub free: &'a FreeBits,
    /// Cost of a straight link.
    pub straight: T,
    /// Cost of a diagonal link.
    pub diagonal: T,
}

/// The links of a tile.
pub struct FreeDesk<L, const CUT: bool> {
    rows: FreeLinks<L, CUT>,
    cols: FreeLinks<L, CUT>,
    open: bool,
    creep: Box<Creep>,
}

impl<T: TileCost, const CUT: bool> Links for FreeGrid<'_, T, CUT> {
    type Number = T;
    type Desk<L: Lanes<Number = T>> = FreeDesk<L, CUT>;
    type Lines<L: Lanes<Number = T>> = FreeLinks<L, CUT>;

    #[inline(always)]
    fn desk<L: Lanes<Number = T>>(&self) -> Self::Desk<L> {
        let (straight, diagonal) = (L::splat(self.straight), L::splat(self.diagonal));
        let lines = || FreeLinks { free: [0; SIDE + 2], straight, diagonal };
        FreeDesk { rows: lines(), cols: lines(), open: false, creep: Box::default() }
    }

    #[inline(always)]
    fn lay_out<L: Lanes<Number = T>>(&self, tile: usize, desk: &mut Self::Desk<L>) {
        self.free.lines(tile, &mut desk.rows.free, &mut desk.cols.free);
        desk.open = desk.rows.free[1..=SIDE].iter().fold(!0, |all, line| all & line) == !0;
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
        values: *mut L::Number,
        turned: *mut L::Number,
        dirty: Dirty,
    ) -> Marks {
        if desk.open {
            let links = OpenLinks { straight: desk.rows.straight, diagonal: desk.rows.diagonal };
            return if dirty.sides != 0 {
                unsafe { links.spread(values, turned, dirty) }
            } else {
                unsafe { settle::<L, _>(values, turned, &links, &links, dirty) }
            };
        }
        if is_narrow(&desk.rows.free) {
            let steps = [self.straight, self.diagonal];
            let through = |here: T, _: usize, _: usize, code: usize| here.sum(steps[code % 2]);
            return unsafe { desk.creep.settle::<T, CUT>(values, &desk.rows.free, through, dirty) };
        }
        unsafe { settle::<L, _>(values, turned, &desk.rows, &desk.cols, dirty) }
    }

    fn cost(&self, row: usize, col: usize, code: usize) -> T {
        let (down, right) = MOVES[code];
        let (to_row, to_col) = (row.wrapping_add_signed(down), col.wrapping_add_signed(right));
        let free = |row: usize, col: usize| self.free.is_free(row, col);
        let aslant = code % 2 == 1;
        let passes = !aslant || CUT || free(row, to_col) && free(to_row, col);
        if !(passes && free(row, col) && free(to_row, to_col)) {
            return T::FAR;
        }
        if aslant { self.diagonal } else { self.straight }
    }

    #[inline(always)]
    fn lay_out_policy<L: Lanes<Number = T>>(&self, tile: usize, desk: &mut Self::Desk<L>) {
        self.free.lines(tile, &mut desk.rows.free, &mut desk.cols.free);
    }

    #[inline(always)]
    fn on_the_way<L: Lanes<Number = T>>(
        &self,
        desk: &Self::Desk<L>,
        row: usize,
        k: usize,
        around: &Around<L>,
    ) -> [u16; 8] {
        // Differences that wrap are above FAR and equal nothing.
        let straight = around.here.minus(desk.rows.straight);
        let diagonal = around.here.minus(desk.rows.diagonal);
        let mut masks = [0; 8];
        for (code, there) in around.there.iter().enumerate() {
            masks[code] = there.equal(if code % 2 == 0 { straight } else { diagonal });
        }
        if !CUT {
            let free = &desk.rows.free;
            let west = free[row + 1] << 1 | (desk.cols.free[0] >> row & 1);
            let east = free[row + 1] >> 1 | (desk.cols.free[SIDE + 1] >> row & 1) << (SIDE - 1);
            let (above, below) = (free[row], free[row + 2]);
            for (code, sides) in [(1, below & east), (3, below & west), (5, above & west), (7, above & east)]
            {
                masks[code] &= (sides >> (k * LANES)) as u16;
            }
        }
        masks
    }
}
