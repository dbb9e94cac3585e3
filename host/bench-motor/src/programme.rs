//! What people make their motors do.

use std::f64::consts::TAU;

use crate::{Rng, between, pick};

/// A programme: its name and the value (volts, or the goal's angle) over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Programme {
    /// Name.
    pub name: String,
    /// Values at the sampling instants.
    pub values: Vec<f64>,
}

/// Samples `value` at `rate` for `seconds`.
pub fn of(name: &str, seconds: f64, rate: f64, value: impl FnMut(f64) -> f64) -> Programme {
    let n = (seconds * rate).round() as usize;
    Programme { name: name.into(), values: (0..n).map(|k| k as f64 / rate).map(value).collect() }
}

/// SysId's four tests: a slow ramp and a step, each way.
pub fn sysid(rng: &mut Rng, supply: f64, rate: f64, name: &str) -> Vec<Programme> {
    let ramp = supply / between(rng, 10.0, 24.0);
    let step = supply * between(rng, 0.45, 0.7);
    let long = (0.85 * supply / ramp).min(14.0);
    let short = between(rng, 1.5, 2.5);
    let both = [("forward", 1.0), ("reverse", -1.0)];
    let slow = both.map(|(way, s)| of(&format!("{name}quasistatic-{way}"), long, rate, |t| s * ramp * t));
    let fast = both.map(|(way, s)| {
        of(&format!("{name}dynamic-{way}"), short, rate, |t| if t < 0.1 { 0.0 } else { s * step })
    });
    slow.into_iter().chain(fast).collect()
}

/// Levels at random for random times, now and then zero, now and then a reversal.
pub fn levels(rng: &mut Rng, name: &str, top: f64, seconds: f64, rate: f64) -> Programme {
    let (mut level, mut until) = (0.0, 0.3);
    of(name, seconds, rate, |t| {
        if t >= until {
            level = if between(rng, 0.0, 1.0) < 0.15 { 0.0 } else { between(rng, -top, top) };
            until = t + between(rng, 0.15, 1.2);
        }
        level
    })
}

/// Slow triangles through zero.
pub fn triangles(name: &str, top: f64, period: f64, seconds: f64, rate: f64) -> Programme {
    of(name, seconds, rate, |t| {
        let x = (t / period + 0.25).fract();
        top * (1.0 - 4.0 * (x - 0.5).abs())
    })
}

/// A sine whose frequency rises.
pub fn chirp(name: &str, top: f64, hertz: (f64, f64), seconds: f64, rate: f64) -> Programme {
    let growth = (hertz.1 / hertz.0).ln() / seconds;
    of(name, seconds, rate, |t| top * (TAU * hertz.0 * ((growth * t).exp() - 1.0) / growth).sin())
}

/// Sines of one frequency.
pub fn sine(name: &str, top: f64, hertz: f64, seconds: f64, rate: f64) -> Programme {
    of(name, seconds, rate, |t| top * (TAU * hertz * t).sin())
}

/// A drive as with a joystick: trapezoids with pauses.
pub fn drive(rng: &mut Rng, name: &str, top: f64, seconds: f64, rate: f64) -> Programme {
    let (mut goal, mut value, mut until) = (0.0, 0.0_f64, 0.4);
    let slope = top * between(rng, 1.5, 6.0) / rate;
    of(name, seconds, rate, |t| {
        if t >= until {
            goal = pick(rng, &[0.0, 0.4, 0.7, 1.0, -0.5, -0.9]) * top;
            until = t + between(rng, 0.5, 1.8);
        }
        value += (goal - value).clamp(-slope, slope);
        value
    })
}

/// Goals of a servo, rad.
pub fn moves(rng: &mut Rng, name: &str, which: usize, seconds: f64, rate: f64) -> Programme {
    let wide = between(rng, 0.7, 1.5);
    match which {
        0 => of(name, seconds, rate, |t| wide * t.sin() * (3.0 * t).sin()),
        1 => {
            of(
                name,
                seconds,
                rate,
                |t| if (t % 3.0) < 1.5 { wide } else { wide * (3.0 - t % 3.0) - 0.5 * wide },
            )
        }
        2 => of(name, seconds, rate, |t| wide * (t * t).sin()),
        _ => {
            let (mut goal, mut until) = (0.0, 0.2);
            of(name, seconds, rate, |t| {
                if t >= until {
                    goal = between(rng, -wide, wide);
                    until = t + between(rng, 0.4, 1.4);
                }
                goal
            })
        }
    }
}
