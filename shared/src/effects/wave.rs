//! A sine and a cosine of one angle, as one sine: half the polynomials of a step.

use core::f64::consts::TAU;

use crate::scalar::Scalar;

/// `sine sin(a) + cosine cos(a)`, prepared.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wave<S> {
    amplitude: S,
    /// In turns.
    lead: S,
}

impl<S: Scalar> Wave<S> {
    /// Of the two components.
    #[inline(always)]
    pub(super) fn new(sine: S, cosine: S) -> Self {
        Self {
            amplitude: sine.map_with(cosine, libm::hypot),
            lead: cosine.map_with(sine, |cosine, sine| libm::atan2(cosine, sine) / TAU),
        }
    }
    /// Its value at an angle in turns.
    #[inline(always)]
    pub(super) fn at(&self, turn: S) -> S {
        self.amplitude * (turn + self.lead).sin_turns()
    }

    /// The mean of the wave over an even motion from `turn - half` to `turn + half`, in turns.
    ///
    /// sin(d) / d with d = 2 pi half, to 0.2 % of the wave up to its first zero, where a whole period is passed; more
    /// than that counts as nothing (truly a fifth at most).
    #[inline(always)]
    pub(super) fn mean(&self, turn: S, half: S) -> S {
        let passed = (half + half).abs().min(S::one());
        let q = passed * passed;
        let flat = S::lit(-0.166_808).mul_add(q, S::lit(0.811_742));
        let flat = flat.mul_add(q, S::lit(-1.644_934)).mul_add(q, S::one());
        flat * self.at(turn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sine_is_the_sum_of_a_sine_and_a_cosine() {
        for (sine, cosine) in [(0.3, -0.7), (-2.0, 0.0), (0.0, 1.5), (-0.1, -0.2), (0.0, 0.0)] {
            let wave = Wave::new(sine, cosine);
            for k in -20..20 {
                let turn = 0.137 * f64::from(k);
                let truth = sine * libm::sin(TAU * turn) + cosine * libm::cos(TAU * turn);
                assert!((wave.at(turn) - truth).abs() < 2e-8, "{sine} {cosine} {turn}");
            }
        }
    }

    #[test]
    fn a_motion_through_the_wave_meets_its_mean() {
        let wave = Wave::new(0.6, -0.3);
        for half in [0.0, 0.01, 0.1, 0.2, 0.3, 0.4, 0.499] {
            for turn in [0.0, 0.13, 0.6] {
                let truth: f64 = (0..2000)
                    .map(|k| wave.at(turn + half * ((f64::from(k) + 0.5) / 1000.0 - 1.0)))
                    .sum::<f64>()
                    / 2000.0;
                assert!((wave.mean(turn, half) - truth).abs() < 2e-3, "{half} {turn}");
            }
        }
        assert!(wave.mean(0.2, -3.7_f64).abs() < 1e-6);
    }
}
