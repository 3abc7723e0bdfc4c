//! 2^x in plain f32 arithmetic: the same bits on every machine and in every SIMD lane.

/// Above this an answer would leave the range of f32; larger arguments are taken as this.
pub const MOST: f32 = 126.0;

/// 1.5 · 2²³: adding it rounds a small number to the nearest integer, kept in the low bits of the sum.
const ROUNDER: f32 = 12_582_912.0;

/// 2^f on [-1/2, 1/2], fitted for the least relative error with the constant term held at 1.
#[allow(clippy::approx_constant)] // near ln 2, but fitted
const C1: f32 = 0.693_147;
const C2: f32 = 0.240_222_42;
const C3: f32 = 0.055_507_336;
const C4: f32 = 0.009_671_513;
const C5: f32 = 0.001_326_473;

/// 2^x for 0 <= x <= `MOST`, within 2.5e-7 of it (relative); exact at integers. Larger x count as `MOST`.
///
/// x = n + f with n the nearest integer; 2^f is a polynomial by Horner's rule, every operation rounded,
/// none fused; 2^n is put together from its bits.
#[inline(always)]
pub fn exp2(x: f32) -> f32 {
    let x = if x < MOST { x } else { MOST };
    let shifted = x + ROUNDER;
    let f = x - (shifted - ROUNDER);
    let power = f32::from_bits((shifted.to_bits() << 23).wrapping_add(127 << 23));
    let fraction = ((((C5 * f + C4) * f + C3) * f + C2) * f + C1) * f + 1.0;
    fraction * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_stays_below_the_bound_stated() {
        let mut worst = 0.0_f64;
        for i in 0..3_000_000_u32 {
            let x = i as f32 * (MOST / 3_000_000.0);
            worst = worst.max((f64::from(exp2(x)) / f64::from(x).exp2() - 1.0).abs());
        }
        for i in 0..2_000_000_u32 {
            let x = i as f32 * 1e-6;
            worst = worst.max((f64::from(exp2(x)) / f64::from(x).exp2() - 1.0).abs());
        }
        assert!(worst < 2.5e-7, "{worst:e}");
    }

    #[test]
    fn whole_powers_are_exact_and_the_end_is_held() {
        for n in 0..=126 {
            assert_eq!(exp2(n as f32), 2.0_f32.powi(n));
        }
        for beyond in [127.0, 1e9, f32::MAX, f32::INFINITY] {
            assert_eq!(exp2(beyond), 2.0_f32.powi(126));
        }
    }
}
