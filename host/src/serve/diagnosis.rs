//! What is missing from the current model, and what to run next to be sure.

use std::sync::Arc;

use motorlens_shared::effects::Kind;

use super::open::Open;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::ladder;
use crate::diagnose::plan::Limits;
use crate::findings::{Experiment, NextExperiment};
use crate::report::{DRAWN, Suspect, evidence};
use crate::select::DetectionLimit;
use crate::select::adequacy::Adequacy;
use crate::select::fitted::Fitted;
use crate::select::limits::detection_limits;
use crate::select::run::{alike, step_up};

/// Effects that were tried on a model.
#[derive(Debug, Clone, Default)]
pub struct Diagnosis {
    /// With their parameters, best first.
    pub candidates: Vec<Fitted>,
    /// The same as they are told; the first few with what shows them.
    pub suspects: Vec<Suspect>,
    /// What the records cannot tell from the effect that is suggested.
    pub open: Option<Arc<Open>>,
    /// The experiment that would tell them apart, where there are any.
    pub next: Option<NextExperiment>,
    /// What the records would have shown of every further effect.
    pub limits: Vec<DetectionLimit>,
    /// What the model leaves.
    pub left: Adequacy,
    /// The effect that is worth adding, if any: the first of the suspects.
    pub suggested: Option<Kind>,
}

impl Diagnosis {
    /// What `candidates`, tried on `model`, tell; `base` is the model without effects,
    /// `floor` the noise of the readings, rms, `library` the effects that may be added, `open` what the effects of `model` leave open.
    pub fn new(
        evidence: &Evidence,
        base: &Fitted,
        model: &Fitted,
        floor: f64,
        mut candidates: Vec<Fitted>,
        library: &[Kind],
        open: &[Arc<Open>],
    ) -> Self {
        let best = step_up(evidence, base, model, &mut candidates);
        let suggested = best.as_ref().and_then(|best| best.kinds().last().copied());
        // Searched to its end the first may fail where a later one holds: what is suggested stands first.
        if let Some(place) = candidates.iter().position(|c| c.kinds().last().copied() == suggested) {
            candidates[..=place].rotate_right(1);
        }
        let noise = evidence.noise_under(best.as_ref().unwrap_or(model));
        let ranked = ladder::rank(model, &candidates, &noise, evidence);
        let suspects = ranked.into_iter().enumerate().map(|(place, ranked)| {
            let completed = |c: &&Fitted| c.kinds().last() == Some(&ranked.effect);
            let tried = candidates.iter().find(completed).filter(|_| place < DRAWN);
            let drawn = |c: &Fitted| evidence::of(evidence, ranked.effect, &c.values());
            Suspect { figures: tried.map_or_else(Vec::new, drawn), ranked }
        });
        let suspects = suspects.collect();
        let found = best.and_then(|best| alike(evidence, &best, candidates.clone(), base));
        let found = found.map(|set| Arc::new(Open::new(set, evidence)));
        // Where nothing is suggested, what the first of the accepted effects left open is to be told apart, as after `discover`.
        let asked = found.as_ref().or_else(|| open.first().filter(|_| suggested.is_none()));
        let among: Vec<&Fitted> = asked.map_or_else(Vec::new, |open| open.set.models.iter().collect());
        let left = Adequacy::of(evidence, base, model, floor);
        let limits = match suggested {
            Some(_) => Vec::new(),
            None => detection_limits(evidence, base, model, library, left),
        };
        let next = Experiment::after(evidence, model, &among, &limits, Limits::of(evidence)).next;
        Self { suspects, open: found, next, limits, left, suggested, candidates }
    }
}
