//! Lines of several kinds, each with a word before it that tells which: `PWM,1000,120` and `ENC,1003,55`, as boards print what they
//! command and what they measure.
//!
//! With a stamp behind the word, or one of a monitor or a logger before the line, every kind is a table of its own, each value of which holds
//! until the next. Without stamps the kinds take turns, `PWM,120` and `ENC,55`: a turn of them is a row, whose time a rate has to tell.

use std::collections::{BTreeMap, BTreeSet};

use super::events::{Events, Series};
use super::table::{Column, Table, Values};
use super::{Content, Fault};
use crate::log::clock::Clock;
use crate::log::direction;
use crate::log::numbers::number;
use crate::log::stamped::{moment_of, stamped};
use crate::log::text;
use crate::log::timing::median_interval;

/// Share of the lines of a file's beginning that are such rows.
const MOST: f64 = 0.9;
/// Lines of each kind from which a file is told, fewer are those of a garbled word; and more kinds than a motor's log has.
const FEWEST: usize = 4;
const MOST_KINDS: usize = 12;
/// A word of more letters is none that stands before every line.
const LONGEST: usize = 16;
/// The kinds take turns: so many changes for each line of the rarest. A state that stands first in its rows changes now and then.
const TURNS: f64 = 1.0;
/// Stamps of one kind that rise.
const RISE: f64 = 0.95;
/// Stamps in whole numbers that are further apart are microseconds.
pub(super) const LONGEST_STEP_MS: f64 = 500.0;
/// What single letters stand for where both are there; `P` beside others is a position, or a controller's.
const LETTERS: [(&str, &str); 2] = [("P", "pwm"), ("E", "enc")];

/// A line: the word before it, and the numbers behind that.
type Row<'a> = (&'a str, Vec<f64>);
/// The lines of each kind.
type Kinds<'a> = BTreeMap<&'a str, Vec<&'a [f64]>>;

fn row(line: &str) -> Option<Row<'_>> {
    let line = line.trim();
    let (tag, rest) = line.split_at(line.find([',', ';', '\t', ':'])?);
    let tag = tag.trim();
    let is_word = tag.starts_with(char::is_alphabetic)
        && tag.len() <= LONGEST
        && tag.chars().all(|c| c.is_alphanumeric() || c == '_');
    // A word for a direction is a value of its row.
    if !is_word || direction::named(tag).is_some() {
        return None;
    }
    let fields = rest[1..].split([',', ';', '\t']).map(|text| number(text.trim()));
    let fields = fields.collect::<Option<Vec<f64>>>()?;
    fields.iter().all(|value| value.is_finite()).then_some((tag, fields))
}

/// The rows among the lines, and whether the first number of each is the time of the stamp before its line, s. A stamp behind the word, which is
/// the board's own, goes before that.
fn rows_of<'a>(lines: impl Iterator<Item = &'a str>) -> (Vec<Row<'a>>, bool) {
    let mut clock = Clock::default();
    let mut moments = Vec::new();
    let mut rows = Vec::new();
    for line in lines {
        let (stamp, said) = stamped(line.trim()).map_or((None, line), |(stamp, said)| (Some(stamp), said));
        if let Some(row) = row(said) {
            moments.push(stamp.and_then(|stamp| moment_of(stamp, &mut clock)));
            rows.push(row);
        }
    }
    let told = moments.iter().flatten().count();
    if (told as f64) < MOST * rows.len() as f64 || are_stamped(&kinds(&rows)) {
        return (rows, false);
    }
    let with_moment = |(moment, (tag, values)): (&Option<f64>, &Row<'a>)| {
        let values = std::iter::once((*moment)?).chain(values.iter().copied());
        Some((*tag, values.collect::<Vec<f64>>()))
    };
    let timed: Vec<Row<'a>> = moments.iter().zip(&rows).filter_map(with_moment).collect();
    if are_stamped(&kinds(&timed)) { (timed, true) } else { (rows, false) }
}

