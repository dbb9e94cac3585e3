//! Reading a table of samples: canonical logs, and foreign ones by `--map`.

use std::io::BufRead;
use std::path::Path;

use super::fields::Splitter;
use super::guess;
use super::mapping::Mapping;
use super::samples::{Place, Samples};
use super::servo::Servo;
use super::structure::{self, Structure};
use super::text::cannot_read;
use super::units::{Quantity, Unit};
use super::{Metadata, ReadOptions, Record, Warning, preamble};
use crate::error::{BadInput, Result};

/// A column of the file that is wanted.
#[derive(Debug)]
struct Wanted {
    quantity: Quantity,
    index: usize,
    header: String,
    factor: f64,
}

/// Reads the record (or the tests) from `input`, which stands at the beginning of the file at `path`.
///
/// # Errors
/// Bad input, with line and column; wrong usage where an option is missing to make sense of the mapping.
pub fn read(path: &Path, mut input: impl BufRead, options: &ReadOptions) -> Result<Vec<Record>> {
    let by_number = options.map.as_ref().is_some_and(Mapping::is_by_number);
    let head = preamble::read(path, &mut input, by_number)?;
    let mut meta = head.meta;
    options.complete(path, &mut meta)?;

    let width = head.headers.as_ref().map(Vec::len);
    let names = head.headers.unwrap_or_default();
    let choice = Choice { path, line: head.line, names: &names, meta: &meta };
    let wanted = match choice.columns(options.map.as_ref())? {
        Ok(wanted) => wanted,
        Err(Missing { header, why }) => {
            let rows = first_rows(path, input, head.delimiter)?;
            return Err(choice.missing(header, why, guess::propose(&names, &rows)));
        }
    };
    let mut samples = Samples::new(path, wanted.iter().map(|column| column.header.clone()).collect());

    let state = structure::state_column(&names).filter(|k| wanted.iter().all(|column| column.index != *k));
    let mut structure = Structure::default();
    let mut splitter = Splitter::new(head.delimiter);
    let mut numbers = vec![0.0; wanted.len()];
    let mut number = head.line;
    let mut line = Vec::new();
    if let Some(first) = head.first_row {
        line = first.into_bytes();
        number -= 1;
    }
    while !line.is_empty()
        || input.read_until(b'\n', &mut line).map_err(|error| cannot_read(path, &error))? > 0
    {
        number += 1;
        let place = Place::Line(number);
        let text = line.trim_ascii();
        if !text.is_empty() && !text.starts_with(b"#") {
            if !splitter.split(text) {
                let why = "a quotation mark is not closed";
                samples.stray(place, &wanted[0].header, why.into());
            } else {
                match numbers_of(&splitter, &wanted, width, head.delimiter, &mut numbers) {
                    Ok(()) => {
                        samples.accept(place, &numbers)?;
                        if let Some(state) = state.and_then(|index| splitter.get(index)) {
                            structure.saw(samples.len().saturating_sub(1), state);
                        }
                    }
                    Err((column, why)) if width.is_some_and(|width| splitter.len() < width) => {
                        samples.stray(place, column, why);
                    }
                    Err((column, why)) => samples.reject(place, column, why),
                }
            }
        }
        line.clear();
    }
    structure.restarts = samples.restarts().to_vec();
    let (columns, mut warnings) = samples.finish(Some(Place::Line(head.line)))?;
    if head.skipped > 0 {
        warnings.push(Warning {
            place: format!("{}, line {}", path.display(), head.line),
            what: format!("{} lines of text before the header were left out", head.skipped),
            fix: "nothing, if the header is right".into(),
        });
    }
    let mut record = Record {
        name: super::stem(path),
        path: path.to_owned(),
        hold: options.hold.or(meta.hold()).unwrap_or_default(),
        map: options.map.clone(),
        meta,
        warnings,
        ..Record::default()
    };
    fill(&mut record, &wanted, columns, options)?;
    Ok(structure.tests(record))
}

fn numbers_of<'w>(
    row: &Splitter,
    wanted: &'w [Wanted],
    width: Option<usize>,
    delimiter: u8,
    numbers: &mut [f64],
) -> Result<(), (&'w str, String)> {
    if let Some(width) = width
        && row.len() > width
        && row.iter().skip(width).any(|extra| !extra.is_empty())
    {
        let why = format!("the row has {} fields under {width} headers", row.len());
        return Err((&wanted[0].header, why));
    }
    for (column, number) in wanted.iter().zip(numbers) {
        let text = row.get(column.index).unwrap_or_default();
        *number = match self::number(text, delimiter) {
            Some(value) if value.is_finite() => value * column.factor,
            Some(_) => {
                return Err((&column.header, format!("\"{text}\" is not a number a fit can use")));
            }
            None if text.is_empty() => return Err((&column.header, "the field is empty".into())),
            None => {
                let shown: String = text.chars().take(40).collect();
                return Err((&column.header, format!("\"{shown}\" is not a number")));
            }
        };
    }
    Ok(())
}

