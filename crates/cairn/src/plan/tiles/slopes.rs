//! Links of a terrain, priced while its tiles are worked on: nothing is kept but heights, roughness and
//! allowed moves.
//!
//! Between two neighbouring lines there are three pairs of moves, straight and aslant, there and back;
//! they are priced together when a sweep first passes. As in [`directed`](super::directed), a cost
//! stands at the cell that a move leaves.

use std::cell::{Cell, UnsafeCell};

use super::SIDE;
use super::finish::Around;
use super::lanes::{LANES, Lanes};
use super::level::Simd;
use super::sheet::{LINES, PITCH, Sheet};
use super::sweep::{Line, LineLinks, VECTORS};
use super::visit::Links;
use crate::plan::terrain::{LinkCost, TerrainLinks};
use crate::world::GridGeometry;

/// A line of a sheet from some column on.
type Cells = [f32; SIDE];

/// What prices are made of.
#[derive(Clone)]
struct Ground {
    heights: Box<Sheet<f32>>,
    roughness: Box<Sheet<f32>>,
    /// The bits of the allowed moves, as the bits of a float: turned about the diagonal like one.
    moves: Box<Sheet<f32>>,
}

/// Part of a line of each sheet.
#[derive(Clone, Copy)]
struct Strip<'a> {
    heights: &'a Cells,
    roughness: &'a Cells,
    moves: &'a Cells,
}

impl Ground {
    fn new() -> Self {
        let sheet = || Sheet::all(0.0);
        Self { heights: sheet(), roughness: sheet(), moves: sheet() }
    }

    /// The cells of a line of the tile (0 is the one before it), beginning `shift` behind its first column.
    #[inline(always)]
    fn strip<'a>(&'a self, line: usize, shift: isize) -> Strip<'a> {
        let at = (line * PITCH + LANES).wrapping_add_signed(shift);
        let part =
            |sheet: &'a Sheet<f32>| sheet.0[at..].first_chunk().expect("a line reaches behind the tile");
        Strip { heights: part(&self.heights), roughness: part(&self.roughness), moves: part(&self.moves) }
    }
}

/// Costs between a line and the one before it: out of the line, straight, to the column before, to the
/// one behind; then back, straight, to the one behind, to the one before. The last two with margins.
#[repr(align(64))]
#[derive(Clone)]
struct Gap([f32; 6 * SIDE + 2 * LANES]);

impl Gap {
    const STRAIGHT: usize = 0;
    const LEFT: usize = SIDE;
    const RIGHT: usize = 2 * SIDE;
    const BACK: usize = 3 * SIDE;
    const BACK_RIGHT: usize = 4 * SIDE + LANES;
    const BACK_LEFT: usize = 5 * SIDE + LANES;
}

/// Codes of the moves out of a row to the row before: straight, to the column before, to the one behind.
/// The ways back are the codes opposite.
const BETWEEN_ROWS: [usize; 3] = [6, 5, 7];
/// The same between columns.
const BETWEEN_COLS: [usize; 3] = [4, 5, 3];

/// The links between the lines of a tile, priced when they are first asked for.
pub struct Slopes<M> {
    model: M,
    ground: Ground,
    codes: [usize; 3],
    /// Gap i lies between the lines i - 1 and i; line 0 is the one before the tile.
    gaps: UnsafeCell<Box<[Gap; LINES]>>,
    /// The gaps that are priced, a bit each.
    priced: Cell<u128>,
}

impl<M: LinkCost> Slopes<M> {
    fn new(model: M, codes: [usize; 3]) -> Self {
        let gaps = vec![Gap([f32::INFINITY; 6 * SIDE + 2 * LANES]); LINES].into_boxed_slice();
        let gaps = gaps.try_into().unwrap_or_else(|_| unreachable!("LINES gaps"));
        Self { model, ground: Ground::new(), codes, gaps: UnsafeCell::new(gaps), priced: Cell::new(0) }
    }

    /// A gap, priced.
    ///
    /// # Safety
    /// The level of `L` is enabled.
    #[inline(always)]
    unsafe fn gap<L: Lanes>(&self, gap: usize) -> *const f32 {
        // SAFETY: nobody else looks at this gap meanwhile; the desk is one thread's.
        unsafe {
            if self.priced.get() >> gap & 1 == 0 {
                self.priced.set(self.priced.get() | 1 << gap);
                self.price_at::<L>(gap);
            }
            (*self.gaps.get())[gap].0.as_ptr()
        }
    }

