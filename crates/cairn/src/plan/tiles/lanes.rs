//! Sixteen numbers at once, on each instruction set that is worth its own code.
//!
//! Every level does the same operations, each rounded once, so results agree to the bit.

use super::level::Simd;
#[cfg(target_arch = "x86_64")]
use super::{avx2, avx512, avx512_wide, registers::Registers, sse2};
use crate::plan::Cost;

/// Numbers in one [`Lanes`].
pub const LANES: usize = 16;

/// Sixteen costs side by side. Masks have bit i for number i.
///
/// Sums wrap in integers: callers keep them below the largest value of the type. Numbers are ordered
/// rightly up to twice [`FAR`](TileCost::FAR).
///
/// # Safety
/// Methods of a level may only run where the processor has its instructions, inside a function that
/// enables them; `load` and `store` need sixteen valid numbers at the pointer.
pub unsafe trait Lanes: Copy {
    /// One number.
    type Number: TileCost;
    /// The instructions that its methods need.
    const LEVEL: Simd;

    /// Says that what is at `to`, if there is anything, will be written soon.
    #[inline(always)]
    fn prefetch_for_writing<N>(to: *const N) {
        // SAFETY: a hint; it reads nothing.
        #[cfg(target_arch = "x86_64")]
        unsafe {
            std::arch::x86_64::_mm_prefetch::<{ std::arch::x86_64::_MM_HINT_ET0 }>(to.cast());
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = to;
    }
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
    ($type:ident, $avx512:ty, $avx2:ty, $sse2:ty) => {
        #[cfg(target_arch = "x86_64")]
        type Avx512 = $avx512;
        #[cfg(target_arch = "x86_64")]
        type Avx2 = $avx2;
        #[cfg(target_arch = "x86_64")]
        type Portable = $sse2;
        #[cfg(not(target_arch = "x86_64"))]
        type Avx512 = super::plain::Plain<$type>;
        #[cfg(not(target_arch = "x86_64"))]
        type Avx2 = super::plain::Plain<$type>;
        #[cfg(not(target_arch = "x86_64"))]
        type Portable = super::plain::Plain<$type>;
    };
}

macro_rules! integer_tile_cost {
    ($type:ident, $far:expr, $avx512:ty, $avx2:ty, $sse2:ty) => {
        impl TileCost for $type {
            levels!($type, $avx512, $avx2, $sse2);
            const FAR: Self = $far;
            #[inline(always)]
            fn sum(self, other: Self) -> Self {
                self.wrapping_add(other)
            }
        }
    };
}
integer_tile_cost!(
    u32,
    u32::MAX / 2,
    avx512::U32,
    Registers<avx2::U32, 2>,
    Registers<sse2::U32, 4>
);
integer_tile_cost!(
    u64,
    u64::MAX / 4, // twice this is still positive as a signed number
    Registers<avx512_wide::U64, 2>,
    Registers<avx2::U64, 4>,
    Registers<sse2::U64, 8>
);

macro_rules! float_tile_cost {
    ($type:ident, $avx512:ty, $avx2:ty, $sse2:ty) => {
        impl TileCost for $type {
            levels!($type, $avx512, $avx2, $sse2);
            const FAR: Self = $type::INFINITY;
            #[inline(always)]
            fn sum(self, other: Self) -> Self {
                self + other
            }
        }
    };
}
float_tile_cost!(f32, avx512::F32, Registers<avx2::F32, 2>, Registers<sse2::F32, 4>);
float_tile_cost!(f64, Registers<avx512_wide::F64, 2>, Registers<avx2::F64, 4>, Registers<sse2::F64, 8>);
