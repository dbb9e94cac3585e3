//! One source, compiled for several vector units, chosen when the program runs.

#![allow(unsafe_code, reason = "compiled for vector units that are asked for before they are used")]

use super::fused::Fused32;
use motorlens_shared::lanes::Lanes;
use motorlens_shared::linear::Laned;

/// Candidates that go through a kernel side by side, at every level.
pub const LANES: usize = 16;

/// The same in double precision.
pub const DOUBLES: usize = 4;

/// Sets of vector instructions that the kernels are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// What every processor of this architecture has: SSE2 on x86-64 (no fused multiply-add), NEON on aarch64.
    Baseline,
    /// x86-64 with AVX2 and fused multiply-add.
    Avx2,
    /// x86-64 with AVX-512 F, VL and DQ.
    Avx512,
}

/// Work that is the same text at every level.
///
/// [`Self::run`] and all that it calls must be `#[inline(always)]`, or the compiler builds it once, for the
/// baseline, and calls that.
pub trait Work {
    /// What it returns.
    type Output;
    /// Runs on blocks of [`LANES`] numbers in single precision, or [`DOUBLES`] in double.
    fn run<T: Laned<Element: bytemuck::Pod>>(self) -> Self::Output;
}

#[cfg(target_arch = "aarch64")]
type BaselineElement = Fused32;
#[cfg(not(target_arch = "aarch64"))]
type BaselineElement = f32;

impl Level {
    /// Whether this processor has it. The answer is cached by the standard library.
    #[must_use]
    pub fn present(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        let (fused, wide) = (
            is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512dq"),
        );
        #[cfg(not(target_arch = "x86_64"))]
        let (fused, wide) = (false, false);
        match self {
            Self::Baseline => true,
            Self::Avx2 => fused,
            Self::Avx512 => fused && wide,
        }
    }

    /// The levels that this processor has, widest first. Never empty.
    #[must_use]
    pub fn available() -> Vec<Self> {
        [Self::Avx512, Self::Avx2, Self::Baseline].into_iter().filter(|l| l.present()).collect()
    }

    /// The widest level of this processor.
    #[must_use]
    pub fn best() -> Self {
        Self::available()[0]
    }

    /// As printed in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Baseline => "baseline",
            Self::Avx2 => "AVX2+FMA",
            Self::Avx512 => "AVX-512",
        }
    }

    /// Runs `work` compiled for this level, or for the baseline where the processor lacks it.
    pub fn run<W: Work>(self, work: W) -> W::Output {
        #[cfg(target_arch = "x86_64")]
        if self != Self::Baseline && self.present() {
            // SAFETY: the processor has the features, as just asked.
            return match self {
                Self::Avx512 => unsafe { with_avx512(work) },
                _ => unsafe { with_avx2(work) },
            };
        }
        work.run::<Lanes<BaselineElement, LANES>>()
    }
}

impl Level {
    /// The same in double precision, for searches of a few candidates at a time.
    pub fn run_double<W: Work>(self, work: W) -> W::Output {
        #[cfg(target_arch = "x86_64")]
        if self != Self::Baseline && self.present() {
            // SAFETY: the processor has the features, as just asked.
            return unsafe { double_with_avx2(work) };
        }
        work.run::<Lanes<f64, DOUBLES>>()
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn double_with_avx2<W: Work>(work: W) -> W::Output {
    work.run::<Lanes<f64, DOUBLES>>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn with_avx2<W: Work>(work: W) -> W::Output {
    work.run::<Lanes<Fused32, LANES>>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2,fma")]
fn with_avx512<W: Work>(work: W) -> W::Output {
    work.run::<Lanes<Fused32, LANES>>()
}
