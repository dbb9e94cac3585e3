//! A log dropped on the page.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use axum::Json;
use axum::body::Bytes;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use serde::Deserialize;
use serde_json::json;

use super::App;
use super::jobs::{self, Answer, End};
use super::session::Session;
use crate::error::{Error, Result};
use crate::log::{ReadOptions, Record, check_usable, read};
use crate::motor_file::MotorFile;

/// What a dropped log is.
#[derive(Debug, Deserialize)]
pub struct Dropped {
    /// Name of the file.
    name: String,
    /// `training`, `unseen`, or `replace`: the only training record from now on.
    role: String,
    /// Which column is what, as for `--map`; empty for canonical columns.
    #[serde(default)]
    map: String,
    /// Supply of the driver, V, where the log has the duty only.
    supply_v: Option<f64>,
    /// Counts per turn of the output shaft, where the log has counts.
    counts_per_rev: Option<f64>,
}

/// Reads the log; if it can be used, fits the base model anew.
pub async fn upload(State(app): State<Arc<App>>, Query(dropped): Query<Dropped>, body: Bytes) -> Answer {
    let read = tokio::task::block_in_place(|| parse(&dropped, &body));
    let new = read.map_err(|error| (StatusCode::UNPROCESSABLE_ENTITY, Json(error.to_json())))?;
    let count = new.len();
    jobs::start(&app, &format!("Reading {}", dropped.name), move |job| {
        let (mut records, mut validation, motor) = match dropped.role.as_str() {
            "replace" => (Vec::new(), Vec::new(), MotorFile::default()),
            _ => {
                let session = job.app.session();
                (session.records.clone(), session.validation.clone(), session.motor.clone())
            }
        };
        if dropped.role == "unseen" {
            validation.extend(new)
        } else {
            records.extend(new)
        }
        match Session::new(records, validation, motor) {
            Ok(new) => End::Done(
                format!("{} is in; the base model is fitted to it.", dropped.name),
                Box::new(move |session| *session = new),
            ),
            Err(error) => End::Failed(error.to_json()),
        }
    })
    .map(|_| Json(json!({ "records": count })))
}

/// The records in `content`, judged.
fn parse(dropped: &Dropped, content: &[u8]) -> Result<Vec<Record>> {
    let io = |source| Error::Io { doing: "cannot keep the log for reading".into(), source };
    let directory = tempfile::tempdir().map_err(io)?;
    // Only the last part of the name, so that it stays within the directory.
    let name = Path::new(&dropped.name).file_name().map_or_else(|| PathBuf::from("log.csv"), PathBuf::from);
    let path = directory.path().join(&name);
    std::fs::write(&path, content).map_err(io)?;
    let map = if dropped.map.is_empty() { None } else { Some(dropped.map.parse()) };
    let map = map.transpose().map_err(|why: String| Error::usage(why, "choose the columns again"))?;
    let shorter = |error: Error| match error {
        Error::BadInput(mut fault) => {
            fault.file.clone_from(&name);
            Error::BadInput(fault)
        }
        other => other,
    };
    let motor = MotorFile { counts_per_rev: dropped.counts_per_rev, ..MotorFile::default() };
    let options = ReadOptions { map, motor, supply_volts: dropped.supply_v, ..ReadOptions::default() };
    let mut records = read(&path, &options).map_err(shorter)?;
    for record in &mut records {
        record.path.clone_from(&name);
        check_usable(record)?;
    }
    Ok(records)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dropped(map: &str) -> Dropped {
        let (name, role) = ("../../etc/log.csv".into(), "replace".into());
        Dropped { name, role, map: map.into(), supply_v: None, counts_per_rev: None }
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
        let wish = Dropped { supply_v: Some(8.0), counts_per_rev: Some(1000.0), ..wish };
        let records = parse(&wish, text.as_bytes()).unwrap();
        let (volts, angles) = (&records[0].voltage_v, records[0].angle_rad.as_ref().unwrap());
        assert!((volts[50] - 8.0 * 100.0 / 255.0 * 1.0_f64.sin()).abs() < 1e-9, "{}", volts[50]);
        let turn = std::f64::consts::TAU;
        assert!((angles[50] + 0.22 * turn * 0.9_f64.cos()).abs() < 1e-3 * turn, "{}", angles[50]);
    }

    #[test]
    fn a_bad_log_gets_a_message_without_the_place_where_it_was_kept() {
        let text = "time_s,voltage_v,angle_rad\n0,1,2\n1,x,3\n";
        let error = parse(&dropped(""), text.as_bytes()).unwrap_err().to_string();
        assert!(error.starts_with("log.csv") && error.contains("line 3"), "{error}");
    }
}
