//! What a straight segment crosses on a grid, exactly, and what it costs.
//!
//! Grid coordinates are cells: u along the columns, v along the rows; cell (row, col) holds
//! [col, col + 1) × [row, row + 1) and its centre is (col + 1/2, row + 1/2).
//!
//! A segment visits the cells from that of its first point to that of its last, one border after the
//! other. A step through a corner needs the two cells beside it free, unless corners may be cut. A
//! segment along a border needs the cells on both sides. Which border comes next is decided without
//! rounding: in integers between centres, by an exact orientation test between other points.

use std::cmp::Ordering;

use crate::world::Cell;

/// The ground that segments cross.
pub trait Ground {
    /// Cost per unit length in cell (row, col) of the grid; infinite where it may not be entered.
    fn cost(&self, row: usize, col: usize) -> f64;

    /// Whether all that may be entered costs the same, so that only length counts.
    fn is_uniform(&self) -> bool {
        false
    }
}

/// A point that a path may turn at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Vertex {
    /// The centre of a cell.
    Centre(Cell),
    /// Any point of a cell, in grid coordinates.
    Point {
        /// Along the columns \[cells\].
        u: f64,
        /// Along the rows \[cells\].
        v: f64,
    },
}

impl Vertex {
    /// The point (u, v), which must be finite and >= 0.
    pub fn point(u: f64, v: f64) -> Self {
        // So near to a border that the exact test below would underflow: on it.
        let clear = |x: f64| if x < 1e-30 { 0.0 } else { x };
        Self::Point { u: clear(u), v: clear(v) }
    }

    /// (u, v).
    pub fn coordinates(self) -> (f64, f64) {
        match self {
            Self::Centre(cell) => (cell.col as f64 + 0.5, cell.row as f64 + 0.5),
            Self::Point { u, v } => (u, v),
        }
    }

    fn cell(self) -> Cell {
        match self {
            Self::Centre(cell) => cell,
            Self::Point { u, v } => Cell::new(v as usize, u as usize),
        }
    }

    /// Length of the segment to `other` \[cells\].
    pub fn distance(self, other: Self) -> f64 {
        let ((u, v), (p, q)) = (self.coordinates(), other.coordinates());
        (p - u).hypot(q - v)
    }
}

/// The cost of a segment \[cost × cells\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Toll {
    /// Sum over the cells of cost times length, nearly rounded once.
    pub cost: f64,
    /// What the true cost is sure not to exceed.
    pub most: f64,
}

/// Who may go straight where on a ground.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a, G> {
    /// The ground.
    pub ground: &'a G,
    /// Whether a segment may pass through the corner of a cell that is not free.
    pub corner_cutting: bool,
}

impl<G: Ground> Sight<'_, G> {
    /// The cost of the segment from `a` to `b`; None where it may not pass, or costs more than `limit`.
    pub fn toll(&self, a: Vertex, b: Vertex, limit: f64) -> Option<Toll> {
        let length = a.distance(b);
        if let (Vertex::Centre(from), Vertex::Centre(to)) = (a, b) {
            let line = Lattice::new(from, to);
            return self.walk(line, from, to, length, limit, 0.0);
        }
        let ((u, v), (p, q)) = (a.coordinates(), b.coordinates());
        let on_border = |x: f64, y: f64| x == y && x > 0.0 && x.fract() == 0.0;
        if on_border(u, p) {
            return self.border(v, q, limit, |row, side| self.ground.cost(row, u as usize - side));
        }
        if on_border(v, q) {
            return self.border(u, p, limit, |col, side| self.ground.cost(v as usize - side, col));
        }
        // A crossing is at (border - u) / (p - u) with three roundings, each share a difference of two.
        let error = 8.0 * f64::EPSILON;
        let (from, to) = (a.cell(), b.cell());
        self.walk(Slant::new((u, v), (p, q), from, to), from, to, length, limit, error)
    }

    /// The toll of the way along a border from `start` to `end`, whose n-th cells cost `cost(n, side)`.
    fn border(&self, start: f64, end: f64, limit: f64, cost: impl Fn(usize, usize) -> f64) -> Option<Toll> {
        let (low, high) = (start.min(end), start.max(end));
        let mut sum = Sum::default();
        let mut at = low;
        while at < high {
            let cell = at as usize;
            let next = high.min(cell as f64 + 1.0);
            sum.add((next - at) * cost(cell, 0).max(cost(cell, 1)));
            at = next;
        }
        let cost = sum.total();
        (cost <= limit && cost < f64::INFINITY)
            .then_some(Toll { cost, most: cost * (1.0 + 4.0 * f64::EPSILON) })
    }

    /// Follows `line` over the cells. The share of each run of cells of one cost is off by `error` of
    /// the whole at most.
    fn walk(
        &self,
        mut line: impl Line,
        from: Cell,
        to: Cell,
        length: f64,
        limit: f64,
        error: f64,
    ) -> Option<Toll> {
        let scale = length / line.whole();
        let is_free = |row, col| self.ground.cost(row, col) < f64::INFINITY;
        let towards = |from: usize, to: usize| if to < from { -1 } else { 1 };
        let (down, right) = (towards(from.row, to.row), towards(from.col, to.col));
        let Cell { mut row, mut col } = from;
        let mut now = self.ground.cost(row, col);
        if now == f64::INFINITY {
            return None;
        }
        let mut sum = Sum::default();
        let (mut begin, mut unsure) = (0.0, now);
        while (row, col) != (to.row, to.col) {
            let border = line.next();
            let at = line.pass(border);
            let (there_row, there_col) = (row.wrapping_add_signed(down), col.wrapping_add_signed(right));
            match border {
                Ordering::Less => col = there_col,
                Ordering::Greater => row = there_row,
                Ordering::Equal => {
                    let sides_free = || is_free(row, there_col) && is_free(there_row, col);
                    if !(self.corner_cutting || sides_free()) {
                        return None;
                    }
                    (row, col) = (there_row, there_col);
                }
            }
            let here = self.ground.cost(row, col);
            if here == f64::INFINITY {
                return None;
            }
            if here != now {
                sum.add(now * (at - begin));
                (now, begin) = (here, at);
                unsure += now;
                if sum.total() * scale > limit {
                    return None;
                }
            }
        }
        sum.add(now * (line.whole() - begin));
        let cost = sum.total() * scale;
        let most = cost + unsure * length * error;
        (cost <= limit).then_some(Toll { cost, most })
    }
}

