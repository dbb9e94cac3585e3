//! The exponential of a decay, for numbers of every kind.

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

#[cfg(test)]
mod tests {
    use super::decay;

    #[test]
    fn it_is_the_exponential_as_exactly_as_stated() {
        for k in 0..4000 {
            let x = f64::from(k) * 0.01;
            assert!((decay(x) - libm::exp(-x)).abs() < 1e-5, "at {x}");
        }
    }
}
