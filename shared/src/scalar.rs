//! The numbers the model runs on.
//!
//! One source text of the motor runs as `f64` (reference), `f32` (the board), 32-bit fixed point
//! ([`crate::fixed::Fixed`], boards without a floating-point unit) and as a block of lanes
//! ([`crate::lanes::Lanes`], the host's vector units, one candidate per lane).
//! That works because the model is branch-free: every choice is a [`Scalar::pick_gt`], `min` or `max`.

use core::f64::consts::SQRT_2;
use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A number, or a block of numbers that go through the same steps.
pub trait Scalar:
    Copy
    + Debug
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + Send
    + Sync
    + 'static
{
    /// What one lane holds; recorded data is kept as a slice of these and spread over the lanes.
    type Element: Scalar;

    /// The representable number nearest to `x`, in every lane.
    fn lit(x: f64) -> Self;
    /// The same element in every lane.
    fn splat(x: Self::Element) -> Self;
    /// `self * m + a`. Fused only where the type says so, so that `f32` gives the same bits on the
    /// board as on the host.
    fn mul_add(self, m: Self, a: Self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// The smaller of two numbers.
    fn min(self, other: Self) -> Self;
    /// The larger of two numbers.
    fn max(self, other: Self) -> Self;
    /// `x` where `a > b`, else `y`.
    fn pick_gt(a: Self, b: Self, x: Self, y: Self) -> Self;
    /// Whether `a > b` in any lane: to skip what no lane needs, which leaves every lane its own result.
    fn any_gt(a: Self, b: Self) -> bool;
    /// The nearest integer (ties either way).
    fn round(self) -> Self;
    /// Element of `table` at `index - back`, linearly interpolated; ends are held.
    /// `back` is 0 or more, in samples, and differs by lane.
    fn look_back(table: &[Self::Element], index: usize, back: Self) -> Self;
    /// `f` of every lane, in double precision: for functions that the model itself does not need.
    fn map(self, f: fn(f64) -> f64) -> Self;
    /// `f` of every lane and its partner in `other`.
    fn map_with(self, other: Self, f: fn(f64, f64) -> f64) -> Self;

    /// The number of a cell of the voltage grid: known before a run, but not to a number that only writes down what is
    /// computed with it.
    #[inline(always)]
    fn count(index: usize) -> Self {
        Self::lit(index as f64)
    }
    /// Zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::lit(0.0)
    }
    /// One.
    #[inline(always)]
    fn one() -> Self {
        Self::lit(1.0)
    }
    /// Limited to `low ..= high`.
    #[inline(always)]
    fn clamp(self, low: Self, high: Self) -> Self {
        self.max(low).min(high)
    }
    /// Moved towards zero by `by`, and not past it: the solution of set-valued dry friction.
    #[inline(always)]
    fn shrink(self, by: Self) -> Self {
        self - self.clamp(-by, by)
    }
    /// sqrt(self^2 + other^2) where either is not 0, within 2e-8 of itself; its squares are never formed, which fixed point
    /// could not hold.
    #[inline(always)]
    fn hypot(self, other: Self) -> Self {
        let (one, half) = (Self::one(), Self::lit(0.5));
        let (a, b) = (self.abs(), other.abs());
        let (long, short) = (a.max(b), a.min(b));
        let ratio = short / long;
        let square = ratio * ratio;
        // A chord of sqrt(1 + square), shifted to half its error, and two rounds of Heron's.
        let chord = square.mul_add(Self::lit(SQRT_2 - 1.0), Self::lit(1.009));
        let sum = one + square;
        let nearer = half * (chord + sum / chord);
        long * (half * (nearer + sum / nearer))
    }
    /// -1, 0 or 1.
    #[inline(always)]
    fn sign(self) -> Self {
        let zero = Self::zero();
        Self::pick_gt(self, zero, Self::one(), Self::pick_gt(zero, self, -Self::one(), zero))
    }
    /// Sine of an angle in turns (1 = a whole revolution); error below 4e-9.
    ///
    /// Odd polynomial on a quarter turn (Taylor series to the 13th power, Horner form).
    #[inline(always)]
    fn sin_turns(self) -> Self {
        let x = self - self.round(); // -0.5 ..= 0.5
        let quarter = Self::lit(0.25);
        // Fold the outer quarters back: sin(pi - a) = sin(a).
        let folded =
            Self::pick_gt(x, quarter, Self::lit(0.5) - x, Self::pick_gt(-x, quarter, Self::lit(-0.5) - x, x));
        // In quarter turns, so that every power stays within one: fixed point keeps its digits.
        let q = folded * Self::lit(4.0);
        let s = q * q;
        let mut p = Self::lit(5.692_172_921_967_923e-8);
        for c in [
            -3.598_843_235_212_084e-6,
            1.604_411_847_873_598_2e-4,
            -4.681_754_135_318_687e-3,
            7.969_262_624_616_703e-2,
            -0.645_964_097_506_246_2,
            core::f64::consts::FRAC_PI_2,
        ] {
            p = p.mul_add(s, Self::lit(c));
        }
        q * p
    }
    /// Cosine of an angle in turns.
    #[inline(always)]
    fn cos_turns(self) -> Self {
        (self + Self::lit(0.25)).sin_turns()
    }
}

