//! Exact discretisation of the second-order part, in closed form.

use super::laned::Laned;
use crate::motor::Combinations;
use nalgebra::Complex;
use serde::{Deserialize, Serialize};

/// What the voltage does between two samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Hold {
    /// It stays: a drive that holds its command.
    Zero,
    /// It moves on a straight line: a sampled smooth voltage.
    First,
}

/// What was measured at the output shaft.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// rad.
    Angle,
    /// rad/s.
    Speed,
}

/// One candidate (or one per lane) as a difference equation of two states, `sum` and `change`.
///
/// ```text
/// prediction = gain integral + from_voltage u + from_sum sum + from_change change
/// change' = u + restoring sum + keeping change
/// sum'    = sum + change
/// ```
///
/// This form and not the shorter w\[n\] = u + d1 w\[n-1\] + d2 w\[n-2\], because for slow poles d1 + d2 comes
/// close to 1 and what is left of it after rounding to `f32` would be wrong by percents; here that rest,
/// `restoring`, is stored by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filter<T> {
    /// rad/(V s) for angle; 0 for speed.
    pub gain: T,
    /// Direct part; 0 for a held voltage.
    pub from_voltage: T,
    /// Weight of the sum.
    pub from_sum: T,
    /// Weight of the change.
    pub from_change: T,
    /// -(1 - e1)(1 - e2), with e1 and e2 the discrete poles.
    pub restoring: T,
    /// e1 + e2 - 1.
    pub keeping: T,
}

/// Response of one pole over one step: x\[n+1\] = (1 + grown) x\[n\] + old u\[n\] + new u\[n+1\].
struct PoleStep<P> {
    grown: P,
    old: P,
    new: P,
}

impl Filter<f64> {
    /// Exact for a voltage that obeys `hold`, at any `step` (s), for real, equal and complex poles.
    ///
    /// Equal poles are moved apart by 1e-10 of their squared sum, which moves the response by less than 1e-9.
    #[must_use]
    pub fn new(motor: &Combinations, step: f64, hold: Hold, kind: Kind) -> Self {
        let (alpha, beta) = (motor.a2_over_a1, motor.a3_over_a1);
        // Numerator c1 s + c0 of the second-order part of the prediction.
        let (gain, s1, s0) = match kind {
            Kind::Angle => (motor.gain(), -motor.gain(), -motor.gain() * alpha),
            Kind::Speed => (0.0, 0.0, motor.b_over_a1),
        };
        let mut discriminant = alpha * alpha - 4.0 * beta;
        let apart = 1e-10 * alpha * alpha;
        if discriminant.abs() < apart {
            discriminant = apart;
        }
        // Weights of u and of the older inputs, decay product, and the two numbers of the recursion.
        let (direct, older, product, closing, keeping);
        if discriminant > 0.0 {
            let root = libm::sqrt(discriminant);
            let p2 = -0.5 * (alpha + root);
            let p1 = beta / p2; // from the product: the difference would lose its digits
            let r1 = (s1 * p1 + s0) / (p1 - p2);
            let r2 = (s1 * p2 + s0) / (p2 - p1);
            let (a, b) = (real_pole(p1, step, hold), real_pole(p2, step, hold));
            direct = r1 * a.new + r2 * b.new;
            older = r1 * a.old * (b.grown + 1.0) + r2 * b.old * (a.grown + 1.0);
            product = (a.grown + 1.0) * (b.grown + 1.0);
            closing = a.grown * b.grown;
            keeping = 1.0 + a.grown + b.grown;
        } else {
            let p = Complex::new(-0.5 * alpha, 0.5 * libm::sqrt(-discriminant));
            let r = (p * s1 + s0) / Complex::new(0.0, 2.0 * p.im);
            let a = complex_pole(p, step, hold);
            let decay = a.grown + 1.0;
            // The conjugate pole adds the conjugate: twice the real part.
            direct = 2.0 * (r * a.new).re;
            older = 2.0 * (r * a.old * decay.conj()).re;
            product = decay.norm_sqr();
            closing = a.grown.norm_sqr();
            keeping = 1.0 + 2.0 * a.grown.re;
        }
        // A steady input gives the steady output s0 / beta, exactly: no difference of near-equal numbers.
        let from_sum = closing * (s0 / beta - direct);
        Self {
            gain,
            from_voltage: direct,
            from_sum,
            from_change: from_sum + product * direct + older,
            restoring: -closing,
            keeping,
        }
    }
}

