//! Long work: one job at a time, told as it goes, stopped at once when asked.
//!
//! A job works on copies and hands over what is to change; a stopped one changes nothing. A search looks at the
//! wish to stop only between two of its steps, so the page does not wait for it: it is left to end by itself.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError};

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde_json::{Value, json};

use super::App;
use super::session::Session;

/// An answer, or why not.
pub type Answer = Result<Json<Value>, (StatusCode, Json<Value>)>;

/// A refusal with its reason.
pub fn refused(status: StatusCode, why: &str) -> (StatusCode, Json<Value>) {
    (status, Json(json!({ "why": why })))
}

/// What a job changes in the session.
pub type Change = Box<dyn FnOnce(&mut Session) + Send>;

/// How a job ends.
pub enum End {
    /// With this message and this change.
    Done(String, Change),
    /// As the user wished, with this message.
    Stopped(String),
    /// With what is wrong.
    Failed(Value),
}

/// A job that runs.
#[derive(Debug)]
pub struct Running {
    what: String,
    stop: AtomicBool,
    /// Whether to wait for the end of a stopped job: a motor has to stand before one may say so.
    waited_for: bool,
}

/// What a job sees of the page.
pub struct Job<'a> {
    /// What all requests share.
    pub app: &'a App,
    running: &'a Arc<Running>,
}

impl Job<'_> {
    /// Whether the user wants it to stop.
    pub fn stopped(&self) -> bool {
        self.running.stop.load(Ordering::Relaxed)
    }

    /// Tells the page, unless it waits no longer.
    pub fn tell(&self, event: Value) {
        if self.running.waited_for || !self.stopped() {
            self.app.tell(event);
        }
    }
}

/// Starts `work`, a search, in a thread of its own if nothing else runs.
pub fn start(app: &Arc<App>, what: &str, work: impl FnOnce(&Job) -> End + Send + 'static) -> Answer {
    launch(app, what, false, work)
}

/// Starts `work` on a device: when it is stopped the page waits until it has ended.
pub fn start_on_device(
    app: &Arc<App>,
    what: &str,
    work: impl FnOnce(&Job) -> End + Send + 'static,
) -> Answer {
    launch(app, what, true, work)
}

fn launch(
    app: &Arc<App>,
    what: &str,
    waited_for: bool,
    work: impl FnOnce(&Job) -> End + Send + 'static,
) -> Answer {
    let mine = Arc::new(Running { what: what.into(), stop: AtomicBool::new(false), waited_for });
    let mut running = app.job.lock().unwrap_or_else(PoisonError::into_inner);
    if running.is_some() {
        return Err(refused(StatusCode::CONFLICT, "something else is running; stop it first"));
    }
    *running = Some(Arc::clone(&mine));
    drop(running);
    app.tell(json!({ "type": "started", "what": what, "device": waited_for }));
    let app = Arc::clone(app);
    std::thread::spawn(move || {
        let job = Job { app: &app, running: &mine };
        let end = catch_unwind(AssertUnwindSafe(|| work(&job)));
        finish(
            &app,
            &mine,
            end.unwrap_or_else(|_| {
                End::Failed(json!({ "why": "the work failed; please report these logs" }))
            }),
        );
    });
    Ok(Json(json!({ "started": true })))
}

/// Ends a job, if it is still the one that runs.
fn finish(app: &App, mine: &Arc<Running>, end: End) {
    let mut running = app.job.lock().unwrap_or_else(PoisonError::into_inner);
    if !running.as_ref().is_some_and(|job| Arc::ptr_eq(job, mine)) {
        return;
    }
    *running = None;
    let event = match end {
        End::Done(message, change) => {
            change(&mut app.session());
            json!({ "type": "done", "message": message })
        }
        End::Stopped(message) => json!({ "type": "stopped", "message": message }),
        End::Failed(error) => json!({ "type": "failed", "error": error }),
    };
    drop(running);
    app.tell(event);
}

/// What runs, where something does.
pub fn running(app: &App) -> Option<String> {
    app.job.lock().unwrap_or_else(PoisonError::into_inner).as_ref().map(|job| job.what.clone())
}

/// Stops the running job.
pub async fn stop(State(app): State<Arc<App>>) -> Answer {
    let mut running = app.job.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(job) = running.clone() else {
        return Err(refused(StatusCode::CONFLICT, "nothing is running"));
    };
    job.stop.store(true, Ordering::Relaxed);
    if !job.waited_for {
        *running = None;
        drop(running);
        app.tell(json!({ "type": "stopped", "message": "Stopped. The model is as it was." }));
    }
    Ok(Json(json!({ "stopping": true })))
}