    /// Prices a gap in a function of its own.
    ///
    /// # Safety
    /// The level of `L` is enabled; nobody else looks at the gap.
    #[inline(always)]
    unsafe fn price_at<L: Lanes>(&self, gap: usize) {
        // SAFETY: the caller's.
        unsafe {
            let costs = &mut (*self.gaps.get())[gap];
            match L::LEVEL {
                #[cfg(target_arch = "x86_64")]
                Simd::Avx512 => price_avx512(&self.ground, self.model, self.codes, gap, costs),
                #[cfg(target_arch = "x86_64")]
                Simd::Avx2 => price_avx2(&self.ground, self.model, self.codes, gap, costs),
                _ => price_portable(&self.ground, self.model, self.codes, gap, costs),
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx2,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn price_avx512<M: LinkCost>(ground: &Ground, model: M, codes: [usize; 3], gap: usize, costs: &mut Gap) {
    price(ground, model, codes, gap, costs);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn price_avx2<M: LinkCost>(ground: &Ground, model: M, codes: [usize; 3], gap: usize, costs: &mut Gap) {
    price(ground, model, codes, gap, costs);
}

#[inline(never)]
fn price_portable<M: LinkCost>(ground: &Ground, model: M, codes: [usize; 3], gap: usize, costs: &mut Gap) {
    price(ground, model, codes, gap, costs);
}

/// Prices the links between two lines, there and back.
#[inline(always)]
fn price<M: LinkCost>(ground: &Ground, model: M, codes: [usize; 3], gap: usize, costs: &mut Gap) {
    let here = ground.strip(gap, 0);
    for (pair, shift) in [(0, 0), (1, -1), (2, 1)] {
        let there = ground.strip(gap - 1, shift);
        let (out, back) = costs.0.split_at_mut(Gap::BACK);
        let out = &mut out[pair * SIDE..][..SIDE];
        let back_at = [Gap::BACK, Gap::BACK_RIGHT - 1, Gap::BACK_LEFT + 1][pair] - Gap::BACK;
        let back = &mut back[back_at..][..SIDE];
        let (Ok(out), Ok(back)) = (out.try_into(), back.try_into()) else { return };
        let bits = [1 << codes[pair], 1 << (codes[pair] ^ 4)];
        if pair == 0 {
            both_ways::<M, false>(model, here, there, bits, out, back);
        } else {
            both_ways::<M, true>(model, here, there, bits, out, back);
        }
    }
}

/// Prices the moves from some cells to others and back.
#[inline(always)]
fn both_ways<M: LinkCost, const DIAGONAL: bool>(
    model: M,
    here: Strip<'_>,
    there: Strip<'_>,
    bits: [u32; 2],
    out: &mut Cells,
    back: &mut Cells,
) {
    for i in 0..SIDE {
        let rise = there.heights[i] - here.heights[i];
        let (from, to) = if M::USES_ROUGHNESS { (here.roughness[i], there.roughness[i]) } else { (0.0, 0.0) };
        // Opposite differences are exact opposites, so the way back shares what both have in common.
        let (cost, cost_back) =
            (model.link::<DIAGONAL>(rise, from, to), model.link::<DIAGONAL>(-rise, from, to));
        let (moves, moves_back) = (here.moves[i].to_bits(), there.moves[i].to_bits());
        out[i] = if moves & bits[0] != 0 { cost } else { f32::INFINITY };
        back[i] = if moves_back & bits[1] != 0 { cost_back } else { f32::INFINITY };
    }
}

impl<L: Lanes<Number = f32>, M: LinkCost> LineLinks<L> for Slopes<M> {
    #[inline(always)]
    fn lower<const FORWARD: bool>(&self, to: usize, before: &Line<L>, line: &mut Line<L>) -> u64 {
        let far = L::splat(f32::INFINITY);
        let [straight, left, right] = if FORWARD {
            [Gap::STRAIGHT, Gap::LEFT, Gap::RIGHT]
        } else {
            [Gap::BACK, Gap::BACK_LEFT, Gap::BACK_RIGHT]
        };
        // SAFETY: sweeps run at the level of L.
        let costs = unsafe { self.gap::<L>(if FORWARD { to } else { to + 1 }) };
        let mut changed = 0;
        for k in 0..VECTORS {
            // SAFETY: a gap holds SIDE numbers from each of these places on.
            let (straight, from_left, from_right) = unsafe {
                let costs = costs.add(k * LANES);
                (L::load(costs.add(straight)), L::load(costs.add(left)), L::load(costs.add(right)))
            };
            let from_left = before[k].after(if k > 0 { before[k - 1] } else { far }).plus(from_left);
            let behind = if k + 1 < VECTORS { before[k + 1] } else { far };
            let from_right = before[k].ahead(behind).plus(from_right);
            let offered = before[k].plus(straight).min(from_left.min(from_right));
            changed |= u64::from(offered.less(line[k])) << (k * LANES);
            line[k] = line[k].min(offered);
        }
        changed
    }
}

/// The links of a tile.
pub struct SlopeDesk<M> {
    rows: Slopes<M>,
    cols: Slopes<M>,
    /// Costs of the moves along rows, codes 0 and 4, of a whole tile.
    along: Box<[[[f32; SIDE + LANES]; 2]; SIDE]>,
}

impl<M: LinkCost> TerrainLinks<'_, M> {
    /// First row and column of a tile.
    fn place(&self, tile: usize) -> (usize, usize) {
        let across = self.geometry.cols.div_ceil(SIDE);
        (tile / across * SIDE, tile % across * SIDE)
    }

    /// Copies what prices are made of for a tile and the cells around it; no moves are allowed outside the grid.
    #[inline(always)]
    fn copy(&self, tile: usize, to: &mut Ground) {
        let (first_row, first_col) = self.place(tile);
        let GridGeometry { rows, cols, .. } = self.geometry;
        let before = usize::from(first_col > 0); // a column before the tile
        let count = (cols - first_col).min(SIDE + 1) + before;
        for line in 0..LINES {
            let row = (first_row + line).wrapping_sub(1);
            let moves = &mut to.moves.0[line * PITCH..(line + 1) * PITCH];
            if row >= rows {
                moves.fill(0.0);
                continue;
            }
            let from = row * cols + first_col - before;
            let (first, last) = (LANES - before, LANES - before + count);
            for (to, &bits) in moves[first..last].iter_mut().zip(&self.allowed[from..from + count]) {
                *to = f32::from_bits(u32::from(bits));
            }
            moves[..first].fill(0.0);
            moves[last..].fill(0.0);
            let place = line * PITCH + first..line * PITCH + last;
            to.heights.0[place.clone()].copy_from_slice(&self.elevation[from..from + count]);
            if M::USES_ROUGHNESS {
                to.roughness.0[place].copy_from_slice(&self.roughness[from..from + count]);
            }
        }
    }
}

impl<M: LinkCost> TerrainLinks<'_, M> {
    /// Asks for what will be copied for a tile, if there is one.
    #[inline(always)]
    fn fetch(&self, tile: usize) {
        let (first_row, first_col) = self.place(tile);
        let GridGeometry { rows, cols, .. } = self.geometry;
        for row in first_row..(first_row + SIDE).min(rows) {
            let at = row * cols + first_col;
            fetch(&self.allowed, at);
            for line in (0..SIDE).step_by(LANES) {
                fetch(self.elevation, at + line);
                if M::USES_ROUGHNESS {
                    fetch(&self.roughness, at + line);
                }
            }
        }
    }
}

/// Asks for a number, if there is one, to be brought near.
#[inline(always)]
fn fetch<T>(numbers: &[T], at: usize) {
    #[cfg(target_arch = "x86_64")]
    if at < numbers.len() {
        use std::arch::x86_64::{_MM_HINT_T1, _mm_prefetch};
        // SAFETY: the number is there.
        unsafe { _mm_prefetch::<_MM_HINT_T1>(numbers.as_ptr().add(at).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (numbers, at);
}

impl<M: LinkCost> Links for TerrainLinks<'_, M> {
    type Number = f32;
    type Desk<L: Lanes<Number = f32>> = SlopeDesk<M>;
    type Lines<L: Lanes<Number = f32>> = Slopes<M>;

    fn desk<L: Lanes<Number = f32>>(&self) -> Self::Desk<L> {
        SlopeDesk {
            rows: Slopes::new(self.model, BETWEEN_ROWS),
            cols: Slopes::new(self.model, BETWEEN_COLS),
            along: Box::new([[[f32::INFINITY; SIDE + LANES]; 2]; SIDE]),
        }
    }

    #[inline(always)]
    fn lay_out<L: Lanes<Number = f32>>(&self, tile: usize, desk: &mut Self::Desk<L>) {
        self.copy(tile, &mut desk.rows.ground);
        let (rows, cols) = (&desk.rows.ground, &mut desk.cols.ground);
        // SAFETY: tiles are laid out at the level of L.
        unsafe {
            rows.heights.turn::<L>(&mut cols.heights);
            rows.moves.turn::<L>(&mut cols.moves);
            if M::USES_ROUGHNESS {
                rows.roughness.turn::<L>(&mut cols.roughness);
            }
        }
        desk.rows.priced.set(0);
        desk.cols.priced.set(0);
    }

    #[inline(always)]
    fn rows<L: Lanes<Number = f32>>(desk: &Self::Desk<L>) -> &Self::Lines<L> {
        &desk.rows
    }

    #[inline(always)]
    fn cols<L: Lanes<Number = f32>>(desk: &Self::Desk<L>) -> &Self::Lines<L> {
        &desk.cols
    }

    fn cost(&self, row: usize, col: usize, code: usize) -> f32 {
        let index = row * self.geometry.cols + col;
        if self.allowed[index] >> code & 1 == 1 {
            TerrainLinks::cost(self, index, code)
        } else {
            f32::INFINITY
        }
    }

    #[inline(always)]
    fn lay_out_policy<L: Lanes<Number = f32>>(&self, tile: usize, desk: &mut Self::Desk<L>) {
        self.copy(tile, &mut desk.rows.ground);
        self.fetch(tile + 1);
        let SlopeDesk { rows, along, .. } = desk;
        for gap in 1..LINES {
            // SAFETY: tiles are written out at the level of L.
            unsafe { rows.price_at::<L>(gap) };
        }
        let ground = &rows.ground;
        for (row, [right, left]) in along.iter_mut().enumerate() {
            let (here, there) = (ground.strip(row + 1, 0), ground.strip(row + 1, 1));
            let (Ok(out), Ok(back)) = ((&mut right[..SIDE]).try_into(), (&mut left[1..=SIDE]).try_into())
            else {
                continue;
            };
            both_ways::<M, false>(self.model, here, there, [1, 1 << 4], out, back);
        }
        // Pairs that begin or end beside the tile.
        let (first_row, first_col) = self.place(tile);
        let GridGeometry { rows: height, cols: width, .. } = self.geometry;
        let gaps = rows.gaps.get_mut();
        let cost = |row: usize, col: usize, code: usize| {
            if row >= height || col >= width || self.allowed[row * width + col] >> code & 1 == 0 {
                f32::INFINITY
            } else {
                TerrainLinks::cost(self, row * width + col, code)
            }
        };
        for (row, [_, left]) in along.iter_mut().enumerate() {
            left[0] = cost(first_row + row, first_col, 4);
            gaps[row + 2].0[Gap::BACK_LEFT] = cost(first_row + row, first_col, 3);
            gaps[row + 2].0[Gap::BACK_RIGHT + SIDE - 1] = cost(first_row + row, first_col + SIDE - 1, 1);
        }
    }

    #[inline(always)]
    fn on_the_way<L: Lanes<Number = f32>>(
        &self,
        desk: &Self::Desk<L>,
        row: usize,
        k: usize,
        around: &Around<L>,
    ) -> [u16; 8] {
        // SAFETY: nobody changes the gaps meanwhile; each holds SIDE numbers from these places on.
        let (gaps, along) = (unsafe { &*desk.rows.gaps.get() }, &desk.along[row]);
        let (above, below) = (&gaps[row + 1].0, &gaps[row + 2].0);
        let costs: [&[f32]; 8] = [
            &along[0],
            &below[Gap::BACK_RIGHT..],
            &below[Gap::BACK..],
            &below[Gap::BACK_LEFT..],
            &along[1],
            &above[Gap::LEFT..],
            &above[Gap::STRAIGHT..],
            &above[Gap::RIGHT..],
        ];
        let mut masks = [0; 8];
        for (code, mask) in masks.iter_mut().enumerate() {
            // SAFETY: as above.
            let cost = unsafe { L::load(costs[code].as_ptr().add(k * LANES)) };
            *mask = around.there[code].plus(cost).equal(around.here);
        }
        masks
    }
}
