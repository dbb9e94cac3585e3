//! What the page asks for: itself, the state, the figures, the exports, the events.

use std::convert::Infallible;
use std::sync::{Arc, PoisonError};

use axum::Json;
use axum::extract::{Path, Query, State};
use axum::http::StatusCode;
use axum::http::header::{CACHE_CONTROL, CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{Html, IntoResponse};
use motorlens_shared::effects::Kind;
use serde::Deserialize;
use serde_json::json;
use tokio_stream::wrappers::BroadcastStream;
use tokio_stream::{Stream, StreamExt};

use super::App;
use super::jobs::{Answer, refused};
use crate::report::{self, fails, falls, missing, records, words};

const PAGE: &str = include_str!("assets/page.html");
const SCRIPT: &str = include_str!("assets/page.js");
const STYLE: &str = include_str!("assets/page.css");

fn asset(kind: &'static str, body: impl IntoResponse) -> impl IntoResponse {
    ([(CONTENT_TYPE, kind), (CACHE_CONTROL, "no-cache")], body)
}

/// The page.
pub async fn page() -> impl IntoResponse {
    Html(PAGE)
}

/// The plotting library; it changes with the program only.
pub async fn library() -> impl IntoResponse {
    ([(CONTENT_TYPE, "text/javascript"), (CACHE_CONTROL, "max-age=3600")], report::plotting_library())
}

/// How figures are drawn.
pub async fn plots() -> impl IntoResponse {
    asset("text/javascript", report::PLOTS)
}

/// What the page does.
pub async fn script() -> impl IntoResponse {
    asset("text/javascript", SCRIPT)
}

/// How it looks.
pub async fn style() -> impl IntoResponse {
    asset("text/css", format!("{}{STYLE}", report::STYLE))
}

/// Everything but the figures.
pub async fn state(State(app): State<Arc<App>>) -> Answer {
    let running = app.job.lock().unwrap_or_else(PoisonError::into_inner).is_some();
    let session = app.session();
    let layout = &session.current.layout;
    let plain = layout.axes.iter().enumerate().map(|(k, axis)| {
        let at = |x: f64| layout.plain(k, x);
        json!({ "name": axis.name, "unit": axis.unit, "value": at(session.current.found.x[k]),
                "low": at(axis.low), "high": at(axis.high), "log": axis.unit_value == 0.0 })
    });
    let record = |r: &crate::log::Record, unseen: bool| json!({ "name": r.name, "unseen": unseen, "samples": r.len(), "seconds": r.duration_s() });
    let fitted = session.records.iter().map(|r| record(r, false));
    let kept_out = session.validation.iter().map(|r| record(r, true));
    let effects = Kind::ALL.iter().map(|kind| {
        let spec = kind.spec();
        json!({ "name": spec.name, "title": spec.title, "added": session.current.kinds().contains(kind) })
    });
    let puzzle = session
        .puzzle
        .as_ref()
        .map(|p| json!({ "revealed": p.revealed, "answer": p.revealed.then_some(&p.answer) }));
    Ok(Json(json!({
        "title": report::title(&session.records),
        "records": fitted.chain(kept_out).collect::<Vec<_>>(),
        "parameters": plain.collect::<Vec<_>>(),
        "effects": effects.collect::<Vec<_>>(),
        "ladder": session.ladder,
        "steps": falls::steps(&session.ladder),
        "floor": session.floor,
        "unit": session.unit(),
        "diagnosed": session.diagnosis.is_some(),
        "puzzle": puzzle,
        "running": running,
    })))
}

/// The figures and tables of a step.
pub async fn figures(State(app): State<Arc<App>>, Path(step): Path<String>) -> Answer {
    tokio::task::block_in_place(|| {
        let mut session = app.session();
        let diagnosed = session.diagnosis.is_some();
        let story = session.story();
        let answer = match step.as_str() {
            "fails" => json!({ "figures": fails::figures(story) }),
            "missing" => {
                let (cards, figures) = missing::cards(story);
                json!({ "figures": figures, "cards": cards, "faults": story.faults, "diagnosed": diagnosed })
            }
            "falls" => json!({
                "figures": [falls::figure(&story.ladder, story.floor, story.unit)],
                "parameters": words::estimate_rows(&story.parameters),
                "combinations": words::estimate_rows(&story.combinations),
                "summary": words::summary(story),
            }),
            _ => return Err(refused(StatusCode::NOT_FOUND, "there is no such step")),
        };
        Ok(Json(answer))
    })
}

/// The part of a record that is on the screen.
#[derive(Debug, Deserialize)]
pub struct Part {
    from: Option<f64>,
    to: Option<f64>,
}

/// The figure of one record, or of a part of it with all that can be seen there.
pub async fn record(
    State(app): State<Arc<App>>,
    Path(number): Path<usize>,
    Query(part): Query<Part>,
) -> Answer {
    tokio::task::block_in_place(|| {
        let mut session = app.session();
        let floor = session.floor;
        let (shown, [base, model]) =
            session.drawn(number).ok_or_else(|| refused(StatusCode::NOT_FOUND, "there is no such record"))?;
        let figure = records::figure("record", shown, [base, model], floor, part.from.zip(part.to));
        Ok(Json(json!(figure)))
    })
}

/// The model file.
pub async fn model(State(app): State<Arc<App>>) -> impl IntoResponse {
    let text = serde_json::to_string_pretty(&app.session().model()).unwrap_or_default();
    ([(CONTENT_TYPE, "application/json"), (CONTENT_DISPOSITION, "attachment; filename=\"model.json\"")], text)
}

/// The report file.
pub async fn report(
    State(app): State<Arc<App>>,
) -> Result<impl IntoResponse, (StatusCode, Json<serde_json::Value>)> {
    let page = tokio::task::block_in_place(|| report::html(app.session().story()));
    let page = page.map_err(|e| (StatusCode::INTERNAL_SERVER_ERROR, Json(e.to_json())))?;
    let named = "attachment; filename=\"motorlens-report.html\"";
    Ok(([(CONTENT_TYPE, "text/html; charset=utf-8"), (CONTENT_DISPOSITION, named)], page))
}

/// What jobs tell, as they go.
pub async fn events(State(app): State<Arc<App>>) -> Sse<impl Stream<Item = Result<Event, Infallible>>> {
    let stream = BroadcastStream::new(app.events.subscribe()).map(|event| {
        // A page that fell behind looks at the state again.
        let event = event.unwrap_or_else(|_| json!({ "type": "behind" }));
        Ok(Event::default().data(event.to_string()))
    });
    Sse::new(stream).keep_alive(KeepAlive::default())
}
