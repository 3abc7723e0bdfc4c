use super::ground::Ground;
use crate::plan::Cost;

/// A number type that the plain planners add up in.
pub trait Number: Cost + Default {
    /// The sum, not checked: the queues look after what does not fit.
    fn add(self, other: Self) -> Self;
    /// What [`bucket`](Self::bucket) needs for buckets as wide as the largest power of two that is no
    /// wider than `cheapest`.
    fn scale(cheapest: Self) -> Self;
    /// The number of the bucket it belongs into.
    fn bucket(self, scale: Self) -> usize;
    /// The largest value that still may have any link of at most `dearest` added.
    fn limit(dearest: Self) -> Self;
    /// The key of a value and a cell, to be ordered by value first.
    type Entry: Ord + Copy;
    /// Packs.
    fn entry(self, cell: u32) -> Self::Entry;
    /// Unpacks the cell.
    fn cell(entry: Self::Entry) -> u32;
    /// Unpacks the value.
    fn value(entry: Self::Entry) -> Self;
}

macro_rules! number {
    ($type:ident, $add:expr, $scale:expr, $bucket:expr, $limit:expr, $entry:ty, $pack:expr, $cell:expr, $value:expr) => {
        impl Number for $type {
            type Entry = $entry;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                $add(self, other)
            }
            fn scale(cheapest: Self) -> Self {
                $scale(cheapest)
            }
            #[inline(always)]
            fn bucket(self, scale: Self) -> usize {
                $bucket(self, scale)
            }
            fn limit(dearest: Self) -> Self {
                $limit(dearest)
            }
            #[inline(always)]
            fn entry(self, cell: u32) -> Self::Entry {
                $pack(self, cell)
            }
            #[inline(always)]
            fn cell(entry: Self::Entry) -> u32 {
                $cell(entry)
            }
            #[inline(always)]
            fn value(entry: Self::Entry) -> Self {
                $value(entry)
            }
        }
    };
}

number!(
    u32,
    u32::wrapping_add,
    |cheapest: u32| cheapest.max(1).ilog2(),
    |value: u32, shift: u32| (value >> (shift & 31)) as usize,
    |dearest: u32| u32::MAX - 1 - dearest,
    u64,
    |value: u32, cell: u32| u64::from(value) << 32 | u64::from(cell),
    |entry: u64| entry as u32,
    |entry: u64| (entry >> 32) as u32
);
number!(
    u64,
    u64::wrapping_add,
    |cheapest: u64| u64::from(cheapest.max(1).ilog2()),
    |value: u64, shift: u64| (value >> (shift & 63)) as usize,
    |dearest: u64| u64::MAX - 1 - dearest,
    (u64, u32),
    |value: u64, cell: u32| (value, cell),
    |entry: (u64, u32)| entry.1,
    |entry: (u64, u32)| entry.0
);
number!(
    f32,
    |a: f32, b: f32| a + b,
    |cheapest: f32| f32::from_bits(cheapest.to_bits() & 0x7f80_0000).recip(), // exact
    |value: f32, scale: f32| (value * scale) as usize,
    |dearest: f32| f32::MAX - dearest,
    u64,
    |value: f32, cell: u32| u64::from(value.to_bits()) << 32 | u64::from(cell),
    |entry: u64| entry as u32,
    |entry: u64| f32::from_bits((entry >> 32) as u32)
);

/// What links cost, and which cells there are.
pub trait LinkCosts<C: Number> {
    /// Writes 1 for the free cells of a row, 0 for the others.
    fn free_row(&self, row: usize, cols: usize, free: &mut [u8]);
    /// The bits of the moves that cells allow, row-major, if they are more than free cells would allow.
    fn moves(&self) -> Option<&[u8]> {
        None
    }
    /// Copies what belongs to the cells into the ring of `ground`.
    fn pad(&mut self, ground: &Ground);
    /// The cost of the link from `tail` to `head`, padded indices, which is the move `code`.
    fn cost(&self, tail: usize, head: usize, code: usize) -> C;
    /// (cheapest, dearest) of the links.
    fn range(&self) -> (C, C);
    /// Marks by 1 the cells of a row, from padded index `tail` on, whose values are exactly those of the
    /// row from `head` on, which the move `code` leads to, and the link there.
    fn match_row(&self, tail: usize, head: usize, code: usize, values: &[C], equal: &mut [u8]);
}

/// Links of two lengths between free cells.
pub struct FreeLinks<'a, C> {
    free: &'a [bool],
    lengths: [C; 2],
}

impl<'a, C: Number> FreeLinks<'a, C> {
    /// Links among cells that are true, with the lengths of a straight and a diagonal one.
    pub fn new(free: &'a [bool], lengths: [C; 2]) -> Self {
        Self { free, lengths }
    }
}

