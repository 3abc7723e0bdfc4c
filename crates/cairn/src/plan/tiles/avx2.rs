//! Registers of AVX2.

use std::arch::x86_64::*;

use super::level::Simd;
use super::registers::{Register, register};

const LEVEL: Simd = Simd::Avx2;

// SAFETY, of every unsafe block below: callers keep the trait's contract: AVX2 is there and enabled, and
// pointers reach as far as the trait says.

/// Ones in each of eight numbers whose bit of the mask is set.
#[inline(always)]
fn spread_eight(mask: u16, place: usize) -> __m256i {
    unsafe {
        let first = 1 << (8 * place);
        let bits = _mm256_setr_epi32(
            first,
            2 * first,
            4 * first,
            8 * first,
            16 * first,
            32 * first,
            64 * first,
            128 * first,
        );
        _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(i32::from(mask)), bits), bits)
    }
}

/// Ones in each of four numbers whose bit of the mask is set.
#[inline(always)]
fn spread_four(mask: u16, place: usize) -> __m256i {
    unsafe {
        let first = 1 << (4 * place);
        let bits = _mm256_setr_epi64x(first, 2 * first, 4 * first, 8 * first);
        _mm256_cmpeq_epi64(_mm256_and_si256(_mm256_set1_epi64x(i64::from(mask)), bits), bits)
    }
}

/// Sixteen bits of two vectors of eight truths.
#[inline(always)]
fn bits_of_eights<const N: usize>(truths: [__m256i; N]) -> u16 {
    unsafe {
        let low = _mm256_movemask_ps(_mm256_castsi256_ps(truths[0]));
        let high = _mm256_movemask_ps(_mm256_castsi256_ps(truths[1]));
        (low | high << 8) as u16
    }
}

/// Sixteen bits of four vectors of four truths.
#[inline(always)]
fn bits_of_fours<const N: usize>(truths: [__m256i; N]) -> u16 {
    unsafe {
        // Halves of 64-bit truths, two vectors in one: their quarters lie 0 2 1 3.
        let low = _mm256_packs_epi32(truths[0], truths[1]);
        let high = _mm256_packs_epi32(truths[2], truths[3]);
        let low = _mm256_permute4x64_epi64::<0b11_01_10_00>(low);
        let high = _mm256_permute4x64_epi64::<0b11_01_10_00>(high);
        bits_of_eights([low, high])
    }
}

/// Where a < b, as unsigned numbers.
#[inline(always)]
fn less_of_eights(a: __m256i, b: __m256i) -> __m256i {
    unsafe {
        let half = _mm256_set1_epi32(i32::MIN);
        _mm256_cmpgt_epi32(_mm256_xor_si256(b, half), _mm256_xor_si256(a, half))
    }
}

/// Where a < b, as signed numbers.
#[inline(always)]
fn less_of_fours(a: __m256i, b: __m256i) -> __m256i {
    unsafe { _mm256_cmpgt_epi64(b, a) }
}

#[inline(always)]
fn least_of_fours(a: __m256i, b: __m256i) -> __m256i {
    unsafe { _mm256_blendv_epi8(a, b, _mm256_cmpgt_epi64(a, b)) }
}

#[inline(always)]
fn most_of_fours(a: __m256i, b: __m256i) -> __m256i {
    unsafe { _mm256_blendv_epi8(b, a, _mm256_cmpgt_epi64(a, b)) }
}

#[inline(always)]
unsafe fn transpose_eight(from: *const f32, from_pitch: usize, to: *mut f32, to_pitch: usize) {
    unsafe {
        let mut r = [_mm256_setzero_ps(); 8];
        for (i, row) in r.iter_mut().enumerate() {
            *row = _mm256_loadu_ps(from.add(i * from_pitch));
        }
        let mut t = r;
        for i in 0..4 {
            t[2 * i] = _mm256_unpacklo_ps(r[2 * i], r[2 * i + 1]);
            t[2 * i + 1] = _mm256_unpackhi_ps(r[2 * i], r[2 * i + 1]);
        }
        let mut u = t;
        for i in 0..2 {
            for j in 0..2 {
                let (a, b) = (t[4 * i + j], t[4 * i + j + 2]);
                u[4 * i + 2 * j] = _mm256_shuffle_ps::<0b01_00_01_00>(a, b);
                u[4 * i + 2 * j + 1] = _mm256_shuffle_ps::<0b11_10_11_10>(a, b);
            }
        }
        for i in 0..4 {
            _mm256_storeu_ps(to.add(i * to_pitch), _mm256_permute2f128_ps::<0x20>(u[i], u[i + 4]));
            _mm256_storeu_ps(to.add((i + 4) * to_pitch), _mm256_permute2f128_ps::<0x31>(u[i], u[i + 4]));
        }
    }
}

