//! Whether a counter loses edges, told by two runs of one programme, without any model.
//!
//! Both runs turn alike, but which edges are lost is chance: the readings part while the shaft is fast, by whole counts
//! that never come back, and stay together while it is slow. What disturbs a motor parts them at every speed.

use super::Record;
use super::repeats::differences;

/// The difference is looked at in means over this long, s: counting averages out.
const WINDOW_S: f64 = 0.1;
/// Shares of the no-load speed below which nothing is lost yet, and above which it is.
const SLOW: f64 = 0.2;
const FAST: f64 = 0.35;
/// From one fast window to the next the difference moves by more than this, counts (root mean square) ...
const PARTING: f64 = 0.6;
/// ... from one slow window to the next by less than this ...
const TOGETHER: f64 = 0.5;
/// ... and by so many times less.
const TIMES: f64 = 4.0;

/// Whether the counts of `first` and `second`, runs of one programme, part at speed alone. `quantum`: rad a count;
/// `no_load_speed`, rad/s. False where the programme is not both fast and slow, and where no angle was counted.
pub fn loses_counts(first: &Record, second: &Record, quantum: f64, no_load_speed: f64) -> bool {
    let (Some(angle), true) = (&first.angle_rad, second.angle_rad.is_some() && quantum > 0.0) else {
        return false;
    };
    let Some(difference) = differences(first, second) else { return false };
    // Where the runs began a sample apart, one is missing: little in a window.
    let common = difference.len().min(angle.len());
    let per_window = (WINDOW_S * angle.len() as f64 / first.duration_s()).round().max(1.0) as usize;
    let windows: Vec<(f64, f64)> = (0..common / per_window)
        .map(|k| {
            let (from, to) = (k * per_window, ((k + 1) * per_window).min(common - 1));
            let parted = difference[from..to].iter().sum::<f64>() / (to - from).max(1) as f64 / quantum;
            let speed = (angle[to] - angle[from]) / (first.time_s[to] - first.time_s[from]);
            (parted, speed.abs() / no_load_speed)
        })
        .collect();
    let rms = |counts: &dyn Fn(f64, f64) -> bool| {
        let squares: Vec<f64> = windows
            .windows(2)
            .filter(|w| counts(w[0].1, w[1].1))
            .map(|w| (w[1].0 - w[0].0).powi(2))
            .collect();
        (squares.len() > 1).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
    };
    let fast = rms(&|before, after| before.min(after) > FAST);
    let slow = rms(&|before, after| before.max(after) < SLOW);
    matches!((fast, slow), (Some(fast), Some(slow)) if fast > PARTING && slow < TOGETHER && fast > TIMES * slow)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exam::case::{Case, Conditions};
    use motorlens_virtual_motor::Kind;

    fn told(seed: u64, hidden: &[Kind], disturbed: f64) -> bool {
        let case = Case::new(seed, hidden, Conditions { disturbed, spoilt: 0.0 });
        let quantum = std::f64::consts::TAU / case.motor.counts_per_rev.unwrap();
        let volts = case.motor.nameplate.no_load_speed_rad_s.unwrap();
        loses_counts(&case.records[2], &case.records[5], quantum, volts)
    }

    #[test]
    fn two_runs_of_a_counter_that_loses_edges_part_at_speed() {
        for seed in 40..46 {
            assert!(told(seed, &[Kind::LostCounts], 0.0), "seed {seed}");
        }
    }

    #[test]
    fn neither_noise_nor_other_effects_nor_a_disturbance_part_two_runs_so() {
        for seed in 40..52 {
            assert!(!told(seed, &[], 0.0), "seed {seed}");
            assert!(!told(seed, &[], 1.0), "seed {seed}, disturbed");
            assert!(!told(seed, &[Kind::QuadraticDrag, Kind::Coast], 0.0), "seed {seed}, drag and coasting");
            assert!(!told(seed, &[Kind::Coulomb, Kind::Delay], 1.0), "seed {seed}, friction, disturbed");
        }
    }
}
