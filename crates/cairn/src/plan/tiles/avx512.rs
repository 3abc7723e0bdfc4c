//! Sixteen 32-bit numbers in one AVX-512 register.

use std::arch::x86_64::*;

use super::lanes::Lanes;
use super::level::Simd;

/// Sixteen u32.
#[derive(Clone, Copy)]
pub struct U32(__m512i);
/// Sixteen f32.
#[derive(Clone, Copy)]
pub struct F32(__m512);

/// Sixteen vectors as rows of a matrix, turned about its diagonal.
#[inline(always)]
unsafe fn turned(r: [__m512i; 16]) -> [__m512i; 16] {
    // SAFETY: the caller runs where AVX-512 is enabled.
    unsafe {
        let mut t = r;
        for i in 0..8 {
            t[2 * i] = _mm512_unpacklo_epi32(r[2 * i], r[2 * i + 1]);
            t[2 * i + 1] = _mm512_unpackhi_epi32(r[2 * i], r[2 * i + 1]);
        }
        let mut u = t;
        for i in 0..4 {
            u[4 * i] = _mm512_unpacklo_epi64(t[4 * i], t[4 * i + 2]);
            u[4 * i + 1] = _mm512_unpackhi_epi64(t[4 * i], t[4 * i + 2]);
            u[4 * i + 2] = _mm512_unpacklo_epi64(t[4 * i + 1], t[4 * i + 3]);
            u[4 * i + 3] = _mm512_unpackhi_epi64(t[4 * i + 1], t[4 * i + 3]);
        }
        // u[4 i + j] holds, in its four quarters q, the columns 4 q + j of the rows 4 i .. 4 i + 3.
        let mut v = u;
        for j in 0..4 {
            let (a, b) = (u[j], u[4 + j]);
            let (c, d) = (u[8 + j], u[12 + j]);
            let ab_even = _mm512_shuffle_i32x4::<0b10_00_10_00>(a, b);
            let ab_odd = _mm512_shuffle_i32x4::<0b11_01_11_01>(a, b);
            let cd_even = _mm512_shuffle_i32x4::<0b10_00_10_00>(c, d);
            let cd_odd = _mm512_shuffle_i32x4::<0b11_01_11_01>(c, d);
            v[j] = _mm512_shuffle_i32x4::<0b10_00_10_00>(ab_even, cd_even);
            v[8 + j] = _mm512_shuffle_i32x4::<0b11_01_11_01>(ab_even, cd_even);
            v[4 + j] = _mm512_shuffle_i32x4::<0b10_00_10_00>(ab_odd, cd_odd);
            v[12 + j] = _mm512_shuffle_i32x4::<0b11_01_11_01>(ab_odd, cd_odd);
        }
        v
    }
}

#[inline(always)]
unsafe fn transpose(from: *const i32, from_pitch: usize, to: *mut i32, to_pitch: usize) {
    // SAFETY: the caller's.
    unsafe {
        let mut rows = [_mm512_setzero_si512(); 16];
        for (i, row) in rows.iter_mut().enumerate() {
            *row = _mm512_loadu_si512(from.add(i * from_pitch).cast());
        }
        for (i, column) in turned(rows).into_iter().enumerate() {
            _mm512_storeu_si512(to.add(i * to_pitch).cast(), column);
        }
    }
}

/// As [`Lanes::store_codes`].
#[inline(always)]
pub unsafe fn store_codes(masks: [u16; 8], to: *mut i8) {
    // SAFETY: the caller's.
    unsafe {
        let mut codes = _mm_set1_epi8(-1);
        for (code, mask) in masks.into_iter().enumerate().rev() {
            codes = _mm_mask_mov_epi8(codes, mask, _mm_set1_epi8(code as i8));
        }
        _mm_storeu_si128(to.cast(), codes);
    }
}

// SAFETY: callers keep the trait's contract: AVX-512 F, BW and VL are there and enabled.
unsafe impl Lanes for U32 {
    type Number = u32;
    const LEVEL: Simd = Simd::Avx512;

