//! Fewer points for drawing: every peak stays, whatever the screen's width. Never used for fitting.

/// Places of at most about `points` samples, ascending, such that in every stretch the lowest and the highest of
/// each of `columns` are kept, and the ends.
pub fn keep(columns: &[&[f64]], from: usize, to: usize, points: usize) -> Vec<usize> {
    let n = to.saturating_sub(from);
    if n <= points || columns.is_empty() {
        return (from..to).collect();
    }
    let stretches = (points / (2 * columns.len())).max(1);
    let mut places = vec![from, to - 1];
    for s in 0..stretches {
        let (a, b) = (from + s * n / stretches, from + (s + 1) * n / stretches);
        for column in columns {
            let (mut low, mut high) = (a, a);
            for k in a..b {
                if column[k] < column[low] {
                    low = k;
                }
                if column[k] > column[high] {
                    high = k;
                }
            }
            places.extend([low, high]);
        }
    }
    places.sort_unstable();
    places.dedup();
    places
}

/// `digits` significant digits: what a screen can show, and a third of the bytes.
pub fn rounded(x: f64, digits: i32) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return 0.0;
    }
    let places = digits - 1 - x.abs().log10().floor() as i32;
    // Of a large number, whole tens are divided out: tenths of a power of ten are no exact numbers.
    let scale = 10_f64.powi(places.abs());
    let y = if places >= 0 { (x * scale).round() / scale } else { (x / scale).round() * scale };
    if y.is_finite() { y } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_spike_survives() {
        let mut y = vec![0.0; 100_000];
        y[54_321] = 1.0;
        let places = keep(&[&y], 0, y.len(), 1000);
        assert!(places.contains(&54_321) && places.len() <= 1002);
        assert!(places.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn short_columns_are_kept_whole() {
        let y = [1.0, 2.0, 3.0];
        assert_eq!(keep(&[&y], 0, 3, 1000), [0, 1, 2]);
    }

    #[test]
    fn rounding_keeps_significant_digits() {
        assert_eq!(rounded(0.001_234_567, 4), 0.001_235);
        assert_eq!(rounded(-98_765.4, 2), -99_000.0);
        assert_eq!(rounded(0.0, 3), 0.0);
    }
}
