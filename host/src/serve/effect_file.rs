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

/// The file.
#[derive(Debug, Deserialize)]
pub struct File {
    name: String,
}

/// Reads the effect and offers it, on this page, beside those of the library.
pub async fn offer(State(app): State<Arc<App>>, Query(file): Query<File>, text: String) -> Answer {
    let library = app.library().clone();
    let read = tokio::task::block_in_place(|| -> Result<_, Error> {
        let io = |source| Error::Io { doing: "cannot keep the effect for reading".into(), source };
        let directory = tempfile::tempdir().map_err(io)?;
        let name = Path::new(&file.name).file_name().unwrap_or("effect.toml".as_ref());
        let path = directory.path().join(name);
        std::fs::write(&path, &text).map_err(io)?;
        library.read(&path).map_err(|error| match error {
            Error::BadInput(mut fault) => {
                fault.file = name.into();
                Error::BadInput(fault)
            }
            other => other,
        })
    });
    let refused = |error: Error| (StatusCode::UNPROCESSABLE_ENTITY, Json(error.to_json()));
    let kind = read.map_err(refused)?;
    app.offer(kind).map_err(refused)?;
    // What was tried without it is tried again.
    app.session().diagnosis = None;
    Ok(Json(json!({ "effect": kind.name() })))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula::Library;
    use crate::motor_file::MotorFile;
    use crate::serve::{Session, answers, fits};
    use crate::{Measured, record};

    const NAME: &str = "lobe_of_one_page";
    const TITLE: &str = "a lobe that one page was given";

    /// A page with a motor's answer to steps, 5 ms apart, in counts of a milliradian.
    fn page() -> Arc<App> {
        let steps = [6.0, 0.0, -4.0, 2.0, 9.0, -7.0];
        let time: Vec<f64> = (0..600).map(|k| f64::from(k) * 5e-3).collect();
        let volts: Vec<f64> = (0..600).map(|k| steps[k / 100 % steps.len()]).collect();
        let (mut angle, mut speed) = (0.0_f64, 0.0_f64);
        let mut angles = Vec::new();
        for v in &volts {
            angles.push((angle / 1e-3).round() * 1e-3);
            for _ in 0..50 {
                speed += 1e-4 * (0.9 * v - speed) / 0.05;
                angle += 1e-4 * speed;
            }
        }
        let run = record("steps", &time, &volts, Measured::Angle(&angles)).unwrap();
        let session = Session::new(vec![run], Vec::new(), MotorFile::default()).unwrap();
        Arc::new(App::new(session, Library::default()))
    }

    /// Titles of the effects that a diagnosis on this page tries.
    async fn tried(app: &Arc<App>) -> Vec<String> {
        let mut events = app.events.subscribe();
        let _ = fits::diagnose(State(Arc::clone(app))).await.unwrap();
        let mut titles = Vec::new();
        loop {
            let event = events.recv().await.unwrap();
            match event["type"].as_str() {
                Some("started") => {}
                Some("trying") => titles.push(event["effect"].as_str().unwrap().to_owned()),
                Some("done") => return titles,
                _ => panic!("{event}"),
            }
        }
    }

    /// Whether the page's lists and its glossary name the effect.
    async fn named(app: &Arc<App>) -> [bool; 2] {
        let state = answers::state(State(Arc::clone(app))).await.unwrap();
        let glossary = answers::glossary(State(Arc::clone(app))).await.unwrap();
        [state, glossary].map(|answer| answer.0.to_string().contains(NAME))
    }

    #[tokio::test(flavor = "multi_thread")]
    async fn an_effect_that_one_page_is_given_is_unknown_to_another_page() {
        let text = format!(
            "name = \"{NAME}\"\nport = \"torque\"\ntitle = \"{TITLE}\"\nformula = \"-size * sin(3 * angle)\"\n\
             [[parameter]]\nname = \"size\"\nunit = \"V\"\nlow = -6\ntypical = 0.3\nhigh = 6\n"
        );
        let (first, second) = (page(), page());
        let file = File { name: "lobe.toml".into() };
        let _ = offer(State(Arc::clone(&first)), Query(file), text).await.unwrap();
        assert_eq!((named(&first).await, named(&second).await), ([true; 2], [false; 2]));
        let has = |titles: &[String]| titles.iter().any(|title| title == TITLE);
        assert!(has(&tried(&first).await));
        assert!(!has(&tried(&second).await));
        let which = serde_json::from_value(json!({ "effect": NAME })).unwrap();
        assert!(fits::add(State(second), Json(which)).await.is_err());
    }
}