    #[inline(always)]
    fn splat(value: u32) -> Self {
        Self(unsafe { _mm512_set1_epi32(value as i32) })
    }
    #[inline(always)]
    unsafe fn load(from: *const u32) -> Self {
        Self(unsafe { _mm512_loadu_si512(from.cast()) })
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut u32) {
        unsafe { _mm512_storeu_si512(to.cast(), self.0) }
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self(unsafe { _mm512_add_epi32(self.0, other.0) })
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self(unsafe { _mm512_sub_epi32(self.0, other.0) })
    }
    #[inline(always)]
    fn times(self, other: Self) -> Self {
        Self(unsafe { _mm512_mullo_epi32(self.0, other.0) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(unsafe { _mm512_min_epu32(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(unsafe { _mm512_max_epu32(self.0, other.0) })
    }
    #[inline(always)]
    fn less(self, other: Self) -> u16 {
        unsafe { _mm512_cmplt_epu32_mask(self.0, other.0) }
    }
    #[inline(always)]
    fn equal(self, other: Self) -> u16 {
        unsafe { _mm512_cmpeq_epu32_mask(self.0, other.0) }
    }
    #[inline(always)]
    fn where_else(self, mask: u16, other: Self) -> Self {
        Self(unsafe { _mm512_mask_mov_epi32(other.0, mask, self.0) })
    }
    #[inline(always)]
    fn after(self, before: Self) -> Self {
        Self(unsafe { _mm512_alignr_epi32::<15>(self.0, before.0) })
    }
    #[inline(always)]
    fn ahead(self, behind: Self) -> Self {
        Self(unsafe { _mm512_alignr_epi32::<1>(behind.0, self.0) })
    }
    #[inline(always)]
    unsafe fn store_codes(masks: [u16; 8], to: *mut i8) {
        unsafe { store_codes(masks, to) }
    }
    #[inline(always)]
    unsafe fn transpose(from: *const u32, from_pitch: usize, to: *mut u32, to_pitch: usize) {
        unsafe { transpose(from.cast(), from_pitch, to.cast(), to_pitch) }
    }
}

// SAFETY: callers keep the trait's contract: AVX-512 F, BW and VL are there and enabled.
unsafe impl Lanes for F32 {
    type Number = f32;
    const LEVEL: Simd = Simd::Avx512;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self(unsafe { _mm512_set1_ps(value) })
    }
    #[inline(always)]
    unsafe fn load(from: *const f32) -> Self {
        Self(unsafe { _mm512_loadu_ps(from) })
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut f32) {
        unsafe { _mm512_storeu_ps(to, self.0) }
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self(unsafe { _mm512_add_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self(unsafe { _mm512_sub_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn times(self, other: Self) -> Self {
        Self(unsafe { _mm512_mul_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(unsafe { _mm512_min_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(unsafe { _mm512_max_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn less(self, other: Self) -> u16 {
        unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn equal(self, other: Self) -> u16 {
        unsafe { _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn where_else(self, mask: u16, other: Self) -> Self {
        Self(unsafe { _mm512_mask_mov_ps(other.0, mask, self.0) })
    }
    #[inline(always)]
    fn after(self, before: Self) -> Self {
        let (this, before) = unsafe { (_mm512_castps_si512(self.0), _mm512_castps_si512(before.0)) };
        Self(unsafe { _mm512_castsi512_ps(_mm512_alignr_epi32::<15>(this, before)) })
    }
    #[inline(always)]
    fn ahead(self, behind: Self) -> Self {
        let (this, behind) = unsafe { (_mm512_castps_si512(self.0), _mm512_castps_si512(behind.0)) };
        Self(unsafe { _mm512_castsi512_ps(_mm512_alignr_epi32::<1>(behind, this)) })
    }
    #[inline(always)]
    unsafe fn store_codes(masks: [u16; 8], to: *mut i8) {
        unsafe { store_codes(masks, to) }
    }
    #[inline(always)]
    unsafe fn transpose(from: *const f32, from_pitch: usize, to: *mut f32, to_pitch: usize) {
        unsafe { transpose(from.cast(), from_pitch, to.cast(), to_pitch) }
    }
}
