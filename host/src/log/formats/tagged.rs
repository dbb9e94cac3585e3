//! Lines of several kinds, each with a word before it that tells which: `PWM,1000,120` and `ENC,1003,55`, as boards print what they
//! command and what they measure.
//!
//! With a stamp behind the word every kind is a table of its own, each value of which holds until the next. Without stamps the kinds take
//! turns, `PWM,120` and `ENC,55`: a turn of them is a row, whose time a rate has to tell.

use std::collections::{BTreeMap, BTreeSet};

use super::events::{Events, Series};
use super::table::{Column, Table, Values};
use super::{Content, Fault};
use crate::log::direction;
use crate::log::numbers::number;
use crate::log::text::TextReader;
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
const LONGEST_STEP_MS: f64 = 500.0;
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

/// Whether a file that begins so has lines of several kinds.
pub fn is(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    // The last line is perhaps cut off.
    let Some((whole, _)) = text.rsplit_once('\n') else { return false };
    let lines: Vec<&str> =
        whole.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#')).collect();
    let rows: Vec<Row> = lines.iter().filter_map(|line| row(line)).collect();
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
        row(head).is_none()
            && head.chars().any(char::is_alphabetic)
            && rows.iter().all(|(_, values)| values.len() + 1 == width(head))
    });
    // `name: value` is a list of values.
    let are_values =
        || lines.iter().all(|line| line.contains(':')) && rows.iter().all(|(_, values)| values.len() == 1);
    !is_headed
        && (2..=MOST_KINDS).contains(&kinds.len())
        && of_kinds as f64 >= MOST * lines.len() as f64
        && turns as f64 >= TURNS * rarest as f64
        && kinds.values().all(is_one)
        && (are_stamped(&kinds) || are_in_turn(&rows, &kinds) && !are_values())
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
    let rows: Vec<Row> = text.lines().filter_map(row).collect();
    let mut kinds = kinds(&rows);
    if !are_stamped(&kinds) {
        return Ok(Content::Table(turns(&rows, &kinds)?));
    }
    kinds.values_mut().for_each(|lines| lines.retain(|line| line.len() > 1));
    Ok(Content::Events(events(&kinds)))
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

