//! Long work: one job at a time, told as it goes, stopped when asked.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError};

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use motorlens_shared::effects::Kind;
use motorlens_shared::simulator::MAX_EFFECTS;
use serde::Deserialize;
use serde_json::{Value, json};

use super::App;
use super::steps::{self, Step};
use crate::diagnose::candidate::{Candidate, Evidence};
use crate::diagnose::climb::worth;
use crate::diagnose::stage::{self, Effort};

/// An answer, or why not.
pub type Answer = Result<Json<Value>, (StatusCode, Json<Value>)>;

/// A refusal with its reason.
pub fn refused(status: StatusCode, why: &str) -> (StatusCode, Json<Value>) {
    (status, Json(json!({ "why": why })))
}

/// How a job ends.
pub enum End {
    /// With this message.
    Done(String),
    /// As the user wished.
    Stopped,
    /// With what is wrong.
    Failed(Value),
}

/// Unwinds out of a search whose user wants it to stop.
struct Stopped;

/// Starts `work` in a thread of its own, if nothing else runs.
pub fn start(
    app: &Arc<App>,
    what: &str,
    work: impl FnOnce(&App, &AtomicBool) -> End + Send + 'static,
) -> Answer {
    let mut running = app.job.lock().unwrap_or_else(PoisonError::into_inner);
    if running.is_some() {
        return Err(refused(StatusCode::CONFLICT, "something else is running; stop it first"));
    }
    let stop = Arc::new(AtomicBool::new(false));
    *running = Some(Arc::clone(&stop));
    drop(running);
    app.tell(json!({ "type": "started", "what": what }));
    let app = Arc::clone(app);
    std::thread::spawn(move || {
        let end = catch_unwind(AssertUnwindSafe(|| work(&app, &stop)));
        *app.job.lock().unwrap_or_else(PoisonError::into_inner) = None;
        app.tell(match end {
            Ok(End::Done(message)) => json!({ "type": "done", "message": message }),
            Ok(End::Stopped) => json!({ "type": "stopped" }),
            Ok(End::Failed(error)) => json!({ "type": "failed", "error": error }),
            Err(cause) if cause.is::<Stopped>() => json!({ "type": "stopped" }),
            Err(_) => {
                json!({ "type": "failed", "error": { "why": "the search failed; please report these logs" } })
            }
        });
    });
    Ok(Json(json!({ "started": true })))
}

/// Asks the running job to stop.
pub async fn stop(State(app): State<Arc<App>>) -> Answer {
    match &*app.job.lock().unwrap_or_else(PoisonError::into_inner) {
        Some(job) => job.store(true, Ordering::Relaxed),
        None => return Err(refused(StatusCode::CONFLICT, "nothing is running")),
    }
    Ok(Json(json!({ "stopping": true })))
}

/// A copy to work on while the page goes on with the original.
fn copy(app: &App) -> (Evidence, Candidate) {
    let session = app.session();
    let e = &session.evidence;
    let evidence = Evidence {
        whole: e.whole.clone_without_count(),
        train: e.train.clone_without_count(),
        unseen: e.unseen.clone_without_count(),
        floor: e.floor,
    };
    (evidence, session.current.clone())
}

fn tell_step(app: &App, step: &Step) {
    app.tell(json!({ "type": "step", "step": step }));
}

/// Tries `library` on `model`, telling which effect is on trial.
fn tried(
    app: &App,
    stop: &AtomicBool,
    evidence: &Evidence,
    model: &Candidate,
    library: &[Kind],
) -> Vec<Candidate> {
    let mut count = 0;
    let effort = if model.kinds().is_empty() { Effort::FIRST } else { Effort::LATER };
    stage::run(evidence, model, library, effort, &mut |effect| {
        if stop.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Stopped));
        }
        count += 1;
        let title = effect.spec().title;
        app.tell(json!({ "type": "trying", "effect": title, "done": count, "of": library.len() }));
    })
}

/// What is missing from the current model?
pub async fn diagnose(State(app): State<Arc<App>>) -> Answer {
    start(&app, "Looking for what is missing", |app, stop| {
        let (evidence, model) = copy(app);
        let found = tried(app, stop, &evidence, &model, Kind::ALL);
        if stop.load(Ordering::Relaxed) {
            return End::Stopped;
        }
        let good = found.first().is_some_and(|best| worth(best, &model));
        app.session().diagnosed(found);
        End::Done(if good {
            "The best suspect comes first. Add it and watch the error fall.".into()
        } else {
            "Nothing of the library is worth adding to this model.".into()
        })
    })
}

/// Which effect.
#[derive(Debug, Deserialize)]
pub struct Which {
    effect: String,
}

impl Which {
    fn kind(&self) -> Result<Kind, (StatusCode, Json<Value>)> {
        Kind::by_name(&self.effect)
            .ok_or_else(|| refused(StatusCode::UNPROCESSABLE_ENTITY, "there is no effect of that name"))
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
    start(&app, &format!("Adding {kind}"), move |app, stop| {
        let (evidence, model) = copy(app);
        let known = app
            .session()
            .diagnosis
            .as_ref()
            .and_then(|d| d.candidates.iter().find(|c| c.kinds().last() == Some(&kind)).cloned());
        let known = known.or_else(|| tried(app, stop, &evidence, &model, &[kind]).into_iter().next());
        let Some(known) = known else {
            return End::Failed(json!({ "why": format!("{kind} cannot be added to this model") }));
        };
        // The old parameters start where they are, so that one sees them give way.
        let parameters = known.values().effects.pop().map(|e| e.1).unwrap_or_default();
        let begin = model.values().with(kind, parameters);
        let Some(new) = steps::search(&evidence, &begin, stop, &mut |s| tell_step(app, &s)) else {
            return End::Stopped;
        };
        let good = worth(&new, &model);
        app.session().step_to(new);
        End::Done(format!(
            "{} is in the model{}",
            kind.spec().title,
            if good {
                "."
            } else {
                ", but unseen data do not say that it is worth its parameters. Remove it?"
            }
        ))
    })
}

/// Takes an effect out and fits the rest again.
pub async fn remove(State(app): State<Arc<App>>, Json(which): Json<Which>) -> Answer {
    let kind = which.kind()?;
    if !app.session().current.kinds().contains(&kind) {
        return Err(refused(StatusCode::CONFLICT, "the model does not have it"));
    }
    start(&app, &format!("Removing {kind}"), move |app, stop| {
        let (evidence, model) = copy(app);
        let begin = model.values().without(kind);
        let Some(new) = steps::search(&evidence, &begin, stop, &mut |s| tell_step(app, &s)) else {
            return End::Stopped;
        };
        app.session().step_to(new);
        End::Done(format!("{} is out of the model.", kind.spec().title))
    })
}
