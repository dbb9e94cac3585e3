//! The residual torque seen from several sides: by speed, by voltage, by angle, around reversals; and the order
//! left in the error itself, as autocorrelation and spectrum.

use std::f64::consts::TAU;

use super::free_run::FreeRun;
use super::residual_torque::ResidualTorque;
use crate::log::motion::{mean, span};

/// Mean residual torque in bins of something.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Binned {
    /// Middle of each bin that has samples enough.
    pub at: Vec<f64>,
    /// Mean residual torque there, V.
    pub mean_v: Vec<f64>,
    /// Standard deviation within the bin, V.
    pub spread_v: Vec<f64>,
    /// Share of the residual torque's variance that the bins' means account for, 0 ..= 1.
    pub explained: f64,
}

/// Bins with fewer samples than this say nothing.
pub(super) const FEWEST_IN_BIN: usize = 8;

/// Bins of `torque_v` between `low` and `high` by `key`, over any number of records. Samples outside, or with no
/// key, are left out.
pub fn binned<'a>(
    samples: impl Iterator<Item = (Option<f64>, &'a f64)>,
    low: f64,
    high: f64,
    bins: usize,
) -> Binned {
    let mut sums = vec![(0_usize, 0.0, 0.0); bins];
    for (key, f) in samples {
        let Some(key) = key.filter(|key| *key >= low && *key < high) else { continue };
        let bin = (((key - low) / (high - low) * bins as f64) as usize).min(bins - 1);
        sums[bin].0 += 1;
        sums[bin].1 += f;
        sums[bin].2 += f * f;
    }
    let mut out = Binned::default();
    let (mut all, mut by_means, mut total, mut samples) = (0.0, 0.0, 0.0, 0.0);
    for (bin, (n, sum, square)) in sums.into_iter().enumerate() {
        if n < FEWEST_IN_BIN {
            continue;
        }
        let count = n as f64;
        let mean = sum / count;
        out.at.push(low + (bin as f64 + 0.5) * (high - low) / bins as f64);
        out.mean_v.push(mean);
        out.spread_v.push((square / count - mean * mean).max(0.0).sqrt());
        all += square;
        by_means += count * mean * mean;
        total += sum;
        samples += count;
    }
    // A constant is seen from every side alike, so it speaks for none of them.
    let constant = if samples > 0.0 { total * total / samples } else { 0.0 };
    out.explained = if all > constant { ((by_means - constant) / (all - constant)).max(0.0) } else { 0.0 };
    out
}

/// Largest magnitude that matters: exceeded by one in a hundred.
pub(super) fn reach<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    let mut all: Vec<f64> = values.map(|v| v.abs()).collect();
    if all.is_empty() {
        return 1.0;
    }
    let place = (all.len() * 99 / 100).min(all.len() - 1);
    let (_, reach, _) = all.select_nth_unstable_by(place, f64::total_cmp);
    reach.max(1e-9)
}

/// By speed and direction.
pub fn by_speed(all: &[ResidualTorque]) -> Binned {
    let reach = reach(all.iter().flat_map(|r| &r.speed_rad_s));
    let samples = all.iter().flat_map(|r| r.speed_rad_s.iter().map(|w| Some(*w)).zip(&r.torque_v));
    binned(samples, -reach, reach * (1.0 + 1e-9), 32)
}

/// By the voltage applied.
pub fn by_voltage(all: &[ResidualTorque]) -> Binned {
    let reach = reach(all.iter().flat_map(|r| &r.voltage_v));
    let samples = all.iter().flat_map(|r| r.voltage_v.iter().map(|v| Some(*v)).zip(&r.torque_v));
    binned(samples, -reach, reach * (1.0 + 1e-9), 32)
}

