//! A data log written as a list, one value a line: `Timestamp,Name,Value` (or `Key` for `Name`), times in seconds; or
//! `time_s,signal,value`.
//!
//! DataLogTool and AdvantageScope write WPILib's data logs so. Each entry has its own times, as in the data log itself.

use std::collections::{BTreeMap, BTreeSet};
use std::io::BufRead;

use super::events::{Events, Series};
use super::{Content, Fault};
use crate::log::fields::{Separator, Splitter};
use crate::log::preamble::is_nothing;
use crate::log::text::TextReader;

/// What the column of the names is called beside one of times in seconds, in small letters.
const NAMES: [&str; 7] = ["name", "key", "signal", "topic", "channel", "variable", "field"];

/// The separator of a list, if this is the beginning of one.
fn separator(start: &[u8]) -> Option<u8> {
    // Of UTF-16 the letters of a header remain when its zeros go.
    let text = String::from_utf8_lossy(start).replace('\0', "");
    let header = text.lines().map(str::trim).find(|line| !is_nothing(line) && !line.starts_with('#'))?;
    let is_header = |separator: &u8| {
        let mut names = header
            .split(char::from(*separator))
            .map(|name| name.trim_matches(|c: char| !c.is_ascii_alphanumeric()).to_ascii_lowercase());
        let (time, name, value) = (names.next(), names.next(), names.next());
        let is =
            |text: &Option<String>, words: &[&str]| text.as_deref().is_some_and(|text| words.contains(&text));
        let wpilib = is(&time, &["timestamp"]) && is(&name, &["name", "key"]);
        (wpilib || is(&time, &["time_s"]) && is(&name, &NAMES)) && is(&value, &["value"])
    };
    [b',', b';', b'\t'].into_iter().find(is_header)
}

/// Whether a file that begins so is a list.
pub fn is(start: &[u8]) -> bool {
    separator(start).is_some()
}

/// Reads a list.
///
/// # Errors
/// A fault where a time is no number.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    let again = "export the log again";
    let mut splitter = Splitter::of(Separator::Byte(separator(all).unwrap_or(b',')), false);
    let mut series: BTreeMap<String, Series> = BTreeMap::new();
    let unreadable = |why: std::io::Error| Fault::new(why.to_string(), again);
    let mut lines = TextReader::new(all).map_err(unreadable)?;
    let (mut line, mut number, mut is_below) = (String::new(), 0_u64, false);
    while lines.read_line(&mut line).map_err(unreadable)? > 0 {
        number += 1;
        let closed = splitter.split(&line);
        let is_row = is_below && closed && !is_nothing(line.trim()) && !line.starts_with('#');
        is_below |= is(line.as_bytes());
        line.clear();
        let (Some(time), Some(name), Some(value)) = (splitter.get(0), splitter.get(1), splitter.get(2))
        else {
            continue;
        };
        if !is_row || value.is_empty() {
            continue;
        }
        let Some(time_s) = time.parse().ok().filter(|time: &f64| time.is_finite()) else {
            return Err(Fault::new(format!("line {number}: \"{time}\" is not a time"), again));
        };
        if !series.contains_key(name) {
            series.insert(name.to_owned(), Series::default());
        }
        let Some(series) = series.get_mut(name) else { continue };
        let truth = || match value {
            "true" => Some(1.0),
            "false" => Some(0.0),
            _ => None,
        };
        // An entry is of one type: that of its first value.
        match value.parse().ok().or_else(truth) {
            Some(value) if series.texts.is_empty() => series.numbers.push(value),
            None if series.numbers.is_empty() => series.texts.push(value.to_owned()),
            _ => continue,
        }
        series.times.push(time_s);
    }
    Ok(Content::Events(Events::new(series, BTreeSet::new())))
}

#[cfg(test)]
mod tests {
    use crate::error::Result;
    use crate::log::read_tests::file;
    use crate::log::{ReadOptions, Record, read};

    fn exported(content: &str) -> Result<Vec<Record>> {
        let (_directory, path) = file(content.as_bytes());
        read(&path, &ReadOptions::default())
    }

    /// Two tests of 30 turns of the loop each, with the state logged in every turn and idling in between.
    fn log() -> String {
        let mut text = "Timestamp,Name,Value\n0,\"systemTime\",5\n".to_owned();
        for turn in 0..100 {
            let t = f64::from(turn) * 0.02;
            let (state, sign) = match turn {
                10..40 => ("quasistatic-forward", 1.0),
                60..90 => ("dynamic-reverse", -1.0),
                _ => ("none", 0.0),
            };
            text += &format!("{t},\"sysid-test-state-arm\",\"{state}\"\n");
            for (late, kind, value) in
                [(1e-5, "voltage", 2.0), (2e-5, "position", t), (3e-5, "velocity", 1.0)]
            {
                text += &format!("{},\"/arm/{kind}-left\",{}\n", t + late, sign * value);
            }
        }
        text
    }

    #[test]
    fn each_test_of_a_list_becomes_a_record_in_radians_and_needs_no_format() {
        for text in [
            log(),
            log().replace("Timestamp,Name", "Timestamp,Key"),
            log().replace("Timestamp,Name", "\"Timestamp\",\"Name\""),
            log().replace(',', ";"),
        ] {
            let records = exported(&text).unwrap();
            assert_eq!(records.len(), 2);
            assert_eq!(records[0].len(), 30);
            assert!(records[0].name.ends_with("quasistatic-forward left"));
            assert_eq!(records[1].voltage_v[0], -2.0);
            let turn = std::f64::consts::TAU;
            assert!((records[1].angle_rad.as_ref().unwrap()[0] + 1.2 * turn).abs() < 1e-9);
            assert!((records[1].speed_rad_s.as_ref().unwrap()[0] + turn).abs() < 1e-9);
        }
    }

    #[test]
    fn a_list_without_tests_is_a_table_of_its_entries() {
        let text = log().replace("sysid-test-state-arm", "mode").replace("quasistatic-forward", "auto");
        let text = text.replace("dynamic-reverse", "teleop");
        let refused = exported(&text).unwrap_err().to_string();
        assert!(refused.contains("--map time=time_s:s,voltage=/arm/voltage-left:V"), "{refused}");
    }

    #[test]
    fn what_is_wrong_in_an_export_is_named() {
        for (text, words) in [
            (log().replace("voltage-", "volts-"), ["no test has", "include"]),
            (log().replace("0.02,", "noon,"), ["line 7: \"noon\" is not a time", "export"]),
        ] {
            let said = exported(&text).unwrap_err().to_string();
            assert!(words.iter().all(|word| said.contains(word)), "{said}");
        }
    }
}
