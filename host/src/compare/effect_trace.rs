//! One effect along the records: what the measurement asks for beyond a model without it, and what its equation says.
//!
//! Both are had alike, as the difference from a run of the same model with the effect taken out: once of the
//! measurement, once of the run with the effect. So the equation of any effect, be it a torque, a voltage, a gap or a fault
//! of the sensor, is drawn in the same quantity as what it is to explain, and smoothed alike.

use std::f64::consts::TAU;

use super::free_run::FreeRun;
use super::residual_torque::{ResidualTorque, residual_torque};
use super::residual_views::{around, reach, reversals};
use crate::fit::layout::BaseValues;
use crate::log::timing::median_interval;

/// What the records show of an effect, and what the effect's equation says: both of one unit, one value a moment.
#[derive(Debug, Clone, Default)]
pub struct Pair {
    /// Measurement beyond the model without the effect.
    pub seen: Vec<f64>,
    /// Model with the effect beyond the model without it.
    pub said: Vec<f64>,
}

/// An event of a record and the moments around it: which, time since the event (s), sign of the event.
type Around = Vec<(usize, f64, f64)>;

/// A record with one effect singled out; all columns have one length.
#[derive(Debug, Clone, Default)]
pub struct EffectTrace {
    /// The measured motion.
    pub motion: ResidualTorque,
    /// Voltage that drives the current: applied less back-EMF, V.
    pub winding_v: Vec<f64>,
    /// Residual torque, V.
    pub torque: Pair,
    /// Error of the speed, rad/s.
    pub speed: Pair,
    /// Error of the angle without its slow part, rad.
    pub angle: Pair,
    /// Moments around reversals.
    pub reversals: Around,
    /// Moments around jumps of the voltage.
    pub jumps: Around,
}

/// Time before and after a reversal or a jump of the voltage, s.
pub const SPAN_S: (f64, f64) = (0.05, 0.25);
/// A change of the voltage between two samples is a jump from this share of its reach on.
const JUMP: f64 = 0.25;
/// An error that changes more slowly than this is not the effect's, s.
const SLOW_S: f64 = 1.0;

impl EffectTrace {
    /// From the runs `with` and `without` the effect over one record, whose model has the base `base`.
    pub fn new(with: &FreeRun, without: &FreeRun, base: &BaseValues) -> Self {
        let seen = residual_torque(without, base);
        let run = FreeRun { measured: with.simulated.clone(), ..without.clone() };
        let said = residual_torque(&run, base);
        let less = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
        let speed = |r: &ResidualTorque| less(&r.speed_rad_s, &r.simulated_speed_rad_s);
        let angle = |r: &ResidualTorque| quick(&r.time_s, &less(&r.angle_rad, &r.simulated_angle_rad));
        let back_emf = (1.0 - base.viscous_share) / base.gain;
        let volts = seen.voltage_v.iter().zip(&seen.speed_rad_s);
        Self {
            winding_v: volts.map(|(v, w)| v - back_emf * w).collect(),
            speed: Pair { seen: speed(&seen), said: speed(&said) },
            angle: Pair { seen: angle(&seen), said: angle(&said) },
            reversals: around(&seen.time_s, &reversals(&seen), SPAN_S),
            jumps: around(&seen.time_s, &jumps(&seen), SPAN_S),
            torque: Pair { seen: seen.torque_v.clone(), said: said.torque_v },
            motion: seen,
        }
    }
}

/// Instants at which the voltage jumps, and the sign of the jump.
fn jumps(r: &ResidualTorque) -> Vec<(f64, f64)> {
    let enough = JUMP * reach(r.voltage_v.iter());
    let change = |k: usize| r.voltage_v[k] - r.voltage_v[k - 1];
    (1..r.time_s.len())
        .filter(|k| change(*k).abs() > enough)
        .map(|k| (r.time_s[k], change(k).signum()))
        .collect()
}

