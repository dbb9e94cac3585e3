//! Tables in whose first lines no header was recognised: numbers at once, or below what a board says as it starts.

use super::fields::Separator;
use super::layout::{Layout, MOST_CHATTER, fields, is_number, new, row};

/// Numbers without a header, or a header below which nothing was recognised.
pub(super) fn plain(lines: &[&str]) -> Layout {
    let first = lines.first().copied().unwrap_or_default();
    let all = |separator: &Separator| {
        let of = |line: &str| {
            let values = ending_in_one(fields(line, separator));
            (values.len() >= 2 && values.iter().all(|value| is_number(value))).then_some(values.len())
        };
        let width = of(first);
        width.is_some() && lines.iter().skip(1).take(2).all(|line| of(line) == width)
    };
    let separators =
        [Separator::Byte(b';'), Separator::Byte(b'\t'), Separator::Byte(b','), Separator::Blanks];
    if let Some(separator) = separators.into_iter().find(all) {
        return new(separator);
    }
    if let Some((separator, rows)) = numbers_below(lines) {
        return Layout { rows, ..new(separator) };
    }
    let separator = Separator::Byte(delimiter_of(first));
    let names = fields(first, &separator);
    // A word that stands before the numbers of every row is no name; channels may be called by numbers.
    let stays = |second: &&str| {
        let second = fields(second, &separator);
        second.len() == names.len()
            && names.iter().zip(&second).all(|(a, b)| is_number(a) && is_number(b) || a == b)
    };
    let is_row = row(first, &separator).is_some() && lines.get(1).is_some_and(stays);
    // Cells that are blank name nothing.
    let mut filled = names.iter().filter(|name| !name.is_empty()).peekable();
    if filled.peek().is_some() && filled.all(|name| is_number(name)) || is_row {
        return new(separator);
    }
    let mut names = ending_in_one(names);
    names.extend(behind_the_last_name(lines.get(1..).unwrap_or_default(), &separator, names.len()));
    Layout { header: Some(0), names, rows: 1, ..new(separator) }
}

/// The names of the columns that `rows` have behind the `named` ones: their places. Simulink names a signal of several numbers once.
fn behind_the_last_name(rows: &[&str], separator: &Separator, named: usize) -> Vec<String> {
    let first = &rows[..rows.len().min(3)];
    // Without a point in them they may be the two halves of numbers with decimal commas.
    let halves = *separator == Separator::Byte(b',') && !first.iter().all(|line| line.contains('.'));
    let widths: Vec<Option<usize>> = first.iter().map(|line| row(line, separator)).collect();
    match widths[..] {
        [Some(width), ref rest @ ..] if named >= 2 && !halves && rest.iter().all(|w| *w == Some(width)) => {
            (named..width).map(|place| place.to_string()).collect()
        }
        _ => Vec::new(),
    }
}

/// Numbers without a header below what a board says as it starts: from the line at which three rows of nothing else begin.
fn numbers_below(lines: &[&str]) -> Option<(Separator, usize)> {
    let width = |line: &str, separator: &Separator| {
        let values = ending_in_one(fields(line, separator));
        (values.len() >= 2 && values.iter().all(|value| is_number(value))).then_some(values.len())
    };
    let last = lines.len().saturating_sub(2).min(MOST_CHATTER);
    (1..last).find_map(|k| {
        [Separator::Byte(b';'), Separator::Byte(b'\t'), Separator::Byte(b','), Separator::Blanks]
            .into_iter()
            .find(|separator| {
                let first = width(lines[k], separator);
                first.is_some() && (1..3).all(|more| width(lines[k + more], separator) == first)
            })
            // What may be names, as many as the numbers or not, is a header, good or bad.
            .filter(|separator| {
                let before = fields(lines[k - 1], separator).len();
                // A bracket that stays open begins a matrix.
                let is_open = lines[k - 1].trim_end().ends_with(['[', '{']);
                before < 2
                    || is_open
                    || *separator == Separator::Blanks && Some(before) != width(lines[k], separator)
            })
            .map(|separator| (separator, k))
    })
}

/// Fields without the blank one behind a separator at the end of the line.
fn ending_in_one(mut fields: Vec<String>) -> Vec<String> {
    if fields.last().is_some_and(String::is_empty) {
        fields.pop();
    }
    fields
}

/// The separator of a line: a semicolon or tab wins over commas, which may then be decimal.
fn delimiter_of(line: &str) -> u8 {
    let has = |wanted: char| {
        let mut quoted = false;
        line.chars().any(|c| {
            quoted ^= c == '"';
            !quoted && c == wanted
        })
    };
    [';', '\t'].into_iter().find(|&candidate| has(candidate)).map_or(b',', |candidate| candidate as u8)
}
