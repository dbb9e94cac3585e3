//! Binary logs: every format gives the records that a CSV of the same numbers gives, and is refused in words where it is damaged.

mod arrays;
#[path = "../formats_support/mod.rs"]
mod formats_support;
#[path = "../program/mod.rs"]
mod program;
mod tables;
mod wpilog;

use std::path::PathBuf;

use formats_support::canonical_columns;
use motorlens::log::{ReadOptions, Record, read};

fn written(name: &str, content: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join(name);
    std::fs::write(&path, content).unwrap();
    (directory, path)
}

/// The records of a file with this content.
fn records(name: &str, content: &[u8], map: &str) -> motorlens::error::Result<Vec<Record>> {
    let (_directory, path) = written(name, content);
    let map = (!map.is_empty()).then(|| map.parse().unwrap());
    read(&path, &ReadOptions { map, ..ReadOptions::default() })
}

fn refusal(name: &str, content: &[u8], map: &str) -> String {
    records(name, content, map).unwrap_err().to_string()
}

/// What the CSV of the same numbers gives.
fn as_csv(map: &str) -> Record {
    let (names, columns) = canonical_columns();
    let mut text = names.join(",") + "\n";
    for row in 0..columns[0].len() {
        let fields: Vec<String> = columns.iter().map(|column| format!("{:?}", column[row])).collect();
        text += &(fields.join(",") + "\n");
    }
    records("log.csv", text.as_bytes(), map).unwrap().remove(0)
}

#[track_caller]
fn same(found: &Record, expected: &Record, within: f64) {
    let close =
        |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= within);
    assert!(close(&found.time_s, &expected.time_s), "times differ: {:?} {:?}", found.time_s, expected.time_s);
    assert!(close(&found.voltage_v, &expected.voltage_v), "voltages differ");
    for (a, b) in [(&found.angle_rad, &expected.angle_rad), (&found.speed_rad_s, &expected.speed_rad_s)] {
        assert_eq!(a.is_some(), b.is_some());
        assert!(a.iter().zip(b).all(|(a, b)| close(a, b)), "motions differ");
    }
}

/// The motion that `fixtures.py` writes.
fn fixed() -> Record {
    let time_s: Vec<f64> = (0..60).map(|k| f64::from(k) / 100.0).collect();
    let round = |x: f64, scale: f64| (x * scale).round() / scale;
    Record {
        voltage_v: (0..60).map(|k| if k / 15 % 2 == 0 { 4.5 } else { -3.25 }).collect(),
        angle_rad: Some(time_s.iter().map(|t| round(1.5 - 1.5 * (4.0 * t).cos(), 1e4)).collect()),
        speed_rad_s: Some(time_s.iter().map(|t| round(6.0 * (4.0 * t).sin(), 1e3)).collect()),
        time_s,
        ..Record::default()
    }
}

#[test]
fn what_only_another_program_reads_is_answered_with_that_program() {
    let directory = tempfile::tempdir().unwrap();
    for (name, content, is, program) in [
        ("match.hoot", &b"\0\x01\x02\x03"[..], "hoot", "owlet"),
        ("run.bag", b"#ROSBAG V2.0\n", "ROS 1 bag", "mcap convert"),
        ("run.mf4", b"MDF     4.10    ", "measurement", "asammdf"),
        ("log.csv.gz", b"\x1F\x8B\x08\0", "gzip", "gunzip"),
    ] {
        std::fs::write(directory.path().join(name), content).unwrap();
        let refused = program::run(directory.path(), &format!("fit {name}")).ends(3);
        assert!(refused.err.contains(is) && refused.err.contains(program), "{}", refused.err);
    }
}
