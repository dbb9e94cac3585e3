//! A data log written as a list, one value a line: `Timestamp,Name,Value` (or `Key` for `Name`), times in seconds; or
//! `time_s,signal,value`, or Grafana's `Time,Metric,Value` with dates or counts of ms, us or ns.
//!
//! InfluxDB's answers are lists too, annotated or not. DataLogTool and AdvantageScope write WPILib's data logs so. Each entry has its own
//! times, as in the data log itself.

use std::collections::{BTreeMap, BTreeSet};

use super::events::{Events, Series};
use super::{Content, Fault};
use crate::log::clock::Clock;
use crate::log::fields::{Separator, Splitter};
use crate::log::line_ends::read_row;
use crate::log::preamble::is_nothing;
use crate::log::text::TextReader;
use crate::log::timing::median_interval;

/// What the column of the names is called beside one of times, in small letters.
const NAMES: [&str; 9] =
    ["name", "key", "signal", "topic", "channel", "variable", "field", "metric", "series"];
/// Whole times are seconds, ms or us up to these intervals of the series that was logged most often, and ns beyond.
const UNITS: [(f64, f64); 3] = [(1.0, 1.0), (500.0, 1e-3), (200_000.0, 1e-6)];

/// How a list is written.
#[derive(Debug, Clone)]
struct Shape {
    separator: u8,
    time: usize,
    name: usize,
    value: usize,
    /// Times are seconds, whatever they look like.
    in_seconds: bool,
    /// Columns that tell values of one name apart: InfluxDB's measurement and tags.
    tags: Vec<usize>,
}

impl Shape {
    /// The shape of a list with this header; none where it is another table's.
    fn of(header: &str) -> Option<Shape> {
        [b',', b';', b'\t'].into_iter().find_map(|separator| {
            let names: Vec<String> = header
                .split(char::from(separator))
                .map(|name| {
                    name.trim_matches(|c: char| !c.is_ascii_alphanumeric() && c != '_').to_ascii_lowercase()
                })
                .collect();
            Self::of_influx(separator, &names).or_else(|| {
                let is = |k: usize, words: &[&str]| {
                    names.get(k).is_some_and(|name| words.contains(&name.as_str()))
                };
                let wpilib = is(0, &["timestamp"]) && is(1, &["name", "key"]);
                let in_seconds = wpilib || is(0, &["time_s"]);
                let is_list = (wpilib
                    || is(0, &["time_s", "time", "timestamp", "date", "zeit"]) && is(1, &NAMES))
                    && is(2, &["value"]);
                is_list.then(|| Shape { separator, time: 0, name: 1, value: 2, in_seconds, tags: Vec::new() })
            })
        })
    }

    /// InfluxDB's, whose columns are in any order, with `_start` and `_stop` of the query and its table's number beside them.
    fn of_influx(separator: u8, names: &[String]) -> Option<Shape> {
        const OTHERS: [&str; 8] = ["", "result", "table", "_start", "_stop", "_time", "_value", "_field"];
        let place = |wanted: &str| names.iter().position(|name| name == wanted);
        let tags = (0..names.len()).filter(|k| !OTHERS.contains(&names[*k].as_str())).collect();
        Some(Shape {
            separator,
            time: place("_time")?,
            name: place("_field")?,
            value: place("_value")?,
            in_seconds: true,
            tags,
        })
    }
}

/// The header that a file begins with.
fn header(start: &[u8]) -> Option<Shape> {
    // Of UTF-16 the letters of a header remain when its zeros go.
    let text = String::from_utf8_lossy(start).replace('\0', "");
    let header = text.lines().map(str::trim).find(|line| !is_nothing(line) && !line.starts_with('#'))?;
    Shape::of(header)
}

/// Whether a file that begins so is a list.
pub fn is(start: &[u8]) -> bool {
    header(start).is_some()
}

/// Reads a list.
///
/// # Errors
/// A fault where a time is no time.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    let again = "export the log again";
    let unreadable = |why: std::io::Error| Fault::new(why.to_string(), again);
    let mut lines = TextReader::new(all).map_err(unreadable)?;
    let mut found: Option<(Shape, Splitter)> = None;
    let mut series: BTreeMap<String, Series> = BTreeMap::new();
    let mut clock = Clock::default();
    let (mut line, mut number, mut of_influx, mut in_seconds) = (String::new(), 0_u64, false, false);
    loop {
        let lines_of_row = read_row(&mut lines, &mut line).map_err(unreadable)?;
        if lines_of_row == 0 {
            break;
        }
        // A row is found at its first line.
        let at = number + 1;
        number += lines_of_row;
        // InfluxDB begins every table of an answer with a header of its own.
        if let Some(shape) = Some(line.trim()).filter(|line| line.contains("alue")).and_then(Shape::of) {
            of_influx |= !shape.tags.is_empty();
            let splitter = Splitter::of(Separator::Byte(shape.separator), false);
            found = Some((shape, splitter));
            line.clear();
            continue;
        }
        let Some((shape, splitter)) = &mut found else {
            line.clear();
            continue;
        };
        let is_row = splitter.split(&line) && !is_nothing(line.trim()) && !line.starts_with('#');
        line.clear();
        let (Some(time), Some(name), Some(value)) =
            (splitter.get(shape.time), splitter.get(shape.name), splitter.get(shape.value))
        else {
            continue;
        };
        if !is_row || value.is_empty() {
            continue;
        }
        let plain = time.parse().ok().filter(|time: &f64| time.is_finite());
        in_seconds |= shape.in_seconds || plain.is_none_or(|time| time.fract() != 0.0);
        let Some(time_s) = plain.or_else(|| clock.read(time, 1.0, None)) else {
            return Err(Fault::new(format!("line {at}: \"{time}\" is not a time"), again));
        };
        let tags = shape.tags.iter().filter_map(|tag| splitter.get(*tag)).filter(|tag| !tag.is_empty());
        let name = tags.chain([name]).collect::<Vec<_>>().join(".");
        let series = series.entry(name).or_default();
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
    if !in_seconds {
        to_seconds(&mut series);
    }
    let series = if of_influx { without_what_all_have(series) } else { series };
    Ok(Content::Events(Events::new(series, BTreeSet::new())))
}

