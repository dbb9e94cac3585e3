//! How much one reading scatters, from the readings alone.

use nalgebra::{DMatrix, DVector};

use super::grid::{Grid, Quantity};
use crate::log::motion::span;

/// Standard deviation of one reading: of the counting where an encoder counts, else of its fast scatter, and at least of its rounding.
///
/// The scatter is a robust one of second differences, which smooth motion does not have.
pub fn reading_noise(quantity: Quantity, y: &[f64], quantum: f64) -> f64 {
    let counting = quantum / 12.0_f64.sqrt();
    // An angle is counted; the digits of a speed are those of its writing.
    if quantity == Quantity::Angle && quantum > 0.0 {
        return counting;
    }
    let second: Vec<f64> = y.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2]).collect();
    (robust(&second).unwrap_or(0.0) / 6.0_f64.sqrt()).max(least_noise(y, quantum))
}

/// The least that the readings `y` may scatter by: their counting or rounding to a `quantum`, and the digits that a number has.
pub fn least_noise(y: &[f64], quantum: f64) -> f64 {
    (quantum / 12.0_f64.sqrt()).max(1e-5 * span(y)).max(1e-9)
}

/// Orders of the differences from which the fast scatter is taken: of readings that a filter may have made, which leaves ever less of its noise in
/// higher ones, and of an angle that is counted.
const ORDERS: [std::ops::RangeInclusive<usize>; 2] = [2..=2, 2..=6];
/// Readings before each whose voltages may have moved it, and readings for each of them that it takes to tell by how much.
const VOLTAGES: usize = 12;
const PER_VOLTAGE: usize = 10;
/// So many differences, evenly over the record, tell it well enough.
const DIFFERENCES: usize = 20_000;

/// What is white in the readings of `grid`: the least that differences of several orders tell, since smooth motion fades from order to order and
/// white noise does not (difference-based estimate of variance: P. Hall, J. Kay, D. Titterington, *Biometrika* 77, 1990). Robust, by the median.
///
/// Where readings are as slow as the motor a new voltage moves it within one or two, which no difference takes for smooth: from each difference
/// what the voltages before foresee of it is taken (a finite impulse response by least squares), and the smaller scatter counts.
pub fn fast_scatter(grid: &Grid) -> f64 {
    let is_counted = grid.quantity == Quantity::Angle && grid.quantum > 0.0;
    scatter(&grid.measured, &grid.sample_voltages(), &ORDERS[usize::from(is_counted)])
}

fn scatter(y: &[f64], voltages: &[f64], orders: &std::ops::RangeInclusive<usize>) -> f64 {
    let mut d = y.to_vec();
    let mut energy = 1.0;
    let mut least = f64::INFINITY;
    for order in 1..=*orders.end() {
        d = d.windows(2).map(|w| w[1] - w[0]).collect();
        // The sum of the squares of the binomial coefficients of `order`.
        energy *= (4 * order - 2) as f64 / order as f64;
        if orders.contains(&order) {
            let plain = robust(&d);
            let unforeseen = unforeseen(&d, &voltages[order.min(voltages.len())..]);
            let scatter = plain.into_iter().chain(unforeseen).fold(f64::INFINITY, f64::min);
            least = least.min(scatter / energy.sqrt());
        }
    }
    if least.is_finite() { least } else { 0.0 }
}

/// Standard deviation by the median of the sizes; none of nothing.
fn robust(d: &[f64]) -> Option<f64> {
    let mut sizes: Vec<f64> = d.iter().map(|d| d.abs()).collect();
    let middle = sizes.len() / 2;
    (!sizes.is_empty()).then(|| *sizes.select_nth_unstable_by(middle, f64::total_cmp).1 / 0.6745)
}

/// The same of what the last `voltages` do not foresee of the differences `d`, of which each ends with one; none where there are too few.
fn unforeseen(d: &[f64], voltages: &[f64]) -> Option<f64> {
    let lags = VOLTAGES.min(d.len() / PER_VOLTAGE);
    let all = d.len().checked_sub(lags).filter(|_| lags > 1)?;
    let taken = || (0..all).step_by(all.div_ceil(DIFFERENCES).max(1));
    let rows = taken().count();
    let row = |k: usize| voltages[k..=k + lags].iter().copied().chain([1.0]);
    let size = lags + 2;
    let (mut normal, mut right) = (DMatrix::zeros(size, size), DVector::zeros(size));
    for k in taken() {
        let row = DVector::from_iterator(size, row(k));
        normal.syger(1.0, &row, &row, 1.0);
        right.axpy(d[k + lags], &row, 1.0);
    }
    // Voltages that hardly change foresee nothing, each by itself.
    let ridge = 1e-9 * normal.trace() / size as f64;
    for k in 0..size {
        normal[(k, k)] += ridge;
    }
    normal.fill_upper_triangle_with_lower_triangle();
    let answer = normal.cholesky()?.solve(&right);
    let left: Vec<f64> =
        taken().map(|k| d[k + lags] - row(k).zip(answer.iter()).map(|(u, a)| u * a).sum::<f64>()).collect();
    let freedom = rows as f64 / rows.saturating_sub(size).max(1) as f64;
    robust(&left).map(|left| left * freedom.sqrt())
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
        let fast_scatter = |y: &[f64]| scatter(y, &vec![0.0; y.len()], &ORDERS[1]);
        for y in [&noisy, &written] {
            let ratio = fast_scatter(y) / expected;
            assert!((0.7..1.5).contains(&ratio), "{ratio}");
        }
        assert!(fast_scatter(&smooth) < 1e-4, "{}", fast_scatter(&smooth));
        assert_eq!(fast_scatter(&[1.0]), 0.0);
    }

    #[test]
    fn what_new_voltages_do_within_a_reading_is_no_scatter() {
        let mut seed = 7_u32;
        let mut noise = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        };
        // A motor as slow as its readings, under a random binary voltage.
        let voltages: Vec<f64> = (0..200).map(|_| if noise() > 0.0 { 12.0 } else { -12.0 }).collect();
        let run = voltages.iter().scan(0.0, |w, u| {
            *w += (1.0 - (-1.0_f64).exp()) * (u - *w);
            Some(*w)
        });
        let y: Vec<f64> = run.map(|w| w + 0.03 * noise()).collect();
        let expected = 0.03 / 12.0_f64.sqrt();
        let differences = scatter(&y, &vec![0.0; y.len()], &ORDERS[0]);
        assert!(differences > 50.0 * expected, "{differences}");
        let told = scatter(&y, &voltages, &ORDERS[0]);
        assert!((0.7..1.4).contains(&(told / expected)), "{told} for {expected}");
    }
}