impl<T: Laned> Filter<T> {
    /// One candidate per lane; lanes past the end of `candidates` repeat the last.
    ///
    /// # Panics
    /// Where `candidates` is empty.
    #[inline(always)]
    #[must_use]
    pub fn gather(candidates: &[Filter<f64>]) -> Self {
        let last = candidates.len() - 1;
        macro_rules! lanes_of {
            ($($field:ident),*) => {
                Self { $($field: T::from_lanes(|lane| candidates[lane.min(last)].$field)),* }
            };
        }
        lanes_of!(gain, from_voltage, from_sum, from_change, restoring, keeping)
    }
}

/// With x = p T, phi1 = (e^x - 1)/x and phi2 = (e^x - 1 - x)/x^2: old = T (phi1 - phi2), new = T phi2.
fn real_pole(p: f64, step: f64, hold: Hold) -> PoleStep<f64> {
    let x = p * step;
    let grown = libm::expm1(x);
    let whole = if x == 0.0 { step } else { grown / p };
    if hold == Hold::Zero {
        return PoleStep { grown, old: whole, new: 0.0 };
    }
    let new = if x.abs() < SMALL {
        step * TAYLOR.iter().rev().fold(0.0, |sum, c| sum * x + c)
    } else {
        (whole - step) / x
    };
    PoleStep { grown, old: whole - new, new }
}

/// The same for one of a pair of conjugate poles.
fn complex_pole(p: Complex<f64>, step: f64, hold: Hold) -> PoleStep<Complex<f64>> {
    let x = p * step;
    let (sin, cos) = libm::sincos(x.im);
    let half = libm::sin(0.5 * x.im);
    let grown = libm::expm1(x.re);
    // e^x - 1 without cancellation for a slow turn.
    let grown = Complex::new(grown * cos - 2.0 * half * half, (grown + 1.0) * sin);
    let whole = grown / p;
    if hold == Hold::Zero {
        return PoleStep { grown, old: whole, new: Complex::new(0.0, 0.0) };
    }
    let new = if x.norm_sqr() < SMALL * SMALL {
        let zero = Complex::new(0.0, 0.0);
        TAYLOR.iter().rev().fold(zero, |sum, c| sum * x + *c) * step
    } else {
        (whole - step) / x
    };
    PoleStep { grown, old: whole - new, new }
}

/// Below this |p T|, phi2 is summed as a series: the closed form would lose digits.
const SMALL: f64 = 0.1;
/// 1/(k + 2)!, which leaves 1e-16 at [`SMALL`].
const TAYLOR: [f64; 9] = [
    0.5,
    1.0 / 6.0,
    1.0 / 24.0,
    1.0 / 120.0,
    1.0 / 720.0,
    1.0 / 5040.0,
    1.0 / 40_320.0,
    1.0 / 362_880.0,
    1.0 / 3_628_800.0,
];

#[cfg(test)]
mod tests {
    use super::{Filter, Hold, Kind};
    use crate::linear::{Prepare, State};
    use crate::motor::Combinations;

