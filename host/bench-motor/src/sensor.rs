//! From the true angle to what a log holds.

use crate::motor::Motor;
use crate::plant::TRACE_S;
use crate::{Rng, chance};

/// How the sensor reads and what becomes of it on the way into the log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sensor {
    /// A reading is so late, s.
    pub latency_s: f64,
    /// Time constant of a filter before counting, s.
    pub filter_s: f64,
    /// A reading is updated only this often, s; at every sample where zero.
    pub hold_s: f64,
    /// Reading error of a disc off its centre: amplitude at the output, rad, and phase.
    pub eccentric: (f64, f64),
    /// Share of the counts lost above an output speed, rad/s.
    pub lost: (f64, f64),
    /// The speed is a difference over this time, s; no speed is logged where zero.
    pub window_s: f64,
    /// Time constant of a filter behind the difference, s.
    pub speed_filter_s: f64,
    /// The speed is written in steps of this, rad/s; as it is where zero.
    pub speed_step: f64,
}

/// Counter readings, one per traced angle, rad of the output shaft.
pub fn counter(sensor: &Sensor, motor: &Motor, angle: &[f64], rng: &mut Rng) -> Vec<f64> {
    let count = motor.count_rad();
    let late = (sensor.latency_s / TRACE_S).round() as usize;
    let hold = ((sensor.hold_s / TRACE_S).round() as usize).max(1);
    let turns = if motor.encoder_on_output { 1.0 } else { motor.gear };
    let keep = if sensor.filter_s > 0.0 { (-TRACE_S / sensor.filter_s).exp() } else { 0.0 };
    let mut filtered = angle.first().copied().unwrap_or(0.0);
    let mut edges = (filtered / count).floor();
    let (mut missing, mut read) = (0.0, Vec::with_capacity(angle.len()));
    for k in 0..angle.len() {
        let x = angle[k.saturating_sub(late)];
        filtered = keep * filtered + (1.0 - keep) * x;
        let disc = sensor.eccentric.0 * (turns * filtered + sensor.eccentric.1).sin();
        let now = ((filtered + disc) / count).floor();
        let passed = now - edges;
        if sensor.lost.0 > 0.0 && passed != 0.0 && k > 0 {
            let before = k.saturating_sub(40);
            let speed = (angle[k] - angle[before]) / ((k - before) as f64 * TRACE_S);
            if speed.abs() > sensor.lost.1 {
                let lost = (0..passed.abs() as usize).filter(|_| chance(rng, sensor.lost.0)).count();
                missing += lost as f64 * passed.signum();
            }
        }
        edges = now;
        let value = (now - missing) * count;
        read.push(if k % hold == 0 { value } else { read[k - 1] });
    }
    read
}

/// Speeds at `times`, as a microcontroller or a robot's library gives them.
pub fn speeds(sensor: &Sensor, counter: &[f64], times: &[f64]) -> Vec<f64> {
    let at = |t: f64| counter[((t / TRACE_S).round().max(0.0) as usize).min(counter.len() - 1)];
    let mut filtered = 0.0;
    let mut last = times.first().copied().unwrap_or(0.0);
    let speed = |&t: &f64| {
        let raw = (at(t) - at(t - sensor.window_s)) / sensor.window_s;
        let keep =
            if sensor.speed_filter_s > 0.0 { (-(t - last) / sensor.speed_filter_s).exp() } else { 0.0 };
        last = t;
        filtered = keep * filtered + (1.0 - keep) * raw;
        if sensor.speed_step > 0.0 {
            (filtered / sensor.speed_step).round() * sensor.speed_step
        } else {
            filtered
        }
    };
    times.iter().map(speed).collect()
}

/// Angles at `times`.
pub fn angles(counter: &[f64], times: &[f64]) -> Vec<f64> {
    times.iter().map(|t| counter[((t / TRACE_S).round() as usize).min(counter.len() - 1)]).collect()
}