/// The values with their stamps, whose unit nothing tells.
fn events(kinds: &Kinds<'_>) -> Events {
    let stamps = |lines: &Vec<&[f64]>| lines.iter().map(|line| line[0]).collect::<Vec<f64>>();
    let longest = kinds.values().max_by_key(|lines| lines.len()).map(stamps).unwrap_or_default();
    let second = second(&longest);
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
    Events::new(all, BTreeSet::new()).with_stamps(second)
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
mod tests {
    use super::super::super::read_tests::file;
    use super::super::super::{ReadOptions, Record, read};
    use super::*;

    fn lines(count: usize, line: impl Fn(usize) -> String) -> String {
        (0..count).map(line).collect()
    }

    /// The records of lines that are told to be of several kinds.
    fn records(text: &str, map: &str, supply_volts: f64, rate_hz: Option<f64>) -> Vec<Record> {
        assert!(is(text.as_bytes()));
        let (_directory, path) = file(text.as_bytes());
        let map = Some(map.parse().unwrap());
        let options =
            ReadOptions { map, supply_volts: Some(supply_volts), rate_hz, ..ReadOptions::default() };
        read(&path, &options).unwrap()
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
            map: Some("time=stamp:ms,duty=pwm:255,angle=enc:rev/1000".parse().unwrap()),
            supply_volts: Some(12.0),
            ..ReadOptions::default()
        };
        let records = read(&path, &options).unwrap();
        let all: usize = records.iter().map(|record| record.len()).sum();
        assert!(all > 390, "{all}");
        let asked = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(asked.contains("time=stamp:ms,duty=pwm:255,angle=enc:counts"), "{asked}");
        assert!(asked.contains("nothing tells the unit of \"stamp\": ms is a guess"), "{asked}");
        // The same stamps in another unit.
        let options = ReadOptions {
            map: Some("time=stamp:us,duty=pwm:255,angle=enc:rev/1000".parse().unwrap()),
            ..options
        };
        let faster = read(&path, &options).unwrap();
        let length = |records: &[Record]| {
            let times = |record: &Record| record.time_s[record.len() - 1] - record.time_s[0];
            records.iter().map(times).sum::<f64>()
        };
        assert!((length(&records) / length(&faster) / 1e3 - 1.0).abs() < 0.02);
    }

    #[test]
    fn lines_without_stamps_that_take_turns_are_rows_at_a_rate() {
        let text = lines(400, |k| {
            let duty = (200.0 * (0.03 * k as f64).sin()) as i64;
            format!("PWM,{duty}\nENC,{},{}\n", 7 * k, -7 * (k as i64))
        });
        let records = records(&text, "duty=PWM:255,angle=ENC_0:rev/1000", 12.0, Some(200.0));
        assert_eq!((records.len(), records[0].len()), (1, 400));
        assert!((records[0].time_s[399] - 399.0 / 200.0).abs() < 1e-9);
    }

    #[test]
    fn a_lost_line_leaves_the_rows_after_it_as_they_are() {
        let duty = |k: usize| (200.0 * (0.03 * k as f64).sin()) as i64;
        let text = lines(400, |k| match k {
            100 => format!("ENC,{}\n", 7 * k),
            200 => format!("PWM,{}\nNC,{}\n", duty(k), 7 * k),
            _ => format!("PWM,{}\nENC,{}\n", duty(k), 7 * k),
        });
        let text = format!("WM,3\n{text}");
        let records = records(&text, "duty=PWM:255,angle=ENC:rev/1000", 255.0, Some(200.0));
        let all: usize = records.iter().map(Record::len).sum();
        assert!(all > 390, "{all}");
        let volts = records.iter().flat_map(|record| record.voltage_v.iter());
        let angles = records.iter().flat_map(|record| record.angle_rad.as_ref().unwrap().iter());
        let row = |angle_rad: f64| (angle_rad / std::f64::consts::TAU * 1000.0 / 7.0).round() as usize;
        let is_apart = |(v, x): &(&f64, &f64)| (**v - duty(row(**x)) as f64).abs() > 0.5;
        // The line that is lost, and the reading that is.
        let apart = volts.zip(angles).filter(is_apart).count();
        assert!(apart <= 2, "{apart}");
    }

    #[test]
    fn a_line_that_was_cut_off_and_a_garbled_word_take_no_stamps_from_the_others() {
        let text = lines(400, |k| {
            let duty = (200.0 * (0.03 * k as f64).sin()) as i64;
            let counts = match k {
                100 => "E:10".to_owned(),
                200 => format!("EE:{},{}", 1003 + 10 * k, 7 * k),
                _ => format!("E:{},{}", 1003 + 10 * k, 7 * k),
            };
            format!("P:{},{duty}\n{counts}\n", 1000 + 10 * k)
        });
        let text = format!("0,55\nE:10\n{text}");
        let records = records(&text, "time=stamp:ms,duty=pwm:255,angle=enc:rev/1000", 12.0, None);
        let all: usize = records.iter().map(|record| record.len()).sum();
        assert!(all > 390, "{all}");
    }

    #[test]
    fn words_that_are_values_of_a_row_come_in_no_order() {
        let states = ["idle", "ramp", "hold", "ramp", "idle", "hold", "idle"];
        assert!(!is(lines(200, |k| format!("{},{k}\n", states[k * k % 7])).as_bytes()));
        assert!(!is(lines(200, |k| format!("{},{k}\n", states[k / 40])).as_bytes()));
    }

    #[test]
    fn stamps_are_milliseconds_microseconds_or_seconds() {
        let of = |step: f64| second(&(0..50).map(|k| step * f64::from(k)).collect::<Vec<_>>());
        assert_eq!([10.0, 10_000.0, 0.01, 10.5].map(of), [1e3, 1e6, 1.0, 1e3]);
    }
}