#[inline(always)]
unsafe fn transpose_four(from: *const f64, from_pitch: usize, to: *mut f64, to_pitch: usize) {
    unsafe {
        let (a, b) = (_mm256_loadu_pd(from), _mm256_loadu_pd(from.add(from_pitch)));
        let (c, d) = (_mm256_loadu_pd(from.add(2 * from_pitch)), _mm256_loadu_pd(from.add(3 * from_pitch)));
        let (ab_even, ab_odd) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
        let (cd_even, cd_odd) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
        _mm256_storeu_pd(to, _mm256_permute2f128_pd::<0x20>(ab_even, cd_even));
        _mm256_storeu_pd(to.add(to_pitch), _mm256_permute2f128_pd::<0x20>(ab_odd, cd_odd));
        _mm256_storeu_pd(to.add(2 * to_pitch), _mm256_permute2f128_pd::<0x31>(ab_even, cd_even));
        _mm256_storeu_pd(to.add(3 * to_pitch), _mm256_permute2f128_pd::<0x31>(ab_odd, cd_odd));
    }
}

#[inline(always)]
unsafe fn store_codes(masks: [u16; 8], to: *mut i8) {
    unsafe {
        let bits = _mm_setr_epi8(1, 2, 4, 8, 16, 32, 64, -128, 1, 2, 4, 8, 16, 32, 64, -128);
        let halves = _mm_setr_epi8(0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1);
        let mut codes = _mm_set1_epi8(-1);
        for (code, mask) in masks.into_iter().enumerate().rev() {
            let of_lane = _mm_shuffle_epi8(_mm_set1_epi16(mask as i16), halves);
            let set = _mm_cmpeq_epi8(_mm_and_si128(of_lane, bits), bits);
            codes = _mm_blendv_epi8(codes, _mm_set1_epi8(code as i8), set);
        }
        _mm_storeu_si128(to.cast(), codes);
    }
}

/// Number i is number i - 1 of `this`; number 0 is the last of `before`. `REST` is 16 bytes less one number.
#[inline(always)]
fn after<const REST: i32>(this: __m256i, before: __m256i) -> __m256i {
    unsafe { _mm256_alignr_epi8::<REST>(this, _mm256_permute2x128_si256::<0x21>(before, this)) }
}

/// Number i is number i + 1 of `this`; the last is number 0 of `behind`. `BYTES` is one number.
#[inline(always)]
fn ahead<const BYTES: i32>(this: __m256i, behind: __m256i) -> __m256i {
    unsafe { _mm256_alignr_epi8::<BYTES>(_mm256_permute2x128_si256::<0x21>(this, behind), this) }
}

#[inline(always)]
fn chosen_eights(mask: u16, place: usize, a: __m256i, b: __m256i) -> __m256i {
    unsafe { _mm256_blendv_epi8(b, a, spread_eight(mask, place)) }
}
#[inline(always)]
fn chosen_fours(mask: u16, place: usize, a: __m256i, b: __m256i) -> __m256i {
    unsafe { _mm256_blendv_epi8(b, a, spread_four(mask, place)) }
}

