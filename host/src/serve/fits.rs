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
use super::open::Open;
use super::session::{Doubt, NextModel, Session, rung};
use super::steps;
use crate::compare::free_run::free_runs;
use crate::compare::rise::{Rise, worst_rise};
use crate::diagnose::evidence::Evidence;
use crate::diagnose::ladder::Rung;
use crate::fit::layout::Values;
use crate::report::falls::{judged, judged_on};
use crate::report::figure::{NOW, change_in_words, in_words};
use crate::select::fitted::Fitted;
use crate::select::forward::forward;

/// Copies to work on while the page goes on with the originals.
struct Work {
    evidence: Evidence,
    base: Fitted,
    /// As effects are chosen by.
    model: Fitted,
    /// The same as it is shown.
    shown: Fitted,
    floor: f64,
}

impl Work {
    fn of(session: &Session) -> Self {
        Self {
            evidence: session.evidence.clone(),
            base: session.base.clone(),
            model: session.chosen.clone(),
            shown: session.current.clone(),
            floor: session.floor,
        }
    }

    fn unit(&self) -> &'static str {
        self.evidence.whole.grids.first().map_or("rad", |grid| grid.quantity.unit())
    }
}

/// Unwinds out of a stage whose user wants it to stop.
struct Stopped;

/// Tries `library`, telling which effect is on trial; none when stopped.
fn tried(job: &Job, work: &Work, library: &[Kind]) -> Option<Vec<Fitted>> {
    let mut count = 0;
    let found = catch_unwind(AssertUnwindSafe(|| {
        forward(&work.evidence, &work.model, library, 0.0, &mut |effect| {
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
        let work = Work::of(&job.app.session());
        let (refused, open) = {
            let session = job.app.session();
            (session.refused.clone(), session.open.clone())
        };
        let library = job.app.library().clone();
        let untried = library.kinds().iter().copied().filter(|kind| !refused.contains(kind));
        let Some(found) = tried(job, &work, &untried.collect::<Vec<_>>()) else { return stopped() };
        let Work { evidence, base, model, floor, .. } = &work;
        let diagnosis = Diagnosis::new(evidence, base, model, *floor, found, library.kinds(), &open);
        // The badge doubts the effect that came last and proposes to remove it: the status goes the same way.
        let doubt = job.app.session().doubt;
        let message = match (diagnosis.suggested, doubt) {
            (None, _) => "No effect of the library is worth adding to this model.".to_owned(),
            (Some(effect), None) => format!("An effect is missing; {effect} is the best candidate."),
            (Some(_), Some(doubt)) => format!(
                "No effect is proposed before {} is removed: held-out data do not confirm it.",
                doubt.effect
            ),
        };
        End::Done(message, Box::new(move |session| session.diagnosis = Some(Arc::new(diagnosis))))
    })
}

/// Which effect.
#[derive(Debug, Deserialize)]
pub struct Which {
    effect: String,
}

impl Which {
    fn kind(&self, app: &App) -> Result<Kind, (StatusCode, Json<serde_json::Value>)> {
        app.library()
            .by_name(&self.effect)
            .ok_or_else(|| refused(StatusCode::UNPROCESSABLE_ENTITY, "there is no effect of that name"))
    }
}

/// The model that a search from `begin` ends at, told step by step; none when stopped.
fn searched(job: &Job, work: &Work, begin: &Values) -> Option<Fitted> {
    let mut tell = |step: steps::Step| job.tell(json!({ "type": "step", "step": step }));
    steps::search(&work.evidence, begin, &work.model, &|| job.stopped(), &mut tell)
}

/// An effect that comes or goes, and what is known of the model that it leads to.
enum Change {
    /// The effect comes; tried before, the model with it is this one.
    Adding(Kind, Box<Fitted>),
    /// The effect goes.
    Removing(Kind),
}

/// Searches from `begin` and makes the result the session's model.
fn refit(job: &Job, work: &Work, begin: &Values, change: Change, what: &str) -> End {
    let Some(chosen) = searched(job, work, begin) else { return stopped() };
    let (chosen, added, removed) = match change {
        // From where the old parameters stood a search may end beside what the diagnosis found, and the next effect would mend that.
        Change::Adding(kind, known) => {
            (chosen.or_better(Some(known.settled(&work.evidence))), Some(kind), None)
        }
        Change::Removing(kind) => (chosen, None, Some(kind)),
    };
    let shown = chosen.simulating(&work.evidence);
    let (before, after) = (rung(&work.evidence, &work.shown), rung(&work.evidence, &shown));
    let rise = rise(&work.evidence, &work.shown, &shown);
    let rises = judged(&after).rmse > judged(&before).rmse;
    let doubt = added
        .filter(|_| rises || !chosen.beats(&work.model, &work.evidence, &work.base))
        .map(|effect| Doubt { effect, rises });
    let message = format!("{what}: {}.", told(&before, &after, rise.as_ref(), work.unit()));
    let open = still_open(job.app, work, added, &chosen);
    let next = NextModel { chosen, shown, rung: after, rise, doubt, open };
    End::Done(
        message,
        Box::new(move |session| {
            // What held-out data did not confirm is not suggested again.
            session
                .refused
                .extend(session.doubt.map(|doubt| doubt.effect).filter(|effect| removed == Some(*effect)));
            session.step_to(next);
        }),
    )
}

/// What the effects of `model` leave open: that of the session's, judged anew beside what came or went, and that of the one `added`, as its
/// diagnosis found it.
fn still_open(app: &App, work: &Work, added: Option<Kind>, model: &Fitted) -> Vec<Arc<Open>> {
    let (known, suggested) = {
        let session = app.session();
        (session.open.clone(), session.diagnosis.as_ref().and_then(|diagnosis| diagnosis.open.clone()))
    };
    let new = added.zip(suggested).and_then(|(kind, open)| open.accepting(kind, &work.evidence));
    let known = known.iter().filter(|open| open.is_of(model.kinds()));
    let known = known.filter_map(|open| open.beside(model, &work.evidence, &work.base));
    known.chain(new.filter(|open| open.is_of(model.kinds()))).map(Arc::new).collect()
}

/// The error before and after, on the records that judge, and where it rose.
fn told(before: &Rung, after: &Rung, rise: Option<&Rise>, unit: &str) -> String {
    let [old, new] = [before, after].map(|rung| judged(rung).rmse);
    let is_seen = in_words(old, unit) != in_words(new, unit);
    let place = rise.filter(|_| is_seen).map_or_else(String::new, Rise::place);
    format!("the error on {} {}{place}", judged_on(after), change_in_words(old, new, unit, NOW))
}

/// Where `after` is worse than `before` on the records that judge.
fn rise(evidence: &Evidence, before: &Fitted, after: &Fitted) -> Option<Rise> {
    let problem = evidence.kept_out.as_ref().unwrap_or(&evidence.whole);
    let runs = |model: &Fitted| free_runs(problem, &model.values());
    worst_rise(&runs(before), &runs(after))
}

/// `session` with the effects that the model `had`, fitted to its records; none when stopped.
pub fn kept(job: &Job, mut session: Session, had: &Values) -> Option<Session> {
    if had.effects.is_empty() {
        return Some(session);
    }
    let work = Work::of(&session);
    let begin = Values { effects: had.effects.clone(), ..work.model.values() };
    let chosen = searched(job, &work, &begin)?;
    let shown = chosen.simulating(&work.evidence);
    let (after, rise) = (rung(&work.evidence, &shown), rise(&work.evidence, &work.shown, &shown));
    session.step_to(NextModel { chosen, shown, rung: after, rise, doubt: None, open: Vec::new() });
    Some(session)
}

/// Adds an effect and fits everything again.
pub async fn add(State(app): State<Arc<App>>, Json(which): Json<Which>) -> Answer {
    let kind = which.kind(&app)?;
    let has = app.session().current.kinds().to_vec();
    if has.contains(&kind) || has.len() >= MAX_EFFECTS {
        return Err(refused(
            StatusCode::CONFLICT,
            "the model has it already, or has as many effects as it can",
        ));
    }
    jobs::start(&app, &format!("Adding {kind}"), move |job| {
        let work = Work::of(&job.app.session());
        let diagnosis = job.app.session().diagnosis.clone();
        let known = diagnosis
            .and_then(|d| d.candidates.iter().find(|c| c.kinds().last() == Some(&kind)).cloned())
            .map_or_else(|| tried(job, &work, &[kind]), |c| Some(vec![c]));
        let Some(known) = known else { return stopped() };
        let Some(known) = known.first() else {
            return End::Failed(
                json!({ "why": format!("{kind} cannot join this model: an effect in it says the same, or stands between rotor and load already; remove that one first") }),
            );
        };
        // The old parameters start where they are, so that one sees them move.
        let parameters = known.values().effects.pop().map(|e| e.1).unwrap_or_default();
        let begin = work.model.values().with(kind, parameters);
        let change = Change::Adding(kind, Box::new(known.clone()));
        refit(job, &work, &begin, change, &format!("{kind} is in the model"))
    })
}

/// Takes an effect out and fits the rest again.
pub async fn remove(State(app): State<Arc<App>>, Json(which): Json<Which>) -> Answer {
    let kind = which.kind(&app)?;
    if !app.session().current.kinds().contains(&kind) {
        return Err(refused(StatusCode::CONFLICT, "the model does not have it"));
    }
    jobs::start(&app, &format!("Removing {kind}"), move |job| {
        let work = Work::of(&job.app.session());
        // A model that was there before comes back as it was.
        let without = work.model.values().without(kind);
        let begin = job.app.session().passed_with(&without.kinds()).unwrap_or(without);
        refit(job, &work, &begin, Change::Removing(kind), &format!("{kind} is out of the model"))
    })
}
