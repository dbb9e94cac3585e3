//! What the page asks for: itself, the state, the figures, the exports, the events.

use std::convert::Infallible;
use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, Query, State};
use axum::http::StatusCode;
use axum::http::header::{CACHE_CONTROL, CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{Html, IntoResponse};
use serde::Deserialize;
use serde_json::json;
use tokio_stream::wrappers::BroadcastStream;
use tokio_stream::{Stream, StreamExt};

use super::App;
use super::fields;
use super::jobs::{self, Answer, refused};
use crate::fit::grid::Grid;
use crate::fit::search::Problem;
use crate::glossary;
use crate::log::Metadata;
use crate::report::missing::Setting;
use crate::report::{self, fails, falls, missing, records, words};
use crate::sentence::capital;

const PAGE: &str = include_str!("assets/page.html");
const STYLE: &str = include_str!("assets/page.css");

/// The scripts of the page by name, in the order in which it loads them.
const SCRIPTS: [(&str, &str); 9] = [
    ("uplot.js", report::LIBRARY),
    ("plots.js", report::PLOTS),
    ("overview.js", report::OVERVIEW),
    ("page.js", include_str!("assets/page.js")),
    ("steps.js", include_str!("assets/steps.js")),
    ("data.js", include_str!("assets/data.js")),
    ("advice.js", include_str!("assets/advice.js")),
    ("log.js", include_str!("assets/log.js")),
    ("device.js", include_str!("assets/device.js")),
];

fn asset(kind: &'static str, body: impl IntoResponse) -> impl IntoResponse {
    ([(CONTENT_TYPE, kind), (CACHE_CONTROL, "no-cache")], body)
}

/// The page.
pub async fn page() -> Result<impl IntoResponse, (StatusCode, Json<serde_json::Value>)> {
    let page = fields::laid_out(PAGE).map_err(|e| (StatusCode::INTERNAL_SERVER_ERROR, Json(e.to_json())))?;
    Ok(Html(page))
}

/// A script of the page.
pub async fn script(
    Path(name): Path<String>,
) -> Result<impl IntoResponse, (StatusCode, Json<serde_json::Value>)> {
    let script = SCRIPTS.iter().find(|script| script.0 == name);
    let (_, text) = script.ok_or_else(|| refused(StatusCode::NOT_FOUND, "there is no such script"))?;
    Ok(asset("text/javascript", *text))
}

/// How it looks.
pub async fn style() -> impl IntoResponse {
    asset("text/css", [report::LIBRARY_STYLE, report::STYLE, STYLE].concat())
}

/// Everything but the figures.
pub async fn state(State(app): State<Arc<App>>) -> Answer {
    let running = jobs::running(&app);
    let device = app.device().as_ref().map(|device| json!(device));
    let session = app.session();
    let layout = &session.current.layout;
    let plain = layout.axes.iter().enumerate().map(|(k, axis)| {
        let at = |x: f64| layout.plain(k, x);
        json!({ "name": axis.name, "unit": axis.unit, "value": at(session.current.x[k]),
                "low": at(axis.low), "high": at(axis.high), "log": axis.unit_value == 0.0 })
    });
    let record = |grid: &Grid, unseen: bool| {
        let seconds = grid.time_s.last().zip(grid.time_s.first()).map_or(0.0, |(b, a)| b - a);
        json!({ "name": grid.name, "unseen": unseen, "seconds": seconds })
    };
    let grids =
        |problem: &Problem, unseen| problem.grids.iter().map(|grid| record(grid, unseen)).collect::<Vec<_>>();
    let fitted = grids(&session.evidence.whole, false);
    let kept_out = session.evidence.kept_out.as_ref().map_or_else(Vec::new, |p| grids(p, true));
    let records: Vec<_> = fitted.into_iter().chain(kept_out).collect();
    let library = app.library().clone();
    let effects = library.kinds().iter().map(|kind| {
        let spec = kind.spec();
        json!({ "name": spec.name, "title": spec.title, "added": session.current.kinds().contains(kind) })
    });
    // What the records tell of their motor need not be typed again to run it.
    let told =
        |of: fn(&Metadata) -> Option<f64>| session.data.entries.iter().find_map(|e| of(&e.record.meta));
    let puzzle = session
        .puzzle
        .as_ref()
        .map(|p| json!({ "revealed": p.revealed, "answer": p.revealed.then_some(&p.answer) }));
    Ok(Json(json!({
        "title": session.scene().title(),
        "records": records,
        "data": session.data.to_json(),
        "models": session.passed.iter().map(|p| &p.name).collect::<Vec<_>>(),
        "against": session.view().against.name,
        "parameters": plain.collect::<Vec<_>>(),
        "effects": effects.collect::<Vec<_>>(),
        "ladder": session.ladder,
        "floor": session.floor,
        "noise": capital(&session.yardstick().noise_in_words()),
        "unit": session.unit(),
        "faults": session.faults,
        "counts_per_rev": session.data.motor.counts_per_rev.or_else(|| told(Metadata::counts_per_rev)),
        "gear_ratio": session.data.motor.gear_ratio.or_else(|| told(Metadata::gear_ratio)),
        "diagnosed": session.diagnosis.is_some(),
        "puzzle": puzzle,
        "running": running,
        "device": device,
    })))
}

/// The figures and words of a step.
pub async fn figures(State(app): State<Arc<App>>, Path(step): Path<String>) -> Answer {
    tokio::task::block_in_place(|| {
        let scene = app.session().scene();
        let view = &scene.view;
        let answer = match step.as_str() {
            "fails" => {
                let [base, model] = view.torques();
                json!({ "figures": fails::figures(&view.all_shown(), [base, model], scene.gear_ratio()) })
            }
            "missing" => {
                let diagnosis = scene.diagnosis.as_deref().cloned().unwrap_or_default();
                let rivals = scene.rivals();
                let setting = Setting { rivals: &rivals, in_model: scene.effects() };
                let (cards, figures) = missing::cards(&scene.suspects(), &setting);
                json!({ "figures": figures, "cards": cards, "rivals": rivals, "next": diagnosis.next,
                        "worth": diagnosis.suggested.is_some(), "diagnosed": scene.diagnosis.is_some() })
            }
            "falls" => {
                let ladder = falls::Ladder {
                    rungs: &scene.ladder,
                    rises: &scene.rises,
                    baseline: scene.baseline.as_ref(),
                    noise: scene.floor,
                    unit: scene.unit,
                };
                let standing = scene.standing();
                json!({
                    "figures": [ladder.figure()],
                    "rows": ladder.rows(),
                    "last_over_floor": ladder.last_over_noise(),
                    "summary": words::summary(&scene.ladder, scene.floor, scene.unit, &standing),
                    "headline": words::first_sentence(&standing.headline),
                    "standing": standing,
                })
            }
            "estimates" => {
                let [parameters, combinations] = view.estimates();
                let effects = scene.effects();
                json!({ "parameters": words::estimate_rows(parameters, &effects),
                        "combinations": words::estimate_rows(combinations, &effects),
                        "faults": scene.shown_by_the_fit() })
            }
            _ => return Err(refused(StatusCode::NOT_FOUND, "there is no such step")),
        };
        Ok(Json(answer))
    })
}

/// Which of the models passed.
#[derive(Debug, Deserialize)]
pub struct Against {
    model: usize,
}

/// Draws the model beside another one.
pub async fn against(State(app): State<Arc<App>>, Json(against): Json<Against>) -> Answer {
    if app.session().compare_with(against.model) {
        Ok(Json(json!({ "model": against.model })))
    } else {
        Err(refused(StatusCode::NOT_FOUND, "there is no such model"))
    }
}

/// Every parameter with its symbol, unit, meaning and equation.
pub async fn glossary(State(app): State<Arc<App>>) -> Answer {
    let terms = glossary::terms(app.library().kinds());
    Ok(Json(json!({ "terms": terms, "words": glossary::WORDS, "equations": glossary::BASE_EQUATIONS })))
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
        let (view, floor) = {
            let session = app.session();
            (session.view(), session.floor)
        };
        let shown =
            view.shown(number).ok_or_else(|| refused(StatusCode::NOT_FOUND, "there is no such record"))?;
        Ok(Json(json!(records::figure("record", shown, floor, part.from.zip(part.to)))))
    })
}

