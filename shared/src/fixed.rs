//! 32-bit fixed point for boards without a floating-point unit.
//!
//! A number is an `i32` counted in units of 2^-FRAC, so its range is +-2^(31-FRAC). Products are
//! formed in 64 bits and rounded to nearest; sums and products saturate instead of wrapping, so an
//! overload shows as a flat top and never as a sign change.
//! The motor fits into this range in per-unit scaling: see `step::Units`.

use crate::scalar::Scalar;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A fixed-point number with `FRAC` fractional bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fixed<const FRAC: u32>(pub i32);

impl<const FRAC: u32> Fixed<FRAC> {
    /// The step between neighbouring numbers.
    pub const RESOLUTION: f64 = 1.0 / (1_u64 << FRAC) as f64;

    /// The value as a float.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        f64::from(self.0) * Self::RESOLUTION
    }

    #[inline(always)]
    fn saturated(wide: i64) -> Self {
        Self(wide.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32)
    }
}

impl<const FRAC: u32> Add for Fixed<FRAC> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}
impl<const FRAC: u32> Sub for Fixed<FRAC> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}
impl<const FRAC: u32> Mul for Fixed<FRAC> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let wide = i64::from(self.0) * i64::from(other.0);
        Self::saturated((wide + (1_i64 << (FRAC - 1))) >> FRAC)
    }
}
impl<const FRAC: u32> Div for Fixed<FRAC> {
    type Output = Self;
    /// A zero divisor saturates towards the sign of the dividend.
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        if other.0 == 0 {
            return Self(if self.0 < 0 { i32::MIN } else { i32::MAX });
        }
        Self::saturated((i64::from(self.0) << FRAC) / i64::from(other.0))
    }
}
impl<const FRAC: u32> Neg for Fixed<FRAC> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.saturating_neg())
    }
}
impl<const FRAC: u32> AddAssign for Fixed<FRAC> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
impl<const FRAC: u32> SubAssign for Fixed<FRAC> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<const FRAC: u32> Scalar for Fixed<FRAC> {
    type Element = Self;
    #[inline(always)]
    fn lit(x: f64) -> Self {
        let units = x * (1_u64 << FRAC) as f64;
        // `as` saturates, which is what an out-of-range literal should do.
        Self((if units < 0.0 { units - 0.5 } else { units + 0.5 }) as i32)
    }
    #[inline(always)]
    fn splat(x: Self) -> Self {
        x
    }
    /// One rounding for product and sum together.
    #[inline(always)]
    fn mul_add(self, m: Self, a: Self) -> Self {
        let wide = i64::from(self.0) * i64::from(m.0) + (i64::from(a.0) << FRAC);
        Self::saturated((wide + (1_i64 << (FRAC - 1))) >> FRAC)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.saturating_abs())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }
    #[inline(always)]
    fn any_gt(a: Self, b: Self) -> bool {
        a.0 > b.0
    }
    #[inline(always)]
    fn pick_gt(a: Self, b: Self, x: Self, y: Self) -> Self {
        if a.0 > b.0 { x } else { y }
    }
    #[inline(always)]
    fn round(self) -> Self {
        let half = 1_i32 << (FRAC - 1);
        Self((self.0.saturating_add(half) >> FRAC) << FRAC)
    }
    #[inline(always)]
    fn look_back(table: &[Self], index: usize, back: Self) -> Self {
        let whole = (back.0.max(0) >> FRAC) as usize;
        let part = Self(back.0.max(0) & ((1 << FRAC) - 1));
        let at = |k: usize| table[index.saturating_sub(k).min(table.len() - 1)];
        at(whole) + part * (at(whole + 1) - at(whole))
    }
    #[inline(always)]
    fn map(self, f: fn(f64) -> f64) -> Self {
        Self::lit(f(self.to_f64()))
    }
    #[inline(always)]
    fn map_with(self, other: Self, f: fn(f64, f64) -> f64) -> Self {
        Self::lit(f(self.to_f64(), other.to_f64()))
    }
}

#[cfg(test)]
mod tests {
    use super::Fixed;
    use crate::scalar::Scalar;
    use proptest::prelude::*;

    type Q = Fixed<25>;

    proptest! {
        #[test]
        fn products_are_within_half_a_step_of_the_real_ones(a in -7.0_f64..7.0, b in -7.0_f64..7.0) {
            let (p, q) = (Q::lit(a), Q::lit(b));
            prop_assert!(((p * q).to_f64() - p.to_f64() * q.to_f64()).abs() <= 0.5 * Q::RESOLUTION);
            prop_assert!((p + q).to_f64() == p.to_f64() + q.to_f64());
        }

        #[test]
        fn division_undoes_multiplication(a in -7.0_f64..7.0, b in 0.2_f64..7.0) {
            let back = Q::lit(a) / Q::lit(b) * Q::lit(b);
            prop_assert!((back.to_f64() - a).abs() < 4e-7);
        }
    }

    #[test]
    fn overload_saturates_and_keeps_its_sign() {
        assert!((Q::lit(60.0) + Q::lit(60.0)).to_f64() > 63.9);
        assert!((Q::lit(-60.0) * Q::lit(60.0)).to_f64() < -63.9);
    }

    #[test]
    fn sine_keeps_its_digits() {
        for k in -300..300 {
            let turns = f64::from(k) * 0.01;
            let truth = libm::sin(turns * core::f64::consts::TAU);
            assert!((Q::lit(turns).sin_turns().to_f64() - truth).abs() < 4e-7);
        }
    }
}
