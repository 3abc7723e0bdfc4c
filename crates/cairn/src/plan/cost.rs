/// A number that costs are added up in: u32, u64, f32 or f64.
///
/// `UNREACHABLE` is the largest value of the type (infinity for floats) and never takes part in a
/// sum. Sums that would reach it are None: nothing wraps, saturates or turns infinite unseen.
pub trait Cost: Copy + PartialOrd + std::fmt::Debug + Send + Sync + 'static {
    /// Orders like the costs themselves, and totally.
    type Key: Ord + Copy + std::fmt::Debug + Send + Sync;
    /// The cost of staying.
    const ZERO: Self;
    /// The cost-to-go where there is no way.
    const UNREACHABLE: Self;
    /// Name of the type, for messages.
    const NAME: &'static str;

    /// The sum, rounded once; None if it is too large.
    fn plus(self, other: Self) -> Option<Self>;
    /// The integer that orders like this cost (not NaN, not negative).
    fn key(self) -> Self::Key;
    /// The nearest f64; infinity for `UNREACHABLE`.
    fn to_f64(self) -> f64;
    /// Whether it is NaN.
    fn is_nan(self) -> bool;
    /// Whether `links` times this cost is sure to be less than `UNREACHABLE` however it is summed.
    fn fits(self, links: usize) -> bool;
}

macro_rules! integer_cost {
    ($type:ident) => {
        impl Cost for $type {
            type Key = $type;
            const ZERO: Self = 0;
            const UNREACHABLE: Self = $type::MAX;
            const NAME: &'static str = stringify!($type);

            #[inline]
            fn plus(self, other: Self) -> Option<Self> {
                self.checked_add(other).filter(|&sum| sum != Self::UNREACHABLE)
            }
            #[inline]
            fn key(self) -> Self::Key {
                self
            }
            #[inline]
            fn to_f64(self) -> f64 {
                if self == Self::UNREACHABLE { f64::INFINITY } else { self as f64 }
            }
            fn is_nan(self) -> bool {
                false
            }
            fn fits(self, links: usize) -> bool {
                (self as u128).checked_mul(links as u128).is_some_and(|most| most < Self::UNREACHABLE as u128)
            }
        }
    };
}

macro_rules! float_cost {
    ($type:ident, $bits:ident) => {
        impl Cost for $type {
            type Key = $bits;
            const ZERO: Self = 0.0;
            const UNREACHABLE: Self = $type::INFINITY;
            const NAME: &'static str = stringify!($type);

            #[inline]
            fn plus(self, other: Self) -> Option<Self> {
                let sum = self + other;
                sum.is_finite().then_some(sum)
            }
            #[inline]
            fn key(self) -> Self::Key {
                self.to_bits() // the bits of floats >= +0 order like the floats
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            fn is_nan(self) -> bool {
                $type::is_nan(self)
            }
            fn fits(self, links: usize) -> bool {
                // Each rounded add grows a sum by at most 1 + EPSILON; half the range covers 2^23 of them.
                f64::from(self) * links as f64 <= f64::from($type::MAX) * 0.5
            }
        }
    };
}

integer_cost!(u32);
integer_cost!(u64);
float_cost!(f32, u32);
float_cost!(f64, u64);
