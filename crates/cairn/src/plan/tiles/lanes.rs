//! Sixteen numbers at once, on each instruction set that is worth its own code.
//!
//! Every level does the same operations, each rounded once, so results agree to the bit.

use crate::plan::Cost;

/// Numbers in one [`Lanes`].
pub const LANES: usize = 16;

/// Sixteen costs side by side. Masks have bit i for number i.
///
/// Sums wrap in integers: callers keep them below the largest value of the type.
///
/// # Safety
/// Methods of a level may only run where the processor has its instructions, inside a function that
/// enables them; `load` and `store` need sixteen valid numbers at the pointer.
pub unsafe trait Lanes: Copy {
    /// One number.
    type Number: TileCost;

    /// Sixteen times the same.
    fn splat(value: Self::Number) -> Self;
    /// The sixteen numbers at `from`, which need not be aligned.
    ///
    /// # Safety
    /// `from` points to sixteen readable numbers.
    unsafe fn load(from: *const Self::Number) -> Self;
    /// Writes the sixteen numbers to `to`, which need not be aligned.
    ///
    /// # Safety
    /// `to` points to sixteen writable numbers.
    unsafe fn store(self, to: *mut Self::Number);
    /// Sums.
    fn plus(self, other: Self) -> Self;
    /// Differences (integers wrap).
    fn minus(self, other: Self) -> Self;
    /// Products (of floats; integers wrap).
    fn times(self, other: Self) -> Self;
    /// The smaller of each two.
    fn min(self, other: Self) -> Self;
    /// The larger of each two.
    fn max(self, other: Self) -> Self;
    /// Where self < other.
    fn less(self, other: Self) -> u16;
    /// Where self == other.
    fn equal(self, other: Self) -> u16;
    /// `self` where the mask is set, else `other`.
    fn where_else(self, mask: u16, other: Self) -> Self;
    /// Number i is number i − 1 of `self`; number 0 is the last of `before`.
    fn after(self, before: Self) -> Self;
    /// Number i is number i + 1 of `self`; the last is number 0 of `behind`.
    fn ahead(self, behind: Self) -> Self;
    /// Writes, for each of sixteen cells, the lowest k of which `masks[k]` has its bit, or -1.
    ///
    /// # Safety
    /// `to` points to sixteen writable codes.
    #[inline(always)]
    unsafe fn store_codes(masks: [u16; 8], to: *mut i8) {
        let mut codes = [-1_i8; LANES];
        for (code, mask) in masks.into_iter().enumerate().rev() {
            for (i, of_cell) in codes.iter_mut().enumerate() {
                *of_cell = if mask >> i & 1 == 1 { code as i8 } else { *of_cell };
            }
        }
        // SAFETY: the caller's.
        unsafe { to.cast::<[i8; LANES]>().write_unaligned(codes) }
    }
    /// Turns a 16 × 16 block about its diagonal: `from` and `to` hold rows `pitch` numbers apart.
    ///
    /// # Safety
    /// Both pointers reach 16 rows of 16 numbers at those pitches; they do not overlap.
    unsafe fn transpose(from: *const Self::Number, from_pitch: usize, to: *mut Self::Number, to_pitch: usize);
}

/// A cost that tiles can be solved in.
pub trait TileCost: Cost {
    /// Lanes for processors with AVX-512 F, BW, VL and DQ.
    type Avx512: Lanes<Number = Self>;
    /// Lanes for processors with AVX2.
    type Avx2: Lanes<Number = Self>;
    /// Lanes for every processor.
    type Portable: Lanes<Number = Self>;
    /// "No way" inside tiles, and the cost of a link that is none: twice it does not wrap.
    const FAR: Self;
    /// The sum where it is known to fit (integers wrap otherwise).
    fn sum(self, other: Self) -> Self;
}

macro_rules! levels {
    ($type:ident, $avx512:ty, $avx2:ty) => {
        #[cfg(target_arch = "x86_64")]
        type Avx512 = $avx512;
        #[cfg(target_arch = "x86_64")]
        type Avx2 = $avx2;
        #[cfg(not(target_arch = "x86_64"))]
        type Avx512 = Plain<$type>;
        #[cfg(not(target_arch = "x86_64"))]
        type Avx2 = Plain<$type>;
        type Portable = Plain<$type>;
    };
}

macro_rules! integer_tile_cost {
    ($type:ident, $avx512:ty, $avx2:ty) => {
        impl TileCost for $type {
            levels!($type, $avx512, $avx2);
            const FAR: Self = $type::MAX / 2;
            #[inline(always)]
            fn sum(self, other: Self) -> Self {
                self.wrapping_add(other)
            }
        }
    };
}
integer_tile_cost!(u32, super::avx512::U32, super::avx2::U32);
integer_tile_cost!(u64, Plain<u64>, Plain<u64>);