/// By angle of a shaft that turns `turns_per_turn` times for one of the output: 1 for the output shaft, the gear ratio for the motor's. Angles
/// in degrees of that shaft, turns laid over each other; a motion of less than a turn stays as it is.
pub fn by_angle(all: &[ResidualTorque], turns_per_turn: f64) -> Binned {
    let degrees = |x: &f64| (x * turns_per_turn).to_degrees();
    let (low, high) = turn(all.iter().flat_map(|r| r.angle_rad.iter().map(degrees)));
    let samples = all.iter().flat_map(|r| {
        let places = r.angle_rad.iter().map(|x| Some(within_turn(degrees(x), low)));
        places.zip(&r.torque_v)
    });
    binned(samples, low, high, 45)
}

/// Between which of these `angles`, degrees, a motion is laid out: all that it passes where that is less than a turn, else 0 to 360.
pub(super) fn turn(angles: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) =
        angles.fold((f64::MAX, f64::MIN), |(low, high), at| (f64::min(low, at), f64::max(high, at)));
    if low < high && high - low < 360.0 { (low, high + 1e-9) } else { (0.0, 360.0) }
}

/// `degrees` within the turn that begins at `low`.
pub(super) fn within_turn(degrees: f64, low: f64) -> f64 {
    low + (degrees - low).rem_euclid(360.0)
}

/// Time looked at before and after a reversal, s.
pub(super) const AROUND_S: (f64, f64) = (0.1, 0.3);

/// Instants at which the speed changes its sign for good, and its sign from then on.
pub(super) fn reversals(r: &ResidualTorque) -> Vec<(f64, f64)> {
    let still = 0.02 * reach(r.speed_rad_s.iter());
    let (mut direction, mut crossed) = (0.0, 0.0);
    let mut reversals = Vec::new();
    for (k, w) in r.speed_rad_s.iter().enumerate() {
        if k > 0 && w * r.speed_rad_s[k - 1] <= 0.0 {
            crossed = r.time_s[k];
        }
        if w.abs() > still && w.signum() != direction {
            if direction != 0.0 {
                reversals.push((crossed, w.signum()));
            }
            direction = w.signum();
        }
    }
    reversals
}

/// Samples up to so long before and after each of the `events`, none counted twice: which, when, the event's sign.
pub(super) fn around(time_s: &[f64], events: &[(f64, f64)], span: (f64, f64)) -> Vec<(usize, f64, f64)> {
    let mut near = Vec::new();
    for (k, &(at, sign)) in events.iter().enumerate() {
        let before = if k > 0 { 0.5 * (events[k - 1].0 + at) } else { f64::MIN };
        let after = events.get(k + 1).map_or(f64::MAX, |next| 0.5 * (next.0 + at));
        let first = time_s.partition_point(|t| *t < (at - span.0).max(before));
        let last = time_s.partition_point(|t| *t < (at + span.1).min(after));
        near.extend((first..last.max(first)).map(|j| (j, time_s[j] - at, sign)));
    }
    near
}

/// Around reversals: time since the speed changed its sign; torques count along the new direction.
pub fn around_reversals(all: &[ResidualTorque]) -> Binned {
    let near = all.iter().flat_map(|r| {
        let near = around(&r.time_s, &reversals(r), AROUND_S);
        near.into_iter().map(|(j, since, sign)| (Some(since), sign * r.torque_v[j]))
    });
    let keyed: Vec<(Option<f64>, f64)> = near.collect();
    binned(keyed.iter().map(|(key, f)| (*key, f)), -AROUND_S.0, AROUND_S.1, 40)
}

/// Autocorrelation of the error, its lags (s), and the bound that white noise exceeds once in a hundred.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Autocorrelation {
    /// Lags, s.
    pub lag_s: Vec<f64>,
    /// Correlation, -1 ..= 1.
    pub correlation: Vec<f64>,
    /// 99 % bound of white noise, 2.576 / sqrt(N).
    pub bound: f64,
}

/// Lags up to this, s.
const LONGEST_LAG_S: f64 = 1.0;
/// Number of lags.
const LAGS: usize = 100;