fn fill(record: &mut Record, wanted: &[Wanted], columns: Vec<Vec<f64>>, options: &ReadOptions) -> Result<()> {
    let (mut duty, mut target) = (None, None);
    for (column, values) in wanted.iter().zip(columns) {
        match column.quantity {
            Quantity::Time => record.time_s = values,
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
                let how = format!("it is the duty times {volts} V, whatever the supply did");
                record.meta.insert("voltage", &how).expect("this key takes any text");
                duty.iter().map(|duty| duty * volts).collect()
            }
            (None, None) => {
                return Err(crate::error::Error::usage(
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
    Ok(())
}

/// Rows from which a mapping is guessed.
const GUESSED_FROM: usize = 2000;

/// The numbers of the first rows; NaN where a field is none.
fn first_rows(path: &Path, mut input: impl BufRead, delimiter: u8) -> Result<Vec<Vec<f64>>> {
    let mut splitter = Splitter::new(delimiter);
    let (mut rows, mut line) = (Vec::new(), Vec::new());
    while rows.len() < GUESSED_FROM
        && input.read_until(b'\n', &mut line).map_err(|error| cannot_read(path, &error))? > 0
    {
        if splitter.split(&line) {
            rows.push(splitter.iter().map(|text| number(text, delimiter).unwrap_or(f64::NAN)).collect());
        }
        line.clear();
    }
    Ok(rows)
}

/// The number in a field; a comma is a decimal one where something else separates the fields.
fn number(text: &str, delimiter: u8) -> Option<f64> {
    text.parse::<f64>().ok().or_else(|| {
        let decimal_comma = delimiter != b',' && text.contains(',');
        decimal_comma.then(|| text.replacen(',', ".", 1).parse().ok()).flatten()
    })
}

/// A canonical column that neither the header nor the mapping has.
struct Missing {
    header: &'static str,
    why: &'static str,
}

/// The header of a file, out of which columns are chosen.
struct Choice<'a> {
    path: &'a Path,
    line: u64,
    names: &'a [String],
    meta: &'a Metadata,
}

impl Choice<'_> {
    fn columns(&self, map: Option<&Mapping>) -> Result<Result<Vec<Wanted>, Missing>> {
        let mut wanted = Vec::new();
        for quantity in Quantity::ALL {
            if let Some(source) = map.and_then(|map| map.source(quantity)) {
                wanted.push(self.named(quantity, &source.column, source.unit)?);
            } else if !displaced(quantity, map)
                && let Some(header) = quantity.canonical()
                && let Some(index) = self.names.iter().position(|name| name == header)
            {
                wanted.push(Wanted { quantity, index, header: header.to_owned(), factor: 1.0 });
            }
        }
        let has = |quantity| wanted.iter().any(|column: &Wanted| column.quantity == quantity);
        if !has(Quantity::Time) {
            return Ok(Err(Missing { header: "time_s", why: "no column gives the time" }));
        }
        // The target of a servo drives it only where nothing nearer to the motor was logged.
        if !has(Quantity::Voltage) && !has(Quantity::Duty) && has(Quantity::Target) {
            if !has(Quantity::Angle) {
                let why = "a target moves the motor by its angle, and no column gives the angle";
                return Ok(Err(Missing { header: "angle_rad", why }));
            }
            return Ok(Ok(wanted));
        }
        if !has(Quantity::Voltage) && !has(Quantity::Duty) {
            return Ok(Err(Missing { header: "voltage_v", why: "no column gives the voltage" }));
        }
        if !has(Quantity::Angle) && !has(Quantity::Speed) {
            let why = "no column gives the angle or the speed (speed_rad_s)";
            return Ok(Err(Missing { header: "angle_rad", why }));
        }
        Ok(Ok(wanted))
    }

    fn named(&self, quantity: Quantity, column: &str, unit: Unit) -> Result<Wanted> {
        let by_name = self.names.iter().position(|name| name == column);
        let index = by_name
            .or_else(|| {
                column.parse().ok().filter(|&index| self.names.is_empty() || index < self.names.len())
            })
            .ok_or_else(|| {
                BadInput::new(
                    self.path,
                    format!("there is no column \"{column}\" for {quantity}"),
                    format!("take one of: {}", self.listed()),
                )
                .at_line(self.line)
                .in_column(column)
            })?;
        let header = self.names.get(index).cloned().unwrap_or_else(|| index.to_string());
        let mut factor = unit.factor;
        if unit.counts {
            factor /= self.meta.counts_per_rev().ok_or_else(|| {
                BadInput::new(
                    self.path,
                    "encoder counts need the counts of one turn of the output shaft",
                    format!(
                        "say --counts-per-rev 1400, put counts_per_rev into motor.toml, or write --map {quantity}={column}:rev/1400"
                    ),
                )
                .in_column(&header)
            })?;
        }
        Ok(Wanted { quantity, index, header, factor })
    }

    fn missing(&self, header: &str, why: &str, proposal: Option<guess::Proposal>) -> crate::error::Error {
        let remedy = match &proposal {
            Some(proposal) => {
                let assumptions = proposal.assumptions();
                let assumptions =
                    if assumptions.is_empty() { String::new() } else { format!(" ({assumptions})") };
                format!("say which column is what and in which unit; it looks like {}{assumptions}", proposal.options())
            }
            None => "say which column is what and in which unit, for example --map time=t:ms,voltage=u:V,speed=y:deg/s \
                     or --map duty=pwm:255,angle=enc:counts --supply-volts 12 --counts-per-rev 1320"
                .into(),
        };
        BadInput::new(self.path, format!("{why}; the columns are {}", self.listed()), remedy)
            .at_line(self.line)
            .in_column(header)
            .proposing(proposal)
            .into()
    }

    fn listed(&self) -> String {
        const SHOWN: usize = 20;
        let mut text = self.names.iter().take(SHOWN).cloned().collect::<Vec<_>>().join(", ");
        if self.names.len() > SHOWN {
            text += &format!(" and {} more", self.names.len() - SHOWN);
        }
        text
    }
}

/// Whether the mapping makes a canonical column of this kind unwanted.
fn displaced(quantity: Quantity, map: Option<&Mapping>) -> bool {
    map.is_some_and(|map| match quantity {
        Quantity::Angle | Quantity::Speed => map.names_motion(),
        Quantity::Voltage => [Quantity::Duty, Quantity::Target].iter().any(|q| map.source(*q).is_some()),
        _ => false,
    })
}