macro_rules! float_scalar {
    ($float:ty, $magic:expr) => {
        impl Scalar for $float {
            type Element = Self;
            #[inline(always)]
            fn lit(x: f64) -> Self {
                x as Self
            }
            #[inline(always)]
            fn splat(x: Self) -> Self {
                x
            }
            #[inline(always)]
            fn mul_add(self, m: Self, a: Self) -> Self {
                self * m + a
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn any_gt(a: Self, b: Self) -> bool {
                a > b
            }
            #[inline(always)]
            fn pick_gt(a: Self, b: Self, x: Self, y: Self) -> Self {
                if a > b { x } else { y }
            }
            /// Adding 1.5 x 2^(mantissa bits) leaves no room for a fraction; it vectorises everywhere.
            #[inline(always)]
            fn round(self) -> Self {
                (self + $magic) - $magic
            }
            #[inline(always)]
            fn look_back(table: &[Self], index: usize, back: Self) -> Self {
                let whole = back as usize;
                let part = back - whole as Self;
                let last = table.len() - 1;
                let newer = table[index.saturating_sub(whole).min(last)];
                let older = table[index.saturating_sub(whole + 1).min(last)];
                newer + part * (older - newer)
            }
            #[inline(always)]
            fn map(self, f: fn(f64) -> f64) -> Self {
                f(f64::from(self)) as Self
            }
            #[inline(always)]
            fn map_with(self, other: Self, f: fn(f64, f64) -> f64) -> Self {
                f(f64::from(self), f64::from(other)) as Self
            }
        }
    };
}
float_scalar!(f64, 6_755_399_441_055_744.0);
float_scalar!(f32, 12_582_912.0);

#[cfg(test)]
mod tests {
    use super::Scalar;

    #[test]
    fn sine_in_turns_agrees_with_libm_over_many_revolutions() {
        for k in -4000..4000 {
            let turns = f64::from(k) * 0.001_7;
            let truth = libm::sin(turns * core::f64::consts::TAU);
            assert!((turns.sin_turns() - truth).abs() < 4e-9, "at {turns} turns");
            let truth = libm::cos(turns * core::f64::consts::TAU);
            assert!((turns.cos_turns() - truth).abs() < 4e-9, "at {turns} turns");
        }
    }

    #[test]
    fn hypot_is_the_root_of_the_squares_whichever_is_the_longer() {
        for k in -300..300 {
            let (a, b) = (f64::from(k) * 0.01, 1.3);
            for got in [Scalar::hypot(a, b), Scalar::hypot(b, a), Scalar::hypot(-b, a)] {
                assert!((got / libm::hypot(a, b) - 1.0).abs() < 2e-8, "at {a}: {got}");
            }
        }
    }

    #[test]
    fn shrink_is_the_soft_threshold() {
        assert_eq!(Scalar::shrink(3.0_f64, 1.0), 2.0);
        assert_eq!(Scalar::shrink(-3.0_f64, 1.0), -2.0);
        assert_eq!(Scalar::shrink(0.4_f64, 1.0), 0.0);
    }

    #[test]
    fn look_back_interpolates_and_holds_the_ends() {
        let table = [1.0_f64, 2.0, 4.0];
        assert_eq!(f64::look_back(&table, 2, 0.0), 4.0);
        assert_eq!(f64::look_back(&table, 2, 0.5), 3.0);
        assert_eq!(f64::look_back(&table, 2, 7.5), 1.0);
    }
}
