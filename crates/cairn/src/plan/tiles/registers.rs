//! Sixteen numbers in several registers.

use super::lanes::{LANES, Lanes, TileCost};

/// A vector register of fewer than sixteen numbers.
///
/// # Safety
/// As [`Lanes`]: methods may only run where the processor has the instructions, inside a function that
/// enables them, and pointers must reach as far as the method says.
pub unsafe trait Register: Copy {
    /// One number.
    type Number: TileCost;
    /// The instructions that its methods need.
    const LEVEL: super::level::Simd;
    /// A truth for each number, in the form that comparisons have in this instruction set.
    type Truths: Copy;
    /// Numbers in it.
    const WIDTH: usize;

    /// The same number in every place.
    fn splat(value: Self::Number) -> Self;
    /// The `WIDTH` numbers at `from`, which need not be aligned.
    ///
    /// # Safety
    /// They are readable.
    unsafe fn load(from: *const Self::Number) -> Self;
    /// Writes `WIDTH` numbers to `to`, which need not be aligned.
    ///
    /// # Safety
    /// There is room for them.
    unsafe fn store(self, to: *mut Self::Number);
    /// Sums.
    fn plus(self, other: Self) -> Self;
    /// Differences.
    fn minus(self, other: Self) -> Self;
    /// Products.
    fn times(self, other: Self) -> Self;
    /// The smaller of each two.
    fn min(self, other: Self) -> Self;
    /// The larger of each two.
    fn max(self, other: Self) -> Self;
    /// Where self < other.
    fn less(self, other: Self) -> Self::Truths;
    /// Where self == other.
    fn equal(self, other: Self) -> Self::Truths;
    /// The truths of `N` registers, a bit each, those of the first lowest.
    fn bits<const N: usize>(truths: [Self::Truths; N]) -> u16;
    /// `self` where the mask of register number `place` of sixteen lanes is set, else `other`.
    fn where_else(self, mask: u16, place: usize, other: Self) -> Self;
    /// Number i is number i − 1 of `self`; number 0 is the last of `before`.
    fn after(self, before: Self) -> Self;
    /// Number i is number i + 1 of `self`; the last is number 0 of `behind`.
    fn ahead(self, behind: Self) -> Self;
    /// As [`Lanes::store_codes`].
    ///
    /// # Safety
    /// `to` has room for sixteen codes.
    unsafe fn store_codes(masks: [u16; 8], to: *mut i8);
    /// Turns a block of `WIDTH` rows and columns about its diagonal.
    ///
    /// # Safety
    /// As [`Lanes::transpose`], with `WIDTH` for sixteen.
    unsafe fn transpose(from: *const Self::Number, from_pitch: usize, to: *mut Self::Number, to_pitch: usize);
}

/// `N` registers, together sixteen numbers.
#[derive(Clone, Copy)]
pub struct Registers<R, const N: usize>([R; N]);

/// Lanes of two registers and of more: written out, so that no loop is left for the compiler to unroll
/// before it can see that registers need no memory.
macro_rules! lanes_of {
    ($count:literal: $($i:literal)*) => {
        // SAFETY: the register's.
        unsafe impl<R: Register> Lanes for Registers<R, $count> {
            type Number = R::Number;
            const LEVEL: super::level::Simd = R::LEVEL;

            #[inline(always)]
            fn splat(value: R::Number) -> Self {
                Self([R::splat(value); $count])
            }
            #[inline(always)]
            unsafe fn load(from: *const R::Number) -> Self {
                Self(unsafe { [$(R::load(from.add($i * R::WIDTH))),*] })
            }
            #[inline(always)]
            unsafe fn store(self, to: *mut R::Number) {
                unsafe { $(self.0[$i].store(to.add($i * R::WIDTH));)* }
            }
            #[inline(always)]
            fn plus(self, other: Self) -> Self {
                Self([$(self.0[$i].plus(other.0[$i])),*])
            }
            #[inline(always)]
            fn minus(self, other: Self) -> Self {
                Self([$(self.0[$i].minus(other.0[$i])),*])
            }
            #[inline(always)]
            fn times(self, other: Self) -> Self {
                Self([$(self.0[$i].times(other.0[$i])),*])
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self([$(self.0[$i].min(other.0[$i])),*])
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self([$(self.0[$i].max(other.0[$i])),*])
            }
            #[inline(always)]
            fn less(self, other: Self) -> u16 {
                R::bits([$(self.0[$i].less(other.0[$i])),*])
            }
            #[inline(always)]
            fn equal(self, other: Self) -> u16 {
                R::bits([$(self.0[$i].equal(other.0[$i])),*])
            }
            #[inline(always)]
            fn where_else(self, mask: u16, other: Self) -> Self {
                Self([$(self.0[$i].where_else(mask, $i, other.0[$i])),*])
            }
            #[inline(always)]
            fn after(self, before: Self) -> Self {
                let whole = self.0;
                Self([$(whole[$i].after(if $i == 0 { before.0[$count - 1] } else { whole[($i + $count - 1) % $count] })),*])
            }
            #[inline(always)]
            fn ahead(self, behind: Self) -> Self {
                let whole = self.0;
                Self([$(whole[$i].ahead(if $i + 1 == $count { behind.0[0] } else { whole[($i + 1) % $count] })),*])
            }
            #[inline(always)]
            unsafe fn store_codes(masks: [u16; 8], to: *mut i8) {
                unsafe { R::store_codes(masks, to) }
            }
            #[inline(always)]
            unsafe fn transpose(from: *const R::Number, from_pitch: usize, to: *mut R::Number, to_pitch: usize) {
                for row in (0..LANES).step_by(R::WIDTH) {
                    for col in (0..LANES).step_by(R::WIDTH) {
                        unsafe {
                            R::transpose(
                                from.add(row * from_pitch + col),
                                from_pitch,
                                to.add(col * to_pitch + row),
                                to_pitch,
                            )
                        };
                    }
                }
            }
        }
    };
}
lanes_of!(2: 0 1);
lanes_of!(4: 0 1 2 3);
lanes_of!(8: 0 1 2 3 4 5 6 7);

