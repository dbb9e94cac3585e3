//! The loops on the base model with a delay, by their phase margin.
//!
//! Plant: gain / (s (tau_m s + 1)(tau_e s + 1)) e^(-s delay). The velocity's PI cancels the mechanical pole, ki = kp / tau_m. The
//! position's PD puts its zero where the poles of tau_m s^2 + (1 + gain kd) s + gain kp are equal, and its natural frequency as high
//! as the margin allows. Both crossovers are found by bisection on the loop itself. Source: Franklin, Powell, Emami-Naeini,
//! Feedback Control of Dynamic Systems, chapter 6.

use nalgebra::Complex;
use serde::Serialize;

use crate::fit::layout::BaseValues;

/// How far a loop is from the edge.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Margins {
    /// Crossover, Hz.
    pub crossover_hz: f64,
    /// Phase margin, degrees.
    pub phase_deg: f64,
    /// Factor by which the gain may rise.
    pub gain: f64,
    /// More delay that it bears, s.
    pub delay_s: f64,
}

/// Gains of a loop in volts per unit of the output shaft.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Loop {
    /// Proportional: V s/rad of a velocity loop, V/rad of a position loop.
    pub kp: f64,
    /// Integral, V/rad.
    pub ki: f64,
    /// Derivative, V s/rad.
    pub kd: f64,
    /// Its margins.
    pub margins: Margins,
}

/// What the loop's open chain is at an angular frequency.
type Chain<'a> = &'a dyn Fn(f64) -> Complex<f64>;

fn plant(base: &BaseValues, delay_s: f64, omega: f64) -> Complex<f64> {
    let s = Complex::new(0.0, omega);
    let one = Complex::new(1.0, 0.0);
    let delay = Complex::from_polar(1.0, -omega * delay_s);
    delay * base.gain / ((one + s * base.tau_m) * (one + s * base.tau_e))
}

/// PI of the velocity.
pub(super) fn velocity(base: &BaseValues, delay_s: f64, margin: f64) -> Loop {
    let chain = |kp: f64| {
        move |omega: f64| {
            let s = Complex::new(0.0, omega);
            plant(base, delay_s, omega) * (Complex::new(kp, 0.0) + Complex::new(kp / base.tau_m, 0.0) / s)
        }
    };
    let kp = largest(&|kp| margins(&chain(kp)).phase_deg.to_radians() >= margin, 1.0 / base.gain);
    Loop { kp, ki: kp / base.tau_m, kd: 0.0, margins: margins(&chain(kp)) }
}

/// PD of the position.
pub(super) fn position(base: &BaseValues, delay_s: f64, margin: f64) -> Loop {
    let gains = |omega_n: f64| {
        let kp = base.tau_m * omega_n * omega_n / base.gain;
        // Where back-EMF and friction damp more than that already, nothing is added.
        let kd = ((2.0 * base.tau_m * omega_n - 1.0) / base.gain).max(0.0);
        (kp, kd)
    };
    let chain = |(kp, kd): (f64, f64)| {
        move |omega: f64| {
            let s = Complex::new(0.0, omega);
            plant(base, delay_s, omega) / s * (Complex::new(kp, 0.0) + s * kd)
        }
    };
    let held = |omega_n: f64| margins(&chain(gains(omega_n))).phase_deg.to_radians() >= margin;
    let (kp, kd) = gains(largest(&held, 1.0 / base.tau_m));
    Loop { kp, ki: 0.0, kd, margins: margins(&chain((kp, kd))) }
}

/// The largest number that `holds`, about `scale`: bisection of its logarithm.
fn largest(holds: &dyn Fn(f64) -> bool, scale: f64) -> f64 {
    let (mut low, mut high) = (scale * 1e-3, scale * 1e4);
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        if holds(middle) { low = middle } else { high = middle }
    }
    low
}

/// Margins by a fine walk along the frequencies, the phase unwrapped.
fn margins(chain: Chain) -> Margins {
    const FROM: f64 = 1e-2;
    const PER_DECADE: i32 = 200;
    let at = |k: i32| FROM * 10_f64.powf(f64::from(k) / f64::from(PER_DECADE));
    let mut before = chain(at(0));
    let mut phase = before.arg();
    let (mut crossover, mut gain) = (None, None);
    for k in 1..7 * PER_DECADE {
        let now = chain(at(k));
        let turned = (now / before).arg();
        if crossover.is_none() && before.norm() >= 1.0 && now.norm() < 1.0 {
            let part = before.norm().ln() / (before.norm() / now.norm()).ln();
            crossover = Some((at(k - 1) * (at(k) / at(k - 1)).powf(part), phase + part * turned));
        }
        let pi = std::f64::consts::PI;
        if gain.is_none() && phase > -pi && phase + turned <= -pi {
            gain = Some(1.0 / now.norm());
        }
        phase += turned;
        before = now;
    }
    let (omega, angle) = crossover.unwrap_or((FROM, phase));
    let margin = std::f64::consts::PI + angle;
    Margins {
        crossover_hz: omega / std::f64::consts::TAU,
        phase_deg: margin.to_degrees(),
        gain: gain.unwrap_or(f64::MAX),
        delay_s: margin / omega,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BASE: BaseValues = BaseValues { gain: 0.9, tau_m: 0.05, tau_e: 6e-4, viscous_share: 0.1 };

    /// With the mechanical pole cancelled the loop is kp gain / (tau_m s) with a lag: its margin is known.
    #[test]
    fn a_velocity_loop_has_the_margin_that_was_asked_and_crosses_where_that_puts_it() {
        let delay = 3e-3;
        let found = velocity(&BASE, delay, 60_f64.to_radians());
        assert!((found.margins.phase_deg - 60.0).abs() < 0.1, "{found:?}");
        let omega = found.margins.crossover_hz * std::f64::consts::TAU;
        let spent = omega * delay + (omega * BASE.tau_e).atan();
        assert!((spent - 30_f64.to_radians()).abs() < 2e-3, "{spent}");
        let kp = BASE.tau_m * omega / BASE.gain * (1.0 + (omega * BASE.tau_e).powi(2)).sqrt();
        assert!((found.kp / kp - 1.0).abs() < 2e-3, "{found:?}");
    }

    #[test]
    fn more_delay_makes_both_loops_slower_and_keeps_their_margins() {
        for design in [velocity, position] {
            let [fast, slow] = [2e-3, 1e-2].map(|delay| design(&BASE, delay, 60_f64.to_radians()));
            assert!(slow.margins.crossover_hz < 0.6 * fast.margins.crossover_hz, "{fast:?} {slow:?}");
            assert!(slow.margins.phase_deg > 59.9 && slow.margins.gain > 2.0, "{slow:?}");
        }
    }
}