impl<C: Number> LinkCosts<C> for FreeLinks<'_, C> {
    fn free_row(&self, row: usize, cols: usize, free: &mut [u8]) {
        for (to, &from) in free.iter_mut().zip(&self.free[row * cols..]) {
            *to = u8::from(from);
        }
    }

    fn pad(&mut self, _: &Ground) {}

    #[inline(always)]
    fn cost(&self, _: usize, _: usize, code: usize) -> C {
        self.lengths[code % 2]
    }

    fn range(&self) -> (C, C) {
        (self.lengths[0], self.lengths[1])
    }

    fn match_row(&self, tail: usize, head: usize, code: usize, values: &[C], equal: &mut [u8]) {
        let length = self.lengths[code % 2];
        let pairs = values[tail..].iter().zip(&values[head..]);
        for (equal, (&value, &next)) in equal.iter_mut().zip(pairs) {
            *equal = u8::from((next.add(length) == value) & (value < C::UNREACHABLE));
        }
    }
}

/// A cost per cell that makes up the cost of links: the mean rule in some number type.
pub trait CellPrice<C>: Copy + Default + PartialOrd {
    /// Whether the cell may be entered.
    fn is_free(self) -> bool;
    /// The cost of a link between this cell and another, straight (0) or diagonal (1).
    fn link(self, other: Self, kind: usize) -> C;
}

macro_rules! whole_price {
    ($sum:ident) => {
        impl CellPrice<$sum> for u8 {
            #[inline(always)]
            fn is_free(self) -> bool {
                self > 0
            }
            #[inline(always)]
            fn link(self, other: Self, kind: usize) -> $sum {
                ($sum::from(self) + $sum::from(other)) * [985, 1393][kind & 1]
            }
        }
    };
}
whole_price!(u32);
whole_price!(u64);

impl CellPrice<f32> for f32 {
    #[inline(always)]
    fn is_free(self) -> bool {
        self < f32::INFINITY && self > 0.0
    }
    #[inline(always)]
    fn link(self, other: Self, kind: usize) -> f32 {
        (self + other) * [0.5, std::f64::consts::FRAC_1_SQRT_2 as f32][kind & 1]
    }
}

/// Links that cost their length times the mean of their two cells: in whole numbers (a + b) · 985 or
/// 1393 with weights 1..255, 0 blocked; in single precision (a + b) · ½ or √½, infinite blocked.
pub struct MeanLinks<'a, P> {
    prices: &'a [P],
    padded: &'a mut Vec<P>,
}

impl<'a, P> MeanLinks<'a, P> {
    /// Links among cells of these prices, row-major; `padded` is memory to work in.
    pub fn new(prices: &'a [P], padded: &'a mut Vec<P>) -> Self {
        Self { prices, padded }
    }
}

impl<C: Number, P: CellPrice<C>> LinkCosts<C> for MeanLinks<'_, P> {
    fn free_row(&self, row: usize, cols: usize, free: &mut [u8]) {
        for (to, &price) in free.iter_mut().zip(&self.prices[row * cols..]) {
            *to = u8::from(price.is_free());
        }
    }

    fn pad(&mut self, ground: &Ground) {
        self.padded.clear();
        self.padded.resize(ground.len(), P::default());
        for row in 0..ground.rows {
            let begin = ground.index(row, 0);
            self.padded[begin..begin + ground.cols]
                .copy_from_slice(&self.prices[row * ground.cols..(row + 1) * ground.cols]);
        }
    }

    #[inline(always)]
    fn cost(&self, tail: usize, head: usize, code: usize) -> C {
        self.padded[tail].link(self.padded[head], code)
    }

    fn range(&self) -> (C, C) {
        let mut free = self.prices.iter().copied().filter(|price| price.is_free());
        let Some(first) = free.next() else { return (C::ZERO, C::ZERO) };
        let least = |a: P, b: P| if b < a { b } else { a };
        let most = |a: P, b: P| if b > a { b } else { a };
        let (low, high) = free.fold((first, first), |(low, high), p| (least(low, p), most(high, p)));
        (low.link(low, 0), high.link(high, 1))
    }

    fn match_row(&self, tail: usize, head: usize, code: usize, values: &[C], equal: &mut [u8]) {
        let pairs = values[tail..].iter().zip(&values[head..]);
        let prices = self.padded[tail..].iter().zip(&self.padded[head..]);
        for (equal, ((&value, &next), (&here, &there))) in equal.iter_mut().zip(pairs.zip(prices)) {
            let through = next.add(here.link(there, code % 2));
            *equal = u8::from((through == value) & (value < C::UNREACHABLE));
        }
    }
}
