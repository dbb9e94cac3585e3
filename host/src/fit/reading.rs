//! How much one reading scatters, from the readings alone.

use super::grid::Quantity;

/// Standard deviation of one reading: of the counting where an encoder counts, else of its fast scatter, and at least of its rounding.
///
/// The scatter is a robust one of second differences, which smooth motion does not have.
pub fn reading_noise(quantity: Quantity, y: &[f64], quantum: f64) -> f64 {
    let counting = quantum / 12.0_f64.sqrt();
    // An angle is counted; the digits of a speed are those of its writing.
    if quantity == Quantity::Angle && quantum > 0.0 {
        return counting;
    }
    let mut d: Vec<f64> = y.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).collect();
    d.sort_by(f64::total_cmp);
    let range = y.iter().fold(f64::MIN, |a, b| a.max(*b)) - y.iter().fold(f64::MAX, |a, b| a.min(*b));
    let median = d.get(d.len() / 2).copied().unwrap_or(0.0);
    (median / (0.6745 * 6.0_f64.sqrt())).max(counting).max(1e-5 * range).max(1e-9)
}

/// Orders of the differences from which the fast scatter is taken.
const ORDERS: std::ops::RangeInclusive<usize> = 2..=6;

/// What is white in `y`: the least that differences of several orders tell, since smooth motion fades from order to order and white noise
/// does not (difference-based estimate of variance: P. Hall, J. Kay, D. Titterington, *Biometrika* 77, 1990). Robust, by the median.
pub fn fast_scatter(y: &[f64]) -> f64 {
    let mut d = y.to_vec();
    let mut energy = 1.0;
    let mut least = f64::INFINITY;
    for order in 1..=*ORDERS.end() {
        d = d.windows(2).map(|w| w[1] - w[0]).collect();
        // The sum of the squares of the binomial coefficients of `order`.
        energy *= (4 * order - 2) as f64 / order as f64;
        let mut sizes: Vec<f64> = d.iter().map(|d| d.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        if let (true, Some(median)) = (ORDERS.contains(&order), sizes.get(sizes.len() / 2)) {
            least = least.min(median / (0.6745 * energy.sqrt()));
        }
    }
    if least.is_finite() { least } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fast_scatter_is_that_of_white_noise_and_none_of_smooth_motion_or_of_decimals() {
        let mut seed = 7_u32;
        let mut noise = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        };
        let smooth: Vec<f64> = (0..4000).map(|k| 10.0 * (0.05 * f64::from(k)).sin()).collect();
        let noisy: Vec<f64> = smooth.iter().map(|y| y + noise()).collect();
        let written: Vec<f64> = noisy.iter().map(|y| (y * 1e4).round() / 1e4).collect();
        let expected = 1.0 / 12.0_f64.sqrt();
        for y in [&noisy, &written] {
            let ratio = fast_scatter(y) / expected;
            assert!((0.7..1.5).contains(&ratio), "{ratio}");
        }
        assert!(fast_scatter(&smooth) < 1e-4, "{}", fast_scatter(&smooth));
        assert_eq!(fast_scatter(&[1.0]), 0.0);
    }
}
