//! Registers of AVX-512 with eight 64-bit numbers.

use std::arch::x86_64::*;

use super::avx512::store_codes;
use super::level::Simd;
use super::registers::{Register, register};

const LEVEL: Simd = Simd::Avx512;

// SAFETY, of every unsafe block below: callers keep the trait's contract: AVX-512 F, BW, VL and DQ are
// there and enabled, and pointers reach as far as the trait says.

/// Sixteen bits of two vectors of eight truths.
#[inline(always)]
fn bits<const N: usize>(truths: [u8; N]) -> u16 {
    u16::from(truths[0]) | u16::from(truths[1]) << 8
}

#[inline(always)]
fn chosen(mask: u16, place: usize, a: __m512i, b: __m512i) -> __m512i {
    unsafe { _mm512_mask_mov_epi64(b, (mask >> (8 * place)) as u8, a) }
}

/// Number i is number i - 1 of `this`; number 0 is the last of `before`.
#[inline(always)]
fn after(this: __m512i, before: __m512i) -> __m512i {
    unsafe { _mm512_alignr_epi64::<7>(this, before) }
}

/// Number i is number i + 1 of `this`; the last is number 0 of `behind`.
#[inline(always)]
fn ahead(this: __m512i, behind: __m512i) -> __m512i {
    unsafe { _mm512_alignr_epi64::<1>(behind, this) }
}

#[inline(always)]
unsafe fn transpose(from: *const i64, from_pitch: usize, to: *mut i64, to_pitch: usize) {
    unsafe {
        let mut r = [_mm512_setzero_si512(); 8];
        for (i, row) in r.iter_mut().enumerate() {
            *row = _mm512_loadu_si512(from.add(i * from_pitch).cast());
        }
        let mut t = r;
        for i in 0..4 {
            t[2 * i] = _mm512_unpacklo_epi64(r[2 * i], r[2 * i + 1]);
            t[2 * i + 1] = _mm512_unpackhi_epi64(r[2 * i], r[2 * i + 1]);
        }
        // t[2 i + j] holds, in its four quarters q, the columns 2 q + j of the rows 2 i and 2 i + 1.
        let mut v = t;
        for j in 0..2 {
            let low_even = _mm512_shuffle_i64x2::<0b10_00_10_00>(t[j], t[2 + j]);
            let low_odd = _mm512_shuffle_i64x2::<0b11_01_11_01>(t[j], t[2 + j]);
            let high_even = _mm512_shuffle_i64x2::<0b10_00_10_00>(t[4 + j], t[6 + j]);
            let high_odd = _mm512_shuffle_i64x2::<0b11_01_11_01>(t[4 + j], t[6 + j]);
            v[j] = _mm512_shuffle_i64x2::<0b10_00_10_00>(low_even, high_even);
            v[4 + j] = _mm512_shuffle_i64x2::<0b11_01_11_01>(low_even, high_even);
            v[2 + j] = _mm512_shuffle_i64x2::<0b10_00_10_00>(low_odd, high_odd);
            v[6 + j] = _mm512_shuffle_i64x2::<0b11_01_11_01>(low_odd, high_odd);
        }
        for (i, column) in v.into_iter().enumerate() {
            _mm512_storeu_si512(to.add(i * to_pitch).cast(), column);
        }
    }
}

/// Operations on floats, of vectors kept as bits.
macro_rules! on_floats {
    ($($name:ident = $op:ident;)*) => {
        $(
            #[inline(always)]
            fn $name(a: __m512i, b: __m512i) -> __m512i {
                unsafe { _mm512_castpd_si512($op(_mm512_castsi512_pd(a), _mm512_castsi512_pd(b))) }
            }
        )*
    };
}
on_floats! {
    add_f64 = _mm512_add_pd;
    sub_f64 = _mm512_sub_pd;
    mul_f64 = _mm512_mul_pd;
    min_f64 = _mm512_min_pd;
    max_f64 = _mm512_max_pd;
}

#[inline(always)]
fn less_f64(a: __m512i, b: __m512i) -> u8 {
    unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(_mm512_castsi512_pd(a), _mm512_castsi512_pd(b)) }
}
#[inline(always)]
fn equal_f64(a: __m512i, b: __m512i) -> u8 {
    unsafe { _mm512_cmp_pd_mask::<_CMP_EQ_OQ>(_mm512_castsi512_pd(a), _mm512_castsi512_pd(b)) }
}
#[inline(always)]
fn splat_u64(value: u64) -> __m512i {
    unsafe { _mm512_set1_epi64(value as i64) }
}
#[inline(always)]
fn splat_f64(value: f64) -> __m512i {
    splat_u64(value.to_bits())
}

register! {
    /// Eight u64.
    U64(__m512i) of 8 u64, truths u8,
    splat splat_u64, load _mm512_loadu_si512, store _mm512_storeu_si512,
    plus _mm512_add_epi64, minus _mm512_sub_epi64, times _mm512_mullo_epi64,
    min _mm512_min_epu64, max _mm512_max_epu64, less _mm512_cmplt_epu64_mask, equal _mm512_cmpeq_epu64_mask,
    bits bits, chosen chosen, after after, ahead ahead,
    codes store_codes, transpose transpose,
}
register! {
    /// Eight f64.
    F64(__m512i) of 8 f64, truths u8,
    splat splat_f64, load _mm512_loadu_si512, store _mm512_storeu_si512,
    plus add_f64, minus sub_f64, times mul_f64,
    min min_f64, max max_f64, less less_f64, equal equal_f64,
    bits bits, chosen chosen, after after, ahead ahead,
    codes store_codes, transpose transpose,
}
