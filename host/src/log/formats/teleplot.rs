//! Values that stand one a line, each with its name: Teleplot's `>name:value` and `>name:stamp:value§unit|flags` with stamps in
//! milliseconds (<https://github.com/nesnes/teleplot>), and `name: value` as boards print it; or some a line, others in the next.
//!
//! Where the values have stamps, of their own or before their lines, each holds until the next of its name. Where they have none, or too coarse
//! ones, a row is what stands between two values of one name, so that a rate or a column of times has to tell the time.

use std::collections::{BTreeMap, BTreeSet};

use super::events::{Events, Series};
use super::lines::{Entry, Line, are_of_kinds, line_of};
use super::table::{Column, Table, Values};
use super::tagged::LONGEST_STEP_MS;
use super::{Content, Fault};
use crate::log::clock::Clock;
use crate::log::guess::words;
use crate::log::numbers::number;
use crate::log::stamped::moment_of;
use crate::log::text;
use crate::log::timing::median_interval;

/// Share of the lines of a file's beginning that are such values, with and without Teleplot's mark.
const MOST_MARKED: f64 = 0.5;
const MOST_PLAIN: f64 = 0.8;
/// More names than any motor's log has.
const MOST_NAMES: usize = 200;
/// Lines from which a file is told.
const FEWEST_LINES: usize = 8;
/// Share of the lines that have a stamp, and of the stamps of one name that rise, from which they tell the time.
const MOST_STAMPED: f64 = 0.9;
const RISE: f64 = 0.95;
/// A name that comes less often than this share of the most frequent one begins no row.
const OFTEN: f64 = 0.9;

/// Whether a file that begins so has a value a line.
pub fn is(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    // The last line is perhaps cut off.
    let Some((whole, _)) = text.rsplit_once('\n') else { return false };
    // Dashes part the messages of a ROS topic.
    let is_told = |line: &&str| !matches!(line.trim(), "" | "---") && !line.starts_with('#');
    let lines: Vec<&str> = whole.lines().filter(is_told).collect();
    if lines.len() < FEWEST_LINES {
        return false;
    }
    let all: Vec<Line> = lines.iter().filter_map(|line| line_of(line)).collect();
    let is_marked = all.iter().any(Line::is_marked);
    let read: Vec<&Line> = all.iter().filter(|line| !is_marked || line.entries.len() == 1).collect();
    let entries = || read.iter().flat_map(|line| &line.entries);
    let names: BTreeSet<&str> = entries().map(|entry| entry.name).collect();
    let most = if is_marked { MOST_MARKED } else { MOST_PLAIN };
    // Remarks with a colon have each their own name.
    names.len() > 1
        && 3 * names.len() <= entries().count()
        && read.len() as f64 >= most * lines.len() as f64
        && (is_marked || are_of_kinds(&read))
}

/// Reads such a file.
///
/// # Errors
/// A fault where it is no text.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    let text = text::whole(all);
    let text = text.map_err(|why| Fault::new(why.to_string(), "save the lines as they were received"))?;
    let mut lines: Vec<Line> = text.lines().filter_map(line_of).collect();
    if lines.iter().any(Line::is_marked) {
        lines.retain(Line::is_marked);
    }
    let entries = || lines.iter().flat_map(|line| &line.entries);
    let values = || entries().flat_map(|entry| &entry.values);
    if 2 * values().filter(|(stamp, _)| stamp.is_some()).count() > values().count() {
        return Ok(Content::Events(events(entries())));
    }
    // A board's own time goes before when a line was received.
    let names: BTreeSet<&str> = entries().map(|entry| entry.name).collect();
    let moments = if names.iter().any(|name| words::is_time(name)) { Vec::new() } else { moments(&lines) };
    if tell(&lines, &moments) {
        return Ok(Content::Events(received(&lines, &moments)));
    }
    rows(&lines, &moments).map(Content::Table)
}

/// When each line was received or said, s; nothing where too few lines tell.
fn moments(lines: &[Line<'_>]) -> Vec<Option<f64>> {
    let mut clock = Clock::default();
    let all: Vec<Option<f64>> = lines.iter().map(|line| moment_of(line.stamp?, &mut clock)).collect();
    let told = all.iter().flatten().count();
    if told as f64 >= MOST_STAMPED * all.len() as f64 { all } else { Vec::new() }
}

/// The name that comes most often.
fn most_frequent<'a>(lines: &[Line<'a>]) -> Option<(&'a str, usize)> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for entry in lines.iter().flat_map(|line| &line.entries) {
        *counts.entry(entry.name).or_default() += 1;
    }
    counts.into_iter().max_by_key(|(_, count)| *count)
}

