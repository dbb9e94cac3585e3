//! A slider moves: the new curves and the new error, at once.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::Deserialize;
use serde_json::{Map, json};

use super::App;
use super::jobs::{Answer, refused};
use crate::compare::free_run::pooled;
use crate::report::records::moved;

/// Where the sliders stand.
#[derive(Debug, Deserialize)]
pub struct Sliders {
    /// The record that is looked at, training first.
    record: usize,
    /// Plain values in the order of the parameters.
    values: Vec<f64>,
    /// The part of the record on the screen, s; all of it if absent.
    window: Option<(f64, f64)>,
}

/// The run under the sliders' values, and its error on all training records.
pub async fn slide(State(app): State<Arc<App>>, Json(sliders): Json<Sliders>) -> Answer {
    tokio::task::block_in_place(|| {
        let (layout, view, unit) = {
            let session = app.session();
            (session.current.layout.clone(), session.view(), session.unit())
        };
        if sliders.values.len() != layout.len() || sliders.values.iter().any(|v| !v.is_finite()) {
            return Err(refused(StatusCode::UNPROCESSABLE_ENTITY, "these values are not the model's"));
        }
        let search: Vec<f64> = sliders
            .values
            .iter()
            .zip(&layout.axes)
            .map(|(v, a)| if a.unit_value == 0.0 { v.max(1e-12).ln() } else { v / a.unit_value })
            .zip(&layout.axes)
            .map(|(x, a)| x.clamp(a.low, a.high))
            .collect();
        let mut runs = view.tracks.runs(&layout.unpack(&search));
        let run = runs
            .get(sliders.record)
            .ok_or_else(|| refused(StatusCode::NOT_FOUND, "there is no such record"))?;
        let curves: Map<_, _> =
            moved(run, sliders.window).into_iter().map(|(name, curve)| (name.into(), json!(curve))).collect();
        let fitted = (0..view.tracks.len()).filter(|k| !view.tracks.unseen(*k)).count();
        let unseen = runs.split_off(fitted.min(runs.len()));
        Ok(Json(json!({
            "error": pooled(&runs).unwrap_or_default().rmse,
            "unseen_error": (!unseen.is_empty()).then(|| pooled(&unseen).map(|m| m.rmse)).flatten(),
            "unit": unit,
            "curves": curves,
        })))
    })
}