/// `error` less its mean over a second around each moment.
fn quick(time_s: &[f64], error: &[f64]) -> Vec<f64> {
    let beside = ((0.5 * SLOW_S / median_interval(time_s).max(1e-9)).round() as usize).max(1);
    let mut sums = vec![0.0];
    for e in error {
        sums.push(sums[sums.len() - 1] + e);
    }
    (0..error.len())
        .map(|k| {
            let (from, to) = (k.saturating_sub(beside), (k + beside + 1).min(error.len()));
            error[k] - (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect()
}

/// Highest multiple of a sine's frequency that is looked at.
const HIGHEST_HARMONIC: usize = 9;
/// A voltage is a sine where no more than this share of its square is left beside one; of a triangle 1.4 % are.
const NOT_A_SINE: f64 = 0.005;

/// Amplitudes of the residual torque at the multiples of the frequency of the sines among the records.
pub fn harmonics(traces: &[EffectTrace]) -> Option<(Vec<f64>, Pair)> {
    let sines: Vec<(&EffectTrace, f64)> = traces.iter().filter_map(|t| Some((t, sine(&t.motion)?))).collect();
    if sines.len() * 2 < traces.len() || sines.is_empty() {
        return None;
    }
    let orders: Vec<f64> = (1..=HIGHEST_HARMONIC).map(|k| k as f64).collect();
    let mean = |pick: fn(&EffectTrace) -> &Vec<f64>| {
        let at = |order: f64| {
            let each = sines.iter().map(|(t, f)| amplitude(&t.motion.time_s, pick(t), order * f, *f));
            each.sum::<f64>() / sines.len() as f64
        };
        orders.iter().map(|order| at(*order)).collect::<Vec<f64>>()
    };
    let pair = Pair { seen: mean(|t| &t.torque.seen), said: mean(|t| &t.torque.said) };
    Some((orders, pair))
}

/// Amplitude of `values` at `frequency`, Hz, over whole periods of `basic`, Hz.
fn amplitude(time_s: &[f64], values: &[f64], frequency: f64, basic: f64) -> f64 {
    let Some((first, last)) = time_s.first().zip(time_s.last()) else { return 0.0 };
    let end = first + ((last - first) * basic + 1e-6).floor() / basic;
    let (mut re, mut im, mut count) = (0.0, 0.0, 0.0);
    for (t, x) in time_s.iter().zip(values).take_while(|(t, _)| **t < end) {
        let (s, c) = (TAU * frequency * t).sin_cos();
        (re, im, count) = (re + x * c, im + x * s, count + 1.0);
    }
    2.0 * f64::hypot(re, im) / f64::max(count, 1.0)
}

/// The frequency of the voltage, Hz, where it is one sine for two periods at least.
fn sine(r: &ResidualTorque) -> Option<f64> {
    let length = r.time_s.last()? - r.time_s.first()?;
    let rising = (1..r.time_s.len())
        .filter(|k| r.voltage_v[k - 1] < 0.0 && r.voltage_v[*k] >= 0.0)
        .collect::<Vec<_>>();
    let (first, last) = (rising.first()?, rising.last()?);
    let frequency = (rising.len() - 1) as f64 / (r.time_s[*last] - r.time_s[*first]);
    let (from, to) = (r.time_s[*first], r.time_s[*last]);
    let whole = || r.time_s.iter().zip(&r.voltage_v).filter(|(t, _)| **t >= from && **t < to);
    let (mut power, mut re, mut im, mut count) = (0.0, 0.0, 0.0, 0.0);
    for (t, v) in whole() {
        let (s, c) = (TAU * frequency * t).sin_cos();
        (power, re, im, count) = (power + v * v, re + v * c, im + v * s, count + 1.0);
    }
    let of_sine = 2.0 * (re * re + im * im) / count;
    (rising.len() > 1 && length * frequency > 2.0 && power - of_sine < NOT_A_SINE * power)
        .then_some(frequency)
}

#[cfg(test)]
mod tests {
    use super::super::residual_torque::testing::{BASE, made};
    use super::*;

    /// A made run whose equation is known: its "with" is the true motor.
    fn trace(torque: impl Fn(f64, f64) -> f64) -> EffectTrace {
        let without = made(torque);
        let with = FreeRun { simulated: without.measured.clone(), ..without.clone() };
        EffectTrace::new(&with, &without, &BASE)
    }

    #[test]
    fn a_right_law_says_what_is_seen() {
        let t = trace(|x, _| -0.3 * x.sin());
        assert_eq!(t.torque.seen, t.torque.said);
        assert_eq!(t.angle.seen, t.angle.said);
        assert!(t.torque.seen.iter().any(|f| *f > 0.28));
        assert_eq!(t.motion.time_s.len(), t.winding_v.len());
    }

    #[test]
    fn friction_has_odd_harmonics_under_a_sine_and_other_voltages_have_none() {
        let mut t = trace(|_, w| -0.4 * (w / 0.02).tanh());
        assert!(harmonics(std::slice::from_ref(&t)).is_none(), "a triangle is no sine");
        let (n, dt, f) = (t.motion.time_s.len(), 1e-3, 0.5);
        for k in 0..n {
            t.motion.time_s[k] = k as f64 * dt;
            t.motion.voltage_v[k] = 5.0 * (TAU * f * k as f64 * dt).sin();
            t.torque.seen[k] = -0.4 * (TAU * f * k as f64 * dt).sin().signum();
        }
        let (orders, pair) = harmonics(&[t]).unwrap();
        assert_eq!(orders[2], 3.0);
        let third = 4.0 / std::f64::consts::PI * 0.4 / 3.0;
        assert!((pair.seen[2] / third - 1.0).abs() < 0.02, "{} for {third}", pair.seen[2]);
        assert!(pair.seen[1] < 0.05 * third, "{}", pair.seen[1]);
    }

    #[test]
    fn a_slow_drift_of_the_angle_is_left_out() {
        let time: Vec<f64> = (0..4000).map(|k| f64::from(k) * 1e-3).collect();
        let error: Vec<f64> = time.iter().map(|t| 0.2 * t + 0.01 * (TAU * 5.0 * t).sin()).collect();
        let quick = quick(&time, &error);
        let largest = quick[600..3400].iter().fold(0.0_f64, |m, e| m.max(e.abs()));
        assert!((largest - 0.01).abs() < 5e-4, "{largest}");
    }
}