/// Autocorrelation of the error of `runs` together.
pub fn autocorrelation(runs: &[&FreeRun]) -> Autocorrelation {
    let interval = runs
        .iter()
        .map(|run| crate::log::timing::median_interval(&run.time_s))
        .fold(0.0_f64, f64::max)
        .max(1e-9);
    let step = (LONGEST_LAG_S / LAGS as f64 / interval).round().max(1.0) * interval;
    let errors: Vec<Vec<f64>> = runs.iter().map(|run| evenly(run, step)).collect();
    let count: usize = errors.iter().map(Vec::len).sum();
    let power: f64 = errors.iter().flatten().map(|e| e * e).sum();
    let mut out = Autocorrelation { bound: 2.576 / (count.max(1) as f64).sqrt(), ..Default::default() };
    // Of a lag longer than half a record too few pairs are left to tell anything.
    let longest = errors.iter().map(Vec::len).max().unwrap_or(0) / 2;
    for lag in 1..=LAGS.min(longest) {
        let product: f64 = errors
            .iter()
            .map(|e| e.iter().zip(e.get(lag..).unwrap_or(&[])).map(|(a, b)| a * b).sum::<f64>())
            .sum();
        out.lag_s.push(lag as f64 * step);
        out.correlation.push(if power > 0.0 { product / power } else { 0.0 });
    }
    out
}

/// The error without its mean, at every `step` seconds: nearest samples.
fn evenly(run: &FreeRun, step: f64) -> Vec<f64> {
    let (Some(first), Some(last)) = (run.time_s.first(), run.time_s.last()) else { return Vec::new() };
    let count = ((last - first) / step) as usize;
    let mut errors: Vec<f64> = (0..count)
        .map(|k| {
            let at = first + k as f64 * step;
            let j = run.time_s.partition_point(|t| *t < at - 1e-9).min(run.time_s.len() - 1);
            run.measured[j] - run.simulated[j]
        })
        .collect();
    let mean = mean(&errors);
    errors.iter_mut().for_each(|e| *e -= mean);
    errors
}

/// Amplitude of the residual torque by order: cycles per turn of the motor.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Spectrum {
    /// Cycles per turn of the motor shaft.
    pub order: Vec<f64>,
    /// Amplitude, V.
    pub amplitude_v: Vec<f64>,
}

/// Highest order looked for.
const HIGHEST_ORDER: f64 = 16.0;
/// Orders looked at.
const ORDERS: usize = 128;

