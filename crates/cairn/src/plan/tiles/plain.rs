//! Sixteen numbers in plain Rust, for processors without code of their own.

use super::lanes::{LANES, Lanes};

/// Sixteen numbers in plain Rust, for every processor and every type.
#[derive(Clone, Copy)]
pub struct Plain<T>([T; LANES]);

macro_rules! plain_lanes {
    ($type:ident, $bits:ident, $plus:expr, $minus:expr, $times:expr) => {
        impl Plain<$type> {
            /// The bit of each number in a mask, as wide as the number: they are compared in vectors.
            const BITS: [$bits; LANES] = {
                let mut bits = [1; LANES];
                let mut i = 1;
                while i < LANES {
                    bits[i] = bits[i - 1] << 1;
                    i += 1;
                }
                bits
            };
        }

        // SAFETY: plain Rust needs no instructions beyond the target's.
        unsafe impl Lanes for Plain<$type> {
            type Number = $type;
            const LEVEL: super::level::Simd = super::level::Simd::Portable;

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
                let mut bits = Self::BITS;
                for i in 0..LANES {
                    bits[i] = if self.0[i] < other.0[i] { bits[i] } else { 0 };
                }
                bits.into_iter().fold(0, |all, bit| all | bit) as u16
            }
            #[inline(always)]
            fn equal(self, other: Self) -> u16 {
                let mut bits = Self::BITS;
                for i in 0..LANES {
                    bits[i] = if self.0[i] == other.0[i] { bits[i] } else { 0 };
                }
                bits.into_iter().fold(0, |all, bit| all | bit) as u16
            }
            #[inline(always)]
            fn where_else(self, mask: u16, other: Self) -> Self {
                let mut chosen = other.0;
                for i in 0..LANES {
                    chosen[i] = if mask as $bits & Self::BITS[i] != 0 { self.0[i] } else { other.0[i] };
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
plain_lanes!(u32, u32, u32::wrapping_add, u32::wrapping_sub, u32::wrapping_mul);
plain_lanes!(u64, u64, u64::wrapping_add, u64::wrapping_sub, u64::wrapping_mul);
plain_lanes!(f32, u32, std::ops::Add::add, std::ops::Sub::sub, std::ops::Mul::mul);
plain_lanes!(f64, u64, std::ops::Add::add, std::ops::Sub::sub, std::ops::Mul::mul);
