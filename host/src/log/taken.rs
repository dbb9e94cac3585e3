//! Rows as they are taken in by one source of their time, and what they come to: the columns, and what is said of them.

use std::path::Path;

use super::choice::{Columns, TimeSource, Wanted};
use super::clock::Clock;
use super::counter;
use super::direction;
use super::mapping::Mapping;
use super::preamble::Preamble;
use super::rows::{Blanks, Rows, is_held};
use super::samples::Place;
use super::several::Several;
use super::steady_states::said_beside_log;
use super::structure;
use super::table::{Part, Read};
use super::units::Quantity;
use super::unsigned;
use super::{Metadata, Warning};
use crate::error::{BadInput, Error, Result};

/// What is known of a table beside its rows.
pub(super) struct About<'a> {
    pub path: &'a Path,
    pub head: &'a Preamble,
    pub meta: Metadata,
    pub map: Option<Mapping>,
    pub part: Part,
}

/// Rows that are read with one source of their time.
pub(super) struct Taken<'a> {
    wanted: &'a Columns,
    rows: Rows<'a>,
    state: Option<usize>,
    fault: Option<Error>,
}

impl<'a> Taken<'a> {
    pub fn new(
        path: &'a Path,
        wanted: &'a Columns,
        names: &[String],
        head: &Preamble,
        clock: &'a mut Clock,
    ) -> Self {
        let mut rows = Rows::new(path, wanted, head, clock);
        rows.several = Several::new(names, |k| wanted.reads(k));
        let state = structure::state_column(names).filter(|k| !wanted.reads(*k));
        let state = state.or_else(|| {
            rows.structure.whose = rows.several.parting().map(|k| names[k].clone());
            rows.several.parting()
        });
        Taken { wanted, rows, state, fault: None }
    }

    /// Takes a line, and tells whether it or one before it cannot be read.
    pub fn take(&mut self, number: u64, line: &str) -> bool {
        if self.fault.is_none() {
            self.fault = self.rows.take(number, line, self.state).err();
        }
        self.fault.is_some()
    }

    /// The columns; where a rate tells the time, with the name of what cannot, and the reason.
    pub fn finish(self, about: &About, no_time: Option<(&str, &str)>) -> Result<Read> {
        match self.fault {
            Some(fault) => {
                let several = self.rows.several.fault(about.path, about.map.as_ref());
                Err(several.map_or(fault, Error::from))
            }
            None => finished(self.rows, self.wanted, about, no_time),
        }
    }
}

