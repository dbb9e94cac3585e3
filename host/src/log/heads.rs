//! What stands before every line, or in turns before the values of each signal: a word and a colon, TwinCAT's names.

use super::fields::Separator;
use super::layout::{Layout, MOST, MOST_CHATTER, fields, is_number, new};

/// Lines of which one tells the word before all.
const LAST: usize = 5;
/// What may stand in such words beside letters: `<info> app:`, `[motor] left-drive:`.
const AROUND: [char; 9] = ['_', '<', '>', '[', ']', '.', '-', '/', ' '];

/// The word and the colon that stand before two numbers or more in most lines.
pub(super) fn tag_of(lines: &[&str]) -> Option<String> {
    // The last line may be closing words.
    lines.iter().rev().take(LAST).find_map(|line| tag_like(line, lines))
}

/// The same, where it is that of `line`.
fn tag_like(line: &str, lines: &[&str]) -> Option<String> {
    let tag = &line[..=line.find(':')?];
    let mut letters = tag.trim_end_matches(':').chars();
    let is_word =
        tag.contains(char::is_alphabetic) && letters.all(|c| c.is_alphabetic() || AROUND.contains(&c));
    let separators =
        [Separator::Byte(b';'), Separator::Byte(b'\t'), Separator::Byte(b','), Separator::Blanks];
    let has_numbers = |line: &&str| {
        line.strip_prefix(tag).is_some_and(|rest| {
            separators.iter().any(|separator| {
                let values = fields(rest.trim_start(), separator);
                values.len() >= 2 && values.iter().all(|value| is_number(value))
            })
        })
    };
    let tagged = lines.iter().filter(|line| has_numbers(line)).count();
    (is_word && tagged >= 2 && tagged as f64 >= MOST * lines.len() as f64).then(|| tag.to_owned())
}

/// TwinCAT's scope: a line of `Name` and a signal in turns, remarks of the same shape, and below them a time and a value in turns.
pub(super) fn scope(lines: &[&str]) -> Option<Layout> {
    let separators = [Separator::Byte(b'\t'), Separator::Byte(b';'), Separator::Byte(b',')];
    separators.into_iter().find_map(|separator| {
        let of = |key: &str| {
            let mut all = lines.iter().take(MOST_CHATTER).map(|line| fields(line, &separator)).enumerate();
            all.find(|(_, fields)| {
                fields.len() >= 4
                    && fields.len() % 2 == 0
                    && fields.iter().step_by(2).all(|field| field == key)
            })
        };
        let (header, mut names) = of("Name")?;
        let is_row = |line: &&str| {
            let values = fields(line, &separator);
            values.len() == names.len() && values.iter().all(|value| is_number(value))
        };
        let rows = header + lines[header..].iter().position(is_row)?;
        let mut units = of("Unit").map(|(_, units)| units).unwrap_or_default();
        units.iter_mut().step_by(2).for_each(String::clear);
        names.iter_mut().step_by(2).for_each(|name| *name = "Time".into());
        Some(Layout { header: Some(header), names, units, rows, ..new(separator) })
    })
}