/// Makes seconds of times that are whole counts.
fn to_seconds(series: &mut BTreeMap<String, Series>) {
    let longest = series.values().map(|series| series.times.as_slice()).max_by_key(|times| times.len());
    let interval = longest.map_or(0.0, median_interval);
    let unit = UNITS.iter().find(|(most, _)| interval < *most).map_or(1e-9, |(_, unit)| *unit);
    series.values_mut().flat_map(|series| &mut series.times).for_each(|time| *time *= unit);
}

/// The same names without the measurement and the tags that all of InfluxDB's have.
fn without_what_all_have(series: BTreeMap<String, Series>) -> BTreeMap<String, Series> {
    let Some(first) = series.keys().next().cloned() else { return series };
    let ends = first.match_indices('.').map(|(at, _)| at + 1);
    let common = ends.rev().find(|end| series.keys().all(|name| name.starts_with(&first[..*end])));
    match common {
        Some(end) => series.into_iter().map(|(name, series)| (name[end..].to_owned(), series)).collect(),
        None => series,
    }
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
    fn a_value_in_quotes_goes_on_over_a_line_end() {
        let quoted = log().replace(",2\n", ",\"2\r\n\"\n").replace(",1\n", ",\"1\n\"\n");
        let [plain, quoted] = [log(), quoted].map(|text| exported(&text).unwrap());
        assert_eq!(plain[0].voltage_v, quoted[0].voltage_v);
        assert_eq!(plain[0].speed_rad_s, quoted[0].speed_rad_s);
    }

    #[test]
    fn a_list_without_tests_is_a_table_of_its_entries() {
        let text = log().replace("sysid-test-state-arm", "mode").replace("quasistatic-forward", "auto");
        let text = text.replace("dynamic-reverse", "teleop");
        let refused = exported(&text).unwrap_err().to_string();
        assert!(refused.contains("--map time=time_s:s,voltage=/arm/voltage-left:V"), "{refused}");
    }

    #[test]
    fn a_list_of_dates_or_counts_is_read_in_seconds() {
        let moment = |k: u32| format!("2024-05-01 12:00:{:06.3}", 0.02 * f64::from(k));
        let millis = |k: u32| format!("{}", 1_714_557_600_000_u64 + 20 * u64::from(k));
        for (time, head) in
            [(&moment as &dyn Fn(u32) -> String, "Time,Metric,Value"), (&millis, "timestamp,series,value")]
        {
            let row = |k| format!("{0},voltage,{1}\n{0},theta,{k}\n", time(k), k % 7);
            let text = format!("{head}\n{}", (0..100).map(row).collect::<String>());
            let (_directory, path) = file(text.as_bytes());
            let map = Some("time=time_s,voltage=voltage,angle=theta".parse().unwrap());
            let record = read(&path, &ReadOptions { map, ..ReadOptions::default() }).unwrap().remove(0);
            assert_eq!(record.len(), 100, "{head}");
            assert!((record.time_s[99] - record.time_s[0] - 1.98).abs() < 1e-6, "{head}");
        }
    }

    /// As the page of InfluxDB exports it: a table with its annotations for each field.
    fn influx(fields: &[(&str, &str)]) -> String {
        let mut text = String::new();
        for (k, (measurement, field)) in fields.iter().enumerate() {
            text += "#group,false,false,true,true,false,false,true,true\r\n#datatype,string,long,dateTime:RFC3339,dateTime:RFC3339,\
                     dateTime:RFC3339,double,string,string\r\n#default,_result,,,,,,,\r\n\
                     ,result,table,_start,_stop,_time,_value,_field,_measurement\r\n";
            for row in 0..100 {
                let t = 0.02 * f64::from(row);
                let value = if *field == "theta" { t } else { (3.0 * t).sin() };
                text += &format!(
                    ",,{k},2024-05-01T12:00:00Z,2024-05-01T13:00:00Z,2024-05-01T12:00:{t:06.3}Z,{value},{field},{measurement}\r\n"
                );
            }
            text += "\r\n";
        }
        text
    }

    #[test]
    fn what_influxdb_answers_is_a_list_of_its_fields() {
        for (fields, map) in [
            ([("motor", "theta"), ("motor", "voltage")], "time=time_s,voltage=voltage,angle=theta"),
            ([("arm", "theta"), ("drive", "voltage")], "time=time_s,voltage=drive.voltage,angle=arm.theta"),
        ] {
            let (_directory, path) = file(influx(&fields).as_bytes());
            let options = ReadOptions { map: Some(map.parse().unwrap()), ..ReadOptions::default() };
            let record = read(&path, &options).unwrap().remove(0);
            assert_eq!(record.len(), 100);
            assert!((record.time_s[99] - record.time_s[0] - 1.98).abs() < 1e-9);
            assert!((record.voltage_v[50] - 3.0_f64.sin()).abs() < 1e-12);
        }
        let plain = "_time,_value,_field\n2024-05-01T12:00:00Z,1,voltage\n".to_owned()
            + &influx(&[("m", "theta"), ("m", "voltage")]).replace('#', "# ");
        assert!(exported(&plain).unwrap_err().to_string().contains("--map time=time_s:s,voltage="));
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
