//! Values that stand one a line, each with its name: Teleplot's `>name:value` and `>name:stamp:value§unit|flags` with stamps in
//! milliseconds (<https://github.com/nesnes/teleplot>), and `name: value` as boards print it.
//!
//! Where the values have stamps, each holds until the next of its name. Where they have none, a row is what stands between two values
//! of one name, so that a rate or a column of times has to tell the time.

use std::collections::{BTreeMap, BTreeSet};

use super::events::{Events, Series};
use super::table::{Column, Table, Values};
use super::{Content, Fault};
use crate::log::guess::words;
use crate::log::numbers::number;
use crate::log::stamped::stamped;
use crate::log::text::TextReader;
use crate::log::timing::median_interval;

/// Share of the lines of a file's beginning that are such values, with and without Teleplot's mark.
const MOST_MARKED: f64 = 0.5;
const MOST_PLAIN: f64 = 0.8;
/// More names than any motor's log has.
const MOST_NAMES: usize = 200;
/// Lines from which a file is told.
const FEWEST_LINES: usize = 8;

/// A value with its name.
#[derive(Debug, PartialEq)]
struct Entry<'a> {
    marked: bool,
    name: &'a str,
    unit: &'a str,
    /// Stamp, ms, and the value as it stands there.
    values: Vec<(Option<f64>, &'a str)>,
}

/// The value that a line holds.
fn entry(line: &str) -> Option<Entry<'_>> {
    let line = line.trim();
    let line = stamped(line).map_or(line, |(_, rest)| rest);
    let (marked, rest) = line.strip_prefix('>').map_or((false, line), |rest| (true, rest));
    let (rest, flags) = rest.split_once('|').unwrap_or((rest, ""));
    // Points of a curve and bodies in space are no course over time.
    if flags.contains("xy") || flags.contains("3D") {
        return None;
    }
    let (rest, unit) = rest.split_once('§').unwrap_or((rest, ""));
    let (name, rest) = rest.split_once(':').or_else(|| rest.split_once('=').filter(|_| !marked))?;
    let name = name.trim();
    if name.is_empty()
        || !marked && (!name.starts_with(char::is_alphabetic) || rest.contains([':', ';', ',', '=']))
    {
        return None;
    }
    let value = |text| -> Option<(Option<f64>, &str)> {
        let (stamp, value) =
            str::split_once(text, ':').map_or((None, text), |(stamp, value)| (Some(stamp), value));
        let stamp = match stamp {
            Some(stamp) => Some(number(stamp.trim()).filter(|stamp| stamp.is_finite())?),
            None => None,
        };
        let value = value.trim();
        (!value.is_empty() && (marked || number(value).is_some())).then_some((stamp, value))
    };
    let values =
        rest.split(';').filter(|text| !text.trim().is_empty()).map(value).collect::<Option<Vec<_>>>()?;
    (!values.is_empty()).then_some(Entry { marked, name, unit, values })
}

/// Whether a file that begins so has a value a line.
pub fn is(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    // The last line is perhaps cut off.
    let Some((whole, _)) = text.rsplit_once('\n') else { return false };
    let lines: Vec<&str> =
        whole.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#')).collect();
    if lines.len() < FEWEST_LINES {
        return false;
    }
    let entries: Vec<Entry> = lines.iter().filter_map(|line| entry(line)).collect();
    let marked = entries.iter().filter(|entry| entry.marked).count();
    let names: BTreeSet<&str> = entries.iter().map(|entry| entry.name).collect();
    let most = if marked > 0 { MOST_MARKED } else { MOST_PLAIN };
    // Remarks with a colon have each their own name.
    names.len() > 1 && 3 * names.len() <= entries.len() && entries.len() as f64 >= most * lines.len() as f64
}

/// The text of a file, in whatever encoding.
fn text_of(all: &[u8]) -> std::io::Result<String> {
    let mut text = String::new();
    std::io::Read::read_to_string(&mut TextReader::new(all)?, &mut text)?;
    Ok(text)
}

/// Reads such a file.
///
/// # Errors
/// A fault where it is no text.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    let text =
        text_of(all).map_err(|why| Fault::new(why.to_string(), "save the lines as they were received"))?;
    let mut entries: Vec<Entry> = text.lines().filter_map(entry).collect();
    if entries.iter().any(|entry| entry.marked) {
        entries.retain(|entry| entry.marked);
    }
    let values = || entries.iter().flat_map(|entry| &entry.values);
    if 2 * values().filter(|(stamp, _)| stamp.is_some()).count() > values().count() {
        Ok(Content::Events(events(&entries)))
    } else {
        rows(&entries).map(Content::Table)
    }
}

