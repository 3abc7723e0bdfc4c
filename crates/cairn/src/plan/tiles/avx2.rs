//! Sixteen 32-bit numbers in two AVX2 registers.

use std::arch::x86_64::*;

use super::lanes::Lanes;

/// Sixteen u32.
#[derive(Clone, Copy)]
pub struct U32([__m256i; 2]);
/// Sixteen f32.
#[derive(Clone, Copy)]
pub struct F32([__m256; 2]);

// SAFETY, of every unsafe block below: callers keep the trait's contract: AVX2 is there and enabled, and
// pointers reach as far as the trait says.

/// Eight lanes of ones where the mask has its bit.
#[inline(always)]
fn spread(mask: u8) -> __m256i {
    unsafe {
        let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
        _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(i32::from(mask)), bits), bits)
    }
}

/// The mask of lanes with their highest bit set.
#[inline(always)]
fn gathered(low: __m256, high: __m256) -> u16 {
    unsafe { _mm256_movemask_ps(low) as u16 | (_mm256_movemask_ps(high) as u16) << 8 }
}

/// Lane i of the result is lane i - 1 of `this`; lane 0 is the last of `before`.
#[inline(always)]
fn after(this: __m256i, before: __m256i) -> __m256i {
    unsafe { _mm256_alignr_epi8::<12>(this, _mm256_permute2x128_si256::<0x21>(before, this)) }
}

/// Lane i of the result is lane i + 1 of `this`; the last is lane 0 of `behind`.
#[inline(always)]
fn ahead(this: __m256i, behind: __m256i) -> __m256i {
    unsafe { _mm256_alignr_epi8::<4>(_mm256_permute2x128_si256::<0x21>(this, behind), this) }
}

/// Turns an 8 × 8 block about its diagonal.
#[inline(always)]
unsafe fn transpose_eight(from: *const f32, from_pitch: usize, to: *mut f32, to_pitch: usize) {
    unsafe {
        let r: [__m256; 8] = std::array::from_fn(|i| _mm256_loadu_ps(from.add(i * from_pitch)));
        let t: [__m256; 8] = std::array::from_fn(|i| {
            let (a, b) = (r[i / 2 * 2], r[i / 2 * 2 + 1]);
            if i % 2 == 0 { _mm256_unpacklo_ps(a, b) } else { _mm256_unpackhi_ps(a, b) }
        });
        let u: [__m256; 8] = std::array::from_fn(|i| {
            let (a, b) = (t[i / 4 * 4 + i % 4 / 2], t[i / 4 * 4 + i % 4 / 2 + 2]);
            if i % 2 == 0 {
                _mm256_shuffle_ps::<0b01_00_01_00>(a, b)
            } else {
                _mm256_shuffle_ps::<0b11_10_11_10>(a, b)
            }
        });
        for i in 0..4 {
            _mm256_storeu_ps(to.add(i * to_pitch), _mm256_permute2f128_ps::<0x20>(u[i], u[i + 4]));
            _mm256_storeu_ps(to.add((i + 4) * to_pitch), _mm256_permute2f128_ps::<0x31>(u[i], u[i + 4]));
        }
    }
}

