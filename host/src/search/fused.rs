//! Single precision with fused multiply-add, for processors that have it in vectors.

use bytemuck::{Pod, Zeroable};
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};
use motorlens_shared::scalar::Scalar;

/// An `f32` whose `mul_add` rounds once.
///
/// A type of its own because `f32` must round twice, as the board does. Only where the target has the
/// instruction: elsewhere the fused operation is a slow library call.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default, Pod, Zeroable)]
#[repr(transparent)]
pub struct Fused32(pub f32);

impl From<Fused32> for f64 {
    #[inline(always)]
    fn from(x: Fused32) -> Self {
        Self::from(x.0)
    }
}

macro_rules! through_f32 {
    ($($trait:ident $method:ident),*) => {$(
        impl $trait for Fused32 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
    )*};
}
through_f32!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Fused32 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}
impl AddAssign for Fused32 {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}
impl SubAssign for Fused32 {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        self.0 -= other.0;
    }
}

impl Scalar for Fused32 {
    type Element = Self;

    #[inline(always)]
    fn lit(x: f64) -> Self {
        Self(x as f32)
    }
    #[inline(always)]
    fn splat(x: Self) -> Self {
        x
    }
    #[inline(always)]
    fn mul_add(self, m: Self, a: Self) -> Self {
        Self(self.0.mul_add(m.0, a.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(Scalar::min(self.0, other.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(Scalar::max(self.0, other.0))
    }
    #[inline(always)]
    fn any_gt(a: Self, b: Self) -> bool {
        a.0 > b.0
    }
    #[inline(always)]
    fn pick_gt(a: Self, b: Self, x: Self, y: Self) -> Self {
        Self(f32::pick_gt(a.0, b.0, x.0, y.0))
    }
    #[inline(always)]
    fn round(self) -> Self {
        Self(Scalar::round(self.0))
    }
    #[inline(always)]
    fn look_back(table: &[Self], index: usize, back: Self) -> Self {
        Self(f32::look_back(bytemuck::cast_slice(table), index, back.0))
    }
    #[inline(always)]
    fn map(self, f: fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }
    #[inline(always)]
    fn map_with(self, other: Self, f: fn(f64, f64) -> f64) -> Self {
        Self(self.0.map_with(other.0, f))
    }
}
