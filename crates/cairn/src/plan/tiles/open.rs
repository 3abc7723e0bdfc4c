//! The field inside a tile whose cells are all free: once over it from each side that fell.
//!
//! Where two neighbours of a side differ by no more than a straight link, the best way from that side to
//! a cell first goes aslant, then straight on, away from the side: one sweep follows it. Neither sweeps
//! across nor a second round can find more.

use super::SIDE;
use super::board::Side;
use super::lanes::{LANES, Lanes, TileCost};
use super::sweep::{
    Dirty, Line, LineLinks, Marks, VECTORS, load_line, moved_down, moved_up, store_line, sweep, turn,
};

/// Links of a tile whose cells are all free.
pub struct OpenLinks<L> {
    /// Cost of a straight link.
    pub straight: L,
    /// Cost of a diagonal link.
    pub diagonal: L,
}

impl<L: Lanes> LineLinks<L> for OpenLinks<L> {
    #[inline(always)]
    fn lower<const FORWARD: bool>(&self, _: usize, before: &Line<L>, line: &mut Line<L>) -> u64 {
        let mut changed = 0;
        for k in 0..VECTORS {
            let aslant = moved_up(before, k, L::Number::FAR).min(moved_down(before, k, L::Number::FAR));
            let offered = aslant.plus(self.diagonal).min(before[k].plus(self.straight));
            changed |= u64::from(offered.less(line[k])) << (k * LANES);
            line[k] = line[k].min(offered);
        }
        changed
    }
}

impl<L: Lanes> OpenLinks<L> {
    /// Settles a tile that was settled before some of its sides fell.
    ///
    /// # Safety
    /// As [`settle`](super::sweep::settle); `dirty.sides` are the sides that fell.
    #[inline(always)]
    pub unsafe fn spread(&self, values: *mut L::Number, turned: *mut L::Number, dirty: Dirty) -> Marks {
        let mut fell = Marks::default();
        let fell_at = |side: Side| dirty.sides & side.bit() != 0;
        if fell_at(Side::North) {
            fell.add(unsafe { self.spread_from::<true>(values) });
        }
        if fell_at(Side::South) {
            fell.add(unsafe { self.spread_from::<false>(values) });
        }
        if fell_at(Side::West) || fell_at(Side::East) {
            unsafe { turn::<L>(values, turned, Marks::ALL) };
            let mut across = Marks::default();
            if fell_at(Side::West) {
                across.add(unsafe { self.spread_from::<true>(turned) });
            }
            if fell_at(Side::East) {
                across.add(unsafe { self.spread_from::<false>(turned) });
            }
            if across.lines != 0 {
                unsafe { turn::<L>(turned, values, across) };
            }
            fell.add(across.turned());
        }
        fell
    }

    /// Spreads from the first line forward, or from the last one backward.
    #[inline(always)]
    unsafe fn spread_from<const FORWARD: bool>(&self, values: *mut L::Number) -> Marks {
        let first = if FORWARD { 0 } else { SIDE - 1 };
        let mut line = unsafe { load_line::<L>(values, first) };
        let mut fell = 0;
        loop {
            let mut changed = 0;
            let before = line;
            for (k, numbers) in line.iter_mut().enumerate() {
                let beside = moved_up(&before, k, L::Number::FAR).min(moved_down(&before, k, L::Number::FAR));
                let offered = beside.plus(self.straight);
                changed |= u64::from(offered.less(*numbers)) << (k * LANES);
                *numbers = numbers.min(offered);
            }
            if changed == 0 {
                break;
            }
            fell |= changed;
        }
        let mut marks = Marks { lines: 0, across: fell };
        if fell != 0 {
            unsafe { store_line(values, first, &line) };
            marks.lines = 1 << first;
        }
        marks.add(unsafe { sweep::<FORWARD, L, Self>(values, self, 1 << first) });
        marks
    }
}
