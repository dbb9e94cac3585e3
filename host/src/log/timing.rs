//! The clock of a record: interval, rate, jitter.

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

/// Median absolute deviation of the intervals from their median, s: how far a typical sample comes early or late.
pub fn jitter(time_s: &[f64]) -> f64 {
    let interval = median_interval(time_s);
    let mut deviations: Vec<f64> =
        time_s.windows(2).map(|pair| (pair[1] - pair[0] - interval).abs()).collect();
    median(&mut deviations)
}

/// The middle one of `values`, the upper of two; 0 of none.
pub fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
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
    fn too_few_samples_have_no_rate() {
        assert_eq!(rate(&[1.0]), 0.0);
        assert_eq!(median_interval(&[]), 0.0);
    }
}