/// The borders that a segment crosses, in order.
trait Line {
    /// Which border comes next: of a column (less), of a row (greater), or of both (equal).
    fn next(&self) -> Ordering;
    /// Goes on to it; how far along the segment it is.
    fn pass(&mut self, border: Ordering) -> f64;
    /// How far along the segment its end is.
    fn whole(&self) -> f64;
}

/// Between centres of cells, `columns` and `rows` apart: the m-th border of a column is at
/// (2m + 1) / (2 columns) of the way, so everything is a whole number of 1 / (2 rows × columns) of it,
/// and no more of them than twice the cells of the grid.
struct Lattice {
    /// Between borders of columns and of rows.
    step: [u64; 2],
    /// The next of each.
    ahead: [u64; 2],
}

impl Lattice {
    fn new(from: Cell, to: Cell) -> Self {
        let (rows, cols) = (from.row.abs_diff(to.row) as u64, from.col.abs_diff(to.col) as u64);
        let never = |count: u64, at: u64| if count == 0 { u64::MAX } else { at };
        let (across, down) = (rows.max(1), cols.max(1));
        Self { step: [2 * across, 2 * down], ahead: [never(cols, across), never(rows, down)] }
    }
}

impl Line for Lattice {
    #[inline]
    fn next(&self) -> Ordering {
        self.ahead[0].cmp(&self.ahead[1])
    }

    #[inline]
    fn pass(&mut self, border: Ordering) -> f64 {
        let at = self.ahead[0].min(self.ahead[1]);
        if border != Ordering::Greater {
            self.ahead[0] += self.step[0];
        }
        if border != Ordering::Less {
            self.ahead[1] += self.step[1];
        }
        at as f64
    }

    fn whole(&self) -> f64 {
        (self.step[0] / 2 * self.step[1]) as f64
    }
}

/// Between any two points.
struct Slant {
    from: (f64, f64),
    to: (f64, f64),
    /// The next border of a column and of a row.
    ahead: (f64, f64),
    /// How many of each are left.
    left: (usize, usize),
    passed: f64,
}

impl Slant {
    fn new(from: (f64, f64), to: (f64, f64), first: Cell, last: Cell) -> Self {
        let ahead = |from: usize, to: usize| if to < from { from as f64 } else { from as f64 + 1.0 };
        Self {
            from,
            to,
            ahead: (ahead(first.col, last.col), ahead(first.row, last.row)),
            left: (first.col.abs_diff(last.col), first.row.abs_diff(last.row)),
            passed: 0.0,
        }
    }
}