fn kinds<'a>(rows: &'a [Row<'a>]) -> Kinds<'a> {
    let mut kinds = Kinds::new();
    for (tag, values) in rows {
        kinds.entry(*tag).or_default().push(values.as_slice());
    }
    kinds.retain(|_, lines| lines.len() >= FEWEST);
    kinds
}

/// Whether the first number of the lines is a stamp; a line that was cut off has none.
fn are_stamped(kinds: &Kinds<'_>) -> bool {
    kinds.values().all(|lines| {
        let stamps: Vec<f64> = lines.iter().filter(|line| line.len() > 1).map(|line| line[0]).collect();
        let rises = stamps.windows(2).filter(|pair| pair[1] > pair[0]).count();
        stamps.len() as f64 >= MOST * lines.len() as f64
            && rises as f64 >= RISE * stamps.len().saturating_sub(1) as f64
    })
}

/// Whether the lines come in one order again and again.
fn are_in_turn(rows: &[Row<'_>], kinds: &Kinds<'_>) -> bool {
    let mut next: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for pair in rows.windows(2) {
        *next.entry((pair[0].0, pair[1].0)).or_default() += 1;
    }
    let follows = |tag: &str| next.iter().filter(|(pair, _)| pair.0 == tag).map(|(_, count)| *count).max();
    let in_order: usize = kinds.keys().copied().filter_map(follows).sum();
    let counts = || kinds.values().map(Vec::len);
    let (rarest, most) = (counts().min().unwrap_or(0), counts().max().unwrap_or(0));
    in_order as f64 >= MOST * rows.len().saturating_sub(1) as f64 && rarest as f64 >= MOST * most as f64
}

/// A line without its stamp.
fn said(line: &str) -> &str {
    stamped(line.trim()).map_or(line, |(_, said)| said)
}

/// Whether a file that begins so has lines of several kinds.
pub fn is(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    // The last line is perhaps cut off.
    let Some((whole, _)) = text.rsplit_once('\n') else { return false };
    let lines: Vec<&str> =
        whole.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#')).collect();
    let (rows, by_line) = rows_of(lines.iter().copied());
    // The numbers of a row without the time of its line.
    let width_of = |values: &[f64]| values.len() - usize::from(by_line);
    let kinds = kinds(&rows);
    let counts = || kinds.values().map(Vec::len);
    let (rarest, of_kinds) = (counts().min().unwrap_or(0), counts().sum::<usize>());
    let turns = rows.windows(2).filter(|pair| pair[0].0 != pair[1].0).count();
    let is_one = |lines: &Vec<&[f64]>| {
        let alike = |width: usize| lines.iter().filter(|line| line.len() == width).count();
        lines.iter().take(FEWEST).any(|line| alike(line.len()) as f64 >= MOST * lines.len() as f64)
    };
    // Below a header that names every field it is a table, and the word one of its columns.
    let width = |line: &str| line.split([',', ';', '\t']).count();
    let is_headed = lines.first().is_some_and(|head| {
        let head = said(head);
        row(head).is_none()
            && head.chars().any(char::is_alphabetic)
            && rows.iter().all(|(_, values)| width_of(values) + 1 == width(head))
    });
    // `name: value` is a list of values.
    let are_values = || {
        lines.iter().all(|line| said(line).contains(':'))
            && rows.iter().all(|(_, values)| width_of(values) == 1)
    };
    // Words before as many numbers each, in no order, are states.
    let widest = |lines: &Vec<&[f64]>| lines.iter().map(|line| width_of(line)).max().unwrap_or(0);
    let widths: BTreeSet<usize> = kinds.values().map(widest).collect();
    let are_told = || widths.len() > 1 || widths.contains(&1) || are_in_turn(&rows, &kinds);
    let is_timed = || if by_line { !are_values() && are_told() } else { are_stamped(&kinds) };
    !is_headed
        && (2..=MOST_KINDS).contains(&kinds.len())
        && of_kinds as f64 >= MOST * lines.len() as f64
        && turns as f64 >= TURNS * rarest as f64
        && kinds.values().all(is_one)
        && (is_timed() || !by_line && are_in_turn(&rows, &kinds) && !are_values())
}

/// Reads such a file.
///
/// # Errors
/// A fault where it is no text.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    let text = text::whole(all);
    let text = text.map_err(|why| Fault::new(why.to_string(), "save the lines as they were received"))?;
    let (rows, by_line) = rows_of(text.lines());
    let mut kinds = kinds(&rows);
    if !are_stamped(&kinds) {
        return Ok(Content::Table(turns(&rows, &kinds)?));
    }
    kinds.values_mut().for_each(|lines| lines.retain(|line| line.len() > 1));
    Ok(Content::Events(events(&kinds, by_line)))
}

/// The columns of the kinds: the kind, the place of a number among those behind its word, and the name.
fn columns<'a>(kinds: &Kinds<'a>, first: usize) -> Vec<(&'a str, usize, String)> {
    let is_pair = LETTERS.iter().all(|(letter, _)| kinds.contains_key(letter));
    let mut columns = Vec::new();
    for (tag, lines) in kinds {
        let width = lines.iter().map(|line| line.len()).max().unwrap_or(0);
        let letter = LETTERS.iter().find(|(letter, _)| is_pair && letter == tag).map(|(_, word)| *word);
        let name = letter.filter(|word| !kinds.contains_key(word)).unwrap_or(*tag);
        columns.extend((first..width).map(|place| {
            let is_only = width == first + 1;
            let title = if is_only { name.to_owned() } else { format!("{name}_{}", place - first) };
            (*tag, place, title)
        }));
    }
    columns
}

