//! A record made ready for the filter: voltage, its integral and the measurement, side by side.

use super::discrete::{Hold, Kind};
use crate::scalar::Scalar;

/// Voltage in V, its integral in V s, and the measurement (rad from the first sample, or rad/s).
pub type Sample<T> = [T; 3];

/// Turns a record into samples one by one, so that the board can do it while it measures.
#[derive(Debug, Clone, Copy)]
pub struct Prepare {
    step: f64,
    hold: Hold,
    kind: Kind,
    before: Option<f64>,
    integral: f64,
    origin: f64,
}

impl Prepare {
    /// `step` is the time between samples in s.
    #[must_use]
    pub const fn new(step: f64, hold: Hold, kind: Kind) -> Self {
        Self { step, hold, kind, before: None, integral: 0.0, origin: 0.0 }
    }

    /// The next sample. `voltage` in V; `measured` in rad or rad/s.
    pub fn push(&mut self, voltage: f64, measured: f64) -> Sample<f64> {
        match self.before {
            None => {
                if self.kind == Kind::Angle {
                    self.origin = measured;
                }
            }
            Some(before) => {
                let mean = match self.hold {
                    Hold::Zero => before,
                    Hold::First => 0.5 * (before + voltage),
                };
                self.integral += self.step * mean;
            }
        }
        self.before = Some(voltage);
        [voltage, self.integral, measured - self.origin]
    }

    /// [`Self::push`], rounded to the numbers that a kernel runs on.
    pub fn push_as<T: Scalar>(&mut self, voltage: f64, measured: f64) -> Sample<T> {
        self.push(voltage, measured).map(T::lit)
    }
}

#[cfg(test)]
mod tests {
    use super::{Hold, Kind, Prepare};

    #[test]
    fn the_integral_is_exact_for_both_holds() {
        let volts = [2.0, 4.0, -1.0];
        let run = |hold| {
            let mut prepare = Prepare::new(0.5, hold, Kind::Angle);
            volts.map(|v| prepare.push(v, 0.0)[1])
        };
        assert_eq!(run(Hold::Zero), [0.0, 1.0, 3.0]);
        assert_eq!(run(Hold::First), [0.0, 1.5, 2.25]);
    }

    #[test]
    fn angles_count_from_the_first_sample_and_speeds_do_not() {
        for (kind, expected) in [(Kind::Angle, [0.0, 0.5]), (Kind::Speed, [7.0, 7.5])] {
            let mut prepare = Prepare::new(0.1, Hold::Zero, kind);
            assert_eq!([7.0, 7.5].map(|y| prepare.push(1.0, y)[2]), expected);
        }
    }
}
