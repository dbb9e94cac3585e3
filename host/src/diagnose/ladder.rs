//! The ladder from the base model to the accepted one, and what every effect of the first stage takes away.

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::evidence::Evidence;
use crate::compare::free_run::simulated;
use crate::compare::measures::Measures;
use crate::fit::layout::Values;
use crate::fit::noise::Noise;
use crate::select::fitted::Fitted;
use crate::select::gain::Gain;
use crate::sentence::listed;

/// A model of the sequence, with its errors.
#[derive(Debug, Clone, Serialize)]
pub struct Rung {
    /// Effects in the model.
    pub effects: Vec<Kind>,
    /// Errors on the records fitted.
    pub train: Measures,
    /// Errors on unseen records; none where every record was fitted.
    pub validation: Option<Measures>,
}

#[cfg(test)]
impl Rung {
    /// A model with `effects` that leaves so much, rms, on the records fitted, and on `unseen` ones where there are any.
    pub(crate) fn leaving(effects: &[Kind], train: f64, unseen: Option<f64>) -> Self {
        let measures = |rmse| Measures { rmse, ..Measures::default() };
        Self { effects: effects.to_vec(), train: measures(train), validation: unseen.map(measures) }
    }
}

/// A candidate of the first diagnosis.
#[derive(Debug, Clone, Serialize)]
pub struct Ranked {
    /// The effect.
    pub effect: Kind,
    /// Share of the error that it takes away, 0 ..= 1.
    pub score: f64,
    /// Errors on unseen records with it.
    pub validation: Option<Measures>,
    /// In plain words.
    pub evidence: String,
}

/// `values` on the records fitted, and on unseen ones where there are any.
pub(crate) fn rung(evidence: &Evidence, values: &Values) -> Rung {
    Rung {
        effects: values.kinds(),
        train: simulated(&evidence.whole, values).unwrap_or_default(),
        validation: unseen(evidence, values),
    }
}

/// Errors of kS-kV-kA fitted to the same records; none where they do not give it.
pub(crate) fn baseline(evidence: &Evidence) -> Option<Rung> {
    evidence.usual.as_ref().map(|usual| rung(evidence, &usual.values))
}

/// The errors of `values` running free over the records kept out, if there are any.
fn unseen(evidence: &Evidence, values: &Values) -> Option<Measures> {
    evidence.kept_out.as_ref().and_then(|kept_out| simulated(kept_out, values))
}

/// A change of the error by less than this share is none.
const HARDLY: f64 = 0.005;

/// The `candidates` of a step on `base` in order, with the share of the error above the `noise` that each takes away: every effect once, by the
/// best model that it completes.
pub(crate) fn rank(base: &Fitted, candidates: &[Fitted], noise: &Noise, evidence: &Evidence) -> Vec<Ranked> {
    let mut all: Vec<Ranked> = Vec::new();
    for candidate in candidates {
        let Some(effect) = candidate.kinds().last().copied() else { continue };
        if all.iter().any(|ranked| ranked.effect == effect) {
            continue;
        }
        let [left, before] = [candidate, base].map(|model| model.noise.over(noise));
        let added: Vec<&str> = candidate
            .kinds()
            .iter()
            .filter(|kind| !base.kinds().contains(kind))
            .map(|kind| kind.name())
            .collect();
        all.push(Ranked {
            effect,
            score: share(before, left),
            validation: unseen(evidence, &candidate.values()),
            evidence: evidence_of(&added, 100.0 * left / before, &candidate.gain_over(base)),
        });
    }
    all
}

/// The share of what stands above the noise that is taken away, where errors of so many times the noise stood `before` and are `left`; none
/// where hardly anything stood above it.
fn share(before: f64, left: f64) -> f64 {
    if before - 1.0 < HARDLY { 0.0 } else { ((before - left) / (before - 1.0)).clamp(0.0, 1.0) }
}

/// What speaks for the effects that were `added`, which leave so many `percent` of the error, in words.
fn evidence_of(added: &[&str], percent: f64, gain: &Gain) -> String {
    let names = listed(added);
    let (change, them) = if added.len() == 1 { ("changes", "it") } else { ("change", "them") };
    // What only steps of the voltage show may leave the whole error as it was.
    let left = if percent < 100.0 * (1.0 - HARDLY) {
        format!(
            "with {names} the model leaves {percent:.0} % of what it leaves without {them}, every time scale alike; "
        )
    } else {
        format!("{names} hardly {change} the error as a whole; ")
    };
    format!("{left}on blocks held out its likelihood gains {gain}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_nothing_stands_above_the_noise_no_effect_explains_a_share_of_it() {
        assert_eq!(share(1.0, 1.0), 0.0);
        assert_eq!(share(1.0 + 1e-6, 1.0), 0.0);
        assert_eq!(share(3.0, 2.0), 0.5);
        assert_eq!(share(3.0, 4.0), 0.0);
    }

    #[test]
    fn the_evidence_of_a_pair_names_both_of_its_effects() {
        let gain = Gain { total: 40.0, sure: 1.2 };
        let pair = evidence_of(&["coulomb", "delay"], 100.0, &gain);
        assert!(pair.starts_with("coulomb and delay hardly change the error as a whole; "), "{pair}");
        let one = evidence_of(&["delay"], 60.0, &gain);
        assert!(one.starts_with("with delay the model leaves 60 % of what it leaves without it,"), "{one}");
    }
}
