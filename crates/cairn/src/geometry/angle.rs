use std::f64::consts::{PI, TAU};

/// `angle_rad` wrapped to (−π, π] `[Maalouf06 §2]`.
///
/// NaN and infinities give NaN.
#[inline]
pub fn wrap_angle(angle_rad: f64) -> f64 {
    if -PI < angle_rad && angle_rad <= PI {
        return angle_rad;
    }
    let wrapped = angle_rad.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn pi_stays_and_minus_pi_becomes_pi() {
        assert_eq!(wrap_angle(PI), PI);
        assert_eq!(wrap_angle(-PI), PI);
    }

    proptest! {
        #[test]
        fn wrapping_keeps_the_direction_and_lands_in_the_half_open_turn(a in -1e3..1e3f64) {
            let w = wrap_angle(a);
            prop_assert!(-PI < w && w <= PI);
            prop_assert!((a.sin() - w.sin()).abs() < 1e-9 && (a.cos() - w.cos()).abs() < 1e-9);
        }
    }
}