/// The values with their stamps, which are seconds where they stand before the lines, and whose unit nothing tells where they do not.
fn events(kinds: &Kinds<'_>, by_line: bool) -> Events {
    let stamps = |lines: &Vec<&[f64]>| lines.iter().map(|line| line[0]).collect::<Vec<f64>>();
    let longest = kinds.values().max_by_key(|lines| lines.len()).map(stamps).unwrap_or_default();
    let second = if by_line { 1.0 } else { second(&longest) };
    let mut all: BTreeMap<String, Series> = BTreeMap::new();
    for (tag, place, title) in columns(kinds, 1) {
        let series = all.entry(title).or_default();
        for line in &kinds[tag] {
            if let Some(value) = line.get(place) {
                series.times.push(line[0] / second);
                series.numbers.push(*value);
            }
        }
    }
    let events = Events::new(all, BTreeSet::new());
    if by_line { events } else { events.with_stamps(second) }
}

/// A row for every turn of the kinds, which ends where one of them comes again, and before the kind that comes first: a lost line leaves one
/// field blank, and the rows after it as they are.
fn turns(rows: &[Row<'_>], kinds: &Kinds<'_>) -> Result<Table, Fault> {
    let rows = || rows.iter().filter(|(tag, _)| kinds.contains_key(tag));
    let first = rows().next().map(|(tag, _)| *tag);
    let mut turns: Vec<BTreeMap<&str, &[f64]>> = Vec::new();
    for (tag, values) in rows() {
        if first == Some(*tag) || turns.last().is_none_or(|turn| turn.contains_key(tag)) {
            turns.push(BTreeMap::new());
        }
        if let Some(turn) = turns.last_mut() {
            turn.insert(*tag, values.as_slice());
        }
    }
    let column = |(tag, place, name): (&str, usize, String)| {
        let number =
            |turn: &BTreeMap<&str, &[f64]>| turn.get(tag).and_then(|values| values.get(place)).copied();
        let numbers = turns.iter().map(|turn| number(turn).unwrap_or(f64::NAN)).collect();
        Column { name, values: Values::Numbers(numbers) }
    };
    Table::of(columns(kinds, 0).into_iter().map(column).collect(), Vec::new())
}

/// What a second is in these stamps: seconds have fractions, and of whole numbers the large steps are microseconds.
fn second(stamps: &[f64]) -> f64 {
    let interval = median_interval(stamps);
    match stamps.iter().all(|stamp| stamp.fract() == 0.0) {
        true if interval > LONGEST_STEP_MS => 1e6,
        true => 1e3,
        false if interval >= 1.0 => 1e3,
        false => 1.0,
    }
}

#[cfg(test)]
mod tests;
