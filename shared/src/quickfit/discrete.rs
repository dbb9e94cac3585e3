//! The linear model's filter in `f32` throughout, because `f64` is slow software on a Cortex-M4F.
//!
//! The same difference equation as [`Filter::new`] gives for a held voltage and an angle, from other formulas: those
//! there lose their digits in `f32`. With T the step, and poles x1, x2 counted in steps,
//!
//! ```text
//! closing     = (1 - e^x1)(1 - e^x2)
//! from_change = gain T ((x2/x1)(e^x1 - 1) - (x1/x2)(e^x2 - 1)) / (x1 - x2)
//! ```
//!
//! Every factor is a difference of unlike numbers while the poles lie apart; where they meet or turn complex, both
//! are written with x1, x2 = -h +- sqrt(y), which is smooth in y.

use crate::linear::Filter;
use crate::scalar::Scalar;

/// The square of (x1 - x2)/(x1 + x2) below which the poles count as close.
const CLOSE: f32 = 0.01;

/// A motor without viscous friction, tau_e tau_m s^2 + tau_m s + 1, sampled every `step` seconds. Time constants in s,
/// all positive; gain in counts (or rad) per V s. Coefficients are within 3e-6 of the exact ones, relatively, for
/// steps up to 50 electrical time constants.
pub fn filter([gain, tau_m, tau_e]: [f32; 3], step: f32) -> Filter<f32> {
    // x1, x2 = -h (1 -+ sqrt(apart)).
    let h = 0.5 * step / tau_e;
    let apart = 1.0 - 4.0 * tau_e / tau_m;
    let (closing, grown, change) =
        if apart > CLOSE { far_apart(h, step / tau_m, apart) } else { close(h, step / tau_m, apart) };
    Filter {
        gain,
        from_voltage: 0.0,
        from_sum: -gain * tau_m * closing,
        from_change: gain * step * change,
        restoring: -closing,
        keeping: 1.0 + grown,
    }
}

/// `closing`, e^x1 + e^x2 - 2, and `from_change` per gain and step; `slowness` is the step over tau_m.
fn far_apart(h: f32, slowness: f32, apart: f32) -> (f32, f32, f32) {
    let root = libm::sqrtf(apart);
    let fast = -h * (1.0 + root);
    // From the product of the poles, 2 h slowness: the difference would lose its digits.
    let slow = -2.0 * slowness / (1.0 + root);
    let (grown_slow, grown_fast) = (libm::expm1f(slow), libm::expm1f(fast));
    let change = (fast / slow * grown_slow - slow / fast * grown_fast) / (2.0 * h * root);
    (grown_slow * grown_fast, grown_slow + grown_fast, change)
}

/// The same where the poles nearly meet, or are complex.
fn close(h: f32, slowness: f32, apart: f32) -> (f32, f32, f32) {
    let y = h * h * apart;
    let grown = libm::expm1f(-h);
    let decay = 1.0 + grown;
    // cosh(sqrt y) - 1 and sinh(sqrt y)/sqrt y.
    let (bend, spread) = if y > 0.0 { hyperbolic(libm::sqrtf(y)) } else { circular(libm::sqrtf(-y)) };
    let both = grown + decay * bend;
    // h^2 - y, the product of the poles, is 2 h slowness.
    let change = ((h * h + y) * decay * spread + 2.0 * h * both) / (2.0 * h * slowness);
    (grown * grown - 2.0 * decay * bend, 2.0 * both, change)
}

fn hyperbolic(x: f32) -> (f32, f32) {
    let grown = libm::expm1f(x);
    let twice = 2.0 * (1.0 + grown);
    (grown * grown / twice, grown * (2.0 + grown) / (twice * x))
}

fn circular(x: f32) -> (f32, f32) {
    const TURN: f32 = core::f32::consts::TAU;
    let half = (0.5 * x / TURN).sin_turns();
    // At zero the quotient is 1.
    let spread = if x > 1e-6 { (x / TURN).sin_turns() / x } else { 1.0 };
    (-2.0 * half * half, spread)
}

#[cfg(test)]
mod tests {
    use super::filter;
    use crate::linear::{Filter, Hold, Kind};
    use crate::motor::Combinations;

    /// Largest relative difference of the coefficients to the exact ones.
    fn worst(motor: [f32; 3], step: f32) -> f64 {
        let [gain, tau_m, tau_e] = motor.map(f64::from);
        let beta = 1.0 / (tau_e * tau_m);
        let exact = Combinations { b_over_a1: gain * beta, a2_over_a1: 1.0 / tau_e, a3_over_a1: beta };
        let exact = Filter::new(&exact, step.into(), Hold::Zero, Kind::Angle);
        let rough = filter(motor, step);
        let share = |rough: f32, exact: f64| (f64::from(rough) / exact - 1.0).abs();
        share(rough.from_sum, exact.from_sum)
            .max(share(rough.from_change, exact.from_change))
            .max(share(rough.restoring, exact.restoring))
            .max((f64::from(rough.keeping) - exact.keeping).abs())
    }

    #[test]
    fn single_precision_keeps_six_digits_over_the_whole_search_space() {
        let mut worst_of_all = 0.0_f64;
        for step in [5e-4_f32, 1e-3, 2e-3, 5e-3, 1e-2] {
            for m in 0..60 {
                for e in 0..60 {
                    let between = |low: f32, high: f32, k: i32| low * (high / low).powf(k as f32 / 59.0);
                    let motor = [700.0, between(5e-3, 2.0, m), between((step / 20.0).max(5e-5), 0.02, e)];
                    worst_of_all = worst_of_all.max(worst(motor, step));
                }
            }
        }
        assert!(worst_of_all < 3e-6, "{worst_of_all:e}");
    }

    #[test]
    fn poles_that_meet_or_turn_complex_lose_no_more() {
        for share in [0.2, 0.2474, 0.2476, 0.249_99, 0.25, 0.250_01, 0.26, 0.5, 4.0] {
            let worst = worst([700.0, 0.02, 0.02 * share], 1e-3);
            assert!(worst < 3e-6, "tau_e / tau_m = {share}: {worst:e}");
        }
    }
}
