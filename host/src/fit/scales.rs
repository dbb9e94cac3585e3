//! The error of a simulation by time scale: an orthonormal Haar wavelet transform.
//!
//! A logged error is coloured: counting is white, a disturbance torque makes it wander, a wrong law shows at the scale of the
//! motion it spoils. On wavelet coefficients such noise is nearly uncorrelated, so that one variance a scale whitens it
//! (G. Wornell, *Signal Processing with Fractals*, 1996, ch. 3; D. Percival and A. Walden, *Wavelet Methods for Time Series
//! Analysis*, 2000, ch. 9). A least-squares sum with these weights sees every horizon from two samples to the whole record.

use motorlens_shared::scalar::Scalar;

use super::grid::{Grid, Quantity};

/// How many coefficients each level of a series of `samples` has, finest first. Level `j` (from 0) spans 2^(j+1) samples; an odd
/// sample at the end shares its neighbour.
pub fn levels(samples: usize) -> Vec<usize> {
    let mut left = samples;
    let mut sizes = Vec::new();
    while left >= 2 {
        left = left.div_ceil(2);
        sizes.push(left);
    }
    sizes
}

/// Replaces `series` by its coefficients, level after level from the finest; its last number is the mean times the root of the
/// length (nearly so where the length is no power of two).
#[inline(always)]
pub fn transform<S: Scalar>(series: &mut Vec<S>) {
    let half = S::lit(std::f64::consts::FRAC_1_SQRT_2);
    let mut smooth = std::mem::take(series);
    // A level rounds up by one at most.
    series.reserve(smooth.len() + usize::BITS as usize);
    while smooth.len() >= 2 {
        let n = smooth.len();
        let pairs = n.div_ceil(2);
        for k in 0..pairs {
            let (a, b) = (smooth[(2 * k).min(n - 2)], smooth[(2 * k + 1).min(n - 1)]);
            series.push((b - a) * half);
            smooth[k] = (a + b) * half;
        }
        smooth.truncate(pairs);
    }
    series.extend(smooth);
}

impl Grid {
    /// Weight of the coefficients of each level, 1 / (unit of the record): the inverse of the noise at that scale where it is known,
    /// else of one reading's.
    pub fn weights(&self) -> Vec<f64> {
        let count = levels(self.len()).len();
        let known = |j: usize| self.scales.get(j).or(self.scales.last()).copied();
        (0..count).map(|j| known(j).unwrap_or(1.0 / self.sigma)).collect()
    }

    /// Weight of the plain simulation error, 1 / (unit of the record).
    pub fn even_weight(&self) -> f64 {
        if self.even > 0.0 { self.even } else { 1.0 / self.sigma }
    }

    /// Whether the mean of the error counts: of an angle it does not, since an encoder starts anywhere.
    pub fn mean_counts(&self) -> bool {
        self.quantity != Quantity::Angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transform_keeps_the_energy_of_a_series() {
        let series: Vec<f64> = (0..64).map(|k| (0.3 * f64::from(k)).sin() + 0.2).collect();
        let mut coefficients = series.clone();
        transform(&mut coefficients);
        let energy = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        assert_eq!(coefficients.len(), series.len());
        assert!((energy(&coefficients) / energy(&series) - 1.0).abs() < 1e-12);
        let mean = series.iter().sum::<f64>() / 64.0;
        assert!((coefficients[63] / 8.0 - mean).abs() < 1e-12);
    }

    #[test]
    fn every_level_of_any_length_has_the_coefficients_that_are_announced() {
        for n in [2, 3, 5, 63, 64, 65, 1000] {
            let mut series = vec![1.0; n];
            transform(&mut series);
            assert_eq!(series.len(), levels(n).iter().sum::<usize>() + 1, "{n}");
            let details = &series[..series.len() - 1];
            assert!(details.iter().all(|d: &f64| d.abs() < 1e-12), "a constant has no details: {n}");
        }
    }
}
