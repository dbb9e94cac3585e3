//! The names in a header, and the units in a row below it.

use super::fields::Separator;
use super::guess::unit_names;
use super::layout::{fields, is_bare_number, is_number};

/// The `width` names in a header, which may separate them otherwise than the rows do.
pub(super) fn names_of(line: &str, separator: &Separator, width: usize) -> Option<Vec<String>> {
    let fit = |mut names: Vec<String>| {
        // A column for remarks that nobody wrote, a separator at the end of the header only.
        let last_is_empty = |name: &String| name.is_empty() || name.eq_ignore_ascii_case("comment");
        if names.len() == width + 1 && names.last().is_some_and(last_is_empty) {
            names.pop();
        }
        // `data = [` above the rows of a matrix names nothing.
        let is_none = |name: &String| is_bare_number(name) || ["=", "["].contains(&name.as_str());
        (names.len() == width && !names.iter().any(is_none)).then_some(names)
    };
    let own = if *separator == Separator::DecimalCommas { Separator::Byte(b',') } else { separator.clone() };
    let between = if let Separator::Byte(byte) = separator { char::from(*byte) } else { ',' };
    let own = || fit(fields(line, &own)).or_else(|| fit(within_brackets(fields(line, &own), between)));
    own().or_else(|| match separator {
        Separator::Blanks => {
            let others = [Separator::Byte(b','), Separator::Byte(b';')];
            let by_others = others.iter().find_map(|other| fit(fields(line, other)));
            let words = || with_units(fields(line, separator));
            by_others.or_else(|| fit(far_apart(line))).or_else(|| fit(words()))
        }
        // What separates the rows is no part of a name.
        _ => fit(fields(line, &Separator::Blanks)).filter(|names| !names.iter().any(|n| n.contains(between))),
    })
}

/// The `width` names above a row of units where the channels of an oscilloscope are numbers, as Keysight's: `x-axis,1,2` is x-axis, CH1, CH2.
pub(super) fn channels_of(line: &str, separator: &Separator, width: usize) -> Option<Vec<String>> {
    let names = fields(line, separator);
    let is_channel =
        |name: &String| (1..=2).contains(&name.len()) && name.bytes().all(|b| b.is_ascii_digit());
    let (first, channels) = names.split_first()?;
    let are_channels = names.len() == width && !is_number(first) && channels.iter().all(is_channel);
    let called = channels.iter().map(|channel| format!("CH{channel}"));
    (are_channels && !channels.is_empty()).then(|| [first.clone()].into_iter().chain(called).collect())
}

/// Names that hold the separator within brackets, `time (s, from the start)`, are one.
fn within_brackets(names: Vec<String>, separator: char) -> Vec<String> {
    let is_open = |name: &String| name.matches(['(', '[']).count() > name.matches([')', ']']).count();
    let mut joined: Vec<String> = Vec::new();
    for name in names {
        match joined.last_mut() {
            Some(last) if is_open(last) => *last = format!("{last}{separator} {name}"),
            _ => joined.push(name),
        }
    }
    joined
}

/// Names between which there are two blanks or more.
fn far_apart(line: &str) -> Vec<String> {
    line.split("  ").map(str::trim).filter(|name| !name.is_empty()).map(str::to_owned).collect()
}

/// A date and the time behind it are one field, and so are their names.
fn is_date_and_time(name: &str, word: &str) -> bool {
    let is_one_of = |text: &str, words: [&str; 3]| words.contains(&text.to_lowercase().as_str());
    is_one_of(name, ["date", "datum", "day"]) && is_one_of(word, ["time", "zeit", "uhrzeit"])
}

/// Words, with a unit in brackets joined to the word before it.
fn with_units(words: Vec<String>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for word in words {
        match names.last_mut() {
            Some(name) if word.starts_with(['(', '[']) || is_date_and_time(name, &word) => {
                *name = format!("{name} {word}");
            }
            _ => names.push(word),
        }
    }
    names
}

/// Whether a line holds nothing but units, each in brackets or one that is known.
pub(super) fn is_of_units(line: &str) -> bool {
    let cells = |between: &[char]| -> Vec<&str> {
        line.split(between).map(str::trim).filter(|cell| !cell.is_empty()).collect()
    };
    let by_separator = cells(&[',', ';', '\t']);
    let all = if by_separator.len() > 1 { by_separator } else { cells(&[' ']) };
    let in_brackets = |cell: &&str| cell.starts_with(['[', '(']) && cell.ends_with([']', ')']);
    all.len() > 1 && all.iter().all(|cell| in_brackets(cell) || unit_names::is_unit(cell))
}

/// The units of a row of nothing else, without their brackets.
pub(super) fn units_of(line: &str, separator: &Separator, width: usize) -> Option<Vec<String>> {
    let own = if *separator == Separator::DecimalCommas { Separator::Byte(b',') } else { separator.clone() };
    let units: Vec<String> = fields(line, &own)
        .iter()
        .map(|unit| unit.trim_matches(['[', ']', '(', ')']).trim().to_owned())
        .collect();
    let short = units.iter().all(|unit| unit.chars().count() <= 12 && !is_number(unit));
    let known = units.iter().filter(|unit| unit_names::is_unit(unit)).count();
    (units.len() == width
        && short
        && known > 0
        && 2 * known >= units.iter().filter(|unit| !unit.is_empty()).count())
    .then_some(units)
}
