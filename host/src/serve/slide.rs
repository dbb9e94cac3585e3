//! A slider moves: the new curve and the new error, at once.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::Deserialize;
use serde_json::json;

use super::App;
use super::jobs::{Answer, refused};
use crate::compare::free_run::{FreeRun, free_runs, pooled};
use crate::fit::grid::Quantity;
use crate::report::decimate::keep;
use crate::report::figure::numbers;

/// Where the sliders stand.
#[derive(Debug, Deserialize)]
pub struct Sliders {
    /// The record that is looked at, training first.
    record: usize,
    /// Plain values in the order of the parameters.
    values: Vec<f64>,
}

/// Points of a curve while a slider moves.
const POINTS: usize = 400;
/// Half the span over which a simulated speed is taken, s; as for the figures.
const HALF_SPAN_S: f64 = 0.025;

/// The run under the sliders' values, and its error on all training records.
pub async fn slide(State(app): State<Arc<App>>, Json(sliders): Json<Sliders>) -> Answer {
    tokio::task::block_in_place(|| {
        let session = app.session();
        let layout = &session.current.layout;
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
        let values = layout.unpack(&search);
        let mut runs = free_runs(&session.evidence.whole, &values);
        let error = pooled(&runs).unwrap_or_default().rmse;
        let unseen = session.unseen().map(|u| free_runs(u, &values));
        let unseen_error = unseen.as_ref().and_then(|u| pooled(u)).map(|m| m.rmse);
        runs.extend(unseen.unwrap_or_default());
        let run = runs
            .get(sliders.record)
            .ok_or_else(|| refused(StatusCode::NOT_FOUND, "there is no such record"))?;
        Ok(Json(json!({
            "error": error,
            "unseen_error": unseen_error,
            "unit": session.unit(),
            "curves": curves(run),
        })))
    })
}

/// The model's curves of the record's figure: which trace, and its new points.
fn curves(run: &FreeRun) -> serde_json::Value {
    let left: Vec<f64> = run.measured.iter().zip(&run.simulated).map(|(y, p)| y - p).collect();
    let kept = keep(&[&run.simulated, &left], 0, run.time_s.len(), POINTS);
    let time = numbers(kept.iter().map(|k| run.time_s[*k]), 7);
    let curve = |name: &str, y: serde_json::Value| json!({ "slide": name, "x": time, "y": y });
    let mut all = vec![
        curve("run", numbers(kept.iter().map(|k| run.simulated[*k]), 6)),
        curve("left", numbers(kept.iter().map(|k| left[*k]), 5)),
    ];
    if run.quantity == Quantity::Angle {
        let interval = crate::log::timing::median_interval(&run.time_s).max(1e-9);
        let beside = ((HALF_SPAN_S / interval).round() as usize).max(1);
        let last = run.time_s.len() - 1;
        let speed = |k: usize| {
            let (a, b) = (k.saturating_sub(beside), (k + beside).min(last));
            (run.simulated[b] - run.simulated[a]) / (run.time_s[b] - run.time_s[a])
        };
        all.push(curve("speed", numbers(kept.iter().map(|k| speed(*k)), 5)));
    }
    all.into()
}