/// The name of a column, with its unit if one is told.
fn titled(entry: &Entry) -> String {
    if entry.unit.is_empty() {
        entry.name.to_owned()
    } else {
        format!("{} [{}]", entry.name, entry.unit.trim())
    }
}

/// Whole stamps that are further apart than this, ms, are microseconds.
const LONGEST_STEP_MS: f64 = 500.0;

/// The values with their stamps.
fn events(entries: &[Entry]) -> Events {
    let mut all: BTreeMap<String, Series> = BTreeMap::new();
    for entry in entries {
        let series = all.entry(titled(entry)).or_default();
        for (stamp, value) in &entry.values {
            let Some(stamp) = stamp else { continue };
            // A name is of one type: that of its first value.
            match number(value) {
                Some(value) if series.texts.is_empty() => series.numbers.push(value),
                None if series.numbers.is_empty() => series.texts.push((*value).to_owned()),
                _ => continue,
            }
            series.times.push(*stamp);
        }
    }
    let longest = all.values().map(|series| series.times.as_slice()).max_by_key(|times| times.len());
    let micros = longest.is_some_and(|stamps| {
        stamps.iter().all(|stamp| stamp.fract() == 0.0) && median_interval(stamps) > LONGEST_STEP_MS
    });
    let second = if micros { 1e6 } else { 1e3 };
    all.values_mut().flat_map(|series| &mut series.times).for_each(|stamp| *stamp /= second);
    Events::new(all, BTreeSet::new())
}

/// The values without stamps, as rows. A row begins with a time where there is one, else with the name that came first.
fn rows(entries: &[Entry]) -> Result<Table, Fault> {
    let entries: Vec<(String, &str)> =
        entries.iter().filter_map(|entry| Some((titled(entry), entry.values.last()?.1))).collect();
    let mut names: Vec<String> = Vec::new();
    for (name, _) in &entries {
        if !names.contains(name) && names.len() < MOST_NAMES {
            names.push(name.clone());
        }
    }
    let begin = names.iter().find(|name| words::is_time(name)).or(names.first()).cloned().unwrap_or_default();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    let mut count = 0;
    for (name, value) in &entries {
        if *name == begin {
            count += 1;
            columns.iter_mut().for_each(|column| column.resize(count, f64::NAN));
        }
        let place = names.iter().position(|known| known == name);
        if let (Some(column), Some(value)) = (place.map(|k| &mut columns[k]), number(value))
            && let Some(last) = column.last_mut()
        {
            *last = value;
        }
    }
    let columns = names.into_iter().zip(columns);
    let columns = columns.map(|(name, values)| Column {
        name: name.replace([',', '"', '=', '$', '`', '\\'], "_"),
        values: Values::Numbers(values),
    });
    Table::of(columns.collect(), Vec::new())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_a_name_a_stamp_a_unit_and_flags() {
        let of = |line| entry(line).map(|entry| (entry.name, entry.unit, entry.values));
        assert_eq!(of(">u:5.2"), Some(("u", "", vec![(None, "5.2")])));
        assert_eq!(of(">u:120:5.2§V|g"), Some(("u", "V", vec![(Some(120.0), "5.2")])));
        assert_eq!(of(">u:1:5;2:6\r\n"), Some(("u", "", vec![(Some(1.0), "5"), (Some(2.0), "6")])));
        assert_eq!(of("12:00:01.5 -> >u:5"), Some(("u", "", vec![(None, "5")])));
        assert_eq!(of("PWM: 80"), Some(("PWM", "", vec![(None, "80")])));
        for line in [">track:1:2|xy", ">u:", "hello", "t:1 u:2", "ready: yes", "12:30:01", ">u:noon:5"] {
            assert_eq!(of(line), None, "{line}");
        }
    }

    #[test]
    fn a_file_is_told_by_names_that_come_again() {
        let of = |line: &dyn Fn(u32) -> String| (0..20).map(line).collect::<String>();
        let is = |text: String| is(text.as_bytes());
        assert!(is(of(&|k| format!(">u:{k}\n>x:{k}\n"))));
        assert!(is(of(&|k| format!("u: {k}\r\nx: {k}\r\n"))));
        assert!(!is(of(&|k| format!("key{k}: {k}\n"))));
        assert!(!is(of(&|k| format!("t:{k} u:{k}\n"))));
        assert!(!is(of(&|k| format!("{k},{k}\n"))));
    }
}
