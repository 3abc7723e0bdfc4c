//! Links that cost one thing there and another back: eight costs a cell, laid out tile by tile.
//!
//! c(n, m) is the cost of the move from n to m, nearer the goal; it stands at n, the cell whose number falls.

use std::marker::PhantomData;

use super::SIDE;
use super::finish::Around;
use super::lanes::{LANES, Lanes, TileCost};
use super::sheet::{LINES, PITCH, Sheet};
use super::sweep::{Line, LineLinks, VECTORS};
use super::visit::Links;
use crate::plan::Cost;
use crate::plan::terrain::DirectedRows;
use crate::world::GridGeometry;

/// Codes of the moves out of a column to the column before it (straight, to the row before, to the one
/// behind), then of those to the column behind it.
const BETWEEN_COLS: [usize; 6] = [4, 5, 3, 0, 7, 1];

/// The links between neighbouring lines of a tile: of a straight move, one aslant to the column before,
/// one to the column behind; all from the line before, then all from the line behind.
pub struct DirectedLinks<T> {
    planes: [Box<Sheet<T>>; 6],
}

impl<T: TileCost> DirectedLinks<T> {
    fn new() -> Self {
        Self { planes: std::array::from_fn(|_| Sheet::all(T::FAR)) }
    }

    /// Sixteen numbers of a plane, which holds them.
    #[inline(always)]
    unsafe fn load<L: Lanes<Number = T>>(&self, plane: usize, at: usize) -> L {
        unsafe { L::load(self.planes[plane].0.as_ptr().add(at)) }
    }
}

impl<L: Lanes> LineLinks<L> for DirectedLinks<L::Number> {
    #[inline(always)]
    fn lower<const FORWARD: bool>(&self, to: usize, before: &Line<L>, line: &mut Line<L>) -> u64 {
        let far = L::splat(L::Number::FAR);
        let first = if FORWARD { 0 } else { 3 };
        let mut changed = 0;
        for k in 0..VECTORS {
            let at = to * PITCH + (k + 1) * LANES;
            // SAFETY: every plane holds LINES lines of PITCH numbers.
            let (straight, from_left, from_right): (L, L, L) =
                unsafe { (self.load(first, at), self.load(first + 1, at), self.load(first + 2, at)) };
            let left = before[k].after(if k > 0 { before[k - 1] } else { far }).plus(from_left);
            let right = before[k].ahead(if k + 1 < VECTORS { before[k + 1] } else { far }).plus(from_right);
            let offered = before[k].plus(straight).min(left.min(right));
            changed |= u64::from(offered.less(line[k])) << (k * LANES);
            line[k] = line[k].min(offered);
        }
        changed
    }
}

/// A grid of which every move has a cost of its own, in numbers of type T.
pub struct DirectedGrid<'a, D, T> {
    rows: &'a D,
    number: PhantomData<fn() -> T>,
}

impl<'a, D: DirectedRows, T> DirectedGrid<'a, D, T> {
    /// The links of a grid.
    pub fn new(rows: &'a D) -> Self {
        Self { rows, number: PhantomData }
    }

    /// First row and column of a tile.
    fn place(&self, tile: usize) -> (usize, usize) {
        let across = self.rows.geometry().cols.div_ceil(SIDE);
        (tile / across * SIDE, tile % across * SIDE)
    }
}

/// The links of a tile.
pub struct DirectedDesk<T, N> {
    rows: DirectedLinks<T>,
    cols: DirectedLinks<T>,
    /// The moves along a row, codes 0 and 4.
    along: [Box<Sheet<T>>; 2],
    /// A row of costs in the grid's own numbers.
    row: Box<[N; LINES]>,
}

impl<T, N> DirectedDesk<T, N> {
    /// Costs of the moves with a code, as rows.
    #[inline(always)]
    fn plane(&self, code: usize) -> &Sheet<T> {
        match code {
            0 | 4 => &self.along[code / 4],
            _ => &self.rows.planes[between_rows(code)],
        }
    }
}

/// Where the plane of a move between rows stands in their [`DirectedLinks`].
const fn between_rows(code: usize) -> usize {
    match code {
        6 => 0,
        5 => 1,
        7 => 2,
        2 => 3,
        3 => 4,
        _ => 5,
    }
}