/// Operations on floats, of vectors kept as bits.
macro_rules! on_floats {
    ($($name:ident = $op:expr, of $floats:ident to $bits:ident;)*) => {
        $(
            #[inline(always)]
            fn $name(a: __m256i, b: __m256i) -> __m256i {
                unsafe { $bits($op($floats(a), $floats(b))) }
            }
        )*
    };
}
on_floats! {
    add_f32 = _mm256_add_ps, of _mm256_castsi256_ps to _mm256_castps_si256;
    sub_f32 = _mm256_sub_ps, of _mm256_castsi256_ps to _mm256_castps_si256;
    mul_f32 = _mm256_mul_ps, of _mm256_castsi256_ps to _mm256_castps_si256;
    min_f32 = _mm256_min_ps, of _mm256_castsi256_ps to _mm256_castps_si256;
    max_f32 = _mm256_max_ps, of _mm256_castsi256_ps to _mm256_castps_si256;
    less_f32 = _mm256_cmp_ps::<_CMP_LT_OQ>, of _mm256_castsi256_ps to _mm256_castps_si256;
    equal_f32 = _mm256_cmp_ps::<_CMP_EQ_OQ>, of _mm256_castsi256_ps to _mm256_castps_si256;
    add_f64 = _mm256_add_pd, of _mm256_castsi256_pd to _mm256_castpd_si256;
    sub_f64 = _mm256_sub_pd, of _mm256_castsi256_pd to _mm256_castpd_si256;
    mul_f64 = _mm256_mul_pd, of _mm256_castsi256_pd to _mm256_castpd_si256;
    min_f64 = _mm256_min_pd, of _mm256_castsi256_pd to _mm256_castpd_si256;
    max_f64 = _mm256_max_pd, of _mm256_castsi256_pd to _mm256_castpd_si256;
    less_f64 = _mm256_cmp_pd::<_CMP_LT_OQ>, of _mm256_castsi256_pd to _mm256_castpd_si256;
    equal_f64 = _mm256_cmp_pd::<_CMP_EQ_OQ>, of _mm256_castsi256_pd to _mm256_castpd_si256;
}

/// Products of u64, for which there is no instruction; tiles need none.
#[inline(always)]
fn mul_u64(a: __m256i, b: __m256i) -> __m256i {
    // SAFETY: plain bits of one size.
    let (mut a, b) = unsafe { std::mem::transmute::<[__m256i; 2], ([u64; 4], [u64; 4])>([a, b]) };
    for (a, b) in a.iter_mut().zip(b) {
        *a = a.wrapping_mul(b);
    }
    unsafe { std::mem::transmute::<[u64; 4], __m256i>(a) }
}

#[inline(always)]
fn splat_u32(value: u32) -> __m256i {
    unsafe { _mm256_set1_epi32(value as i32) }
}
#[inline(always)]
fn splat_u64(value: u64) -> __m256i {
    unsafe { _mm256_set1_epi64x(value as i64) }
}
#[inline(always)]
fn splat_f32(value: f32) -> __m256i {
    splat_u32(value.to_bits())
}
#[inline(always)]
fn splat_f64(value: f64) -> __m256i {
    splat_u64(value.to_bits())
}

register! {
    /// Eight u32.
    U32(__m256i) of 8 u32, truths __m256i,
    splat splat_u32, load _mm256_loadu_si256, store _mm256_storeu_si256,
    plus _mm256_add_epi32, minus _mm256_sub_epi32, times _mm256_mullo_epi32,
    min _mm256_min_epu32, max _mm256_max_epu32, less less_of_eights, equal _mm256_cmpeq_epi32,
    bits bits_of_eights, chosen chosen_eights, after after::<12>, ahead ahead::<4>,
    codes store_codes, transpose transpose_eight,
}
register! {
    /// Four u64, compared as signed numbers.
    U64(__m256i) of 4 u64, truths __m256i,
    splat splat_u64, load _mm256_loadu_si256, store _mm256_storeu_si256,
    plus _mm256_add_epi64, minus _mm256_sub_epi64, times mul_u64,
    min least_of_fours, max most_of_fours, less less_of_fours, equal _mm256_cmpeq_epi64,
    bits bits_of_fours, chosen chosen_fours, after after::<8>, ahead ahead::<8>,
    codes store_codes, transpose transpose_four,
}
register! {
    /// Eight f32.
    F32(__m256i) of 8 f32, truths __m256i,
    splat splat_f32, load _mm256_loadu_si256, store _mm256_storeu_si256,
    plus add_f32, minus sub_f32, times mul_f32,
    min min_f32, max max_f32, less less_f32, equal equal_f32,
    bits bits_of_eights, chosen chosen_eights, after after::<12>, ahead ahead::<4>,
    codes store_codes, transpose transpose_eight,
}
register! {
    /// Four f64.
    F64(__m256i) of 4 f64, truths __m256i,
    splat splat_f64, load _mm256_loadu_si256, store _mm256_storeu_si256,
    plus add_f64, minus sub_f64, times mul_f64,
    min min_f64, max max_f64, less less_f64, equal equal_f64,
    bits bits_of_fours, chosen chosen_fours, after after::<8>, ahead ahead::<8>,
    codes store_codes, transpose transpose_four,
}
