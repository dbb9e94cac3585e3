//! Logs dropped on the page: each is read as it comes, and all are taken in at once.

use std::sync::Arc;

use axum::Json;
use axum::body::Bytes;
use axum::extract::{Path, Query, State};
use axum::http::StatusCode;
use serde::Deserialize;
use serde_json::json;

use super::App;
use super::data::{Entry, Role, renewed};
use super::jobs::{self, Answer, End, refused};
use super::origin::Origin;
use super::rig::Rig;
use super::session::Session;
use crate::error::{Error, Result};
use crate::log::ReadOptions;
use crate::motor_file::MotorFile;

/// What a dropped log is.
#[derive(Debug, Deserialize)]
pub struct Dropped {
    /// Name of the file.
    name: String,
    /// What its records are used for.
    role: Role,
    /// Which column is what, as for `--map`; empty for canonical columns.
    #[serde(default)]
    map: String,
    #[serde(flatten)]
    rig: Rig,
}

/// A file whose columns are to be guessed.
#[derive(Debug, Deserialize)]
pub struct Named {
    /// Name of the file.
    name: String,
}

fn unprocessable(error: &Error) -> (StatusCode, Json<serde_json::Value>) {
    (StatusCode::UNPROCESSABLE_ENTITY, Json(error.to_json()))
}

/// The guess at the columns of a file: the same that the command line proposes. Of a text its beginning is enough. Where a file of the same
/// columns is there, it says how that one is read.
pub async fn guess(State(app): State<Arc<App>>, Query(named): Query<Named>, body: Bytes) -> Answer {
    let data = app.session().data.clone();
    tokio::task::block_in_place(|| {
        let origin = Origin::dropped(&named.name, body, ReadOptions::default());
        let look = origin.look().map_err(|error| unprocessable(&error))?;
        let mut told = json!(look);
        told["like"] = json!(data.read_like(look, &origin.file()));
        Ok(Json(told))
    })
}

/// Reads a log and keeps its records until [`take`] is asked for.
pub async fn upload(State(app): State<Arc<App>>, Query(dropped): Query<Dropped>, body: Bytes) -> Answer {
    let read = tokio::task::block_in_place(|| parse(&dropped, body));
    let new = read.map_err(|error| unprocessable(&error))?;
    let names: Vec<String> = new.iter().map(|entry| entry.record.name.clone()).collect();
    app.uploaded().extend(new);
    Ok(Json(json!({ "records": names })))
}

/// How the file of a record is read, to be changed.
pub async fn mapping(State(app): State<Arc<App>>, Path(entry): Path<usize>) -> Answer {
    let data = app.session().data.clone();
    let told = tokio::task::block_in_place(|| data.mapping_of(entry));
    Ok(Json(told.map_err(|error| unprocessable(&error))?))
}

/// Another way to read the file of a record.
#[derive(Debug, Deserialize)]
pub struct Mapped {
    /// Which record.
    entry: usize,
    /// Whether all files that were read as it was are read the new way.
    #[serde(default)]
    alike: bool,
    /// Which column is what, as for `--map`; empty for canonical columns.
    #[serde(default)]
    map: String,
    #[serde(flatten)]
    rig: Rig,
}

/// Reads the file of a record anew; as every change of the data it can be undone.
pub async fn map(State(app): State<Arc<App>>, Json(wish): Json<Mapped>) -> Answer {
    let data = app.session().data.clone();
    let read = || data.mapped(wish.entry, wish.alike, &wish.map, &wish.rig);
    let mut new = tokio::task::block_in_place(read).map_err(|error| unprocessable(&error))?;
    let still = new.settle();
    if new.with(Role::Fit).is_empty() {
        let why = "read so, no record would be left to fit";
        return Err(refused(StatusCode::UNPROCESSABLE_ENTITY, why));
    }
    let mut message = "The columns are read as you say now; Undo reads them as before.".to_owned();
    for warning in still {
        message += &format!(" {}.", warning.what);
    }
    jobs::start(&app, "Reading the columns anew", move |job| renewed(job, new, message))
}

/// What becomes of the records uploaded.
#[derive(Debug, Deserialize)]
pub struct Taking {
    /// Whether they replace those that are there.
    replace: bool,
    /// Whether they are forgotten instead.
    #[serde(default)]
    forget: bool,
    #[serde(flatten)]
    rig: Rig,
}