fn attachment(kind: &'static str, named: &'static str, body: String) -> impl IntoResponse {
    ([(CONTENT_TYPE, kind), (CONTENT_DISPOSITION, named)], body)
}

/// The model file.
pub async fn model(State(app): State<Arc<App>>) -> impl IntoResponse {
    let text = serde_json::to_string_pretty(&app.session().model()).unwrap_or_default();
    attachment("application/json", "attachment; filename=\"model.json\"", text)
}

/// The programme of the next experiment.
pub async fn programme(
    State(app): State<Arc<App>>,
) -> Result<impl IntoResponse, (StatusCode, Json<serde_json::Value>)> {
    let diagnosis = app.session().diagnosis.clone();
    let next = diagnosis.and_then(|d| d.next.clone());
    let next =
        next.ok_or_else(|| refused(StatusCode::NOT_FOUND, "no experiment is needed, or none was sought"))?;
    let text = serde_json::to_string_pretty(&next.programme).unwrap_or_default();
    Ok(attachment("application/json", "attachment; filename=\"programme.json\"", text))
}

/// The report file.
pub async fn report(
    State(app): State<Arc<App>>,
) -> Result<impl IntoResponse, (StatusCode, Json<serde_json::Value>)> {
    let page = tokio::task::block_in_place(|| {
        let scene = app.session().scene();
        report::html(&scene.story())
    });
    let page = page.map_err(|e| (StatusCode::INTERNAL_SERVER_ERROR, Json(e.to_json())))?;
    Ok(attachment("text/html; charset=utf-8", "attachment; filename=\"motorlens-report.html\"", page))
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
