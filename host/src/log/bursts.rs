//! Times at which lines arrived, not at which they were measured: a computer that reads a serial port gets several lines at once.
//!
//! Within a burst there is next to no time, and the bursts come evenly with about as many rows each, so the rows themselves came evenly.

use super::timing::median;

/// Most intervals are below this share of the mean one ...
const WITHIN: f64 = 0.2;
/// ... and those above so many mean ones, which part the bursts, make up this share of the time,
const BETWEEN: f64 = 2.0;
const MOST_OF_TIME: f64 = 0.8;
/// of so many bursts or more, of which nine in ten are alike within this factor, in time and in rows.
const FEWEST_BURSTS: usize = 8;
const ALIKE: f64 = 2.0;
/// Two rows that come together are two signals of one instant.
const FEWEST_ROWS: f64 = 3.0;

/// How lines came.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bursts {
    /// Rows of a burst, in the middle.
    pub rows: f64,
    /// From one burst to the next, s.
    pub every_s: f64,
}

/// The bursts in which the stamps come; none where they are even, or uneven otherwise.
pub(super) fn bursts(time_s: &[f64]) -> Option<Bursts> {
    let steps: Vec<f64> =
        time_s.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step >= 0.0).collect();
    let all: f64 = steps.iter().sum();
    let mean = all / steps.len().max(1) as f64;
    if mean <= 0.0 || median(&mut steps.clone()) > WITHIN * mean {
        return None;
    }
    let gaps: Vec<usize> = (0..steps.len()).filter(|k| steps[*k] > BETWEEN * mean).collect();
    if gaps.len() < FEWEST_BURSTS {
        return None;
    }
    let mut lengths: Vec<f64> = gaps.iter().map(|k| steps[*k]).collect();
    let mut rows: Vec<f64> = gaps.windows(2).map(|pair| (pair[1] - pair[0]) as f64).collect();
    let parted = lengths.iter().sum::<f64>() > MOST_OF_TIME * all;
    let are_alike = [&mut lengths, &mut rows].into_iter().all(|values| {
        values.sort_by(f64::total_cmp);
        let edge = values.len() / 20;
        values[values.len() - 1 - edge] <= ALIKE * values[edge]
    });
    let (rows, every_s) = (median(&mut rows), median(&mut lengths));
    (parted && are_alike && rows >= FEWEST_ROWS).then_some(Bursts { rows, every_s })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_arrive_by_fives_are_told_and_even_uneven_and_paired_ones_are_not() {
        let arrived: Vec<f64> = (0..200).map(|k| f64::from(k / 5) * 0.05 + f64::from(k % 5) * 2e-4).collect();
        let found = bursts(&arrived).unwrap();
        assert!(found.rows == 5.0 && (found.every_s - 0.0492).abs() < 1e-9, "{found:?}");
        let even = |k: i32| f64::from(k) * 0.01;
        let jittering = |k: i32| f64::from(k) * 0.01 + 0.004 * f64::from(k * k).sin();
        let paired = |k: i32| f64::from(k / 2) * 0.02 + f64::from(k % 2) * 1e-4;
        let when_it_changes = |k: i32| 0.01 * f64::from(k) + if k % 50 > 25 { 20.0 } else { 0.0 };
        for course in [&even as &dyn Fn(i32) -> f64, &jittering, &paired, &when_it_changes] {
            assert_eq!(bursts(&(0..200).map(course).collect::<Vec<_>>()), None);
        }
    }
}
