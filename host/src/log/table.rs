//! Reading a table of samples: canonical logs, and foreign ones by `--map`.

use std::io::BufRead;
use std::path::Path;

use super::choice::{Choice, TimeSource, Wanted};
use super::clock::Clock;
use super::direction;
use super::mapping::Mapping;
use super::metadata::BEHIND_DUTY;
use super::numbered;
use super::preamble;
use super::rows::{Blanks, Rows, is_held};
use super::sample::proposal;
use super::samples::Place;
use super::servo::Servo;
use super::several::Several;
use super::structure::{self, Structure};
use super::text::cannot_read;
use super::units::Quantity;
use super::unsigned;
use super::{Metadata, ReadOptions, Record, Warning};
use crate::error::{BadInput, Column, Error, Result};

/// What is said of rows that tell no motion.
pub(super) const BLANK_MOTION: &str = "rows with a blank here were left out";

/// The columns of a table that are wanted.
#[derive(Debug)]
pub(super) struct Read {
    /// Times, s.
    pub time_s: Vec<f64>,
    /// The others, in the units of a record; a duty is a fraction.
    pub values: Vec<(Quantity, Vec<f64>)>,
    pub meta: Metadata,
    /// The mapping, with the units that the header says where it leaves them open.
    pub map: Option<Mapping>,
    pub structure: Structure,
    pub warnings: Vec<Warning>,
}

/// Reads the record (or the tests) from `input`, which stands at the beginning of the file at `path`.
///
/// # Errors
/// Bad input, with line and column; wrong usage where an option is missing to make sense of the mapping.
pub fn read(path: &Path, input: impl BufRead, options: &ReadOptions) -> Result<Vec<Record>> {
    let read = columns(path, input, options, &mut Clock::default(), false)?;
    let structure = read.structure.clone();
    Ok(structure.tests(record(path, super::stem(path), read, options)?))
}

/// Reads the columns; `partial` permits that some are in another file, whose clock is `clock`. Where a rate is given it tells the time in
/// the place of a column that cannot.
///
/// # Errors
/// As [`read`].
pub(super) fn columns(
    path: &Path,
    input: impl BufRead,
    options: &ReadOptions,
    clock: &mut Clock,
    partial: bool,
) -> Result<Read> {
    by_clock_or_rate(path, input, options, clock, partial).map_err(|error| with_map(error, options))
}

fn by_clock_or_rate(
    path: &Path,
    mut input: impl BufRead,
    options: &ReadOptions,
    clock: &mut Clock,
    partial: bool,
) -> Result<Read> {
    let mut of_time = String::new();
    if options.rate_hz.is_none() {
        return columns_by(path, input, options, clock, partial, (&mut of_time, None));
    }
    let mut text = String::new();
    while input.read_line(&mut text).map_err(|error| cannot_read(path, &error))? > 0 {}
    let before = clock.clone();
    let read = columns_by(path, text.as_bytes(), options, clock, partial, (&mut of_time, None));
    let Err(Error::BadInput(fault)) = &read else { return read };
    if fault.column != Some(Column::Name(of_time.clone())) {
        return read;
    }
    *clock = before;
    let mut why = fault.why.clone();
    // Its first and last time may be right.
    let even = fault.proposal.as_ref().and_then(|proposal| proposal.rate.as_ref()?.parse::<f64>().ok());
    if let (Some(even), Some(rate)) = (even, options.rate_hz)
        && (rate / even - 1.0).abs() > OTHER_RATE
    {
        why += &format!(", and from its first to its last they are {even} a second, not {rate}");
    }
    columns_by(path, text.as_bytes(), options, clock, partial, (&mut of_time, Some(&why))).or(read)
}

/// A rate that is further off than this from the one that the times make is told.
const OTHER_RATE: f64 = 0.05;

/// The fault with the mapping that was given beside what is proposed.
fn with_map(error: Error, options: &ReadOptions) -> Error {
    let Error::BadInput(mut fault) = error else { return error };
    if let (Some(proposal), Some(map)) = (&mut fault.proposal, &options.map)
        && proposal.map.is_empty()
    {
        proposal.map = map.written();
    }
    Error::BadInput(fault)
}