/// How strongly the residual torque repeats along the motor's turn, for orders up to 16 of it, in records in which it turns once at least;
/// empty where there are none. The output shaft's own order is 1 / `gear_ratio`.
pub fn orders(all: &[ResidualTorque], gear_ratio: f64) -> Spectrum {
    let mut out = Spectrum::default();
    let mut sums = vec![(0.0, 0.0); ORDERS];
    let mut count = 0_usize;
    let turns_round = |r: &&ResidualTorque| span(&r.angle_rad) >= TAU / gear_ratio;
    for r in all.iter().filter(turns_round) {
        let mean = mean(&r.torque_v);
        // A few thousand samples of a record tell its harmonics.
        let every = r.torque_v.len().div_ceil(12_000).max(1);
        for k in (0..r.torque_v.len()).step_by(every) {
            let f = r.torque_v[k] - mean;
            let (s1, c1) = (r.angle_rad[k] * gear_ratio * HIGHEST_ORDER / ORDERS as f64).sin_cos();
            // Multiples of the angle by rotation instead of one sine each.
            let (mut s, mut c) = (s1, c1);
            for sum in &mut sums {
                sum.0 += f * c;
                sum.1 += f * s;
                (c, s) = (c * c1 - s * s1, s * c1 + c * s1);
            }
            count += 1;
        }
    }
    if count == 0 {
        return out;
    }
    for (k, (re, im)) in sums.into_iter().enumerate() {
        out.order.push((k + 1) as f64 * HIGHEST_ORDER / ORDERS as f64);
        out.amplitude_v.push(2.0 / count as f64 * f64::hypot(re, im));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::residual_torque::residual_torque;
    use super::super::residual_torque::testing::{BASE, made};
    use super::*;

    #[test]
    fn the_side_that_shows_an_effect_explains_it() {
        let friction = [residual_torque(&made(|_, w| -0.4 * (w / 0.02).tanh()), &BASE)];
        let gravity = [residual_torque(&made(|x, _| -0.3 * x.sin()), &BASE)];
        assert!(by_speed(&friction).explained > 0.9);
        assert!(by_angle(&gravity, 1.0).explained > 0.9);
        assert!(by_speed(&gravity).explained < 0.7);
        let speed = by_speed(&friction);
        let jump = speed.mean_v[speed.mean_v.len() - 1] - speed.mean_v[0];
        assert!((jump + 0.8).abs() < 0.05, "{jump}");
    }

    #[test]
    fn a_reversal_turns_friction_round() {
        let friction = [residual_torque(&made(|_, w| -0.4 * (w / 0.02).tanh()), &BASE)];
        let around = around_reversals(&friction);
        let (before, after) = (around.mean_v[2], around.mean_v[around.mean_v.len() - 2]);
        assert!(before > 0.3 && after < -0.3, "{before} {after}");
    }

    #[test]
    fn a_motion_of_less_than_a_turn_is_laid_out_whole_and_more_is_laid_over_itself() {
        let (low, high) = turn([-100.0, 20.0, 95.0].into_iter());
        assert!(low == -100.0 && high > 95.0 && high < 96.0, "{low} {high}");
        assert_eq!([-100.0, 0.0, 95.0].map(|at| within_turn(at, low)), [-100.0, 0.0, 95.0]);
        assert_eq!(turn([-100.0, 300.0].into_iter()), (0.0, 360.0));
        assert_eq!(within_turn(-90.0, 0.0), 270.0);
        assert_eq!(turn(std::iter::empty()), (0.0, 360.0));
    }

    #[test]
    fn a_record_tells_no_lags_longer_than_half_of_it_and_no_orders_of_less_than_a_turn() {
        let mut run = made(|x, _| 0.1 * x.sin());
        for column in [&mut run.time_s, &mut run.measured, &mut run.simulated, &mut run.voltage_v] {
            column.truncate(300);
        }
        let lags = autocorrelation(&[&run]).lag_s;
        assert!(lags.last().is_some_and(|lag| *lag <= 0.15), "{lags:?}");
        let short = [residual_torque(&run, &BASE)];
        assert_eq!(orders(&short, 1.0), Spectrum::default());
    }

    #[test]
    fn ripple_of_the_motor_shaft_shows_at_its_order() {
        let gear = 3.0;
        let ripple = [residual_torque(&made(|x, _| 0.1 * (2.0 * gear * x).sin()), &BASE)];
        let spectrum = orders(&ripple, gear);
        let best = (0..ORDERS).max_by(|a, b| spectrum.amplitude_v[*a].total_cmp(&spectrum.amplitude_v[*b]));
        assert_eq!(spectrum.order[best.unwrap()], 2.0);
        assert!((spectrum.amplitude_v[best.unwrap()] - 0.1).abs() < 0.04);
    }

    #[test]
    fn white_errors_stay_within_the_bound_and_drift_does_not() {
        let mut run = made(|_, _| 0.0);
        let mut state = 1_u64;
        for y in &mut run.measured {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            *y += 1e-3 * ((state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5);
        }
        let outside = |a: &Autocorrelation| a.correlation.iter().filter(|c| c.abs() > a.bound).count();
        assert!(outside(&autocorrelation(&[&run])) <= 5);
        for (k, y) in run.measured.iter_mut().enumerate() {
            *y += 1e-3 * (k as f64 * 1e-3).sin();
        }
        assert!(outside(&autocorrelation(&[&run])) > 50);
    }
}
