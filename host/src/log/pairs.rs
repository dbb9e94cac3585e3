//! Lines in which each value follows its name.

use std::ops::Range;

use super::fields::split_blanks;
use super::guess::unit_names;
use super::numbers::number;

/// Names and values of a line such as `t:12 pwm:80`, `t: 12, pwm = 80`, `t 12 pwm 80`; empty where it is no such line. What stands in brackets before
/// them, and a name whose value would be another name, as in `[7] motor: t:12 pwm:80`, is none of them.
pub fn pairs(line: &str) -> Vec<(Range<usize>, Range<usize>)> {
    if !line.contains([':', '=']) {
        return words_and_numbers(line);
    }
    // `motor: duty 80 enc 7`, as what a board's log says.
    if let Some((word, rest)) = line.split_once(": ")
        && is_word(word.trim())
        && !rest.contains([':', '='])
    {
        let begin = line.len() - rest.len();
        let moved = |range: Range<usize>| begin + range.start..begin + range.end;
        let found = words_and_numbers(rest);
        if !found.is_empty() {
            return found.into_iter().map(|(name, value)| (moved(name), moved(value))).collect();
        }
    }
    const BETWEEN: [char; 5] = [',', ';', '|', '\t', ' '];
    let mut pairs = Vec::new();
    let mut rest = 0;
    while let Some(colon) = line[rest..].find([':', '=']).map(|at| rest + at) {
        // What was behind the value before, as its unit, ends at the last hard separator.
        let hard = line[rest..colon].rfind([',', ';', '|', '\t']).map_or(rest, |at| rest + at + 1);
        let mut name = line[hard..colon].trim_matches(BETWEEN);
        while let Some((_, behind)) =
            name.strip_prefix('[').filter(|_| pairs.is_empty()).and_then(|name| name.split_once(']'))
        {
            name = behind.trim_matches(BETWEEN);
        }
        if pairs.is_empty() && is_name_first(&line[colon + 1..]) && (name.is_empty() || is_word(name)) {
            rest = colon + 1;
            continue;
        }
        // A remark behind the values, as where a program said it: `(motor src/main.rs:42)`.
        if name.starts_with('(') && !pairs.is_empty() {
            break;
        }
        if !name.starts_with(|c: char| c.is_alphabetic() || c == '_') {
            return Vec::new();
        }
        let name_at = hard + line[hard..colon].find(name).unwrap_or(0);
        let value = colon + 1 + value_behind(&line[colon + 1..]);
        let end = line[value..].find(BETWEEN).map_or(line.len(), |at| value + at);
        let end = end_of_unit(line, end)
            .filter(|_| line[..end].ends_with(|c: char| c.is_ascii_digit()))
            .unwrap_or(end);
        pairs.push((name_at..name_at + name.len(), value..end));
        rest = end;
    }
    pairs
}

/// Where the value begins behind a name's colon: in `Time:,12` behind the comma too.
fn value_behind(text: &str) -> usize {
    let begin = text.find(|c| c != ' ').unwrap_or(0);
    let behind = text[begin..].strip_prefix([',', ';', '\t']).unwrap_or_default();
    let word = behind.trim_start_matches(' ').split([',', ';', '\t', ' ']).next().unwrap_or_default();
    if number(word).is_some() { text.len() - behind.trim_start_matches(' ').len() } else { begin }
}

/// Names and values of a line in which words and numbers take turns, between blanks or all between the same separator.
fn words_and_numbers(line: &str) -> Vec<(Range<usize>, Range<usize>)> {
    let mut fields = Vec::new();
    split_blanks(line, &mut fields);
    let pairs = in_turns(line, &fields);
    if !pairs.is_empty() {
        return pairs;
    }
    let by = |separator: char| {
        let field = |(at, text): (usize, &str)| {
            let at = at + text.len() - text.trim_start().len();
            at..at + text.trim().len()
        };
        let starts = line.match_indices(separator).map(|(at, _)| at + 1);
        let fields: Vec<_> = std::iter::once(0).chain(starts).zip(line.split(separator)).map(field).collect();
        // A word and its number are a remark.
        (fields.len() >= 4).then(|| in_turns(line, &fields)).filter(|pairs| !pairs.is_empty())
    };
    [';', '\t', ','].into_iter().find_map(by).unwrap_or_default()
}

/// The fields in pairs, where every first is a name and every second a number.
fn in_turns(line: &str, fields: &[Range<usize>]) -> Vec<(Range<usize>, Range<usize>)> {
    let value = |field: &Range<usize>| {
        field.start..field.start + line[field.clone()].trim_end_matches([',', ';']).len()
    };
    let pair = |pair: &[Range<usize>]| {
        let (name, value) = (pair.first()?.clone(), value(pair.get(1)?));
        (is_word(&line[name.clone()]) && number(&line[value.clone()]).is_some()).then_some((name, value))
    };
    fields.chunks(2).map(pair).collect::<Option<Vec<_>>>().unwrap_or_default()
}

/// Whether a text begins with a name and the sign between it and its value.
pub(super) fn is_name_first(text: &str) -> bool {
    text.split_once([':', '=']).is_some_and(|(name, _)| is_word(name.trim()))
}

pub(super) fn is_word(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic() || c == '_')
        && text.chars().all(|c| c.is_alphanumeric() || ['_', '.', '/', '-'].contains(&c))
}

/// Where the unit ends that stands a blank behind the number at `end` of `line`, as in `Speed: 15.2 RPM`; none where there is none, or
/// where it is the name of the next value.
fn end_of_unit(line: &str, end: usize) -> Option<usize> {
    let word = line[end..].strip_prefix(' ')?.split([',', ';', '|', '\t', ' ']).next()?;
    let end = end + 1 + word.len();
    let is_name = line[end..].trim_start().starts_with([':', '=']);
    (unit_names::unit_named(word).is_some() && !is_name).then_some(end)
}
