//! The exponential of a decay and the logarithm that tells when it ends, for numbers of every kind.

use crate::scalar::Scalar;

/// e^-x for x from 0, within 1e-5: the eighth power of its Pade approximant of order 2.
#[inline(always)]
pub(super) fn decay<S: Scalar>(x: S) -> S {
    // Beyond 16 the approximant would rise again.
    let z = S::lit(0.125) * x.min(S::lit(16.0));
    let even = (z * z).mul_add(S::lit(1.0 / 12.0), S::one());
    let odd = S::lit(0.5) * z;
    let root = (even - odd) / (even + odd);
    let square = root * root;
    let fourth = square * square;
    fourth * fourth
}

/// ln(1 + a / b) of a from 0 and b above, within 0.3 % up to a = 6 b and 2e-6 up to b: 2 artanh(a / (a + 2 b)), as its
/// Pade approximant of order 4.
#[inline(always)]
pub(super) fn ln_one_and<S: Scalar>(a: S, b: S) -> S {
    let z = a / (a + b + b);
    let zz = z * z;
    let over = z * zz.mul_add(S::lit(-110.0), S::lit(210.0));
    over / zz.mul_add(S::lit(9.0), S::lit(-90.0)).mul_add(zz, S::lit(105.0))
}

#[cfg(test)]
mod tests {
    use super::{decay, ln_one_and};

    #[test]
    fn it_is_the_exponential_as_exactly_as_stated() {
        for k in 0..4000 {
            let x = f64::from(k) * 0.01;
            assert!((decay(x) - libm::exp(-x)).abs() < 1e-5, "at {x}");
        }
    }

    #[test]
    fn the_logarithm_is_as_exact_as_stated() {
        for k in 1..600 {
            let x = f64::from(k) * 0.01;
            let bound = if x < 1.0 { 2e-6 } else { 3e-3 };
            assert!((ln_one_and(2.0 * x, 2.0) / libm::log1p(x) - 1.0).abs() < bound, "at {x}");
        }
    }
}