impl<D, N, T> DirectedGrid<'_, D, T>
where
    D: DirectedRows<Number = N>,
    N: Cost,
    T: TileCost + From<N>,
{
    /// Costs of the moves with one code out of the cells of a tile and around it.
    #[inline(always)]
    fn fill<const CODE: usize>(&self, tile: usize, desk: &mut DirectedDesk<T, N>) {
        let (first_row, first_col) = self.place(tile);
        let GridGeometry { rows, cols, .. } = *self.rows.geometry();
        let before = usize::from(first_col > 0); // a column before the tile
        let count = (cols - first_col).min(SIDE + 1) + before;
        let costs = &mut desk.row[..count];
        let plane = match CODE {
            0 | 4 => &mut desk.along[CODE / 4],
            _ => &mut desk.rows.planes[between_rows(CODE)],
        };
        for (line, to) in plane.0.as_chunks_mut::<PITCH>().0.iter_mut().enumerate() {
            let row = (first_row + line).wrapping_sub(1);
            if row >= rows {
                to.fill(T::FAR);
                continue;
            }
            self.rows.row_costs::<CODE>(row, first_col - before, costs);
            let start = LANES - before;
            for (to, &cost) in to[start..start + count].iter_mut().zip(&*costs) {
                let (cost, none) = (T::from(cost), cost == N::UNREACHABLE);
                *to = if none || cost > T::FAR { T::FAR } else { cost };
            }
            to[start + count..].fill(T::FAR);
            to[..start].fill(T::FAR);
        }
    }

    #[inline(always)]
    fn fill_all(&self, tile: usize, desk: &mut DirectedDesk<T, N>) {
        self.fill::<0>(tile, desk);
        self.fill::<1>(tile, desk);
        self.fill::<2>(tile, desk);
        self.fill::<3>(tile, desk);
        self.fill::<4>(tile, desk);
        self.fill::<5>(tile, desk);
        self.fill::<6>(tile, desk);
        self.fill::<7>(tile, desk);
    }

    fn cost_of<const CODE: usize>(&self, row: usize, col: usize) -> T {
        let mut cost = [N::UNREACHABLE];
        self.rows.row_costs::<CODE>(row, col, &mut cost);
        let [cost] = cost;
        if cost == N::UNREACHABLE || T::from(cost) > T::FAR { T::FAR } else { T::from(cost) }
    }
}

impl<D, N, T> Links for DirectedGrid<'_, D, T>
where
    D: DirectedRows<Number = N> + Sync,
    N: Cost,
    T: TileCost + From<N>,
{
    type Number = T;
    type Desk<L: Lanes<Number = T>> = DirectedDesk<T, N>;
    type Lines<L: Lanes<Number = T>> = DirectedLinks<T>;

    fn desk<L: Lanes<Number = T>>(&self) -> Self::Desk<L> {
        let (rows, cols) = (DirectedLinks::new(), DirectedLinks::new());
        let (along, row) = (std::array::from_fn(|_| Sheet::all(T::FAR)), Box::new([N::UNREACHABLE; LINES]));
        DirectedDesk { rows, cols, along, row }
    }

    #[inline(always)]
    fn lay_out<L: Lanes<Number = T>>(&self, tile: usize, desk: &mut Self::Desk<L>) {
        self.fill_all(tile, desk);
        for (plane, code) in BETWEEN_COLS.into_iter().enumerate() {
            let from = match code {
                0 | 4 => &desk.along[code / 4],
                _ => &desk.rows.planes[between_rows(code)],
            };
            turn::<L>(from, &mut desk.cols.planes[plane]);
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

    fn cost(&self, row: usize, col: usize, code: usize) -> T {
        match code {
            0 => self.cost_of::<0>(row, col),
            1 => self.cost_of::<1>(row, col),
            2 => self.cost_of::<2>(row, col),
            3 => self.cost_of::<3>(row, col),
            4 => self.cost_of::<4>(row, col),
            5 => self.cost_of::<5>(row, col),
            6 => self.cost_of::<6>(row, col),
            _ => self.cost_of::<7>(row, col),
        }
    }

    #[inline(always)]
    fn lay_out_policy<L: Lanes<Number = T>>(&self, tile: usize, desk: &mut Self::Desk<L>) {
        self.fill_all(tile, desk);
    }

    #[inline(always)]
    fn on_the_way<L: Lanes<Number = T>>(
        &self,
        desk: &Self::Desk<L>,
        row: usize,
        k: usize,
        around: &Around<L>,
    ) -> [u16; 8] {
        let at = (row + 1) * PITCH + (k + 1) * LANES;
        let mut masks = [0; 8];
        for (code, mask) in masks.iter_mut().enumerate() {
            // SAFETY: every plane holds LINES lines of PITCH numbers.
            let cost = unsafe { L::load(desk.plane(code).0.as_ptr().add(at)) };
            *mask = around.there[code].plus(cost).equal(around.here);
        }
        masks
    }
}

/// Turns the costs of a tile and of the columns beside it about its diagonal.
#[inline(always)]
fn turn<L: Lanes>(from: &Sheet<L::Number>, to: &mut Sheet<L::Number>) {
    // SAFETY: tiles are laid out at the level of L.
    unsafe { from.turn_tile::<L>(to) };
    for i in 0..SIDE {
        to.0[LANES + i] = from.0[(i + 1) * PITCH + LANES - 1];
        to.0[(LINES - 1) * PITCH + LANES + i] = from.0[(i + 1) * PITCH + LANES + SIDE];
    }
}
