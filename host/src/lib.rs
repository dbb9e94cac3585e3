//! Fits a geared DC motor's model to logs, and names the missing physical effect.
//!
//! The program `motorlens` is this library and a command line. [`discover`] takes plain slices; [`discover_records`] takes what
//! [`record`] or [`log::read`] made, with records to judge by; [`fit()`], [`add()`] and [`plan()`] are its parts. [`compare()`] holds a model
//! against records, and [`same()`] two sets of records against each other. An effect is a [`Kind`]. A [`Model`] simulates
//! ([`Model::simulate`]), runs step by step ([`Model::start`]), is written for other tools ([`export`]) and gets its gains ([`tune`]). All
//! quantities are SI and of the output shaft; torques are volts, as voltage and motion tell no more.
//!
//! Features, all on by default: `cli` (the program), `serve` (the page in a browser), `device` (boards at a serial port), and `logs`,
//! the readers that need a crate: `log-xlsx` (spreadsheets), `log-parquet`, `log-mat` (MATLAB, HDF5), `log-mcap` and `log-npz`, each by
//! its own name too. Without any (`default-features = false`) the library reads text logs, fits, diagnoses, simulates and exports.
//!
//! ```
//! use std::ops::ControlFlow;
//! use motorlens::{Options, discover_records, log};
//! # // The log of the example's model, which has 0.4 V of dry friction.
//! # let directory = tempfile::tempdir().expect("a directory");
//! # let (steps_csv, model_json) = (directory.path().join("steps.csv"), directory.path().join("model.json"));
//! # let time: Vec<f64> = (0..1500).map(|k| f64::from(k) * 2e-3).collect();
//! # let volts: Vec<f64> = (0..1500).map(|k| [6.0, 0.0, -4.0, 2.0, 9.0][k / 200 % 5]).collect();
//! # let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/model.json");
//! # let angle = motorlens::Model::read(path.as_ref())?.simulate(&time, &volts, 0.0)?;
//! # let row = |k: usize| format!("{:.3},{},{:.3}\n", time[k], volts[k], angle[k]);
//! # let rows: String = (0..time.len()).map(row).collect();
//! # std::fs::write(&steps_csv, format!("time_s,voltage_v,angle_rad\n{rows}")).expect("a file");
//!
//! let records = log::read(&steps_csv, &log::ReadOptions::default())?;
//! let found = discover_records(&records, &Options::default(), &mut |_| ControlFlow::Continue(()))?;
//! println!("{}", found.findings.headline);
//! found.model.write(&model_json)?;
//! # assert!(found.model.values().kinds().iter().any(|effect| effect.name() == "coulomb"));
//! # Ok::<(), motorlens::Error>(())
//! ```
mod api;
pub mod atomic_file;
pub mod book;
#[cfg(feature = "cli")]
pub mod cli;
pub mod compare;
mod cores;
#[cfg(feature = "device")]
pub mod device;
pub mod diagnose;
pub mod error;
pub mod estimate;
pub mod exam;
pub mod export;
pub mod findings;
pub mod fit;
pub mod formula;
pub mod glossary;
pub mod log;
pub mod model_file;
pub mod motor_file;
mod nearest;
pub mod paper;
pub mod report;
mod run;
pub mod same;
pub mod search;
pub mod select;
mod sentence;
#[cfg(feature = "serve")]
pub mod serve;
pub mod simulate;
mod stop;
pub mod tune;

pub use api::{
    Discovered, Error, Event, Measured, Model, Observer, Options, Result, add, compare, discover,
    discover_records, fit, plan, record, same,
};
pub use motorlens_shared::effects::Kind;
pub use run::Running;
