//! The clock of a record: interval, rate, jitter, and which of them a log may have.

use super::units::{Quantity, Unit};

/// Slower samples than this say nothing about a motor, s.
pub const SLOWEST_INTERVAL: f64 = 5.0;
/// Faster samples than this are not logged, s.
pub const FASTEST_INTERVAL: f64 = 1e-6;
/// The interval of most logs, in its order of magnitude, s.
const USUAL_INTERVAL: f64 = 5e-3;

/// Whether a motor may be logged at such an interval, s.
pub fn is_plausible(interval_s: f64) -> bool {
    (FASTEST_INTERVAL..=SLOWEST_INTERVAL).contains(&interval_s)
}

/// The unit of a time, as `--map` writes it, of which an interval of `interval` is plausible, and most usual of all; none where it is in no
/// unit.
pub fn plausible_unit(interval: f64) -> Option<&'static str> {
    let seconds =
        |unit: &str| Unit::parse(Quantity::Time, unit).map_or(f64::NAN, |unit| interval * unit.factor);
    let off = |unit: &str| (seconds(unit) / USUAL_INTERVAL).ln().abs();
    let units = ["s", "ms", "us", "ns"].into_iter().filter(|unit| is_plausible(seconds(unit)));
    units.min_by(|one, other| off(one).total_cmp(&off(other)))
}

/// Median of the differences of `time_s`, s; 0 for fewer than two samples.
pub fn median_interval(time_s: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    median(&mut steps)
}

/// Mean of the differences of `time_s`, s, of two samples or more.
pub fn mean_interval(time_s: &[f64]) -> f64 {
    (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64
}

/// Samples per second by the median interval; 0 for fewer than two samples.
pub fn rate(time_s: &[f64]) -> f64 {
    let interval = median_interval(time_s);
    if interval > 0.0 { 1.0 / interval } else { 0.0 }
}

/// A rate to three digits, as a person writes it; none where it is none.
pub fn to_three_digits(rate: f64) -> Option<f64> {
    let digits = 10_f64.powf(rate.log10().floor() - 2.0);
    let rounded = (rate / digits).round() * digits;
    // 33.300000000000004 is written as 33.3.
    let rounded = if digits >= 1.0 { rounded } else { (rounded * 1e6).round() / 1e6 };
    (rounded.is_finite() && rounded > 0.0).then_some(rounded)
}

/// Median absolute deviation of the intervals from their median, s: how far a typical sample comes early or late.
pub fn jitter(time_s: &[f64]) -> f64 {
    let interval = median_interval(time_s);
    let mut deviations: Vec<f64> =
        time_s.windows(2).map(|pair| (pair[1] - pair[0] - interval).abs()).collect();
    median(&mut deviations)
}

/// The middle one of `values`, the upper of two; 0 of none.
pub fn median(values: &mut [f64]) -> f64 {
    quantile(values, 0.5)
}

/// The first of `values` that is no smaller than this share of them, which is below 1; 0 of none.
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let place = (share * values.len() as f64) as usize;
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_long_pause_changes_neither_rate_nor_jitter() {
        let mut time: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.01).collect();
        time.extend((0..100).map(|i| 5.0 + f64::from(i) * 0.01));
        assert!((rate(&time) - 100.0).abs() < 1e-6);
        assert!(jitter(&time) < 1e-9);
    }

    #[test]
    fn a_rate_to_three_digits_is_written_with_no_more() {
        let written = |rate: f64| to_three_digits(rate).map(|rate| rate.to_string());
        for (rate, text) in [(33.298, "33.3"), (999.7, "1000"), (12_345.0, "12300"), (0.123_46, "0.123")] {
            assert_eq!(written(rate).as_deref(), Some(text));
        }
        assert_eq!([0.0, -1.0, f64::INFINITY, f64::NAN].map(to_three_digits), [None; 4]);
    }

    #[test]
    fn jitter_is_the_typical_deviation_from_the_interval() {
        // Intervals 9, 10, 11, 12, 13 ms: the median is 11 and a typical one lies 1 ms off.
        let mut time = vec![0.0];
        for i in 0..100 {
            time.push(time[i] + 0.009 + 0.001 * (i % 5) as f64);
        }
        assert!((median_interval(&time) - 0.011).abs() < 1e-12);
        assert!((jitter(&time) - 0.001).abs() < 1e-12);
    }

    #[test]
    fn the_unit_of_an_interval_is_that_in_which_it_is_usual() {
        for (interval, unit) in [
            (5e-4, Some("s")),
            (0.02, Some("s")),
            (0.5, Some("ms")),
            (10.0, Some("ms")),
            (5000.0, Some("us")),
            (1e7, Some("ns")),
            (1e-7, None),
        ] {
            assert_eq!(plausible_unit(interval), unit, "{interval}");
        }
    }

    #[test]
    fn too_few_samples_have_no_rate() {
        assert_eq!(rate(&[1.0]), 0.0);
        assert_eq!(median_interval(&[]), 0.0);
    }
}
