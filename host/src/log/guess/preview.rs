//! A proposal shown before it is used: what each column would be read as, in one line.

use std::fmt::Write as _;

use super::columns::Part;
use super::per_turn_of;
use super::ranges::Range;
use crate::log::direction;
use crate::log::sample::numbers;
use crate::log::ticks::Ticks;
use crate::log::timing;
use crate::log::units::{PerTurn, Quantity, Unit};
use crate::log::unsigned;

/// Columns of a plot in the terminal.
const WIDTH: usize = 32;

/// A line that shows what a column would be read as: its range in its own unit and in SI, and its course.
pub(super) fn preview(names: &[String], rows: &[Vec<f64>], part: &Part) -> String {
    let mut values: Vec<f64> = numbers(rows, part.index).collect();
    let mut name = names.get(part.index).map_or_else(|| part.index.to_string(), Clone::clone);
    if let Some(rest) = part.rest {
        // A time is shown in the unit of its fraction, as one number.
        let unit = Unit::parse(Quantity::Time, &part.unit).map_or(1.0, |unit| unit.factor);
        let both = |row: &Vec<f64>| {
            let (one, other) = (row.get(part.index)?, row.get(rest)?);
            Some(if part.quantity == Quantity::Time { one / unit + other } else { one - other })
        };
        values = rows.iter().filter_map(both).filter(|v| v.is_finite()).collect();
        let _ = write!(name, " {} {}", part.sign(), names.get(rest).map(String::as_str).unwrap_or_default());
    }
    if part.quantity == Quantity::Time {
        values = Ticks::all(values.into_iter());
    }
    if part.quantity == Quantity::Direction
        && let Ok(signs) = direction::signs(&values)
    {
        values = signs;
    }
    if Unit::parse(part.quantity, &part.unit).is_ok_and(|unit| unit.signed_byte) {
        values.iter_mut().for_each(|value| *value = unsigned::signed(*value, unsigned::BYTE));
    }
    let range = Range::of(values.iter().copied());
    let of = if part.quantity == Quantity::Duty { "of full duty" } else { "" };
    let per_turn = per_turn_of(part);
    let unit = Unit::parse(part.quantity, &part.unit).unwrap_or(Unit::SI);
    let factor = unit.factor;
    let own = if part.quantity == Quantity::Duty { "" } else { part.unit.as_str() };
    let mut text =
        format!("{:<8} {name}: {} .. {} {own}", part.quantity.key(), short(range.low), short(range.high));
    if let Some(per_turn) = per_turn {
        text += match per_turn {
            PerTurn::Counts => " (turns follow from the counts per turn)",
            PerTurn::Metres => " (turns follow from the metres per turn)",
        };
    } else if factor != 1.0 {
        let si = part.quantity.si();
        let of = if of.is_empty() { si } else { of };
        let _ = write!(text, " = {} .. {} {of}", short(unit.to_si(range.low)), short(unit.to_si(range.high)));
    }
    if part.quantity == Quantity::Time {
        let rate = timing::rate(&values) / factor;
        let _ = write!(text, ", {} samples a second", short(rate));
    } else if range.high > range.low {
        let _ = write!(text, "  {}", course(&values, range.low, range.high));
    }
    text
}

/// The range of a column that is not used, by its place.
pub(super) fn range_of(rows: &[Vec<f64>], index: usize) -> String {
    format!("{index}: {}", range_in(rows, index).unwrap_or_else(|| "no numbers".into()))
}

/// From where to where a column goes; none where it holds no numbers.
fn range_in(rows: &[Vec<f64>], index: usize) -> Option<String> {
    let values: Vec<f64> = numbers(rows, index).collect();
    values.first()?;
    if values.iter().all(|value| direction::is_word(*value)) {
        return Some("words for a direction".into());
    }
    let range = Range::of(values.into_iter());
    Some(format!("{} .. {}", short(range.low), short(range.high)))
}

/// Columns that are named where they are not used.
const MOST_UNUSED: usize = 6;

/// A line of the columns with names that are not used, where there are some.
pub(super) fn unused(names: &[String], rows: &[Vec<f64>], parts: &[Part]) -> Option<String> {
    let is_used = |k: &usize| parts.iter().any(|part| part.index == *k || part.rest == Some(*k));
    let told =
        |k: usize| Some(format!("{}: {}", names.get(k).filter(|name| !name.is_empty())?, range_in(rows, k)?));
    let all: Vec<String> = (0..names.len()).filter(|k| !is_used(k)).filter_map(told).collect();
    let more = all.len().saturating_sub(MOST_UNUSED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    (!all.is_empty())
        .then(|| format!("{:<8} {}{more}", "unused", all[..all.len().min(MOST_UNUSED)].join(", ")))
}

/// A figure in as many digits as a person reads.
pub(super) fn short(x: f64) -> String {
    let digits = (3.0 - x.abs().max(1e-9).log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A plot of one line.
fn course(values: &[f64], low: f64, high: f64) -> String {
    const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let width = WIDTH.min(values.len());
    (0..width)
        .map(|k| {
            let value = values[k * (values.len() - 1) / (width - 1).max(1)];
            BARS[(((value - low) / (high - low) * 7.0).round() as usize).min(7)]
        })
        .collect()
}