/// Takes the uploaded records in, all at once, and fits the base model anew.
pub async fn take(State(app): State<Arc<App>>, Json(taking): Json<Taking>) -> Answer {
    let new = std::mem::take(&mut *app.uploaded());
    if taking.forget {
        return Ok(Json(json!({ "forgotten": new.len() })));
    }
    let motor = taking.rig.motor(MotorFile::default()).map_err(|error| unprocessable(&error))?;
    let names: Vec<String> = new.iter().map(|entry| entry.record.name.clone()).collect();
    let mut data = app.session().data.changed(|all| {
        if taking.replace {
            all.clear();
        }
        all.extend(new);
    });
    if taking.replace {
        data.motor = motor;
    }
    let still = data.settle();
    if data.with(Role::Fit).is_empty() {
        let why = "no record would be left to fit; give at least one of them the role fit";
        return Err(refused(StatusCode::UNPROCESSABLE_ENTITY, why));
    }
    jobs::start(&app, &format!("Reading {}", names.join(", ")), move |_| match Session::of(data) {
        Ok(new) => {
            let verb = if names.len() == 1 { "is" } else { "are" };
            let mut message = format!("{} {verb} in; the base model is fitted.", names.join(", "));
            for warning in still {
                message += &format!(" {}.", warning.what);
            }
            End::Done(message, Box::new(move |session| *session = new))
        }
        Err(error) => End::Failed(error.to_json()),
    })
}

/// The records in `content`. They are judged when all are taken in, as a set, as the verbs judge theirs.
fn parse(dropped: &Dropped, content: Bytes) -> Result<Vec<Entry>> {
    let options = dropped.rig.options(&dropped.map, ReadOptions::default())?;
    let origin = Arc::new(Origin::dropped(&dropped.name, content, options));
    let entry = |record| Entry { origin: Some(Arc::clone(&origin)), ..Entry::new(record, dropped.role) };
    Ok(origin.records()?.into_iter().map(entry).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::{Hold, Record, read};

    fn dropped(map: &str) -> Dropped {
        Dropped { name: "../../etc/log.csv".into(), role: Role::Fit, map: map.into(), rig: Rig::default() }
    }

    #[test]
    fn a_foreign_log_is_read_through_its_map_and_named_as_dropped() {
        let rows = (0..400).map(|k| {
            let t = f64::from(k) * 0.01;
            format!("{},{},{}\n", 1e3 * t, 4.0 * (2.0 * t).sin(), 3.0 * (2.0 * t - 0.1).sin())
        });
        let text = "ms,u,w\n".to_owned() + &rows.collect::<String>();
        let entries = parse(&dropped("time=0:ms,voltage=1,speed=2"), text.into()).unwrap();
        assert_eq!(entries[0].record.path, std::path::Path::new("log.csv"));
        assert_eq!(entries[0].record.len(), 400);
    }

    #[test]
    fn duty_and_counts_are_read_with_the_supply_and_the_counts_of_a_turn() {
        let row = |k: u32| {
            let t = 0.01 * f64::from(k);
            let counts = -220.0 * (2.0 * t - 0.1).cos();
            format!("{},{},{counts:.0}\n", 10 * k, 100.0 * (2.0 * t).sin())
        };
        let text = "ms,pwm,ticks\n".to_owned() + &(0..600).map(row).collect::<String>();
        let wish = dropped("time=0:ms,duty=1:255,angle=2:counts");
        let rig = Rig::with(&[("supply_volts", "8"), ("counts_per_rev", "1000")]);
        let wish = Dropped { rig, ..wish };
        let entries = parse(&wish, text.into()).unwrap();
        let record = &entries[0].record;
        let (volts, angles) = (&record.voltage_v, record.angle_rad.as_ref().unwrap());
        assert!((volts[50] - 8.0 * 100.0 / 255.0 * 1.0_f64.sin()).abs() < 1e-9, "{}", volts[50]);
        let turn = std::f64::consts::TAU;
        assert!((angles[50] + 0.22 * turn * 0.9_f64.cos()).abs() < 1e-3 * turn, "{}", angles[50]);
    }

    #[test]
    fn what_a_query_says_in_its_fields_is_as_the_options_of_the_command_line_say_it() {
        let text: String = (0..300).map(|k| format!("{},{},{k}\n", 10 * k, k / 50 % 2 * 6)).collect();
        let text = format!("ms,u,w\n{text}");
        let asked = |fields: &str| {
            let uri = format!("http://page/?name=log.csv&role=fit&map=time=0:ms,voltage=1,speed=2&{fields}");
            let Query(dropped) = Query::<Dropped>::try_from_uri(&uri.parse().unwrap()).unwrap();
            parse(&dropped, text.clone().into())
        };
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("log.csv");
        std::fs::write(&path, &text).unwrap();
        let map = Some("time=0:ms,voltage=1,speed=2".parse().unwrap());
        let given = ReadOptions {
            map,
            hold: Some(Hold::First),
            voltage_lead_s: Some(0.008),
            ..ReadOptions::default()
        };
        let by_options = read(&path, &given).unwrap();
        let entries = asked("hold=first&voltage_lead=0.008&servo_gain=").unwrap();
        let Record { voltage_v, hold, meta, .. } = entries[0].record.as_ref();
        assert_eq!((hold, meta.voltage_lead_s()), (&Hold::First, Some(0.008)));
        assert_eq!(
            (voltage_v, hold, meta),
            (&by_options[0].voltage_v, &by_options[0].hold, &by_options[0].meta)
        );
        let refused = asked("voltage_lead=-0.008").unwrap_err().to_string();
        assert!(refused.contains("\"Voltage acts before its row by (s)\" is \"-0.008\""), "{refused}");
    }
}