macro_rules! float_tile_cost {
    ($type:ident, $avx512:ty, $avx2:ty) => {
        impl TileCost for $type {
            levels!($type, $avx512, $avx2);
            const FAR: Self = $type::INFINITY;
            #[inline(always)]
            fn sum(self, other: Self) -> Self {
                self + other
            }
        }
    };
}
float_tile_cost!(f32, super::avx512::F32, super::avx2::F32);
float_tile_cost!(f64, Plain<f64>, Plain<f64>);

/// Sixteen numbers in plain Rust, for every processor and every type.
#[derive(Clone, Copy)]
pub struct Plain<T>([T; LANES]);

macro_rules! plain_lanes {
    ($type:ident, $plus:expr, $minus:expr, $times:expr) => {
        // SAFETY: plain Rust needs no instructions beyond the target's.
        unsafe impl Lanes for Plain<$type> {
            type Number = $type;

            #[inline(always)]
            fn splat(value: $type) -> Self {
                Self([value; LANES])
            }
            #[inline(always)]
            unsafe fn load(from: *const $type) -> Self {
                // SAFETY: the caller's.
                Self(unsafe { from.cast::<[$type; LANES]>().read_unaligned() })
            }
            #[inline(always)]
            unsafe fn store(self, to: *mut $type) {
                // SAFETY: the caller's.
                unsafe { to.cast::<[$type; LANES]>().write_unaligned(self.0) }
            }
            #[inline(always)]
            fn plus(self, other: Self) -> Self {
                let mut sum = self.0;
                for i in 0..LANES {
                    sum[i] = $plus(self.0[i], other.0[i]);
                }
                Self(sum)
            }
            #[inline(always)]
            fn minus(self, other: Self) -> Self {
                let mut difference = self.0;
                for i in 0..LANES {
                    difference[i] = $minus(self.0[i], other.0[i]);
                }
                Self(difference)
            }
            #[inline(always)]
            fn times(self, other: Self) -> Self {
                let mut product = self.0;
                for i in 0..LANES {
                    product[i] = $times(self.0[i], other.0[i]);
                }
                Self(product)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                let mut least = self.0;
                for i in 0..LANES {
                    least[i] = if other.0[i] < self.0[i] { other.0[i] } else { self.0[i] };
                }
                Self(least)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                let mut most = self.0;
                for i in 0..LANES {
                    most[i] = if other.0[i] > self.0[i] { other.0[i] } else { self.0[i] };
                }
                Self(most)
            }
            #[inline(always)]
            fn less(self, other: Self) -> u16 {
                let mut mask = 0;
                for i in 0..LANES {
                    mask |= u16::from(self.0[i] < other.0[i]) << i;
                }
                mask
            }
            #[inline(always)]
            fn equal(self, other: Self) -> u16 {
                let mut mask = 0;
                for i in 0..LANES {
                    mask |= u16::from(self.0[i] == other.0[i]) << i;
                }
                mask
            }
            #[inline(always)]
            fn where_else(self, mask: u16, other: Self) -> Self {
                let mut chosen = other.0;
                for i in 0..LANES {
                    chosen[i] = if mask >> i & 1 == 1 { self.0[i] } else { other.0[i] };
                }
                Self(chosen)
            }
            #[inline(always)]
            fn after(self, before: Self) -> Self {
                let mut moved = self.0;
                moved[0] = before.0[LANES - 1];
                moved[1..].copy_from_slice(&self.0[..LANES - 1]);
                Self(moved)
            }
            #[inline(always)]
            fn ahead(self, behind: Self) -> Self {
                let mut moved = self.0;
                moved[..LANES - 1].copy_from_slice(&self.0[1..]);
                moved[LANES - 1] = behind.0[0];
                Self(moved)
            }
            #[inline(always)]
            unsafe fn transpose(from: *const $type, from_pitch: usize, to: *mut $type, to_pitch: usize) {
                for row in 0..LANES {
                    for col in 0..LANES {
                        // SAFETY: the caller's.
                        unsafe { *to.add(col * to_pitch + row) = *from.add(row * from_pitch + col) };
                    }
                }
            }
        }
    };
}
plain_lanes!(u32, u32::wrapping_add, u32::wrapping_sub, u32::wrapping_mul);
plain_lanes!(u64, u64::wrapping_add, u64::wrapping_sub, u64::wrapping_mul);
plain_lanes!(f32, std::ops::Add::add, std::ops::Sub::sub, std::ops::Mul::mul);
plain_lanes!(f64, std::ops::Add::add, std::ops::Sub::sub, std::ops::Mul::mul);
