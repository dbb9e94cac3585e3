//! Programmes played on the board, drawn as they are played; their records become the session's.

use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use clap::ValueEnum;
use motorlens_shared::link::{Cause, DriveMode, Setup, ToBoard};
use serde::Deserialize;
use serde_json::json;

use super::App;
use super::data::{self, Entry};
use super::device::ask;
use super::jobs::{self, Answer, End, Job, refused};
use super::session::Session;
use crate::device::{Capture, Captured, Port, Shaft, WAITING, record, remedy, wiring};
use crate::error::{Error, Result};
use crate::log::Record;
use crate::motor_file::MotorFile;
use crate::report::decimate::rounded;
use crate::simulate::{Excitation, Play, Role, plays};

/// What to run.
#[derive(Debug, Deserialize)]
pub struct Wish {
    /// An excitation by its name, or `next` for the programme that the diagnosis proposes.
    programme: String,
    /// Largest voltage of a single shape, V.
    amplitude_v: f32,
    /// Length of every run, s; the programme's own if absent.
    seconds: Option<f32>,
    /// Supply of the driver where the board does not measure it, V.
    supply_v: f32,
    /// How the driver is driven: brake, coast or anti-phase.
    drive: String,
    /// The divider that is wired to the board's supply input, by what it divides; 0 for none.
    #[serde(default)]
    divider: f32,
    /// The current amplifier that is wired to the board's current input, mV/A; 0 for none.
    #[serde(default)]
    amplifier: f32,
    /// Stop above this current, A; 0 is no limit.
    current_limit_a: f32,
    /// Counts per turn of the output shaft.
    counts_per_rev: f64,
    /// Motor turns per turn of the output shaft, where known.
    gear_ratio: Option<f64>,
    /// Whether the records join those of the session; else they replace them.
    join: bool,
}

/// The page is told of new samples so often.
const TELL: Duration = Duration::from_millis(50);

/// Runs the programmes one after the other, then fits.
pub async fn run(State(app): State<Arc<App>>, Json(wish): Json<Wish>) -> Answer {
    let bad = |why: &str| refused(StatusCode::UNPROCESSABLE_ENTITY, why);
    let device =
        app.device().clone().ok_or_else(|| refused(StatusCode::CONFLICT, "connect a board first"))?;
    if !(wish.counts_per_rev > 0.0 && wish.counts_per_rev.is_finite()) {
        return Err(bad("how many encoder counts make a turn of the output shaft?"));
    }
    let setup = setup(&wish).map_err(|why| bad(&why))?;
    let plays = if wish.programme == "next" {
        let next = app.session().diagnosis.as_ref().and_then(|d| d.next.clone());
        let next = next.ok_or_else(|| bad("there is no experiment to run: find what is missing first"))?;
        vec![Play { role: Role::Training, programme: next.programme }]
    } else {
        let excitation = Excitation::from_str(&wish.programme, true).map_err(|why| bad(&why))?;
        plays(excitation, wish.amplitude_v, wish.supply_v, wish.seconds, 1)
    };
    for play in &plays {
        play.programme.validate(wish.supply_v).map_err(|fault| bad(&fault.to_string()))?;
    }
    jobs::start_on_device(&app, "Running the motor", move |job| {
        match captured(job, &device.port, setup, &plays, &wish) {
            Ok(Some(records)) => fitted(job, records, &wish),
            Ok(None) => End::Stopped("The motor is stopped. Nothing of this run is used.".into()),
            Err(error) => End::Failed(error.to_json()),
        }
    })
}

fn setup(wish: &Wish) -> std::result::Result<Setup, String> {
    let drive = match wish.drive.as_str() {
        "brake" => DriveMode::SignMagnitudeBrake,
        "coast" => DriveMode::SignMagnitudeCoast,
        "anti-phase" => DriveMode::LockedAntiPhase,
        "in-in" => DriveMode::InInBrake,
        "in-in-coast" => DriveMode::InInCoast,
        other => return Err(format!("{other} is no way to drive a bridge")),
    };
    let wired = |value: f32| (value != 0.0).then_some(value);
    let told = wiring::setup(wish.supply_v, wired(wish.divider), wired(wish.amplifier), wish.current_limit_a);
    let setup = Setup { drive, ..told.map_err(|fault| fault.to_string())? };
    // The board checks again, with its own log.
    setup.check(1024, true).map_err(|fault| fault.to_string())?;
    Ok(setup)
}