impl Line for Slant {
    fn next(&self) -> Ordering {
        match self.left {
            (_, 0) => Ordering::Less,
            (0, _) => Ordering::Greater,
            _ => {
                let rises = (self.to.0 > self.from.0) == (self.to.1 > self.from.1);
                let side = side(self.from, self.to, self.ahead);
                if rises { side } else { side.reverse() }
            }
        }
    }

    fn pass(&mut self, border: Ordering) -> f64 {
        let share = |from: f64, to: f64, at: f64| (at - from) / (to - from);
        let at = if border == Ordering::Greater {
            share(self.from.1, self.to.1, self.ahead.1)
        } else {
            share(self.from.0, self.to.0, self.ahead.0)
        };
        self.passed = at.clamp(self.passed, 1.0);
        if border != Ordering::Greater {
            self.left.0 -= 1;
            self.ahead.0 += if self.to.0 < self.from.0 { -1.0 } else { 1.0 };
        }
        if border != Ordering::Less {
            self.left.1 -= 1;
            self.ahead.1 += if self.to.1 < self.from.1 { -1.0 } else { 1.0 };
        }
        self.passed
    }

    fn whole(&self) -> f64 {
        1.0
    }
}

/// The sign of (c - a) × (b - a), without rounding: less if c lies left of a → b (u right, v up).
///
/// Two products in floating point decide unless they are too near; then all six products are added
/// exactly, as expansions [Shewchuk97 §2].
fn side(a: (f64, f64), b: (f64, f64), c: (f64, f64)) -> Ordering {
    let (left, right) = ((c.0 - a.0) * (b.1 - a.1), (c.1 - a.1) * (b.0 - a.0));
    let difference = left - right;
    if difference.abs() > 8.0 * f64::EPSILON * (left.abs() + right.abs()) {
        return difference.total_cmp(&0.0);
    }
    let mut sum = Expansion::default();
    for (x, y) in [(c.0, b.1), (-c.0, a.1), (-a.0, b.1), (-c.1, b.0), (c.1, a.0), (a.1, b.0)] {
        let product = x * y;
        sum.add(x.mul_add(y, -product));
        sum.add(product);
    }
    sum.sign()
}

/// A sum of twelve numbers at most, kept exactly in parts that do not overlap, smallest first.
#[derive(Default)]
struct Expansion {
    parts: [f64; 12],
    count: usize,
}

impl Expansion {
    fn add(&mut self, term: f64) {
        let mut carried = term;
        let mut kept = 0;
        for i in 0..self.count {
            let (sum, error) = two_sum(carried, self.parts[i]);
            if error != 0.0 {
                self.parts[kept] = error;
                kept += 1;
            }
            carried = sum;
        }
        if carried != 0.0 {
            self.parts[kept] = carried;
            kept += 1;
        }
        self.count = kept;
    }

    fn sign(&self) -> Ordering {
        let largest = self.count.checked_sub(1).map_or(0.0, |last| self.parts[last]);
        largest.partial_cmp(&0.0).unwrap_or(Ordering::Equal)
    }
}

/// A sum and what its rounding left out.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// A sum of many terms with the rounding errors added up beside it.
#[derive(Default)]
struct Sum {
    sum: f64,
    error: f64,
}

impl Sum {
    #[inline]
    fn add(&mut self, term: f64) {
        let (sum, error) = two_sum(self.sum, term);
        self.sum = sum;
        self.error += error;
    }

