//! A block of numbers that go through the model side by side, one candidate per lane.
//!
//! Plain arrays and loops: compiled for a vector unit (AVX2, AVX-512, NEON) they become vector
//! instructions without intrinsics.

use crate::scalar::Scalar;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// `N` numbers of kind `T`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(32))]
pub struct Lanes<T, const N: usize>(pub [T; N]);

// Loops instead of closures: a closure that is not inlined is compiled without the vector unit of its caller.
macro_rules! each_lane {
    ($first:ident, |$l:ident| $value:expr) => {{
        let mut result = $first;
        for $l in 0..N {
            result.0[$l] = $value;
        }
        result
    }};
}

macro_rules! lanewise {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<T: Scalar, const N: usize> $trait for Lanes<T, N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                each_lane!(self, |l| self.0[l] $op other.0[l])
            }
        }
    };
}
lanewise!(Add, add, +);
lanewise!(Sub, sub, -);
lanewise!(Mul, mul, *);
lanewise!(Div, div, /);

impl<T: Scalar, const N: usize> Neg for Lanes<T, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        each_lane!(self, |l| -self.0[l])
    }
}
impl<T: Scalar, const N: usize> AddAssign for Lanes<T, N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
impl<T: Scalar, const N: usize> SubAssign for Lanes<T, N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<T: Scalar<Element = T>, const N: usize> Scalar for Lanes<T, N> {
    type Element = T;
    #[inline(always)]
    fn lit(x: f64) -> Self {
        Self([T::lit(x); N])
    }
    #[inline(always)]
    fn splat(x: T) -> Self {
        Self([x; N])
    }
    #[inline(always)]
    fn mul_add(self, m: Self, a: Self) -> Self {
        each_lane!(self, |l| self.0[l].mul_add(m.0[l], a.0[l]))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        each_lane!(self, |l| self.0[l].abs())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        each_lane!(self, |l| self.0[l].min(other.0[l]))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        each_lane!(self, |l| self.0[l].max(other.0[l]))
    }
    #[inline(always)]
    fn any_gt(a: Self, b: Self) -> bool {
        let mut any = false;
        for l in 0..N {
            any |= T::any_gt(a.0[l], b.0[l]);
        }
        any
    }
    #[inline(always)]
    fn pick_gt(a: Self, b: Self, x: Self, y: Self) -> Self {
        each_lane!(x, |l| T::pick_gt(a.0[l], b.0[l], x.0[l], y.0[l]))
    }
    #[inline(always)]
    fn round(self) -> Self {
        each_lane!(self, |l| self.0[l].round())
    }
    #[inline(always)]
    fn look_back(table: &[T], index: usize, back: Self) -> Self {
        each_lane!(back, |l| T::look_back(table, index, back.0[l]))
    }
    #[inline(always)]
    fn map(self, f: fn(f64) -> f64) -> Self {
        each_lane!(self, |l| self.0[l].map(f))
    }
    #[inline(always)]
    fn map_with(self, other: Self, f: fn(f64, f64) -> f64) -> Self {
        each_lane!(self, |l| self.0[l].map_with(other.0[l], f))
    }
}

#[cfg(test)]
mod tests {
    use super::Lanes;
    use crate::scalar::Scalar;

    #[test]
    fn every_lane_computes_what_a_scalar_computes() {
        let a = Lanes([1.5_f64, -2.0, 0.25, 9.0]);
        let b = Lanes([0.5_f64, 3.0, -4.0, 9.0]);
        let r = Lanes::pick_gt(a, b, a.mul_add(b, a), (a / b).sin_turns());
        for l in 0..4 {
            let (x, y) = (a.0[l], b.0[l]);
            let truth = if x > y { x * y + x } else { (x / y).sin_turns() };
            assert_eq!(r.0[l], truth);
            assert_eq!(a.map(libm::exp).0[l], libm::exp(x));
            assert_eq!(a.map_with(b, libm::atan2).0[l], libm::atan2(x, y));
        }
    }
}
