//! Lines of several kinds, each with a word before it that tells which, and a stamp behind that: `PWM,1000,120` and `ENC,1003,55`, as boards
//! print what they command and what they measure, each at its own time. Every kind is a table of its own; each value holds until the next.

use std::collections::{BTreeMap, BTreeSet};

use super::events::{Events, Series};
use super::{Content, Fault};
use crate::log::direction;
use crate::log::numbers::number;
use crate::log::text::TextReader;
use crate::log::timing::median_interval;

/// Share of the lines of a file's beginning that are such rows.
const MOST: f64 = 0.9;
/// Lines of each kind from which a file is told, and more kinds than a motor's log has.
const FEWEST: usize = 4;
const MOST_KINDS: usize = 12;
/// A word of more letters is none that stands before every line.
const LONGEST: usize = 16;
/// The kinds take turns: so many changes for each line of the rarest. A state that stands first in its rows changes now and then.
const TURNS: f64 = 1.0;
/// Stamps of one kind that rise.
const RISE: f64 = 0.95;
/// Stamps in whole numbers that are further apart are microseconds.
const LONGEST_STEP_MS: f64 = 500.0;
/// What single letters stand for where both are there; `P` beside others is a position, or a controller's.
const LETTERS: [(&str, &str); 2] = [("P", "pwm"), ("E", "enc")];

/// The word before a line, its stamp, and the values behind that.
fn row(line: &str) -> Option<(&str, f64, Vec<f64>)> {
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
    let mut fields = fields.collect::<Option<Vec<f64>>>()?;
    if fields.len() < 2 || fields.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let stamp = fields.remove(0);
    Some((tag, stamp, fields))
}

/// Whether a file that begins so has lines of several kinds.
pub fn is(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    // The last line is perhaps cut off.
    let Some((whole, _)) = text.rsplit_once('\n') else { return false };
    let lines: Vec<&str> =
        whole.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#')).collect();
    let rows: Vec<(&str, f64, Vec<f64>)> = lines.iter().filter_map(|line| row(line)).collect();
    let mut kinds: BTreeMap<&str, Vec<(f64, usize)>> = BTreeMap::new();
    for (tag, stamp, values) in &rows {
        kinds.entry(*tag).or_default().push((*stamp, values.len()));
    }
    let rarest = kinds.values().map(Vec::len).min().unwrap_or(0);
    let turns = rows.windows(2).filter(|pair| pair[0].0 != pair[1].0).count();
    let is_one = |lines: &Vec<(f64, usize)>| {
        let rises = lines.windows(2).filter(|pair| pair[1].0 > pair[0].0).count();
        let alike = lines.iter().filter(|line| line.1 == lines[0].1).count();
        rises as f64 >= RISE * (lines.len() - 1) as f64 && alike as f64 >= MOST * lines.len() as f64
    };
    // Below a header that names every field it is a table, and the word one of its columns.
    let width = |line: &str| line.split([',', ';', '\t']).count();
    let is_headed = lines.first().is_some_and(|head| {
        row(head).is_none()
            && head.chars().any(char::is_alphabetic)
            && rows.iter().all(|(_, _, values)| values.len() + 2 == width(head))
    });
    !is_headed
        && (2..=MOST_KINDS).contains(&kinds.len())
        && rarest >= FEWEST
        && rows.len() as f64 >= MOST * lines.len() as f64
        && turns as f64 >= TURNS * rarest as f64
        && kinds.values().all(is_one)
}

