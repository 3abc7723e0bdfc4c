//! Which instructions the solver uses.

use serde::{Deserialize, Serialize};

use super::lanes::{Lanes, TileCost};

/// Instruction sets that the grid solver has code for. Results do not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Simd {
    /// AVX-512 F, BW, VL and DQ.
    Avx512,
    /// AVX2.
    Avx2,
    /// What every processor of the architecture has.
    Portable,
}

impl Simd {
    /// Every level, the widest first.
    pub const ALL: [Self; 3] = [Self::Avx512, Self::Avx2, Self::Portable];

    /// Whether this processor has the instructions.
    pub fn is_available(self) -> bool {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512dq")
                    && Self::Avx2.is_available()
            }
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => {
                is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("bmi1")
                    && is_x86_feature_detected!("bmi2")
                    && is_x86_feature_detected!("lzcnt")
            }
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx512 | Self::Avx2 => false,
            Self::Portable => true,
        }
    }

    /// The widest level that this processor has.
    pub fn widest() -> Self {
        Self::ALL.into_iter().find(|level| level.is_available()).unwrap_or(Self::Portable)
    }
}

impl std::fmt::Display for Simd {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Avx512 => "avx512",
            Self::Avx2 => "avx2",
            Self::Portable => "portable",
        })
    }
}

/// Something to do with numbers side by side.
pub trait Job {
    /// The numbers.
    type Number: TileCost;
    /// What comes of it.
    type Result;
    /// Does it; must be inlined into its caller, which has the instructions of `L` enabled.
    ///
    /// # Safety
    /// The instructions of `L` are there and enabled.
    unsafe fn run<L: Lanes<Number = Self::Number>>(self) -> Self::Result;
}

/// Does a job at a level.
///
/// # Panics
/// If the processor does not have the level.
pub fn at_level<J: Job>(level: Simd, job: J) -> J::Result {
    assert!(level.is_available(), "{level:?} is not available on this processor");
    match level {
        // SAFETY: the level is available.
        #[cfg(target_arch = "x86_64")]
        Simd::Avx512 => unsafe { avx512(job) },
        #[cfg(target_arch = "x86_64")]
        Simd::Avx2 => unsafe { avx2(job) },
        // SAFETY: plain Rust.
        _ => unsafe { job.run::<<J::Number as TileCost>::Portable>() },
    }
}

/// Plain loops over arrays; `run`, and what it calls, must be `#[inline(always)]`, so that they are compiled
/// for the instructions there are.
pub trait Loops {
    /// What comes of them.
    type Result;
    /// Does them.
    fn run(self) -> Self::Result;
}

/// Does loops at the widest level that this processor has.
pub fn at_widest<J: Loops>(loops: J) -> J::Result {
    at_level(Simd::widest(), Wide(loops))
}

struct Wide<J>(J);

impl<J: Loops> Job for Wide<J> {
    type Number = f32;
    type Result = J::Result;

    #[inline(always)]
    unsafe fn run<L: Lanes<Number = f32>>(self) -> J::Result {
        self.0.run()
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx2,bmi1,bmi2,lzcnt,popcnt")]
fn avx512<J: Job>(job: J) -> J::Result {
    // SAFETY: enabled here.
    unsafe { job.run::<<J::Number as TileCost>::Avx512>() }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn avx2<J: Job>(job: J) -> J::Result {
    // SAFETY: enabled here.
    unsafe { job.run::<<J::Number as TileCost>::Avx2>() }
}
