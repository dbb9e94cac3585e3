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
}