#[inline(always)]
unsafe fn transpose(from: *const f32, from_pitch: usize, to: *mut f32, to_pitch: usize) {
    for row in [0, 8] {
        for col in [0, 8] {
            unsafe {
                transpose_eight(
                    from.add(row * from_pitch + col),
                    from_pitch,
                    to.add(col * to_pitch + row),
                    to_pitch,
                )
            };
        }
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

macro_rules! in_both {
    ($self:ident, $other:ident, $op:ident) => {
        Self(unsafe { [$op($self.0[0], $other.0[0]), $op($self.0[1], $other.0[1])] })
    };
}

unsafe impl Lanes for U32 {
    type Number = u32;

    #[inline(always)]
    fn splat(value: u32) -> Self {
        Self([unsafe { _mm256_set1_epi32(value as i32) }; 2])
    }
    #[inline(always)]
    unsafe fn load(from: *const u32) -> Self {
        Self(unsafe { [_mm256_loadu_si256(from.cast()), _mm256_loadu_si256(from.add(8).cast())] })
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut u32) {
        unsafe {
            _mm256_storeu_si256(to.cast(), self.0[0]);
            _mm256_storeu_si256(to.add(8).cast(), self.0[1]);
        }
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        in_both!(self, other, _mm256_add_epi32)
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        in_both!(self, other, _mm256_sub_epi32)
    }
    #[inline(always)]
    fn times(self, other: Self) -> Self {
        in_both!(self, other, _mm256_mullo_epi32)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        in_both!(self, other, _mm256_min_epu32)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        in_both!(self, other, _mm256_max_epu32)
    }
    #[inline(always)]
    fn less(self, other: Self) -> u16 {
        !self.max(other).equal(self) // not (self >= other)
    }
    #[inline(always)]
    fn equal(self, other: Self) -> u16 {
        let Self(same) = in_both!(self, other, _mm256_cmpeq_epi32);
        gathered(unsafe { _mm256_castsi256_ps(same[0]) }, unsafe { _mm256_castsi256_ps(same[1]) })
    }
    #[inline(always)]
    fn where_else(self, mask: u16, other: Self) -> Self {
        let half = |i: usize, mask: u8| unsafe { _mm256_blendv_epi8(other.0[i], self.0[i], spread(mask)) };
        Self([half(0, mask as u8), half(1, (mask >> 8) as u8)])
    }
    #[inline(always)]
    fn after(self, before: Self) -> Self {
        Self([after(self.0[0], before.0[1]), after(self.0[1], self.0[0])])
    }
    #[inline(always)]
    fn ahead(self, behind: Self) -> Self {
        Self([ahead(self.0[0], self.0[1]), ahead(self.0[1], behind.0[0])])
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

unsafe impl Lanes for F32 {
    type Number = f32;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([unsafe { _mm256_set1_ps(value) }; 2])
    }
    #[inline(always)]
    unsafe fn load(from: *const f32) -> Self {
        Self(unsafe { [_mm256_loadu_ps(from), _mm256_loadu_ps(from.add(8))] })
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut f32) {
        unsafe {
            _mm256_storeu_ps(to, self.0[0]);
            _mm256_storeu_ps(to.add(8), self.0[1]);
        }
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        in_both!(self, other, _mm256_add_ps)
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        in_both!(self, other, _mm256_sub_ps)
    }
    #[inline(always)]
    fn times(self, other: Self) -> Self {
        in_both!(self, other, _mm256_mul_ps)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        in_both!(self, other, _mm256_min_ps)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        in_both!(self, other, _mm256_max_ps)
    }
    #[inline(always)]
    fn less(self, other: Self) -> u16 {
        unsafe {
            gathered(
                _mm256_cmp_ps::<_CMP_LT_OQ>(self.0[0], other.0[0]),
                _mm256_cmp_ps::<_CMP_LT_OQ>(self.0[1], other.0[1]),
            )
        }
    }
    #[inline(always)]
    fn equal(self, other: Self) -> u16 {
        unsafe {
            gathered(
                _mm256_cmp_ps::<_CMP_EQ_OQ>(self.0[0], other.0[0]),
                _mm256_cmp_ps::<_CMP_EQ_OQ>(self.0[1], other.0[1]),
            )
        }
    }
    #[inline(always)]
    fn where_else(self, mask: u16, other: Self) -> Self {
        let half = |i: usize, mask: u8| unsafe {
            _mm256_blendv_ps(other.0[i], self.0[i], _mm256_castsi256_ps(spread(mask)))
        };
        Self([half(0, mask as u8), half(1, (mask >> 8) as u8)])
    }
    #[inline(always)]
    fn after(self, before: Self) -> Self {
        let bits = |numbers: __m256| unsafe { _mm256_castps_si256(numbers) };
        let moved = |this, before| unsafe { _mm256_castsi256_ps(after(bits(this), bits(before))) };
        Self([moved(self.0[0], before.0[1]), moved(self.0[1], self.0[0])])
    }
    #[inline(always)]
    fn ahead(self, behind: Self) -> Self {
        let bits = |numbers: __m256| unsafe { _mm256_castps_si256(numbers) };
        let moved = |this, behind| unsafe { _mm256_castsi256_ps(ahead(bits(this), bits(behind))) };
        Self([moved(self.0[0], self.0[1]), moved(self.0[1], behind.0[0])])
    }
    #[inline(always)]
    unsafe fn store_codes(masks: [u16; 8], to: *mut i8) {
        unsafe { store_codes(masks, to) }
    }
    #[inline(always)]
    unsafe fn transpose(from: *const f32, from_pitch: usize, to: *mut f32, to_pitch: usize) {
        unsafe { transpose(from, from_pitch, to, to_pitch) }
    }
}