/// The records of all plays; none when the user stopped.
fn captured(
    job: &Job,
    port: &str,
    setup: Setup,
    plays: &[Play],
    wish: &Wish,
) -> Result<Option<Vec<(Role, Record)>>> {
    let shaft = Shaft { counts_per_rev: wish.counts_per_rev, gear_ratio: wish.gear_ratio, encoder: None };
    let mut port = Port::open(port)?;
    // Any number but the board's last one: the time is never the same again.
    let mut run = SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |since| since.as_millis() as u32);
    let mut records = Vec::new();
    for (index, play) in (0_u32..).zip(plays) {
        job.tell(json!({ "type": "playing", "programme": play.log_name(), "number": index + 1,
                         "of": plays.len(), "seconds": play.programme.seconds() }));
        let Some(captured) = played(job, &mut port, setup, play, &mut run, &shaft)? else {
            ask(&mut port, [ToBoard::Stop])?;
            return Ok(None);
        };
        if captured.cause != Cause::Finished {
            let why = format!("{}: {}", play.log_name(), captured.cause);
            return Err(Error::device(why, remedy(captured.cause)));
        }
        let mut record = record(&captured, &shaft, &play.programme)
            .map_err(|why| Error::usage(why, "give the programme a name without line breaks"))?;
        record.name = play.log_name();
        record.path = record.name.clone().into();
        records.push((play.role, record));
    }
    Ok(Some(records))
}

/// One play, told as it goes, under this number or, where the shaft is waited for, one of the next; leaves the number for the next play.
/// None when the user stopped, with the motor still running.
fn played(
    job: &Job,
    port: &mut Port,
    setup: Setup,
    play: &Play,
    run: &mut u32,
    shaft: &Shaft,
) -> Result<Option<Captured>> {
    let mut capture = Capture::new(setup, &play.programme, *run).patient();
    let (mut told, mut told_at, mut waits) = (0, Duration::ZERO, false);
    let outcome = port.converse(|now, received, send| {
        if job.stopped() {
            return Some(None);
        }
        capture.receive(received, now);
        capture.poll(now, send);
        let outcome = capture.take_outcome();
        if capture.waits() && !std::mem::replace(&mut waits, true) {
            job.tell(json!({ "type": "waiting", "message": WAITING }));
        }
        if now.saturating_sub(told_at) >= TELL || outcome.is_some() {
            told_at = now;
            told += live(job, &capture, told, shaft);
        }
        outcome.map(Some)
    });
    *run = capture.run().wrapping_add(1);
    Ok(outcome?.transpose()?)
}

/// Tells the page the samples from number `from` on, and returns how many they are.
fn live(job: &Job, capture: &Capture, from: usize, shaft: &Shaft) -> usize {
    let Some(scaling) = capture.scaling() else { return 0 };
    let fresh = capture.samples_from(from);
    if fresh.is_empty() {
        return 0;
    }
    let taken = || fresh.iter().filter(|(_, sample)| !sample.missed());
    let column = |value: &dyn Fn(u32, &motorlens_shared::link::Sample) -> f64| {
        taken().map(|(index, sample)| rounded(value(*index, sample), 6)).collect::<Vec<f64>>()
    };
    job.tell(json!({
        "type": "live",
        "time": column(&|index, sample| scaling.seconds(index, sample)),
        "voltage": column(&|_, sample| f64::from(scaling.volts(sample))),
        "angle": column(&|_, sample| f64::from(sample.count) * shaft.rad_per_count()),
    }));
    fresh.len()
}

/// Fits the base model to the records, alone or with those that there are.
fn fitted(job: &Job, new: Vec<(Role, Record)>, wish: &Wish) -> End {
    let count = new.len();
    let new = new.into_iter().map(|(role, record)| {
        let role = if role == Role::HeldOut { data::Role::Validation } else { data::Role::Fit };
        Entry::new(record, role)
    });
    let known = MotorFile {
        counts_per_rev: Some(wish.counts_per_rev),
        gear_ratio: wish.gear_ratio,
        ..MotorFile::default()
    };
    let mut data = job.app.session().data.changed(|all| {
        if !wish.join {
            all.clear();
        }
        all.extend(new);
    });
    if !wish.join {
        data.motor = known;
    }
    match Session::of(data) {
        Ok(new) => End::Done(
            match count {
                1 => "1 record of the motor is in; the base model is fitted anew.".into(),
                _ => format!("{count} records of the motor are in; the base model is fitted anew."),
            },
            Box::new(move |session| *session = new),
        ),
        Err(error) => End::Failed(error.to_json()),
    }
}
