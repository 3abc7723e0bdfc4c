//! Registers of SSE2, which every x86-64 processor has.

use std::arch::x86_64::*;

use super::level::Simd;
use super::registers::{Register, register};

const LEVEL: Simd = Simd::Portable;

// SAFETY, of every unsafe block below: SSE2 is always there, and pointers reach as far as the trait says.

/// `a` where the bits of `mask` are set, else `b`.
#[inline(always)]
fn choose(mask: __m128i, a: __m128i, b: __m128i) -> __m128i {
    unsafe { _mm_or_si128(_mm_and_si128(mask, a), _mm_andnot_si128(mask, b)) }
}

/// Ones in each of four numbers whose bit of the mask is set.
#[inline(always)]
fn spread_four(mask: u16, place: usize) -> __m128i {
    unsafe {
        let first = 1 << (4 * place);
        let bit = _mm_setr_epi32(first, 2 * first, 4 * first, 8 * first);
        _mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32(i32::from(mask)), bit), bit)
    }
}

/// Ones in each of two numbers whose bit of the mask is set.
#[inline(always)]
fn spread_two(mask: u16, place: usize) -> __m128i {
    unsafe {
        let (low, high) = (1 << (2 * place), 2 << (2 * place));
        let bit = _mm_setr_epi32(low, low, high, high);
        _mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32(i32::from(mask)), bit), bit)
    }
}

/// Sixteen bits of four vectors of four truths.
#[inline(always)]
fn bits_of_fours<const N: usize>(truths: [__m128i; N]) -> u16 {
    unsafe {
        let low = _mm_packs_epi32(truths[0], truths[1]);
        let high = _mm_packs_epi32(truths[2], truths[3]);
        _mm_movemask_epi8(_mm_packs_epi16(low, high)) as u16
    }
}

/// Two vectors of two truths as one of four.
#[inline(always)]
fn four_of_twos(low: __m128i, high: __m128i) -> __m128i {
    unsafe {
        let (low, high) = (_mm_castsi128_ps(low), _mm_castsi128_ps(high));
        _mm_castps_si128(_mm_shuffle_ps::<0b10_00_10_00>(low, high))
    }
}

/// Sixteen bits of eight vectors of two truths.
#[inline(always)]
fn bits_of_twos<const N: usize>(truths: [__m128i; N]) -> u16 {
    bits_of_fours([
        four_of_twos(truths[0], truths[1]),
        four_of_twos(truths[2], truths[3]),
        four_of_twos(truths[4], truths[5]),
        four_of_twos(truths[6], truths[7]),
    ])
}

/// Where a < b, as signed numbers whose difference fits.
#[inline(always)]
fn less_of_twos(a: __m128i, b: __m128i) -> __m128i {
    unsafe {
        let signs = _mm_srai_epi32::<31>(_mm_sub_epi64(a, b));
        _mm_shuffle_epi32::<0b11_11_01_01>(signs)
    }
}

/// Where a < b, as unsigned numbers.
#[inline(always)]
fn less_of_fours(a: __m128i, b: __m128i) -> __m128i {
    unsafe {
        let half = _mm_set1_epi32(i32::MIN);
        _mm_cmplt_epi32(_mm_xor_si128(a, half), _mm_xor_si128(b, half))
    }
}

#[inline(always)]
unsafe fn store_codes(masks: [u16; 8], to: *mut i8) {
    unsafe {
        let bits = _mm_setr_epi8(1, 2, 4, 8, 16, 32, 64, -128, 1, 2, 4, 8, 16, 32, 64, -128);
        let mut codes = _mm_set1_epi8(-1);
        for (code, mask) in masks.into_iter().enumerate().rev() {
            // Its low byte eight times, then its high byte.
            let twice = _mm_cvtsi32_si128(i32::from(mask));
            let twice = _mm_unpacklo_epi8(twice, twice);
            let of_lane = _mm_shuffle_epi32::<0b01_01_00_00>(_mm_shufflelo_epi16::<0b01_01_00_00>(twice));
            let set = _mm_cmpeq_epi8(_mm_and_si128(of_lane, bits), bits);
            codes = choose(set, _mm_set1_epi8(code as i8), codes);
        }
        _mm_storeu_si128(to.cast(), codes);
    }
}