/// Reads such a file.
///
/// # Errors
/// A fault where it is no text.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    let mut text = String::new();
    let lines =
        TextReader::new(all).and_then(|mut lines| std::io::Read::read_to_string(&mut lines, &mut text));
    lines.map_err(|why| Fault::new(why.to_string(), "save the lines as they were received"))?;
    let rows: Vec<(&str, f64, Vec<f64>)> = text.lines().filter_map(row).collect();
    let mut kinds: BTreeMap<&str, Vec<(f64, &[f64])>> = BTreeMap::new();
    for (tag, stamp, values) in &rows {
        kinds.entry(*tag).or_default().push((*stamp, values.as_slice()));
    }
    let stamps = |lines: &Vec<(f64, &[f64])>| lines.iter().map(|line| line.0).collect::<Vec<f64>>();
    let longest = kinds.values().max_by_key(|lines| lines.len()).map(stamps).unwrap_or_default();
    let second = second(&longest);
    let mut all: BTreeMap<String, Series> = BTreeMap::new();
    let is_pair = LETTERS.iter().all(|(letter, _)| kinds.contains_key(letter));
    for (tag, lines) in &kinds {
        let width = lines.iter().map(|line| line.1.len()).max().unwrap_or(0);
        let letter = LETTERS.iter().find(|(letter, _)| is_pair && letter == tag).map(|(_, word)| *word);
        let name = letter.filter(|word| !kinds.contains_key(word)).unwrap_or(*tag);
        for place in 0..width {
            let title = if width == 1 { name.to_owned() } else { format!("{name}_{place}") };
            let series = all.entry(title).or_default();
            for (stamp, values) in lines {
                if let Some(value) = values.get(place) {
                    series.times.push(stamp / second);
                    series.numbers.push(*value);
                }
            }
        }
    }
    Ok(Content::Events(Events::new(all, BTreeSet::new())))
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
mod tests {
    use super::super::super::read_tests::file;
    use super::super::super::{ReadOptions, read};
    use super::*;

    fn lines(count: usize, line: impl Fn(usize) -> String) -> String {
        (0..count).map(line).collect()
    }

    #[test]
    fn lines_of_several_kinds_are_told_from_rows_that_begin_with_a_word() {
        let is = |text: String| is(text.as_bytes());
        assert!(is(lines(40, |k| format!("PWM,{},{}\nENC,{},{k}\n", 10 * k, k % 7, 10 * k + 3))));
        assert!(is(lines(40, |k| format!("P:{},{}\r\nE:{},{k}\r\n", 10 * k, k % 7, 10 * k + 3))));
        // A header may stand above, and one kind come more often.
        let rare = lines(40, |k| {
            let pwm = if k % 4 == 0 { format!("PWM,{k},1\n") } else { String::new() };
            format!("{pwm}ENC,{k},{k},2\n")
        });
        assert!(is(format!("kind,ms,value\n{rare}")));
        // A state, a direction, one kind, words that are names of values.
        assert!(!is(lines(80, |k| format!("{},{k},1,2\n", if k < 40 { "ramp" } else { "step" }))));
        assert!(!is(lines(80, |k| format!("{},{k},120\n", if k % 2 == 0 { "FWD" } else { "REV" }))));
        assert!(!is(lines(80, |k| format!("DATA,{k},120\n"))));
        let seldom = lines(300, |k| format!("{},{k},120,55\n", if k % 16 == 0 { "SAT" } else { "OK" }));
        assert!(!is(format!("status,ms,duty,rpm\n{seldom}")));
        assert!(!is(lines(80, |k| format!("u:{k},w:{k}\n"))));
        assert!(!is(lines(80, |k| format!("{k},{k}\n"))));
    }

    #[test]
    fn a_duty_and_counts_with_stamps_of_their_own_are_one_record() {
        let text = lines(400, |k| {
            let duty = (200.0 * (0.03 * k as f64).sin()) as i64;
            format!("P:{},{duty}\nE:{},{}\n", 1000 + 10 * k, 1003 + 10 * k, 7 * k)
        });
        let (_directory, path) = file(text.as_bytes());
        let options = ReadOptions {
            map: Some("time=time_s:s,duty=pwm:255,angle=enc:rev/1000".parse().unwrap()),
            supply_volts: Some(12.0),
            ..ReadOptions::default()
        };
        let records = read(&path, &options).unwrap();
        let all: usize = records.iter().map(|record| record.len()).sum();
        assert!(all > 390, "{all}");
        let asked = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(asked.contains("pwm") && asked.contains("enc"), "{asked}");
    }

    #[test]
    fn stamps_are_milliseconds_microseconds_or_seconds() {
        let of = |step: f64| second(&(0..50).map(|k| step * f64::from(k)).collect::<Vec<_>>());
        assert_eq!([10.0, 10_000.0, 0.01, 10.5].map(of), [1e3, 1e6, 1.0, 1e3]);
    }
}
