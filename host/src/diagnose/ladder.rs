//! The ladder from the base model to the accepted one, and what every effect of the first stage takes away.

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::climb::Climb;
use super::evidence::Evidence;
use crate::compare::free_run::{free_runs, pooled};
use crate::compare::measures::Measures;
use crate::fit::layout::Values;

/// A rung of the ladder.
#[derive(Debug, Clone, Serialize)]
pub struct Rung {
    /// Effects in the model.
    pub effects: Vec<Kind>,
    /// Errors on the records fitted.
    pub train: Measures,
    /// Errors on unseen records; none where every record was fitted.
    pub validation: Option<Measures>,
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
        train: pooled(&free_runs(&evidence.whole, values)).unwrap_or_default(),
        validation: unseen(evidence, values),
    }
}

/// The errors of `values` running free over the records kept out, if there are any.
fn unseen(evidence: &Evidence, values: &Values) -> Option<Measures> {
    evidence.kept_out.as_ref().and_then(|kept_out| pooled(&free_runs(kept_out, values)))
}

/// The first stage in order, with the share of the base model's error that each takes away.
pub(crate) fn rank(climb: &Climb, evidence: &Evidence) -> Vec<Ranked> {
    let base = &climb.rungs[0];
    climb
        .first
        .iter()
        .map(|c| {
            let share = |new: f64, old: f64| 1.0 - new / old;
            let score = share(c.train.increments, base.train.increments)
                .min(share(c.unseen.increments, base.unseen.increments))
                .clamp(0.0, 1.0);
            let effect = c.kinds()[c.kinds().len() - 1];
            Ranked {
                effect,
                score,
                validation: unseen(evidence, &c.values()),
                evidence: format!(
                    "with {effect} the error is {:.0} % of the base model's on the records fitted, and {:.0} % on blocks held out",
                    100.0 * c.train.increments / base.train.increments,
                    100.0 * c.unseen.increments / base.unseen.increments
                ),
            }
        })
        .collect()
}
