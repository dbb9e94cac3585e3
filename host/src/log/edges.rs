//! Garbled speeds just behind an edge of the drive: a motor that is still speeding up was not faster before than it ever gets.
//!
//! A sensor that times its edges has none to begin with as a shaft starts, and tells anything for a reading or two. They are no spike there
//! and back, because the motion goes on from elsewhere than it came.

use std::ops::Range;

use super::dropouts::LONGEST_SPIKE;
use super::motion::{peak, span};
use super::timing::median;

/// An edge changes the voltage by more than this share of its range; what changes less holds.
pub(super) const EDGE: f64 = 0.05;
/// It holds for so many readings behind those that may be garbled.
const FEWEST: usize = 12;
/// The garbled ones go further than any of these by this factor, ...
const BEYOND: f64 = 1.2;
/// ... behind them the motion is well on its way, as a shaft that broke loose and sticks again is not, and not at its end, ...
const ON_ITS_WAY: Range<f64> = 0.2..0.8;
/// ... and it falls back at once by so many times as much as it goes at once thereafter.
const SUDDEN: f64 = 4.0;

/// The garbled ones of the readings `speed` under `volts`.
pub(super) fn garbled_behind_edges(speed: &[f64], volts: &[f64]) -> Vec<usize> {
    let holds = EDGE * span(volts);
    let is_edge = |k: &usize| (volts[*k] - volts[*k - 1]).abs() > holds;
    let edges = (1..volts.len()).filter(is_edge).filter(|_| holds > 0.0);
    let behind = |k: usize| {
        let end = k + volts[k..].iter().take_while(|v| (**v - volts[k]).abs() <= holds).count();
        // A speed may be a row later than what drives it.
        let begins = [k, k + 1].into_iter().filter(|begin| begin + LONGEST_SPIKE + FEWEST <= end);
        let mut runs = begins.flat_map(|begin| (1..=LONGEST_SPIKE).map(move |count| begin..begin + count));
        runs.find(|run| is_garbled(speed[run.start - 1], &speed[run.clone()], &speed[run.end..end]))
    };
    edges.filter_map(behind).flatten().collect()
}

/// Whether `run` is none of the motion from `before` on to the speed that `later` readings settle at.
fn is_garbled(before: f64, run: &[f64], later: &[f64]) -> bool {
    // Few runs are beyond all of what follows, and the rest need no more than this.
    let beyond = |of: fn(&f64, &f64) -> bool| run.iter().all(|one| later.iter().all(|other| of(one, other)));
    if !beyond(|one, other| one > other) && !beyond(|one, other| one < other) {
        return false;
    }
    let settled = median(&mut later[later.len() / 2..].to_vec());
    // Shares of the way that the motion goes.
    let share = |w: &f64| (w - before) / (settled - before);
    let (run, later): (Vec<f64>, Vec<f64>) =
        (run.iter().map(share).collect(), later.iter().map(share).collect());
    let furthest = later.iter().fold(0.0, |far: f64, x| far.max(*x));
    let steps: Vec<f64> = later.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let fall = run[run.len() - 1] - later[0];
    settled != before
        && run.iter().all(|x| *x > BEYOND * furthest)
        && ON_ITS_WAY.contains(&later[0])
        && fall > SUDDEN * peak(&steps)
}

/// What drives the motor in the readings `out` counts with its mean from the reading before them on, which holds until the next that is kept.
pub(super) fn keep_drive(time_s: &[f64], volts: &mut [f64], out: &[usize]) {
    for run in out.chunk_by(|one, next| next - one == 1) {
        let (first, next) = (run[0].saturating_sub(1), run[run.len() - 1] + 1);
        if next < time_s.len() && first < run[0] {
            let area: f64 = (first..next).map(|k| volts[k] * (time_s[k + 1] - time_s[k])).sum();
            volts[first] = area / (time_s[next] - time_s[first]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The speed of a motor that 9 V drive from reading 100 to 250, and what drives it.
    fn steps(at: impl Fn(usize) -> f64) -> (Vec<f64>, Vec<f64>) {
        let volts = (0..400).map(|k| if (100..250).contains(&k) { 9.0 } else { 0.0 }).collect();
        ((0..400).map(at).collect(), volts)
    }

    fn settling(k: usize) -> f64 {
        let up = |k: usize| 11.0 * (1.0 - (-(k as f64) / 5.0).exp());
        let w = if k < 100 {
            0.0
        } else if k < 250 {
            up(k - 99)
        } else {
            11.0 * (-((k - 249) as f64) / 5.0).exp()
        };
        (w / 0.7).round() * 0.7
    }

    #[test]
    fn readings_beyond_the_speed_that_a_motor_is_still_on_its_way_to_are_garbled() {
        let (mut speed, volts) = steps(settling);
        assert_eq!(garbled_behind_edges(&speed, &volts), [0; 0]);
        (speed[100], speed[101]) = (16.0, 16.7);
        assert_eq!(garbled_behind_edges(&speed, &volts), [100, 101]);
        // As it runs down, and a row later than its drive.
        (speed[100], speed[101]) = (settling(100), settling(101));
        speed[251] = -6.0;
        assert_eq!(garbled_behind_edges(&speed, &volts), [251]);
    }

    #[test]
    fn a_motion_that_swings_or_comes_down_to_its_speed_is_none() {
        let swings = |damping: f64| {
            move |k: usize| match k {
                0..100 => 0.0,
                _ => 11.0 * (1.0 - (-(k as f64 - 100.0) * damping).exp() * (0.9 * (k as f64 - 100.0)).cos()),
            }
        };
        for damping in [0.02, 0.1, 0.3, 0.6] {
            let (speed, volts) = steps(swings(damping));
            assert_eq!(garbled_behind_edges(&speed, &volts), [0; 0], "{damping}");
        }
        // It sticks, breaks loose and sticks again.
        let (speed, volts) = steps(|k| if k == 100 { 5.0 } else { f64::from((102..250).contains(&k)) });
        assert_eq!(garbled_behind_edges(&speed, &volts), [0; 0]);
        // It is fast while it is cold, or its regulator comes later.
        let (speed, volts) =
            steps(|k| if (100..250).contains(&k) { 11.0 + 5.0 * f64::from(k < 103) } else { 0.0 });
        assert_eq!(garbled_behind_edges(&speed, &volts), [0; 0]);
    }

    #[test]
    fn the_drive_of_a_reading_that_is_left_out_counts() {
        let (time_s, mut volts) = ([0.0, 0.1, 0.2, 0.3, 0.4], [0.0, 9.0, 9.0, 9.0, 9.0]);
        keep_drive(&time_s, &mut volts, &[1, 2]);
        assert!((volts[0] - 6.0).abs() < 1e-12, "{volts:?}");
    }
}