    #[inline]
    fn total(&self) -> f64 {
        self.sum + self.error
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[derive(Debug)]
    struct Map {
        rows: usize,
        cols: usize,
        costs: Vec<f64>,
    }

    impl Ground for Map {
        fn cost(&self, row: usize, col: usize) -> f64 {
            if row < self.rows && col < self.cols { self.costs[row * self.cols + col] } else { f64::INFINITY }
        }
    }

    fn map() -> impl Strategy<Value = Map> {
        let cell = prop_oneof![3 => (1u32..9).prop_map(f64::from), 1 => Just(f64::INFINITY)];
        (1usize..9, 1usize..9).prop_flat_map(move |(rows, cols)| {
            prop::collection::vec(cell.clone(), rows * cols).prop_map(move |costs| Map { rows, cols, costs })
        })
    }

    proptest! {
        #[test]
        fn the_side_of_a_point_is_the_sign_of_the_exact_determinant(
            values in prop::array::uniform6(0u64..1 << 40), near in prop::array::uniform2(-3i64..4),
        ) {
            // Nearly collinear: c = a + 3 (b - a), off by a few 2^-36.
            let [ax, ay, bx, by, ..] = values.map(|x| x as i128);
            let (cx, cy) = (3 * bx - 2 * ax + i128::from(near[0]), 3 * by - 2 * ay + i128::from(near[1]));
            let exact = ((cx - ax) * (by - ay) - (cy - ay) * (bx - ax)).cmp(&0);
            let f = |x: i128| x as f64 / (1u64 << 36) as f64;
            prop_assert_eq!(side((f(ax), f(ay)), (f(bx), f(by)), (f(cx), f(cy))), exact);
        }

        #[test]
        fn between_centres_the_integer_walk_and_the_exact_predicate_agree(
            map in map(), ends in prop::array::uniform4(0usize..8), corner_cutting: bool,
        ) {
            let cell = |r: usize, c: usize| Cell::new(r % map.rows, c % map.cols);
            let (a, b) = (Vertex::Centre(cell(ends[0], ends[1])), Vertex::Centre(cell(ends[2], ends[3])));
            let loose = |vertex: Vertex| Vertex::point(vertex.coordinates().0, vertex.coordinates().1);
            let sight = Sight { ground: &map, corner_cutting };
            let (exact, rounded) = (sight.toll(a, b, f64::INFINITY), sight.toll(loose(a), loose(b), f64::INFINITY));
            prop_assert_eq!(exact.is_some(), rounded.is_some());
            if let (Some(exact), Some(rounded)) = (exact, rounded) {
                prop_assert!((exact.cost - rounded.cost).abs() <= 1e-13 * exact.cost);
                prop_assert!(exact.cost <= rounded.most);
            }
        }

        #[test]
        fn a_segment_may_pass_both_ways_at_one_price_or_neither(
            map in map(), ends in prop::array::uniform4(0usize..64), corner_cutting: bool,
        ) {
            // Off the borders: from one the way back may pass a corner more, as the end's cell differs.
            let at = |x: usize, cells: usize| (2 * (x % (4 * cells)) + 1) as f64 / 8.0;
            let point = |u: usize, v: usize| Vertex::point(at(u, map.cols), at(v, map.rows));
            let (a, b) = (point(ends[0], ends[1]), point(ends[2], ends[3]));
            let sight = Sight { ground: &map, corner_cutting };
            match (sight.toll(a, b, f64::INFINITY), sight.toll(b, a, f64::INFINITY)) {
                (Some(there), Some(back)) => prop_assert!((there.cost - back.cost).abs() <= 1e-13 * there.cost),
                (there, back) => prop_assert_eq!(there.is_some(), back.is_some()),
            }
        }

        #[test]
        fn a_limit_only_cuts_off_what_is_dearer(
            map in map(), ends in prop::array::uniform4(0usize..8), limit in 0.0..60.0f64,
        ) {
            let cell = |r: usize, c: usize| Vertex::Centre(Cell::new(r % map.rows, c % map.cols));
            let sight = Sight { ground: &map, corner_cutting: true };
            let (a, b) = (cell(ends[0], ends[1]), cell(ends[2], ends[3]));
            let within = sight.toll(a, b, f64::INFINITY).filter(|toll| toll.cost <= limit);
            prop_assert_eq!(sight.toll(a, b, limit), within);
        }
    }

    #[test]
    fn a_segment_costs_what_its_pieces_cost() {
        // From the centre of (0, 0) to that of (1, 2): pieces of 1/4, 1/4, 1/4 and 1/4 of √5.
        let map = Map { rows: 2, cols: 3, costs: vec![1.0, 2.0, 64.0, 64.0, 4.0, 8.0] };
        let sight = Sight { ground: &map, corner_cutting: false };
        let toll =
            sight.toll(Vertex::Centre(Cell::new(0, 0)), Vertex::Centre(Cell::new(1, 2)), 99.0).unwrap();
        assert_eq!(toll.cost, 15.0 / 4.0 * 5.0_f64.sqrt());
    }

    #[test]
    fn along_a_border_both_sides_must_be_free_and_the_dearer_one_counts() {
        let free = Map { rows: 2, cols: 4, costs: vec![3.0; 8] };
        let mut dear = Map { rows: 2, cols: 4, costs: vec![3.0; 8] };
        dear.costs[1] = 5.0;
        let mut blocked = Map { rows: 2, cols: 4, costs: vec![3.0; 8] };
        blocked.costs[1] = f64::INFINITY;
        let along = |map: &Map| {
            let sight = Sight { ground: map, corner_cutting: true };
            sight.toll(Vertex::point(0.5, 1.0), Vertex::point(3.5, 1.0), 99.0).map(|toll| toll.cost)
        };
        assert_eq!(along(&free), Some(9.0));
        assert_eq!(along(&dear), Some(11.0));
        assert_eq!(along(&blocked), None);
    }
}
