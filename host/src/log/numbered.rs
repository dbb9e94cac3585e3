//! Rows that bear a number: where only a rate tells the time, a number that is missing is a time that passed.

use super::choice::{Columns, Wanted};
use super::guess::words;
use super::numbers::number;
use super::preamble::Preamble;
use super::ticks::Ticks;
use super::timing::median;
use super::units::{Quantity, Unit};

/// Words of which the name of such a column consists.
const NAMES: [&str; 17] = [
    "index", "idx", "frame", "sample", "samples", "row", "n", "nr", "no", "num", "number", "seq", "sequence",
    "packet", "id", "messnr", "timestep",
];
/// Rows from which the numbers are told, and the share of them that rise by as much as most.
const FEWEST: usize = 20;
const ALIKE: f64 = 0.8;

/// The column of the numbers, and by how much they rise from row to row.
pub(super) fn column(names: &[String], head: &Preamble, wanted: &Columns) -> Option<(Wanted, f64)> {
    (0..names.len()).find_map(|index| {
        let per_row =
            (is_called_so(&names[index]) && !wanted.reads(index)).then(|| per_row(head, index))??;
        let header = names[index].clone();
        Some((Wanted { quantity: Quantity::Time, index, less: None, header, unit: Unit::SI }, per_row))
    })
}

/// Whether a column numbers the rows, by its name or by its values: what does is nothing of a motor.
pub(super) fn numbers_rows(name: &str, values: &[f64]) -> bool {
    let is_named = is_called_so(name);
    let steps = || values.windows(2).map(|pair| pair[1] - pair[0]);
    let by_one = steps().filter(|step| *step == 1.0).count() as f64;
    let enough = values.len() >= FEWEST;
    enough && (by_one >= ALIKE * steps().count() as f64 || is_named && steps().all(|step| step >= 0.0))
}

/// Whether a column without a name counts the rows, of several runs one after the other too. No row is left out: nothing else tells such a
/// column from an encoder that turns slowly, or from a clock of about a tick a row.
pub(super) fn counts_rows(values: &[f64]) -> bool {
    values.windows(2).all(|pair| pair[1] - pair[0] == 1.0 || pair[1] < pair[0] && pair[1] == values[0])
}

fn is_called_so(name: &str) -> bool {
    let words = words::of(name);
    !words.is_empty() && words.iter().all(|word| NAMES.contains(&word.as_str()))
}

/// By how much the whole numbers of the first rows rise, if they do.
fn per_row(head: &Preamble, index: usize) -> Option<f64> {
    let mut splitter = head.splitter();
    let mut ticks = Ticks::of_rows();
    let mut numbers = Vec::new();
    for (_, line) in &head.rows {
        if splitter.split(line)
            && let Some(value) = splitter.get(index).and_then(number)
        {
            numbers.push(ticks.read(value));
        }
    }
    let mut steps: Vec<f64> = numbers.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let is_whole = numbers.iter().all(|number| number.fract() == 0.0);
    let rises = numbers.len() >= FEWEST && is_whole && steps.iter().all(|step| *step > 0.0);
    let usual = rises.then(|| median(&mut steps))?;
    let alike = steps.iter().filter(|step| **step == usual).count();
    (alike as f64 >= ALIKE * steps.len() as f64).then_some(usual)
}
