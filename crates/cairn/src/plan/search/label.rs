use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use crate::plan::Cost;

/// How wide the buckets of the queue are: costs within one are settled together.
#[derive(Clone, Copy, Debug)]
pub struct Width {
    shift: u32,
    per_unit: f64,
}

impl Width {
    /// Buckets about as wide as `width`: the greatest power of two not above it for integers, at least 1.
    pub fn about(width: f64) -> Self {
        let shift = if width >= 1.0 { (width.log2() as u32).min(63) } else { 0 };
        let per_unit = 1.0 / width;
        Self { shift, per_unit: if per_unit.is_finite() { per_unit } else { 1.0 } }
    }
}

/// A cost that the search can queue, and share between threads.
pub trait Label: Cost {
    /// One that several threads lower.
    type Shared: Sync + Send;

    /// The number of the bucket; never falls as the cost grows.
    fn bucket(self, width: Width) -> u64;
    /// This cost, shared.
    fn shared(self) -> Self::Shared;
    /// What it is now.
    fn load(shared: &Self::Shared) -> Self;
    /// Makes it the lesser of the two; true if `self` was less.
    fn lower(self, shared: &Self::Shared) -> bool;
}

macro_rules! label {
    ($type:ident, $atomic:ident, $to:expr, $from:expr, |$value:ident, $width:ident| $bucket:expr) => {
        impl Label for $type {
            type Shared = $atomic;

            #[inline]
            fn bucket(self, $width: Width) -> u64 {
                let $value = self;
                $bucket
            }
            #[inline]
            fn shared(self) -> $atomic {
                $atomic::new($to(self))
            }
            #[inline]
            fn load(shared: &$atomic) -> Self {
                $from(shared.load(Ordering::Relaxed))
            }
            #[inline]
            fn lower(self, shared: &$atomic) -> bool {
                // Keys order like the costs, so that the least key is the least cost.
                let key = $to(self);
                key < shared.load(Ordering::Relaxed) && key < shared.fetch_min(key, Ordering::Relaxed)
            }
        }
    };
}

label!(u32, AtomicU32, |cost| cost, |key| key, |value, width| u64::from(
    value.checked_shr(width.shift).unwrap_or(0)
));
label!(u64, AtomicU64, |cost| cost, |key| key, |value, width| value >> width.shift);
// A cast of floats saturates: what is beyond the last bucket is in it.
label!(f32, AtomicU32, f32::to_bits, f32::from_bits, |value, width| (f64::from(value) * width.per_unit)
    as u64);
label!(f64, AtomicU64, f64::to_bits, f64::from_bits, |value, width| (value * width.per_unit) as u64);