#[inline(always)]
unsafe fn transpose_four(from: *const f32, from_pitch: usize, to: *mut f32, to_pitch: usize) {
    unsafe {
        let (a, b) = (_mm_loadu_ps(from), _mm_loadu_ps(from.add(from_pitch)));
        let (c, d) = (_mm_loadu_ps(from.add(2 * from_pitch)), _mm_loadu_ps(from.add(3 * from_pitch)));
        let (ab_low, ab_high) = (_mm_unpacklo_ps(a, b), _mm_unpackhi_ps(a, b));
        let (cd_low, cd_high) = (_mm_unpacklo_ps(c, d), _mm_unpackhi_ps(c, d));
        _mm_storeu_ps(to, _mm_movelh_ps(ab_low, cd_low));
        _mm_storeu_ps(to.add(to_pitch), _mm_movehl_ps(cd_low, ab_low));
        _mm_storeu_ps(to.add(2 * to_pitch), _mm_movelh_ps(ab_high, cd_high));
        _mm_storeu_ps(to.add(3 * to_pitch), _mm_movehl_ps(cd_high, ab_high));
    }
}

#[inline(always)]
unsafe fn transpose_two(from: *const f64, from_pitch: usize, to: *mut f64, to_pitch: usize) {
    unsafe {
        let (a, b) = (_mm_loadu_pd(from), _mm_loadu_pd(from.add(from_pitch)));
        _mm_storeu_pd(to, _mm_unpacklo_pd(a, b));
        _mm_storeu_pd(to.add(to_pitch), _mm_unpackhi_pd(a, b));
    }
}

/// Where both halves of a number are equal.
#[inline(always)]
fn equal_twos(a: __m128i, b: __m128i) -> __m128i {
    unsafe {
        let halves = _mm_cmpeq_epi32(a, b);
        _mm_and_si128(halves, _mm_shuffle_epi32::<0b10_11_00_01>(halves))
    }
}

/// Number i is number i - 1 of `this`; number 0 is the last of `before`. `REST` is 16 bytes less `BYTES`,
/// one number.
#[inline(always)]
fn after<const BYTES: i32, const REST: i32>(this: __m128i, before: __m128i) -> __m128i {
    unsafe { _mm_or_si128(_mm_slli_si128::<BYTES>(this), _mm_srli_si128::<REST>(before)) }
}

/// Number i is number i + 1 of `this`; the last is number 0 of `behind`.
#[inline(always)]
fn ahead<const BYTES: i32, const REST: i32>(this: __m128i, behind: __m128i) -> __m128i {
    unsafe { _mm_or_si128(_mm_srli_si128::<BYTES>(this), _mm_slli_si128::<REST>(behind)) }
}

macro_rules! by_masks {
    ($less:ident, $min:ident, $max:ident, $spread:ident, $chosen:ident) => {
        #[inline(always)]
        fn $min(a: __m128i, b: __m128i) -> __m128i {
            choose($less(a, b), a, b)
        }
        #[inline(always)]
        fn $max(a: __m128i, b: __m128i) -> __m128i {
            choose($less(a, b), b, a)
        }
        #[inline(always)]
        fn $chosen(mask: u16, place: usize, a: __m128i, b: __m128i) -> __m128i {
            choose($spread(mask, place), a, b)
        }
    };
}
by_masks!(less_of_fours, least_of_fours, most_of_fours, spread_four, chosen_fours);
by_masks!(less_of_twos, least_of_twos, most_of_twos, spread_two, chosen_twos);

