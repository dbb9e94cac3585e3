//! Access to the single numbers in a block.

use crate::lanes::Lanes;
use crate::scalar::Scalar;

/// A [`Scalar`] whose lanes can be filled from and read as `f64`: one candidate goes into each lane, and its
/// sum comes out.
pub trait Laned: Scalar {
    /// Number of lanes.
    const LANES: usize;
    /// Lane by lane, rounded to the element.
    fn from_lanes(value: impl FnMut(usize) -> f64) -> Self;
    /// The number in one lane, exactly.
    ///
    /// # Panics
    /// Where `lane` is not below [`Self::LANES`] in a block of several.
    fn lane(&self, lane: usize) -> f64;
}

macro_rules! single {
    ($($float:ty),*) => {$(
        impl Laned for $float {
            const LANES: usize = 1;
            #[inline(always)]
            fn from_lanes(mut value: impl FnMut(usize) -> f64) -> Self {
                value(0) as Self
            }
            #[inline(always)]
            fn lane(&self, _: usize) -> f64 {
                f64::from(*self)
            }
        }
    )*};
}
single!(f32, f64);

impl<T: Scalar<Element = T> + Into<f64>, const N: usize> Laned for Lanes<T, N> {
    const LANES: usize = N;
    #[inline(always)]
    fn from_lanes(mut value: impl FnMut(usize) -> f64) -> Self {
        Self(core::array::from_fn(|lane| T::lit(value(lane))))
    }
    #[inline(always)]
    fn lane(&self, lane: usize) -> f64 {
        self.0[lane].into()
    }
}
