//! The verdict, from plain numbers: one word, one sentence, and what to do next.

use serde::Serialize;

/// Multiples of the noise level above which nothing is called explained.
const MANY: f64 = 10.0;

/// How a diagnosis ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing is left that these data can show.
    Explained,
    /// The accepted effects lower the error, and more than noise is left.
    PartlyExplained,
    /// Much is left, and no effect of the library helps.
    Unexplained,
    /// The data must be mended first.
    BadData,
}

/// The errors that a verdict rests on, rms of the simulation in the measured unit, all of the same records.
#[derive(Debug, Clone, Copy)]
pub struct Errors {
    /// Of the base model.
    pub base: f64,
    /// Of the accepted model.
    pub model: f64,
    /// Noise level.
    pub noise: f64,
}

impl Errors {
    /// Error of the accepted model in multiples of the noise level; none without a noise level.
    pub fn left_over(&self) -> Option<f64> {
        (self.noise > 0.0).then(|| self.model / self.noise)
    }

    /// Fraction of the error above the noise level that the effects explain: negative where the error rose, none where
    /// the base model left no more than noise.
    pub fn explained_share(&self) -> Option<f64> {
        let excess = self.base - self.noise;
        (excess > 0.0).then(|| ((self.base - self.model) / excess).min(1.0))
    }

    /// The verdict on `effects` accepted effects, after which no structure was found (`clean`) or some was.
    pub fn verdict(&self, effects: usize, clean: bool) -> Verdict {
        if clean && self.left_over().is_some_and(|n| n <= MANY) {
            Verdict::Explained
        } else if effects > 0 && self.model < self.base {
            Verdict::PartlyExplained
        } else {
            Verdict::Unexplained
        }
    }

    /// The verdict on `effects` in one sentence.
    pub fn headline(&self, effects: &[&str], verdict: Verdict) -> String {
        let left = self.left_over().map_or_else(|| "an unknown multiple of".into(), |n| format!("{n:.1} x"));
        let (names, verb) = (effects.join(" and "), if effects.len() == 1 { "explains" } else { "explain" });
        match (verdict, self.explained_share()) {
            (Verdict::BadData, _) => "The data must be mended before a model can be judged".into(),
            (Verdict::Explained, _) if effects.is_empty() => {
                format!("The model leaves {left} the noise, and these records show no missing effect")
            }
            (_, _) if effects.is_empty() => {
                format!("No effect of the library helps; what is left is {left} the noise")
            }
            (_, Some(share)) if share < 0.0 => {
                format!("With {names} the error rose; what is left is {left} the noise")
            }
            (_, Some(share)) => {
                format!(
                    "{names} {verb} {:.0} % of the error; what is left is {left} the noise",
                    100.0 * share
                )
            }
            (_, None) => format!("With {names} what is left is {left} the noise"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hundred_times_the_noise_is_never_called_explained() {
        let errors = Errors { base: 151.0, model: 151.0, noise: 1.0 };
        assert_eq!(errors.verdict(0, true), Verdict::Unexplained);
        assert!(errors.headline(&[], Verdict::Unexplained).ends_with("151.0 x the noise"));
    }

    #[test]
    fn the_share_and_what_is_left_are_in_one_sentence() {
        let errors = Errors { base: 101.0, model: 4.0, noise: 1.0 };
        assert_eq!(errors.verdict(1, false), Verdict::PartlyExplained);
        let said = errors.headline(&["coulomb"], Verdict::PartlyExplained);
        assert_eq!(said, "coulomb explains 97 % of the error; what is left is 4.0 x the noise");
    }

    #[test]
    fn a_rise_is_called_a_rise() {
        let errors = Errors { base: 2.0, model: 3.0, noise: 1.0 };
        assert_eq!(errors.verdict(1, false), Verdict::Unexplained);
        assert!(errors.headline(&["delay"], Verdict::Unexplained).contains("the error rose"));
    }
}