/// The same; `of_time` becomes the name of what tells the time, and a rate does where a reason is given why that cannot.
fn columns_by(
    path: &Path,
    mut input: impl BufRead,
    options: &ReadOptions,
    clock: &mut Clock,
    partial: bool,
    (of_time, no_time): (&mut String, Option<&str>),
) -> Result<Read> {
    let by_number = options.map.as_ref().is_some_and(Mapping::is_by_number);
    let mut head = preamble::read(path, &mut input, by_number)?;
    let mut meta = std::mem::take(&mut head.meta);
    options.complete(path, &mut meta)?;
    let names = head.headers.clone().unwrap_or_default();
    let choice = Choice {
        path,
        line: head.line,
        names: &names,
        units: &head.units,
        stamped: head.stamped,
        meta: &meta,
        partial,
        by_rate: no_time.is_some(),
    };
    let map = options.map.as_ref().map(|map| choice.with_units(map));
    let mut wanted = match choice.columns(&ReadOptions { map: map.clone(), ..options.clone() })? {
        Ok(wanted) => wanted,
        Err(missing) => {
            let guess = proposal(path, input, &head)?.with_known(options.known(&meta));
            return Err(choice.refusal(&missing, guess));
        }
    };
    if no_time.is_none() {
        wanted.time.header().clone_into(of_time);
    }
    if let TimeSource::Rate(rate) = wanted.time
        && let Some((column, per_row)) = numbered::column(&names, &head, &wanted)
    {
        wanted.time = TimeSource::Numbered(column, per_row, rate);
    }
    let state = structure::state_column(&names).filter(|k| !wanted.reads(*k));
    let mut rows = Rows::new(path, &wanted, &head, clock);
    rows.several = Several::new(&names, |k| wanted.reads(k));
    for (number, line) in std::mem::take(&mut head.rows) {
        rows.take(number, &line, state)?;
    }
    let (mut number, mut line) = (head.read, String::new());
    while input.read_line(&mut line).map_err(|error| cannot_read(path, &error))? > 0 {
        number += 1;
        rows.take(number, &line, state)?;
        line.clear();
    }
    if let Some(fault) = rows.several.fault(path) {
        return Err(fault.into());
    }
    let Rows { samples, mut structure, held, bracketed, twice, ticks, numbered, .. } = rows;
    structure.restarts = samples.restarts().to_vec();
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
    for (column, Blanks { count, first }) in wanted.values.iter().zip(held) {
        let Some(first) = first else { continue };
        let (what, fix) = if is_held(column.quantity) {
            (
                format!("{count} blank fields hold the value before them, first in line {first}"),
                "nothing, if this is logged when it changes or less often",
            )
        } else {
            (
                format!(
                    "{count} {BLANK_MOTION}, first in line {first}; what drives the motor in them counts until the next row with its mean"
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
    if let Some(why) = no_time {
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
        if *quantity == Quantity::Direction {
            *values = signs(path, column, values)?;
        }
    }
    Ok(Read { time_s, values, meta, map, structure, warnings })
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

/// Gives what drives the motor the sign that a column of directions holds; where it has its own and the speed has none, the speed.
fn turn_round(values: &mut [(Quantity, Vec<f64>)]) {
    let Some((_, signs)) = values.iter().find(|(quantity, _)| *quantity == Quantity::Direction).cloned()
    else {
        return;
    };
    let drives = [Quantity::Voltage, Quantity::Duty, Quantity::Target];
    let has_sign = |wanted: &[Quantity]| {
        let mut of = values.iter().filter(|(quantity, _)| wanted.contains(quantity));
        of.any(|(_, values)| values.iter().any(|value| *value < 0.0))
    };
    let has_speed = values.iter().any(|(quantity, _)| *quantity == Quantity::Speed);
    let is_of_motion = has_speed && has_sign(&drives) && !has_sign(&[Quantity::Speed]);
    let turned: &[Quantity] = if is_of_motion { &[Quantity::Speed] } else { &drives };
    for (_, values) in values.iter_mut().filter(|(quantity, _)| turned.contains(quantity)) {
        values.iter_mut().zip(&signs).for_each(|(value, sign)| *value *= sign);
    }
}

/// The record of the columns.
///
/// # Errors
/// Wrong usage where a duty has no supply.
pub(super) fn record(path: &Path, name: String, mut read: Read, options: &ReadOptions) -> Result<Record> {
    turn_round(&mut read.values);
    let mut record = Record {
        name,
        path: path.to_owned(),
        hold: options.hold.or(read.meta.hold()).unwrap_or_default(),
        map: read.map,
        meta: read.meta,
        warnings: read.warnings,
        time_s: read.time_s,
        ..Record::default()
    };
    let (mut duty, mut target) = (None, None);

    for (quantity, values) in read.values {
        match quantity {
            Quantity::Time | Quantity::Interval | Quantity::Direction => {}
            Quantity::Voltage => record.voltage_v = values,
            Quantity::Duty => duty = Some(values),
            Quantity::Target => target = Some(values),
            Quantity::Angle => record.angle_rad = Some(values),
            Quantity::Speed => record.speed_rad_s = Some(values),
            Quantity::Current => record.current_a = Some(values),
            Quantity::Supply => record.supply_v = Some(values),
        }
    }
    if let Some(duty) = duty {
        record.voltage_v = match (&record.supply_v, options.supply_volts) {
            (Some(supply), _) => duty.iter().zip(supply).map(|(duty, supply)| duty * supply).collect(),
            (None, Some(volts)) => {
                let how = format!("{BEHIND_DUTY}{volts} V, whatever the supply did");
                record.meta.insert("voltage", &how).expect("this key takes any text");
                duty.iter().map(|duty| duty * volts).collect()
            }
            (None, None) => {
                return Err(Error::usage(
                    "duty alone does not give a voltage",
                    "add --supply-volts 7.9, or map the supply: --map ...,supply=COLUMN:V",
                ));
            }
        };
    }
    if let Some(target_rad) = target.filter(|_| record.voltage_v.is_empty()) {
        let volts = options.supply_volts;
        if let (None, Some(volts)) = (&record.supply_v, volts) {
            record.supply_v = Some(vec![volts; target_rad.len()]);
        }
        record.voltage_v = vec![0.0; target_rad.len()];
        let (gain, damping) = (options.servo_gain, options.servo_damping);
        record.servo = Some(Servo { target_rad, gain, damping });
    }
    Ok(record)
}
