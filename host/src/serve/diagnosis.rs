//! What is missing from the current model, and what to run next to be sure.

use motorlens_shared::effects::Kind;
use motorlens_shared::excitation::Programme;
use serde::Serialize;

use crate::diagnose::candidate::Candidate;
use crate::diagnose::climb::{Climb, best_first};
use crate::diagnose::evidence::Evidence;
use crate::diagnose::ladder;
use crate::diagnose::plan::{self, Limits};
use crate::diagnose::rivals::{self, Rivals};
use crate::diagnose::worth::{simplest, worth};
use crate::report::{DRAWN, Suspect, evidence};

/// Effects that were tried on a model.
#[derive(Debug, Clone, Default)]
pub struct Diagnosis {
    /// With their parameters, best first.
    pub candidates: Vec<Candidate>,
    /// The same as they are told; the first few with what shows them.
    pub suspects: Vec<Suspect>,
    /// Sets that cannot be told apart.
    pub rivals: Vec<Vec<Kind>>,
    /// The experiment that would tell them apart, where there are any.
    pub next: Option<Next>,
    /// Whether the first suspect is worth adding.
    pub worth: bool,
}

/// An experiment, and what it would show.
#[derive(Debug, Clone, Serialize)]
pub struct Next {
    /// What it would show.
    pub why: String,
    /// What to play.
    pub programme: Programme,
}

/// Longest programme that is proposed, s.
const LONGEST_S: f64 = 8.0;

impl Diagnosis {
    /// What `candidates`, tried on `model`, tell.
    pub fn new(evidence: &Evidence, model: &Candidate, candidates: Vec<Candidate>) -> Self {
        let best = simplest(&candidates).cloned();
        let worth = best.as_ref().is_some_and(|best| worth(best, model));
        let rungs = std::iter::once(model.clone()).chain(best).collect();
        let climb =
            Climb { rungs, first: best_first(&candidates), refused: Vec::new(), withdrawn: Vec::new() };
        let ranked = ladder::rank(&climb, evidence);
        let found = rivals::rivals(evidence, &climb, &[]);
        let of = |kind: Kind| climb.first.iter().find(|c| c.kinds().last() == Some(&kind));
        let suspects = ranked.into_iter().enumerate().map(|(place, ranked)| {
            let tried = of(ranked.effect).filter(|_| place < DRAWN);
            let drawn = |c: &Candidate| evidence::of(evidence, ranked.effect, &c.values());
            Suspect { figures: tried.map_or_else(Vec::new, drawn), ranked }
        });
        let suspects = suspects.collect();
        let among: Vec<&Candidate> = found.first().into_iter().flat_map(|set| &set.models).collect();
        let limits = Limits { volts: evidence.highest_voltage(), seconds: LONGEST_S };
        let next = plan::choose(&evidence.whole, &among, limits);
        let next = next.map(|plan| Next { why: plan.why(), programme: plan.programme });
        let rivals = found.iter().map(Rivals::kinds).collect();
        Self { suspects, rivals, next, worth, candidates: climb.first }
    }
}