/// Makes a vector type a [`Register`], given the functions that do the work on its vectors.
macro_rules! register {
    (
        $(#[$doc:meta])* $type:ident($vector:ty) of $width:literal $number:ident, truths $truths:ty,
        splat $splat:expr, load $load:expr, store $store:expr,
        plus $plus:expr, minus $minus:expr, times $times:expr,
        min $min:expr, max $max:expr, less $less:expr, equal $equal:expr,
        bits $bits:expr, chosen $chosen:expr, after $after:expr, ahead $ahead:expr,
        codes $codes:expr, transpose $transpose:expr $(,)?
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub struct $type($vector);

        // SAFETY: callers keep the trait's contract.
        #[allow(unused_unsafe)] // some of the functions are safe
        unsafe impl Register for $type {
            type Number = $number;
            const LEVEL: $crate::plan::Simd = LEVEL;
            type Truths = $truths;
            const WIDTH: usize = $width;

            #[inline(always)]
            fn splat(value: $number) -> Self {
                Self(unsafe { $splat(value) })
            }
            #[inline(always)]
            unsafe fn load(from: *const $number) -> Self {
                Self(unsafe { $load(from.cast()) })
            }
            #[inline(always)]
            unsafe fn store(self, to: *mut $number) {
                unsafe { $store(to.cast(), self.0) }
            }
            #[inline(always)]
            fn plus(self, other: Self) -> Self {
                Self(unsafe { $plus(self.0, other.0) })
            }
            #[inline(always)]
            fn minus(self, other: Self) -> Self {
                Self(unsafe { $minus(self.0, other.0) })
            }
            #[inline(always)]
            fn times(self, other: Self) -> Self {
                Self(unsafe { $times(self.0, other.0) })
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self(unsafe { $min(self.0, other.0) })
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(unsafe { $max(self.0, other.0) })
            }
            #[inline(always)]
            fn less(self, other: Self) -> $truths {
                unsafe { $less(self.0, other.0) }
            }
            #[inline(always)]
            fn equal(self, other: Self) -> $truths {
                unsafe { $equal(self.0, other.0) }
            }
            #[inline(always)]
            fn bits<const N: usize>(truths: [$truths; N]) -> u16 {
                $bits(truths)
            }
            #[inline(always)]
            fn where_else(self, mask: u16, place: usize, other: Self) -> Self {
                Self($chosen(mask, place, self.0, other.0))
            }
            #[inline(always)]
            fn after(self, before: Self) -> Self {
                Self(unsafe { $after(self.0, before.0) })
            }
            #[inline(always)]
            fn ahead(self, behind: Self) -> Self {
                Self(unsafe { $ahead(self.0, behind.0) })
            }
            #[inline(always)]
            unsafe fn store_codes(masks: [u16; 8], to: *mut i8) {
                unsafe { $codes(masks, to) }
            }
            #[inline(always)]
            unsafe fn transpose(from: *const $number, from_pitch: usize, to: *mut $number, to_pitch: usize) {
                unsafe { $transpose(from.cast(), from_pitch, to.cast(), to_pitch) }
            }
        }
    };
}
pub(super) use register;