/// Whether the moments of the lines tell the values of one name apart: those of whole seconds do not.
fn tell(lines: &[Line<'_>], moments: &[Option<f64>]) -> bool {
    let Some((name, _)) = most_frequent(lines) else { return false };
    let has_name = |line: &Line<'_>| line.entries.iter().any(|entry| entry.name == name);
    let of_name = lines.iter().zip(moments).filter(|(line, _)| has_name(line));
    let times: Vec<f64> = of_name.filter_map(|(_, moment)| *moment).collect();
    let rises = times.windows(2).filter(|pair| pair[1] > pair[0]).count();
    times.len() > 1 && rises as f64 >= RISE * (times.len() - 1) as f64
}

/// The values of the lines at the moments of those.
fn received(lines: &[Line<'_>], moments: &[Option<f64>]) -> Events {
    let mut all: BTreeMap<String, Series> = BTreeMap::new();
    for (line, moment) in lines.iter().zip(moments) {
        let Some(moment) = moment else { continue };
        for entry in &line.entries {
            if let Some((_, value)) = entry.values.last() {
                take(all.entry(titled(entry)).or_default(), *moment, value);
            }
        }
    }
    Events::new(all, BTreeSet::new())
}

/// Adds a value to a series, whose type is that of its first value.
fn take(series: &mut Series, time: f64, value: &str) {
    match number(value) {
        Some(value) if series.texts.is_empty() => series.numbers.push(value),
        None if series.numbers.is_empty() => series.texts.push(value.to_owned()),
        _ => return,
    }
    series.times.push(time);
}

/// The name of a column, with its unit if one is told.
fn titled(entry: &Entry) -> String {
    if entry.unit.is_empty() {
        entry.name.to_owned()
    } else {
        format!("{} [{}]", entry.name, entry.unit.trim())
    }
}

/// The values with their stamps.
fn events<'e, 'a: 'e>(entries: impl Iterator<Item = &'e Entry<'a>>) -> Events {
    let mut all: BTreeMap<String, Series> = BTreeMap::new();
    for entry in entries {
        let series = all.entry(titled(entry)).or_default();
        for (stamp, value) in &entry.values {
            if let Some(stamp) = stamp {
                take(series, *stamp, value);
            }
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

/// The values without stamps, as rows. A row begins with a time where there is one, else with the first name that comes as often as any;
/// its moment stands before it, where its line has one.
fn rows(lines: &[Line<'_>], moments: &[Option<f64>]) -> Result<Table, Fault> {
    let moment = |k: usize| moments.get(k).copied().flatten().unwrap_or(f64::NAN);
    let entries = || lines.iter().enumerate().flat_map(|(k, line)| line.entries.iter().map(move |e| (k, e)));
    let mut counts: Vec<(String, usize)> = Vec::new();
    for (_, entry) in entries() {
        let name = titled(entry);
        match counts.iter().position(|(known, _)| *known == name) {
            Some(known) => counts[known].1 += 1,
            None if counts.len() < MOST_NAMES => counts.push((name, 1)),
            None => {}
        }
    }
    let most = counts.iter().map(|(_, count)| *count).max().unwrap_or(0);
    let is_often = |(_, count): &&(String, usize)| *count as f64 >= OFTEN * most as f64;
    let begin = counts.iter().find(|(name, _)| words::is_time(name)).or_else(|| counts.iter().find(is_often));
    let begin = begin.map(|(name, _)| name.clone()).unwrap_or_default();
    let names: Vec<String> = counts.into_iter().map(|(name, _)| name).collect();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    let mut times = Vec::new();
    // What was said before the first row holds in it.
    let mut early = vec![f64::NAN; names.len()];
    for (k, entry) in entries() {
        let name = titled(entry);
        if name == begin {
            times.push(moment(k));
            columns.iter_mut().for_each(|column| column.resize(times.len(), f64::NAN));
        }
        let place = names.iter().position(|known| *known == name);
        let value = entry.values.last().and_then(|(_, value)| number(value));
        if let (Some(place), Some(value)) = (place, value) {
            *columns[place].last_mut().unwrap_or(&mut early[place]) = value;
        }
    }
    for (column, early) in columns.iter_mut().zip(early) {
        if let Some(first) = column.first_mut().filter(|first| first.is_nan()) {
            *first = early;
        }
    }
    let columns = names.into_iter().zip(columns);
    let columns = columns.map(|(name, values)| Column {
        name: name.replace([',', '"', '=', '$', '`', '\\'], "_"),
        values: Values::Numbers(values),
    });
    let clock = Column { name: "time_s".into(), values: Values::Numbers(times) };
    let clock = (!moments.is_empty()).then_some(clock);
    Table::of(clock.into_iter().chain(columns).collect(), Vec::new())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_told_by_names_that_come_again() {
        let of = |line: &dyn Fn(u32) -> String| (0..20).map(line).collect::<String>();
        let is = |text: String| is(text.as_bytes());
        assert!(is(of(&|k| format!(">u:{k}\n>x:{k}\n"))));
        assert!(is(of(&|k| format!("u: {k}\r\nx: {k}\r\n"))));
        assert!(is(of(&|k| format!("pwm: {k}\nenc: {k}\n---\n"))));
        assert!(is(of(&|k| format!("pwm: {k} volts: 12\nenc: {k} temp: 30\n"))));
        assert!(!is(of(&|k| format!("pwm: {k} enc: {k}\n{}", if k % 2 == 0 { "pwm: 1\n" } else { "" }))));
        assert!(!is(of(&|k| format!("key{k}: {k}\n"))));
        assert!(!is(of(&|k| format!("t:{k} u:{k}\n"))));
        assert!(!is(of(&|k| format!("{k},{k}\n"))));
    }
}