fn finished(rows: Rows, wanted: &Columns, about: &About, no_time: Option<(&str, &str)>) -> Result<Read> {
    let About { path, head, meta, map, part } = about;
    let path = *path;
    let by_motor = || rows.several.fault(path, map.as_ref());
    if let Some(fault) = rows.chosen.as_ref().and_then(|chosen| chosen.fault(path)).or_else(by_motor) {
        return Err(fault.into());
    }
    let is_parted = rows.several.parted_by().is_some();
    let Rows { samples, mut structure, labels, held, bracketed, twice, ticks, numbered, .. } = rows;
    let labels = labels.and_then(|(_, labels)| labels.usable());
    structure.restarts = samples.restarts().to_vec();
    structure.at_text = matches!(wanted.time, TimeSource::Rate(_));
    // One value names nothing.
    if structure.whose.is_some() && !is_parted {
        structure.whose = None;
        structure.states.clear();
    }
    let samples_read = samples.len();
    let mut blanks = wanted.values.iter().zip(&held).filter(|(_, blanks)| blanks.count > 0);
    let first = blanks.clone().next();
    let blank = blanks.find(|(column, _)| !is_held(column.quantity)).or(first);
    if samples.len() == 0
        && let Some((column, _)) = blank
    {
        let why = "no row has a value here together with the others";
        let fix = "say with --map which columns are to be read, without this one where it is empty";
        return Err(BadInput::new(path, why, fix).in_column(&column.header).into());
    }
    // Of two files the one of the motion is counted where they are joined.
    let samples = if *part == Part::Half { samples.of_at_least(1) } else { samples };
    let (mut columns, mut warnings) = samples.finish(Some(Place::Line(head.line)))?;
    let file = path.display();
    let mut say =
        |place: String, what: String, fix: &str| warnings.push(Warning { place, what, fix: fix.into() });
    if head.skipped > 0 {
        say(
            format!("{file}, line {}", head.line),
            format!("{} lines of text before the header were left out", head.skipped),
            "nothing, if the header is right",
        );
    }
    if *part == Part::OwnStamps {
        say(
            file.to_string(),
            "what drives the motor was logged between the readings of its motion too: it holds from its own stamps on, and counts by its time"
                .into(),
            "nothing, if the stamps of both are of one clock",
        );
    }
    for (column, Blanks { count, first }) in wanted.values.iter().zip(held) {
        let Some(first) = first.filter(|_| *part != Part::OwnStamps || is_held(column.quantity)) else {
            continue;
        };
        let (what, fix) = if is_held(column.quantity) {
            (
                format!("{count} blank fields hold the value before them, first in line {first}"),
                "nothing, if this is logged when it changes or less often",
            )
        } else {
            (
                format!(
                    "{count} rows with a blank here were left out, first in line {first}; what drives the motor in them counts until the next row with its mean"
                ),
                "nothing, if this is logged less often",
            )
        };
        say(format!("{file}, column {}", column.header), what, fix);
    }
    if let Some(first) = bracketed.first {
        say(
            format!("{file}, line {first}"),
            format!(
                "{} numbers in brackets were read as negative ones, as spreadsheets write them",
                bracketed.count
            ),
            "nothing, if they are; otherwise take the brackets away",
        );
    }
    if let Some(first) = twice.first {
        say(
            format!("{file}, line {first}"),
            format!("{} lines say again what the line before them says, and were left out", twice.count),
            "nothing, if they were printed twice; else log the time with more digits",
        );
    }
    if let Some((of_time, why)) = no_time {
        say(
            format!("{file}, column {of_time}"),
            format!("this column cannot tell the time ({why}), and --rate does"),
            "nothing, if the rows came evenly; else log the time with more digits",
        );
    }
    if let (TimeSource::Numbered(column, per_row, _), Some((first, last))) = (&wanted.time, numbered) {
        let missing = (last - first) / per_row + 1.0 - samples_read as f64;
        if missing >= 1.0 {
            say(
                format!("{file}, column {}", column.header),
                format!(
                    "the rows are numbered here, and {missing:.0} numbers are missing: their time passes"
                ),
                "nothing, if they were lost; otherwise remove this column",
            );
        }
    } else if let Some((width, times)) = ticks.wrapped() {
        say(
            format!("{file}, column {}", wanted.time.header()),
            format!("the clock begins anew at {width}, {times} times, and its times go on there"),
            "log the time in 32 bits or more (uint32_t), if a pause may be longer than that",
        );
    }
    if matches!(wanted.time, TimeSource::Stamps) {
        say(
            file.to_string(),
            "the times are those at which the serial monitor received the lines, or the board printed them, some ms late and uneven"
                .into(),
            "print millis() or micros() in every line",
        );
    }
    if wanted.rate_unused {
        say(
            format!("{file}, column {}", wanted.time.header()),
            "--rate is not used, because this tells the time".into(),
            "leave --rate out, or remove the column if it is wrong",
        );
    }
    let time_s = columns.remove(0);
    let mut values: Vec<(Quantity, Vec<f64>)> =
        wanted.values.iter().map(|column| column.quantity).zip(columns).collect();
    let is_by_rate = matches!(wanted.time, TimeSource::Rate(_) | TimeSource::Numbered(..));
    if let Some((what, fix)) = said_beside_log((!is_by_rate).then_some(time_s.as_slice()), &values) {
        warnings.push(Warning { place: file.to_string(), what, fix: fix.into() });
    }
    for (column, (quantity, values)) in wanted.values.iter().zip(&mut values) {
        if let Some(width) = give_signs(column, values) {
            warnings.push(Warning {
                place: format!("{file}, column {}", column.header),
                what: format!(
                    "unsigned_numbers: there are numbers near 0 and near {width} and none between, as negative ones are printed without \
                     their sign; {} was read as -1",
                    width - 1.0
                ),
                fix: "print the number as one with a sign (int16_t, int32_t, %d)".into(),
            });
        }
        if let Some((width, times)) = counter::go_on(column, values) {
            warnings.push(Warning {
                place: format!("{file}, column {}", column.header),
                what: format!(
                    "wrapped_angle: the counter begins anew at {width}, {times} times, and its counts go on there"
                ),
                fix: "nothing, if it was not reset there; else print it as it is kept (int32_t, %ld)".into(),
            });
        }
        if *quantity == Quantity::Direction {
            *values = signs(path, column, values)?;
        }
    }
    Ok(Read { time_s, values, meta: meta.clone(), map: map.clone(), structure, labels, warnings })
}

/// Gives a column of whole numbers the signs that its type took away, and tells the width of the type; an angle wraps there, which is
/// undone anyway. Where such a number is said to be full duty, the type has none.
fn give_signs(column: &Wanted, values: &mut [f64]) -> Option<f64> {
    if [Quantity::Angle, Quantity::Direction].contains(&column.quantity) {
        return None;
    }
    let unit = column.unit;
    let written = |value: f64| (value / unit.factor + unit.zero).round();
    let all = || values.iter().map(|value| value / unit.factor + unit.zero);
    if all().any(|value| (value - value.round()).abs() > 1e-6 * value.abs().max(1.0)) {
        return None;
    }
    let width = unsigned::width_of(values.iter().map(|value| written(*value)))
        .filter(|width| column.quantity != Quantity::Duty || 1.0 / unit.factor.abs() <= 0.5 * width)?;
    for value in values {
        *value = unit.to_si(unsigned::signed(written(*value), width));
    }
    Some(width)
}

/// The signs of a column of directions, all of them turned round where the mapping says `*-1`.
fn signs(path: &Path, column: &Wanted, values: &[f64]) -> Result<Vec<f64>> {
    let signs = direction::signs(values).map_err(|odd| {
        let why = format!("{odd} is no direction");
        let fix = "a direction is 1 and -1, 1 and 0, 1 and 2, or two words such as FWD and REV: map the column that has these";
        BadInput::new(path, why, fix).in_column(&column.header)
    })?;
    Ok(signs.into_iter().map(|sign| sign * column.unit.factor.signum()).collect())
}