    /// theta''' + alpha theta'' + beta theta' = b V by 200 fourth-order Runge-Kutta steps per sample.
    fn integrated(m: &Combinations, volts: &[f64], step: f64, hold: Hold, kind: Kind) -> std::vec::Vec<f64> {
        let rate =
            |x: [f64; 3], v: f64| [x[1], x[2], m.b_over_a1 * v - m.a3_over_a1 * x[1] - m.a2_over_a1 * x[2]];
        let moved = |x: [f64; 3], k: [f64; 3], h: f64| [x[0] + h * k[0], x[1] + h * k[1], x[2] + h * k[2]];
        let mut x = [0.0; 3];
        let mut out = std::vec![0.0];
        let parts = 200;
        for pair in volts.windows(2) {
            for part in 0..parts {
                let h = step / f64::from(parts);
                let at = |fraction: f64| match hold {
                    Hold::Zero => pair[0],
                    Hold::First => pair[0] + (pair[1] - pair[0]) * fraction,
                };
                let begin = f64::from(part) / f64::from(parts);
                let middle = begin + 0.5 / f64::from(parts);
                let end = begin + 1.0 / f64::from(parts);
                let k1 = rate(x, at(begin));
                let k2 = rate(moved(x, k1, 0.5 * h), at(middle));
                let k3 = rate(moved(x, k2, 0.5 * h), at(middle));
                let k4 = rate(moved(x, k3, h), at(end));
                for i in 0..3 {
                    x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
                }
            }
            out.push(if kind == Kind::Angle { x[0] } else { x[1] });
        }
        out
    }

    fn worst(m: &Combinations, step: f64) -> f64 {
        let volts: [f64; 60] =
            core::array::from_fn(|k| 5.0 * libm::sin(0.3 * k as f64) + if k > 30 { -4.0 } else { 0.0 });
        let mut worst = 0.0_f64;
        for hold in [Hold::Zero, Hold::First] {
            for kind in [Kind::Angle, Kind::Speed] {
                let truth = integrated(m, &volts, step, hold, kind);
                let scale = truth.iter().fold(1e-9_f64, |a, b| a.max(b.abs()));
                let filter = Filter::new(m, step, hold, kind);
                let mut prepare = Prepare::new(step, hold, kind);
                let mut state = State::default();
                for (v, y) in volts.iter().zip(truth) {
                    // The first measurement is 0, so the prepared one is the true one.
                    let error = filter.error(&mut state, prepare.push(*v, y));
                    worst = worst.max(error.abs() / scale);
                }
            }
        }
        worst
    }

    #[test]
    fn real_equal_and_complex_poles_agree_with_a_very_fine_integration() {
        // Last column: the bar. Where a record spans a thousandth of the slowest decay, the motion is 1e-7 of
        // the integral that it is the difference to, and so many digits are lost.
        for (gain, alpha, beta, step, bar) in [
            (0.9, 300.0, 5000.0, 1e-2, 1e-9), // real, far apart
            (0.9, 40.0, 400.0, 1e-2, 1e-9),   // equal
            (0.9, 40.0, 399.9, 1e-2, 1e-9),   // nearly equal
            (0.9, 40.0, 400.1, 1e-2, 1e-9),   // nearly equal, complex
            (2.7, 1.08, 19.6, 1e-2, 1e-9),    // the paper's printed Table 1: it rings
            (0.9, 40.0, 4000.0, 1e-3, 1e-9),  // fast ringing, fine sampling
            (0.9, 0.03, 1e-4, 1e-3, 1e-6),    // slow: |p T| = 1e-5
            (0.9, 1e-3, 1e-2, 1e-3, 1e-6),    // slow ringing
        ] {
            let m = Combinations { b_over_a1: gain * beta, a2_over_a1: alpha, a3_over_a1: beta };
            let worst = worst(&m, step);
            assert!(worst < bar, "alpha {alpha}, beta {beta}: {worst:e}");
        }
    }

    #[test]
    fn poles_much_faster_than_the_sampling_stay_finite_and_settle() {
        let m = Combinations::from_gain_and_rates(0.8, 20.0, 1e7);
        let filter = Filter::new(&m, 0.01, Hold::Zero, Kind::Speed);
        let mut state = State::default();
        let last = (0..400).fold(0.0, |_, _| filter.error(&mut state, [6.0, 0.0, 0.0]));
        assert!((last - 0.8 * 6.0).abs() < 1e-9);
    }
}
