//! The error of a simulation by time scale: a wavelet transform by lifting.
//!
//! A logged error is coloured: counting is white, a disturbance torque makes it wander, a wrong equation shows at the scale of the
//! motion it spoils. On wavelet coefficients such noise is nearly uncorrelated, so that one variance a scale whitens it
//! (G. Wornell, *Signal Processing with Fractals*, 1996, ch. 3; D. Percival and A. Walden, *Wavelet Methods for Time Series
//! Analysis*, 2000, ch. 9). A least-squares sum with these weights sees every horizon from two samples to the whole record.
//!
//! A wavelet with R vanishing moments does that for spectra up to f^-(2 R + 1). A disturbance torque makes an angle wander by f^-4 and
//! steeper, where Haar's one moment lets every coefficient of every scale show the same slow drift. So what the averages beside a pair
//! foresee of its difference is taken off (average interpolation, three moments: W. Sweldens, *SIAM Journal on Mathematical Analysis*
//! 29, 1998). That is a triangular map of determinant one: likelihoods need no correction, and white noise stays nearly white.

use motorlens_shared::scalar::Scalar;

use super::grid::{Grid, Quantity};

/// Weight of the plain simulation error beside the error by time scale while effects are chosen: what a disturbance makes of a long run
/// must not hide them.
pub const CHOOSING: f64 = 0.1;
/// The same for the model that is kept: a model is there to simulate.
pub const KEEPING: f64 = 1.0;

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

/// Appends its coefficients to `series`, level after level from the finest; the last number is the mean times the root of the length
/// (nearly so where the length is no power of two). What is quadratic in time leaves nothing but at the coarsest levels.
#[inline(always)]
pub fn append_coefficients<S: Scalar>(series: &mut Vec<S>) {
    let mut n = series.len();
    // A level rounds up by one at most.
    series.reserve(n + usize::BITS as usize);
    if n < 2 {
        series.extend_from_within(..);
        return;
    }
    // The first level reads the series itself: an hour's log is not copied.
    let mut smooth: Vec<S> = Vec::with_capacity(n.div_ceil(2));
    let first = series.len();
    for k in 0..n.div_ceil(2) {
        let (difference, sum) = split(series[(2 * k).min(n - 2)], series[(2 * k + 1).min(n - 1)]);
        series.push(difference);
        smooth.push(sum);
    }
    take_off_foreseen(&mut series[first..], &smooth, n / 2);
    while smooth.len() >= 2 {
        n = smooth.len();
        let first = series.len();
        for k in 0..n.div_ceil(2) {
            let (difference, sum) = split(smooth[(2 * k).min(n - 2)], smooth[(2 * k + 1).min(n - 1)]);
            series.push(difference);
            smooth[k] = sum;
        }
        smooth.truncate(n.div_ceil(2));
        take_off_foreseen(&mut series[first..], &smooth, n / 2);
    }
    series.extend(smooth);
}

/// Difference and sum of a pair, over the root of two.
#[inline(always)]
fn split<S: Scalar>(a: S, b: S) -> (S, S) {
    let half = S::lit(std::f64::consts::FRAC_1_SQRT_2);
    ((b - a) * half, (a + b) * half)
}

/// Takes off the differences within pairs what the pairs' `sums` foresee of them.
#[inline(always)]
fn take_off_foreseen<S: Scalar>(differences: &mut [S], sums: &[S], whole: usize) {
    for (k, difference) in differences.iter_mut().enumerate() {
        if let Some(foreseen) = foreseen(sums, whole, k) {
            *difference -= foreseen;
        }
    }
}

/// What the sums `s` of pairs foresee of the difference within pair `k`, by a parabola; the first `whole` pairs lie side by side, one more
/// overlaps the last of them by half. None where there are too few.
#[inline(always)]
fn foreseen<S: Scalar>(s: &[S], whole: usize, k: usize) -> Option<S> {
    match (whole, k) {
        (0 | 1, _) => None,
        (2, 0 | 1) => Some((s[1] - s[0]) * S::lit(0.25)),
        (2, _) => None,
        (_, 0) => Some(weighted(s, [(0, -0.375), (1, 0.5), (2, -0.125)])),
        (m, k) if k + 1 == m => Some(weighted(s, [(m - 1, 0.375), (m - 2, -0.5), (m - 3, 0.125)])),
        (m, k) if k == m => Some(weighted(s, [(m - 1, 0.5), (m - 2, -0.75), (m - 3, 0.25)])),
        (_, k) => Some((s[k + 1] - s[k - 1]) * S::lit(0.125)),
    }
}

#[inline(always)]
fn weighted<S: Scalar>(s: &[S], terms: [(usize, f64); 3]) -> S {
    let mut sum = S::zero();
    for (at, share) in terms {
        sum = s[at].mul_add(S::lit(share), sum);
    }
    sum
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
        if self.even > 0.0 { self.even } else { CHOOSING.sqrt() / self.sigma }
    }

    /// How far the mean of an angle's error may be from zero at no cost, rad: an encoder begins anywhere within a count.
    pub fn offset(&self) -> f64 {
        self.quantum
    }

    /// Whether the mean of the error counts: of an angle it does not, since an encoder starts anywhere.
    pub fn mean_counts(&self) -> bool {
        self.quantity != Quantity::Angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transformed(mut series: Vec<f64>) -> Vec<f64> {
        let n = series.len();
        append_coefficients(&mut series);
        series.split_off(n)
    }

    #[test]
    fn what_is_quadratic_in_time_leaves_nothing_at_levels_of_three_pairs_and_more() {
        for n in [64, 65, 100, 127] {
            let t = |k: i32| f64::from(k) / f64::from(n);
            let parabola = (0..n).map(|k| 3.0 - 2.0 * t(k) + 5.0 * t(k).powi(2)).collect();
            let sizes = levels(n as usize);
            let series = transformed(parabola);
            // Of an odd number the last pair overlaps: below it only the first level is exact.
            let fine = if n == 64 { 64 - 4 } else { sizes[0] };
            let most = series[..fine].iter().fold(0.0_f64, |most, d| most.max(d.abs()));
            assert!(most < 1e-9, "{n}: {most}");
        }
    }

    #[test]
    fn white_noise_stays_nearly_white() {
        let mut seed = 7_u32;
        let mut noise = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        };
        let series = transformed((0..4096).map(|_| noise()).collect());
        let mut first = 0;
        for size in levels(4096).into_iter().take_while(|size| *size >= 128) {
            let level = &series[first..first + size];
            let variance = level.iter().map(|d| d * d).sum::<f64>() / size as f64 * 12.0;
            let together = level.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / size as f64 * 12.0;
            assert!((0.7..1.4).contains(&variance) && together.abs() < 0.25, "{size}: {variance} {together}");
            first += size;
        }
    }

    #[test]
    fn every_level_of_any_length_has_the_coefficients_that_are_announced() {
        for n in [2, 3, 5, 63, 64, 65, 1000] {
            let series = transformed(vec![1.0; n]);
            assert_eq!(series.len(), levels(n).iter().sum::<usize>() + 1, "{n}");
            let details = &series[..series.len() - 1];
            assert!(details.iter().all(|d: &f64| d.abs() < 1e-12), "a constant has no details: {n}");
        }
    }
}
