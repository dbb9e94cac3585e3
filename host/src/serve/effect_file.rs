//! An effect of the user's own, given as a file: the same as `--effect-file`.

use std::path::Path;
use std::sync::Arc;

use axum::Json;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use serde::Deserialize;
use serde_json::json;

use super::App;
use super::jobs::Answer;
use crate::error::Error;
use crate::formula;

/// The file.
#[derive(Debug, Deserialize)]
pub struct File {
    name: String,
}

/// Reads the effect and offers it beside those of the library.
pub async fn offer(State(app): State<Arc<App>>, Query(file): Query<File>, text: String) -> Answer {
    let read = tokio::task::block_in_place(|| -> Result<_, Error> {
        let io = |source| Error::Io { doing: "cannot keep the effect for reading".into(), source };
        let directory = tempfile::tempdir().map_err(io)?;
        let name = Path::new(&file.name).file_name().unwrap_or("effect.toml".as_ref());
        let path = directory.path().join(name);
        std::fs::write(&path, &text).map_err(io)?;
        formula::read(&path).map_err(|error| match error {
            Error::BadInput(mut fault) => {
                fault.file = name.into();
                Error::BadInput(fault)
            }
            other => other,
        })
    });
    let kind = read.map_err(|error| (StatusCode::UNPROCESSABLE_ENTITY, Json(error.to_json())))?;
    formula::offer(kind);
    // What was tried without it is tried again.
    app.session().diagnosis = None;
    Ok(Json(json!({ "effect": kind.name() })))
}
