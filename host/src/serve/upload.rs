//! Logs dropped on the page: each is read as it comes, and all are taken in at once.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use axum::Json;
use axum::body::Bytes;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use serde::Deserialize;
use serde_json::json;

use super::App;
use super::data::{Entry, Role};
use super::jobs::{self, Answer, End, refused};
use super::session::Session;
use crate::error::{Error, Result};
use crate::log::guess::look;
use crate::log::{EncoderShaft, ReadOptions, Record, read};
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

/// What the fields of the dialogue say of the rig; the query gives all of it as text.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Rig {
    /// Supply of the driver, V, where the log has the duty only.
    supply_v: Option<String>,
    /// Counts per turn of the output shaft.
    counts_per_rev: Option<String>,
    /// Metres of a linear axis per turn of the output shaft.
    metres_per_rev: Option<String>,
    /// Rows per second, where no column tells the time.
    rate_hz: Option<String>,
    /// Turns of the motor per turn of the output shaft.
    gear_ratio: Option<String>,
    /// Where the encoder sits.
    encoder_shaft: Option<EncoderShaft>,
}

impl Rig {
    /// The number in a field, if there is one.
    fn number(field: &Option<String>, name: &str) -> Result<Option<f64>> {
        let Some(text) = field.as_deref().map(str::trim).filter(|text| !text.is_empty()) else {
            return Ok(None);
        };
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() && value > 0.0 => Ok(Some(value)),
            _ => Err(Error::usage(
                format!("{name} is \"{text}\""),
                "give a positive number, or leave it empty",
            )),
        }
    }

    /// What is known of the motor.
    fn motor(&self) -> Result<MotorFile> {
        Ok(MotorFile {
            counts_per_rev: Self::number(&self.counts_per_rev, "counts per turn")?,
            metres_per_rev: Self::number(&self.metres_per_rev, "metres per turn")?,
            gear_ratio: Self::number(&self.gear_ratio, "gear ratio")?,
            encoder_shaft: self.encoder_shaft,
            ..MotorFile::default()
        })
    }
}

/// A file whose columns are to be guessed.
#[derive(Debug, Deserialize)]
pub struct Named {
    /// Name of the file.
    name: String,
}

/// The guess at the columns of a file: the same that the command line proposes. Of a text its beginning is enough.
pub async fn guess(Query(named): Query<Named>, body: Bytes) -> Answer {
    let looked = tokio::task::block_in_place(|| {
        let (_directory, path, name) = kept(&named.name, &body)?;
        look(&path).map_err(|error| called(error, &name))
    });
    let looked = looked.map_err(|error| (StatusCode::UNPROCESSABLE_ENTITY, Json(error.to_json())))?;
    Ok(Json(json!(looked)))
}

/// Reads a log and keeps its records until [`take`] is asked for.
pub async fn upload(State(app): State<Arc<App>>, Query(dropped): Query<Dropped>, body: Bytes) -> Answer {
    let read = tokio::task::block_in_place(|| parse(&dropped, &body));
    let new = read.map_err(|error| (StatusCode::UNPROCESSABLE_ENTITY, Json(error.to_json())))?;
    let names: Vec<String> = new.iter().map(|record| record.name.clone()).collect();
    app.uploaded().extend(new.into_iter().map(|record| Entry::new(record, dropped.role)));
    Ok(Json(json!({ "records": names })))
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
    let motor =
        taking.rig.motor().map_err(|error| (StatusCode::UNPROCESSABLE_ENTITY, Json(error.to_json())))?;
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

/// `content` as a file in a directory of its own, and the file's name.
fn kept(name: &str, content: &[u8]) -> Result<(tempfile::TempDir, PathBuf, PathBuf)> {
    let io = |source| Error::Io { doing: "cannot keep the log for reading".into(), source };
    let directory = tempfile::tempdir().map_err(io)?;
    // Only the last part of the name, so that it stays within the directory.
    let name = Path::new(name).file_name().map_or_else(|| PathBuf::from("log.csv"), PathBuf::from);
    let path = directory.path().join(&name);
    std::fs::write(&path, content).map_err(io)?;
    Ok((directory, path, name))
}

/// The error with the file called as it was dropped, not as it was kept.
fn called(error: Error, name: &Path) -> Error {
    match error {
        Error::BadInput(mut fault) => {
            name.clone_into(&mut fault.file);
            Error::BadInput(fault)
        }
        other => other,
    }
}

/// The records in `content`. They are judged when all are taken in, as a set, as the verbs judge theirs.
fn parse(dropped: &Dropped, content: &[u8]) -> Result<Vec<Record>> {
    let (_directory, path, name) = kept(&dropped.name, content)?;
    let map = if dropped.map.is_empty() { None } else { Some(dropped.map.parse()) };
    let map = map.transpose().map_err(|why: String| Error::usage(why, "choose the columns again"))?;
    let supply_volts = Rig::number(&dropped.rig.supply_v, "supply")?;
    let rate_hz = Rig::number(&dropped.rig.rate_hz, "samples per second")?;
    let motor = dropped.rig.motor()?;
    let options = ReadOptions { map, motor, supply_volts, rate_hz, ..ReadOptions::default() };
    let mut records = read(&path, &options).map_err(|error| called(error, &name))?;
    for record in &mut records {
        record.path.clone_from(&name);
    }
    Ok(records)
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let records = parse(&dropped("time=0:ms,voltage=1,speed=2"), text.as_bytes()).unwrap();
        assert_eq!(records[0].path, Path::new("log.csv"));
        assert_eq!(records[0].len(), 400);
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
        let rig = Rig { supply_v: Some("8".into()), counts_per_rev: Some("1000".into()), ..Rig::default() };
        let wish = Dropped { rig, ..wish };
        let records = parse(&wish, text.as_bytes()).unwrap();
        let (volts, angles) = (&records[0].voltage_v, records[0].angle_rad.as_ref().unwrap());
        assert!((volts[50] - 8.0 * 100.0 / 255.0 * 1.0_f64.sin()).abs() < 1e-9, "{}", volts[50]);
        let turn = std::f64::consts::TAU;
        assert!((angles[50] + 0.22 * turn * 0.9_f64.cos()).abs() < 1e-3 * turn, "{}", angles[50]);
    }

    #[test]
    fn a_field_that_is_no_positive_number_is_named() {
        let rig = Rig { gear_ratio: Some("-3".into()), ..Rig::default() };
        assert!(rig.motor().unwrap_err().to_string().contains("gear ratio is \"-3\""));
        assert_eq!(Rig::default().motor().unwrap(), MotorFile::default());
    }

    #[test]
    fn a_bad_log_gets_a_message_without_the_place_where_it_was_kept() {
        let text = "time_s,voltage_v,angle_rad\n0,1,2\n1,x,3\n";
        let error = parse(&dropped(""), text.as_bytes()).unwrap_err().to_string();
        assert!(error.starts_with("log.csv") && error.contains("line 3"), "{error}");
    }
}