/// Operations on floats, of vectors kept as bits.
macro_rules! on_floats {
    ($($name:ident = $op:ident of $floats:ident to $bits:ident;)*) => {
        $(
            #[inline(always)]
            fn $name(a: __m128i, b: __m128i) -> __m128i {
                unsafe { $bits($op($floats(a), $floats(b))) }
            }
        )*
    };
}
on_floats! {
    add_f32 = _mm_add_ps of _mm_castsi128_ps to _mm_castps_si128;
    sub_f32 = _mm_sub_ps of _mm_castsi128_ps to _mm_castps_si128;
    mul_f32 = _mm_mul_ps of _mm_castsi128_ps to _mm_castps_si128;
    min_f32 = _mm_min_ps of _mm_castsi128_ps to _mm_castps_si128;
    max_f32 = _mm_max_ps of _mm_castsi128_ps to _mm_castps_si128;
    less_f32 = _mm_cmplt_ps of _mm_castsi128_ps to _mm_castps_si128;
    equal_f32 = _mm_cmpeq_ps of _mm_castsi128_ps to _mm_castps_si128;
    add_f64 = _mm_add_pd of _mm_castsi128_pd to _mm_castpd_si128;
    sub_f64 = _mm_sub_pd of _mm_castsi128_pd to _mm_castpd_si128;
    mul_f64 = _mm_mul_pd of _mm_castsi128_pd to _mm_castpd_si128;
    min_f64 = _mm_min_pd of _mm_castsi128_pd to _mm_castpd_si128;
    max_f64 = _mm_max_pd of _mm_castsi128_pd to _mm_castpd_si128;
    less_f64 = _mm_cmplt_pd of _mm_castsi128_pd to _mm_castpd_si128;
    equal_f64 = _mm_cmpeq_pd of _mm_castsi128_pd to _mm_castpd_si128;
}

/// Products of integers, for which there is no instruction; tiles need none.
macro_rules! wrapping_products {
    ($name:ident, $numbers:ty) => {
        #[inline(always)]
        fn $name(a: __m128i, b: __m128i) -> __m128i {
            // SAFETY: plain bits of one size.
            let (mut a, b) = unsafe { std::mem::transmute::<[__m128i; 2], ($numbers, $numbers)>([a, b]) };
            for (a, b) in a.iter_mut().zip(b) {
                *a = a.wrapping_mul(b);
            }
            unsafe { std::mem::transmute::<$numbers, __m128i>(a) }
        }
    };
}
wrapping_products!(mul_u32, [u32; 4]);
wrapping_products!(mul_u64, [u64; 2]);

#[inline(always)]
fn splat_u32(value: u32) -> __m128i {
    unsafe { _mm_set1_epi32(value as i32) }
}
#[inline(always)]
fn splat_u64(value: u64) -> __m128i {
    unsafe { _mm_set1_epi64x(value as i64) }
}
#[inline(always)]
fn splat_f32(value: f32) -> __m128i {
    splat_u32(value.to_bits())
}
#[inline(always)]
fn splat_f64(value: f64) -> __m128i {
    splat_u64(value.to_bits())
}

register! {
    /// Four u32.
    U32(__m128i) of 4 u32, truths __m128i,
    splat splat_u32, load _mm_loadu_si128, store _mm_storeu_si128,
    plus _mm_add_epi32, minus _mm_sub_epi32, times mul_u32,
    min least_of_fours, max most_of_fours, less less_of_fours, equal _mm_cmpeq_epi32,
    bits bits_of_fours, chosen chosen_fours, after after::<4, 12>, ahead ahead::<4, 12>,
    codes store_codes, transpose transpose_four,
}
register! {
    /// Two u64, compared as signed numbers.
    U64(__m128i) of 2 u64, truths __m128i,
    splat splat_u64, load _mm_loadu_si128, store _mm_storeu_si128,
    plus _mm_add_epi64, minus _mm_sub_epi64, times mul_u64,
    min least_of_twos, max most_of_twos, less less_of_twos, equal equal_twos,
    bits bits_of_twos, chosen chosen_twos, after after::<8, 8>, ahead ahead::<8, 8>,
    codes store_codes, transpose transpose_two,
}
register! {
    /// Four f32.
    F32(__m128i) of 4 f32, truths __m128i,
    splat splat_f32, load _mm_loadu_si128, store _mm_storeu_si128,
    plus add_f32, minus sub_f32, times mul_f32,
    min min_f32, max max_f32, less less_f32, equal equal_f32,
    bits bits_of_fours, chosen chosen_fours, after after::<4, 12>, ahead ahead::<4, 12>,
    codes store_codes, transpose transpose_four,
}
register! {
    /// Two f64.
    F64(__m128i) of 2 f64, truths __m128i,
    splat splat_f64, load _mm_loadu_si128, store _mm_storeu_si128,
    plus add_f64, minus sub_f64, times mul_f64,
    min min_f64, max max_f64, less less_f64, equal equal_f64,
    bits bits_of_twos, chosen chosen_twos, after after::<8, 8>, ahead ahead::<8, 8>,
    codes store_codes, transpose transpose_two,
}
