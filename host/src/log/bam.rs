//! `--format bam-json`: position servos logged by Rhoban's BAM ("Better Actuator Models").
//!
//! Such a servo has no voltage sensor behind its own position loop, which drives the motor with
//! `duty = clip(kp * gain * (goal - position), -1, 1)`. The voltage is inferred as `duty * input_volts`; `gain`
//! (`--servo-gain`, per rad of error and unit of kp) was measured on Feetech servos. The loop is much faster than the
//! log, so the voltage runs on between samples (hold "first"). The servo's own speed is a filtered difference of its
//! position and adds nothing; it is left out. When the servo is released its terminals float and the voltage is
//! unknown: the record ends there.

use std::io::BufRead;
use std::path::Path;

use serde::Deserialize;

use super::samples::{Place, Samples};
use super::{Hold, Metadata, ReadOptions, Record, Warning, json};
use crate::error::{BadInput, Result};

/// Duty per radian of error and unit of kp, as measured on a Feetech STS3215.
pub const SERVO_GAIN: f64 = 0.1649;

#[derive(Deserialize)]
struct File {
    kp: f64,
    #[serde(default)]
    trajectory: Option<String>,
    #[serde(default)]
    mass: Option<f64>,
    #[serde(default)]
    length: Option<f64>,
    entries: Vec<Entry>,
}

#[derive(Deserialize)]
struct Entry {
    timestamp: Option<f64>,
    position: Option<f64>,
    goal_position: Option<f64>,
    input_volts: Option<f64>,
    #[serde(default = "held")]
    torque_enable: bool,
}

fn held() -> bool {
    true
}

/// Reads the one record of a BAM log.
///
/// # Errors
/// Bad input where the JSON is broken or has another layout, or the samples fail the rules.
pub fn read(path: &Path, input: impl BufRead, options: &ReadOptions) -> Result<Record> {
    let file: File = json::parse(path, input)?;
    if !(file.kp.is_finite() && file.kp > 0.0) {
        let why = format!("kp = {} does not close a position loop", file.kp);
        return Err(BadInput::new(path, why, "log the proportional gain of the servo")
            .in_column("kp")
            .into());
    }
    let gain = file.kp * options.servo_gain.unwrap_or(SERVO_GAIN);
    let released = file.entries.iter().position(|entry| !entry.torque_enable);
    let headers = ["timestamp", "goal_position", "position", "input_volts"];
    let mut samples = Samples::new(path, headers.map(String::from).to_vec());
    for (index, entry) in file.entries.iter().take(released.unwrap_or(usize::MAX)).enumerate() {
        let fields = [entry.timestamp, entry.goal_position, entry.position, entry.input_volts];
        match fields.iter().position(Option::is_none) {
            None => samples.accept(Place::Entry(index), &fields.map(Option::unwrap_or_default))?,
            Some(lost) => samples.reject(Place::Entry(index), headers[lost], "the number is missing".into()),
        }
    }
    let (mut columns, mut warnings) = samples.finish(None)?;
    if let Some(entry) = released {
        warnings.push(Warning {
            place: format!("{}, entry {entry}", path.display()),
            what: format!(
                "the servo was released here; the {} rows from here on are left out, since its voltage is unknown",
                file.entries.len() - entry
            ),
            fix: "keep the servo powered while logging".into(),
        });
    }
    let mut meta = Metadata::default();
    let facts = [
        ("programme", file.trajectory),
        ("mass_kg", file.mass.map(|mass| mass.to_string())),
        ("arm_m", file.length.map(|length| length.to_string())),
        ("kp", Some(file.kp.to_string())),
        ("voltage", Some("inferred from the position loop".to_owned())),
    ];
    for (key, value) in facts {
        if let Some(value) = value {
            meta.insert(key, &value).expect("these keys take any text");
        }
    }
    options.complete(path, &mut meta)?;
    let supply = columns.pop().unwrap_or_default();
    let position = columns.pop().unwrap_or_default();
    let goal = columns.pop().unwrap_or_default();
    let voltage =
        (0..supply.len()).map(|i| (gain * (goal[i] - position[i])).clamp(-1.0, 1.0) * supply[i]).collect();
    Ok(Record {
        name: super::stem(path),
        path: path.to_owned(),
        time_s: columns.pop().unwrap_or_default(),
        voltage_v: voltage,
        angle_rad: Some(position),
        supply_v: Some(supply),
        hold: options.hold.unwrap_or(Hold::First),
        meta,
        warnings,
        ..Record::default()
    })
}

#[cfg(test)]
mod tests {
    use super::super::read_tests::{assert_bad, file};
    use super::super::{Format, Hold, ReadOptions, Record, read};
    use crate::error::Result;

    fn bam(content: &str) -> Result<Record> {
        let (_directory, path) = file(content.as_bytes());
        let options = ReadOptions { format: Format::BamJson, ..ReadOptions::default() };
        read(&path, &options).map(|mut records| records.remove(0))
    }

    fn log(released_at: usize) -> String {
        let entries: Vec<String> = (0..40)
            .map(|i| {
                format!(
                    "{{\"timestamp\":{},\"position\":0.5,\"goal_position\":{},\"input_volts\":12,\"torque_enable\":{}}}",
                    f64::from(i) * 0.02,
                    if i == 0 { 0.6 } else { 3.0 },
                    (i as usize) < released_at
                )
            })
            .collect();
        format!("{{\"kp\":32,\"mass\":1.13,\"trajectory\":\"sin\",\"entries\":[{}]}}", entries.join(","))
    }

    #[test]
    fn the_voltage_follows_from_the_position_loop_and_is_limited_by_the_supply() {
        let record = bam(&log(40)).unwrap();
        assert_eq!(record.len(), 40);
        assert!((record.voltage_v[0] - 32.0 * 0.1649 * 0.1 * 12.0).abs() < 1e-9);
        assert_eq!(record.voltage_v[1], 12.0);
        assert_eq!(record.hold, Hold::First);
        assert_eq!(record.meta.programme(), Some("sin"));
        assert!(record.warnings.is_empty() && record.speed_rad_s.is_none());
    }

    #[test]
    fn a_released_servo_ends_the_record_with_a_warning() {
        let record = bam(&log(25)).unwrap();
        assert_eq!(record.len(), 25);
        assert!(record.warnings[0].what.contains("15 rows"));
    }

    #[test]
    fn another_layout_is_refused() {
        assert_bad(&bam("{\"kp\": 32}").unwrap_err(), "line 1", "missing field `entries`", "--format");
        assert_bad(&bam(&log(10)).unwrap_err(), "entry 9", "10 samples are too few", "at least 20");
        assert_bad(&bam(&log(40).replace("32", "0")).unwrap_err(), "column kp", "position loop", "gain");
    }
}
