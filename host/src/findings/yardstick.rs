//! In what errors are told: in multiples of the noise, or in their own unit where the readings are too smooth to have any.

use super::verdict::{multiple, times};
use crate::compare::measures::Measures;
use crate::report::figure::in_words;

/// A noise level that is a smaller share of the motion is that of a file's decimals or of a filter: a geared motor's encoder has no such steps.
const SMOOTH: f64 = 1e-6;

/// Whether `noise` is that of readings, where a model with this `error` has missed this share of the motion.
pub(super) fn is_known(noise: f64, error: f64, missed: f64) -> bool {
    let motion = if missed > 0.0 { error / missed } else { 0.0 };
    noise > SMOOTH * motion
}

/// What errors on records of one motion are measured by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Yardstick {
    /// Noise level, in the measured unit; none where it is too small to be known.
    noise: Option<f64>,
    unit: &'static str,
}

impl Yardstick {
    /// Of records that `measures` tells a model's errors on, in `unit`, and the level of their `noise`.
    pub fn new(noise: f64, measures: &Measures, unit: &'static str) -> Self {
        Self { noise: is_known(noise, measures.rmse, measures.missed()).then_some(noise), unit }
    }

    /// The noise as it stands on an axis of errors; none where it is not known.
    pub fn noise(&self) -> Option<f64> {
        self.noise.map(|_| 1.0)
    }

    /// `error` in multiples of the noise; none where that is not known.
    pub fn over_noise(&self, error: f64) -> Option<f64> {
        self.noise.map(|noise| error / noise)
    }

    /// `error` as it stands on the axis.
    pub fn on_axis(&self, error: f64) -> f64 {
        self.over_noise(error).unwrap_or(error)
    }

    /// What the axis is called.
    pub fn axis(&self) -> String {
        self.noise
            .map_or_else(|| format!("Error ({})", self.unit), |_| "Error, multiples of the noise (1)".into())
    }

    /// `error` as a multiple of the noise, in words; none where that is not known.
    pub fn multiple(&self, error: f64) -> Option<String> {
        self.over_noise(error).map(multiple)
    }

    /// `error` in words.
    pub fn words(&self, error: f64) -> String {
        self.multiple(error).unwrap_or_else(|| in_words(error, self.unit))
    }

    /// The same beside a point of a plot whose axis tells the rest.
    pub fn label(&self, error: f64) -> String {
        self.over_noise(error).map_or_else(|| in_words(error, self.unit), times)
    }

    /// What is known of the noise.
    pub fn noise_in_words(&self) -> String {
        self.noise.map_or_else(
            || "the noise is too small to be known".into(),
            |noise| format!("the noise level is {}", in_words(noise, self.unit)),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motion of 1 rad rms of which a hundredth is missed.
    fn measures() -> Measures {
        Measures { rmse: 0.01, nrmse_fit_percent: 99.0, ..Measures::default() }
    }

    #[test]
    fn errors_are_told_in_multiples_of_a_noise_that_is_known() {
        let told = Yardstick::new(1e-3, &measures(), "rad");
        assert_eq!((told.words(0.02), told.label(0.02)), ("20 x the noise".into(), "20 x".into()));
        assert_eq!((told.on_axis(0.02), told.noise()), (20.0, Some(1.0)));
        assert_eq!(told.noise_in_words(), "the noise level is 1 mrad");
    }

    #[test]
    fn beside_readings_without_any_steps_errors_are_told_in_their_unit() {
        let told = Yardstick::new(1e-8, &measures(), "rad");
        assert_eq!((told.words(0.02), told.label(0.02)), ("20 mrad".into(), "20 mrad".into()));
        assert_eq!((told.on_axis(0.02), told.noise()), (0.02, None));
        assert_eq!(told.axis(), "Error (rad)");
        assert!(told.noise_in_words().contains("too small"));
    }
}
