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

/// The `candidates` of the first step in order, with the share of the error that each takes away from `base`, as multiples of the noise.
pub(crate) fn rank(base: &Fitted, candidates: &[Fitted], noise: &Noise, evidence: &Evidence) -> Vec<Ranked> {
    let excess = |model: &Fitted| model.noise.over(noise) - 1.0;
    candidates
        .iter()
        .filter_map(|c| {
            let effect = *c.kinds().last()?;
            let gain = c.gain_over(base);
            let percent = 100.0 * c.noise.over(noise) / base.noise.over(noise);
            Some(Ranked {
                effect,
                score: (1.0 - excess(c) / excess(base).max(1e-9)).clamp(0.0, 1.0),
                validation: unseen(evidence, &c.values()),
                evidence: evidence_of(effect, percent, &gain),
            })
        })
        .collect()
}

/// What speaks for `effect`, which leaves so many `percent` of the error, in words.
fn evidence_of(effect: Kind, percent: f64, gain: &Gain) -> String {
    // What only steps of the voltage show may leave the whole error as it was.
    let left = if percent < 99.5 {
        format!(
            "with {effect} the model leaves {percent:.0} % of what the base model leaves, every time scale alike; "
        )
    } else {
        format!("{effect} hardly changes the error as a whole; ")
    };
    format!("{left}on blocks held out its likelihood gains {gain}")
}
