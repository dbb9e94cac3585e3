//! Reading a table of samples: canonical logs, and foreign ones by `--map`.

use std::io::BufRead;
use std::path::Path;

use super::bursts::bursts;
use super::choice::{Choice, Columns, TimeSource};
use super::clock::Clock;
use super::labels::Labels;
use super::line_ends::read_row;
use super::mapping::Mapping;
use super::metadata::BEHIND_DUTY;
use super::newest;
use super::numbered;
use super::preamble::{self, Preamble};
use super::sample::{Guess, proposal};
use super::servo::Servo;
use super::structure::Structure;
use super::taken::{About, Taken};
use super::text::cannot_read;
use super::units::Quantity;
use super::{Metadata, ReadOptions, Record, Warning};
use crate::error::{Column, Error, Result};

/// What a table is to its log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    /// All of it, a sample a row.
    Whole,
    /// All of it, but what drives the motor has rows of its own, which have no motion.
    OwnStamps,
    /// One of two files that make a record.
    Half,
}

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
    /// What a column of words says, where there is one.
    pub labels: Option<Labels>,
    pub warnings: Vec<Warning>,
}

/// Reads the record (or the tests) from `input`, which stands at the beginning of the file at `path` and is all of its log.
///
/// # Errors
/// Bad input, with line and column; wrong usage where an option is missing to make sense of the mapping.
pub fn read(path: &Path, input: impl BufRead, options: &ReadOptions, part: Part) -> Result<Vec<Record>> {
    let read = columns(path, input, options, &mut Clock::default(), part)?;
    let structure = read.structure.clone();
    Ok(structure.tests(record(path, super::stem(path), read, options)?))
}

/// Reads the columns; those of a [`Part::Half`] are in another file too, whose clock is `clock`. Where a rate is given it tells the time in
/// the place of a column that cannot.
///
/// # Errors
/// As [`read`].
pub(super) fn columns(
    path: &Path,
    input: impl BufRead,
    options: &ReadOptions,
    clock: &mut Clock,
    part: Part,
) -> Result<Read> {
    by_clock_or_rate(path, input, options, clock, part).map_err(|error| with_map(error, options))
}

fn by_clock_or_rate(
    path: &Path,
    mut input: impl BufRead,
    options: &ReadOptions,
    clock: &mut Clock,
    part: Part,
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
        partial: part == Part::Half,
    };
    let map = options.map.as_ref().map(|map| choice.with_units(map));
    let mut wanted = match choice.columns(&ReadOptions { map: map.clone(), ..options.clone() })? {
        Ok(wanted) => wanted,
        Err(missing) => {
            let mut guess = proposal(path, input, &head)?.with_known(options.known(&meta));
            if let (Guess::Proposed(proposal), Some(only)) =
                (&mut guess, map.as_ref().and_then(Mapping::only))
            {
                proposal.map += &format!(",{}", only.written());
            }
            return Err(choice.refusal(&missing, guess));
        }
    };
    let rate = options.rate_hz.filter(|_| !matches!(wanted.time, TimeSource::Rate(_)));
    let mut even = rate.map(|rate| wanted.by_rate(rate));
    for wanted in [Some(&mut wanted), even.as_mut()].into_iter().flatten() {
        number_rows(wanted, &names, &head);
    }
    let before = clock.clone();
    // The rows by the log's own time, and by the rate in case that cannot tell it.
    let mut taken = Taken::new(path, &wanted, &names, &head, clock);
    let mut clock_of_even = Clock::default();
    let mut evenly = even.as_ref().map(|even| Taken::new(path, even, &names, &head, &mut clock_of_even));
    let mut take = |number: u64, line: &str| {
        let fails = taken.take(number, line);
        let fail = evenly.as_mut().is_none_or(|evenly| evenly.take(number, line));
        fails && fail
    };
    let mut failed = false;
    let is_turned = newest::is_first(&wanted.time, &head);
    // The newest wait for the oldest.
    let mut waiting = std::mem::take(&mut head.rows);
    if !is_turned {
        failed = waiting.drain(..).any(|(number, line)| take(number, &line));
    }
    let (mut number, mut line) = (head.read, String::new());
    while !failed {
        let lines = read_row(&mut input, &mut line).map_err(|error| cannot_read(path, &error))?;
        if lines == 0 {
            break;
        }
        // A row is found at its first line.
        let at = number + 1;
        number += lines;
        if is_turned {
            waiting.push((at, std::mem::take(&mut line)));
        } else {
            failed = take(at, &line);
            line.clear();
        }
    }
    let _ = waiting.into_iter().rev().any(|(number, line)| take(number, &line));
    let about = About { path, head: &head, meta, map, part };
    let mut read = taken.finish(&about, None);
    if let (true, Ok(read)) = (is_turned, &mut read) {
        read.warnings.push(Warning {
            place: path.display().to_string(),
            what: "the rows stand from the newest to the oldest, and were turned round".into(),
            fix: "nothing, if their times are right".into(),
        });
    }
    let header = wanted.time.header();
    // Asked only where a rate could take the place of the stamps: it takes a pass over all of them.
    if let Some(evenly) = evenly.take_if(|_| read.as_ref().is_ok_and(|read| bursts(&read.time_s).is_some())) {
        *clock = before;
        return evenly.finish(&about, Some((header, "its rows are stamped in bursts, as they arrived")));
    }
    let (Err(Error::BadInput(fault)), Some(evenly), Some(rate)) = (&read, evenly, rate) else { return read };
    if fault.column != Some(Column::Name(header.to_owned())) {
        return read;
    }
    let mut why = fault.why.clone();
    // Its first and last time may be right.
    let even = fault.proposal.as_ref().and_then(|proposal| proposal.rate.as_ref()?.parse::<f64>().ok());
    if let Some(even) = even.filter(|even| (rate / even - 1.0).abs() > OTHER_RATE) {
        why += &format!(", and from its first to its last they are {even} a second, not {rate}");
    }
    let by_rate = evenly.finish(&about, Some((header, &why)));
    if by_rate.is_ok() {
        *clock = before;
    }
    by_rate.or(read)
}

/// Lets a column of row numbers tell the time of rows that come at a rate.
fn number_rows(wanted: &mut Columns, names: &[String], head: &Preamble) {
    if let TimeSource::Rate(rate) = wanted.time
        && let Some((column, per_row)) = numbered::column(names, head, wanted)
    {
        wanted.time = TimeSource::Numbered(column, per_row, rate);
    }
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
        labels: read.labels,
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
    } else if let (None, false, Some(volts)) =
        (&record.supply_v, record.voltage_v.is_empty(), options.supply_volts)
    {
        // Effects of the bridge depend on the duty, which a voltage alone does not tell.
        if !(volts.is_finite() && volts > 0.0) {
            return Err(Error::usage(
                format!("a supply of {volts} V drives nothing: its voltage is a positive number"),
                "give the voltage of the supply, for example --supply-volts 12",
            ));
        }
        record.meta.insert("supply_volts", &volts.to_string()).expect("this key takes any text");
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
