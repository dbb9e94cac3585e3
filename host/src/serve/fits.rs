//! The searches of the page: what is missing, add it, remove it.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use motorlens_shared::effects::Kind;
use motorlens_shared::simulator::MAX_EFFECTS;
use serde::Deserialize;
use serde_json::json;

use super::App;
use super::diagnosis::Diagnosis;
use super::jobs::{self, Answer, End, Job, refused};
use super::session::rung;
use super::steps;
use crate::diagnose::candidate::Candidate;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::stage::{self, Effort};
use crate::diagnose::worth::worth;
use crate::fit::layout::Values;

/// Copies to work on while the page goes on with the originals.
struct Work {
    evidence: Evidence,
    model: Candidate,
}

impl Work {
    fn of(app: &App) -> Self {
        let session = app.session();
        Self { evidence: session.evidence.clone(), model: session.current.clone() }
    }
}

/// Unwinds out of a stage whose user wants it to stop.
struct Stopped;

/// Tries `library`, telling which effect is on trial; none when stopped.
fn tried(job: &Job, work: &Work, library: &[Kind]) -> Option<Vec<Candidate>> {
    let mut count = 0;
    let effort = if work.model.kinds().is_empty() { Effort::FIRST } else { Effort::LATER };
    let found = catch_unwind(AssertUnwindSafe(|| {
        stage::run(&work.evidence, &work.model, library, effort, &mut |effect| {
            if job.stopped() {
                resume_unwind(Box::new(Stopped));
            }
            count += 1;
            let title = effect.spec().title;
            job.tell(json!({ "type": "trying", "effect": title, "done": count, "of": library.len() }));
        })
    }));
    match found {
        Ok(found) => (!job.stopped()).then_some(found),
        Err(cause) if cause.is::<Stopped>() => None,
        Err(cause) => resume_unwind(cause),
    }
}

fn stopped() -> End {
    End::Stopped("Stopped. The model is as it was.".into())
}

/// What is missing from the current model?
pub async fn diagnose(State(app): State<Arc<App>>) -> Answer {
    jobs::start(&app, "Looking for what is missing", |job| {
        let work = Work::of(job.app);
        let Some(found) = tried(job, &work, Kind::ALL) else { return stopped() };
        let diagnosis = Diagnosis::new(&work.evidence, &work.model, found);
        let message = if diagnosis.worth {
            "The best suspect comes first. Add it and watch the error fall."
        } else {
            "Nothing of the library is worth adding to this model."
        };
        End::Done(message.into(), Box::new(move |session| session.diagnosis = Some(Arc::new(diagnosis))))
    })
}

/// Which effect.
#[derive(Debug, Deserialize)]
pub struct Which {
    effect: String,
}

impl Which {
    fn kind(&self) -> Result<Kind, (StatusCode, Json<serde_json::Value>)> {
        Kind::by_name(&self.effect)
            .ok_or_else(|| refused(StatusCode::UNPROCESSABLE_ENTITY, "there is no effect of that name"))
    }
}

/// Searches from `begin`, telling each step, and makes the result the session's model.
fn refit(job: &Job, work: &Work, begin: &Values, message: impl FnOnce(&Candidate) -> String) -> End {
    let mut tell = |step: steps::Step| job.tell(json!({ "type": "step", "step": step }));
    let stop = || job.stopped();
    match steps::search(&work.evidence, begin, &work.model.values(), &stop, &mut tell) {
        Some(new) => {
            let (message, rung) = (message(&new), rung(&work.evidence, &new));
            End::Done(message, Box::new(move |session| session.step_to(new, rung)))
        }
        None => stopped(),
    }
}

/// Adds an effect and fits everything again.
pub async fn add(State(app): State<Arc<App>>, Json(which): Json<Which>) -> Answer {
    let kind = which.kind()?;
    let has = app.session().current.kinds().to_vec();
    if has.contains(&kind) || has.len() >= MAX_EFFECTS {
        return Err(refused(
            StatusCode::CONFLICT,
            "the model has it already, or has as many effects as it can",
        ));
    }
    jobs::start(&app, &format!("Adding {kind}"), move |job| {
        let work = Work::of(job.app);
        let diagnosis = job.app.session().diagnosis.clone();
        let known = diagnosis
            .and_then(|d| d.candidates.iter().find(|c| c.kinds().last() == Some(&kind)).cloned())
            .map_or_else(|| tried(job, &work, &[kind]), |c| Some(vec![c]));
        let Some(known) = known else { return stopped() };
        let Some(known) = known.first() else {
            return End::Failed(json!({ "why": format!("{kind} cannot be added to this model") }));
        };
        // The old parameters start where they are, so that one sees them give way.
        let parameters = known.values().effects.pop().map(|e| e.1).unwrap_or_default();
        let begin = work.model.values().with(kind, parameters);
        refit(job, &work, &begin, |new| {
            let but = if worth(new, &work.model) {
                "."
            } else {
                ", but unseen data do not say that it is worth its parameters. Remove it?"
            };
            format!("{kind} is in the model{but}")
        })
    })
}

/// Takes an effect out and fits the rest again.
pub async fn remove(State(app): State<Arc<App>>, Json(which): Json<Which>) -> Answer {
    let kind = which.kind()?;
    if !app.session().current.kinds().contains(&kind) {
        return Err(refused(StatusCode::CONFLICT, "the model does not have it"));
    }
    jobs::start(&app, &format!("Removing {kind}"), move |job| {
        let work = Work::of(job.app);
        let begin = work.model.values().without(kind);
        refit(job, &work, &begin, |_| format!("{kind} is out of the model."))
    })
}
