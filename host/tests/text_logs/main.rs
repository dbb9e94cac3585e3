//! One motion, written as people's programs, boards and spreadsheets write it: each is read as the same record, or its proposal reads it.

use std::path::PathBuf;

use motorlens::error::{BadInput, Error};
use motorlens::log::{ReadOptions, Record, read};

mod blanks;
mod boards;
mod clocks;
mod drives;
mod encodings;
mod heads;
mod loggers;
mod names;
mod numbers;
mod proposals;
mod refusals;
mod signs;
mod times;
mod tools;
mod units;

const ROWS: u32 = 200;

/// Time, s, voltage, V, and angle, rad, of row `k`, with four decimals.
fn row(k: u32) -> (f64, f64, f64) {
    let t = f64::from(k) * 0.01;
    let round = |x: f64| (1e4 * x).round() / 1e4;
    (t, round(4.0 * (3.0 * t).sin()), round(2.0 - 2.0 * (3.0 * t).cos()))
}

/// A file of `head` and one line per row.
fn lines(head: &str, line: impl Fn(u32, f64, f64, f64) -> String) -> String {
    let mut text = head.to_owned();
    for k in 0..ROWS {
        let (t, u, x) = row(k);
        text += &line(k, t, u, x);
        text.push('\n');
    }
    text
}

/// A clock time of `ms` milliseconds after `from` seconds since midnight.
fn clock(from: u32, ms: u32) -> String {
    let all = (u64::from(from) * 1000 + u64::from(ms)) % 86_400_000;
    format!("{:02}:{:02}:{:02}.{:03}", all / 3_600_000, all / 60_000 % 60, all / 1000 % 60, all % 1000)
}

fn kept(content: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("log.csv");
    std::fs::write(&path, content).unwrap();
    (directory, path)
}

fn read_bytes(content: &[u8], options: &ReadOptions) -> Result<Record, Error> {
    let (_directory, path) = kept(content);
    read(&path, options).map(|mut records| {
        assert_eq!(records.len(), 1);
        records.remove(0)
    })
}

fn mapped(map: &str) -> ReadOptions {
    ReadOptions { map: (!map.is_empty()).then(|| map.parse().unwrap()), ..ReadOptions::default() }
}

/// The record is that of all rows but the first `missing`, whatever the origin of its clock.
fn assert_same(record: &Record, what: &str, missing: usize) {
    assert_eq!(record.len(), ROWS as usize - missing, "{what}: {:?}", record.warnings);
    let angle = record.angle_rad.as_ref().unwrap();
    for k in 0..record.len() {
        let (t, u, x) = row((k + missing) as u32);
        let since = record.time_s[k] - record.time_s[0] + 0.01 * missing as f64;
        let off = [since - t, record.voltage_v[k] - u, angle[k] - x];
        assert!(off.iter().all(|off| off.abs() < 2e-6), "{what}: {off:?} in row {k}");
    }
}

/// The record that is read of rows written as `what` says: that of all of them.
fn read_same(content: &[u8], options: &ReadOptions, what: &str) -> Record {
    let record = read_bytes(content, options).unwrap_or_else(|error| panic!("{what}: {error}"));
    assert_same(&record, what, 0);
    record
}

const HEADER: &str = "time_s,voltage_v,angle_rad\n";

fn plain() -> String {
    lines(HEADER, |_, t, u, x| format!("{t:.4},{u:.4},{x:.4}"))
}

fn refusal(text: &str) -> Box<BadInput> {
    match read_bytes(text.as_bytes(), &ReadOptions::default()) {
        Err(Error::BadInput(fault)) => fault,
        other => panic!("{other:?}"),
    }
}
