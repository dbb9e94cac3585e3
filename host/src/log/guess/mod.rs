//! A guess at which column of a foreign table is what: never applied by itself, proposed as options that work as pasted.
//!
//! Names tell most ([`words`]); the values decide where they leave something open: whole numbers up to 255 are a duty, a
//! time in steps of 10 counts milliseconds, a voltage that never moves beside a duty is the supply.

mod look;
pub mod words;

use std::fmt::Write as _;

pub use look::{Look, look};

use super::table::Sample;
use super::units::{PerTurn, Quantity, Unit};

/// One column of the proposal.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// What it measures.
    pub quantity: Quantity,
    /// Its place, from 0.
    pub index: usize,
    /// Of a time in two columns, the place of the one that adds the fraction of a second, whose unit `unit` is.
    pub rest: Option<usize>,
    /// Its unit as `--map` writes it.
    pub unit: String,
}

/// Options that would read a table, and what they would make of it.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Proposal {
    /// The value of `--map`.
    pub map: String,
    /// The supply that is assumed, V, where the table has a duty only.
    pub supply_volts: Option<String>,
    /// The counts per turn of the output shaft that are assumed, where the table counts edges.
    pub counts_per_rev: Option<String>,
    /// The metres per turn of the output shaft that are assumed, where the table tells the way of a linear axis.
    pub metres_per_rev: Option<String>,
    /// The rate that is assumed, Hz, where no column tells the time.
    pub rate: Option<String>,
    /// A line for every column, with its range as it would be read.
    pub preview: Vec<String>,
}

impl Proposal {
    /// The options, quoted for any shell.
    pub fn options(&self) -> String {
        let mut text = format!("--map {}", quoted(&self.map));
        for (option, value) in [
            ("--supply-volts", &self.supply_volts),
            ("--counts-per-rev", &self.counts_per_rev),
            ("--metres-per-rev", &self.metres_per_rev),
            ("--rate", &self.rate),
        ] {
            if let Some(value) = value {
                let _ = write!(text, " {option} {value}");
            }
        }
        text
    }

    /// What a person has to put in the place of an assumption.
    pub fn assumptions(&self) -> String {
        let mut all = Vec::new();
        if let Some(volts) = &self.supply_volts {
            all.push(format!("put your supply's voltage in the place of {volts}"));
        }
        if let Some(counts) = &self.counts_per_rev {
            all.push(format!(
                "put the encoder's counts per turn of the output shaft (after x4 and gearing) in the place of {counts}"
            ));
        }
        if let Some(metres) = &self.metres_per_rev {
            all.push(format!(
                "put the metres per turn of the output shaft (a screw's lead, a wheel's circumference) in the place of {metres}"
            ));
        }
        if let Some(rate) = &self.rate {
            all.push(format!("put your samples per second in the place of {rate}"));
        }
        all.join("; ")
    }
}

/// The text as one word of a command line, in any usual shell.
pub fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_=:,./+-%@".contains(c);
    if !text.is_empty() && text.chars().all(plain) { text.to_owned() } else { format!("\"{text}\"") }
}

/// Guesses from the beginning of a table.
pub(super) fn propose_for(sample: &Sample) -> Option<Proposal> {
    proposal(&sample.names, &parts(&sample.with_units, &sample.rows), &sample.rows, sample.stamped)
}

/// Guesses from the names and the first rows of a table; fields that are no numbers are NaN. None where too little is recognised:
/// what drives the motor and what it does must both be.
pub fn propose(names: &[String], rows: &[Vec<f64>]) -> Option<Proposal> {
    proposal(names, &parts(names, rows), rows, false)
}

/// Guesses from the beginnings of two tables, the first of what drives the motor, the second of what it does.
pub(super) fn propose_apart(input: &Sample, output: &Sample) -> Option<Proposal> {
    use Quantity::{Angle, Current, Duty, Interval, Speed, Target, Time, Voltage};
    let of = |sample: &Sample| parts(&sample.with_units, &sample.rows);
    let (mut drives, mut moves) = (of(input), of(output));
    let time = |sample: &Sample, parts: &[Part]| {
        let part = parts.iter().find(|part| part.quantity == Time)?;
        Some((column(&sample.names, part.index), part.unit.clone()))
    };
    // One mapping must fit both files.
    if time(input, &drives) != time(output, &moves) {
        return None;
    }
    drives.retain(|part| ![Angle, Speed, Current, Interval].contains(&part.quantity));
    moves.retain(|part| [Angle, Speed, Current].contains(&part.quantity));
    let driven = drives.iter().any(|part| [Voltage, Duty, Target].contains(&part.quantity));
    if !driven || !moves.iter().any(|part| [Angle, Speed].contains(&part.quantity)) {
        return None;
    }
    let first = written(&input.names, &drives, &input.rows, input.stamped);
    let second = written(&output.names, &moves, &output.rows, true);
    Some(Proposal {
        map: format!("{},{}", first.map, second.map),
        counts_per_rev: second.counts_per_rev.or(first.counts_per_rev),
        metres_per_rev: second.metres_per_rev.or(first.metres_per_rev),
        preview: [first.preview, second.preview].concat(),
        ..first
    })
}

/// The options that `parts` are written as, where they say what drives the motor and what it does; `stamped` says that the lines
/// carry times of their own.
fn proposal(names: &[String], parts: &[Part], rows: &[Vec<f64>], stamped: bool) -> Option<Proposal> {
    let has = |quantity| parts.iter().any(|part| part.quantity == quantity);
    let servo = has(Quantity::Target) && has(Quantity::Angle);
    let driven = has(Quantity::Voltage) || has(Quantity::Duty) || servo;
    if !driven || !(has(Quantity::Angle) || has(Quantity::Speed)) {
        return None;
    }
    Some(written(names, parts, rows, stamped))
}

/// The options that `parts` are written as.
fn written(names: &[String], parts: &[Part], rows: &[Vec<f64>], stamped: bool) -> Proposal {
    let has = |quantity| parts.iter().any(|part| part.quantity == quantity);
    let needs = |per_turn| parts.iter().any(|part| per_turn_of(part) == Some(per_turn));
    let duty_alone = (has(Quantity::Duty) || has(Quantity::Target)) && !has(Quantity::Supply);
    let map: Vec<String> = parts
        .iter()
        .map(|part| {
            let rest = part.rest.map(|rest| format!("+{}", column(names, rest))).unwrap_or_default();
            format!("{}={}{rest}:{}", part.quantity, column(names, part.index), part.unit)
        })
        .collect();
    Proposal {
        map: map.join(","),
        supply_volts: duty_alone.then(|| "12".into()),
        counts_per_rev: needs(PerTurn::Counts).then(|| "1320".into()),
        metres_per_rev: needs(PerTurn::Metres).then(|| "0.008".into()),
        rate: (!stamped && !has(Quantity::Time) && !has(Quantity::Interval)).then(|| "100".into()),
        preview: parts.iter().map(|part| preview(names, rows, part)).collect(),
    }
}

fn per_turn_of(part: &Part) -> Option<PerTurn> {
    Unit::parse(part.quantity, &part.unit).ok()?.per_turn
}

/// A column as a mapping names it: by its name where a shell and the mapping leave that alone, else by its number.
fn column(names: &[String], index: usize) -> String {
    let name = names.get(index).map(String::as_str).unwrap_or_default();
    let awkward = name.is_empty()
        || name.contains([',', '+', '"', '\'', '$', '`', '\\', '!', '\u{fffd}'])
        || name.parse::<f64>().is_ok()
        || name != name.trim()
        || names.iter().filter(|other| *other == name).count() > 1;
    if awkward { index.to_string() } else { name.to_owned() }
}

/// The column for each quantity, in the order of [`Quantity::ALL`].
pub fn parts(names: &[String], rows: &[Vec<f64>]) -> Vec<Part> {
    let said: Vec<words::Said> = names.iter().map(|name| words::said(name)).collect();
    let values =
        |index: usize| rows.iter().filter_map(move |row| row.get(index)).copied().filter(|v| v.is_finite());
    let useful = |index: usize| rows.is_empty() || values(index).next().is_some();
    let mut quantities: Vec<Option<(Quantity, u8)>> = said
        .iter()
        .enumerate()
        .map(|(index, said)| said.quantity.filter(|_| !said.wanted && useful(index)))
        .collect();
    // A voltage that hardly changes beside a duty or a target is the supply's; whole numbers far beyond any supply are a duty.
    let driven = quantities.iter().any(|q| q.is_some_and(|(q, _)| q == Quantity::Duty))
        || said.iter().any(|said| said.target);
    for (index, guess) in quantities.iter_mut().enumerate() {
        let Some((quantity, plain)) = *guess else { continue };
        let range = Range::of(values(index));
        if quantity == Quantity::Voltage {
            if driven && range.low > 0.0 && range.high - range.low < 0.4 * range.high {
                *guess = Some((Quantity::Supply, plain));
            } else if range.whole && range.peak() > 60.0 && said[index].unit.is_none() {
                *guess = Some((Quantity::Duty, plain));
            }
        } else if quantity == Quantity::Duty
            && plain == 2
            && !range.whole
            && range.peak() > 1.0
            && range.peak() <= 60.0
        {
            // "command", "output": in volts by its size.
            *guess = Some((Quantity::Voltage, plain));
        }
    }
    let drives =
        |q: &Option<(Quantity, u8)>| q.is_some_and(|(q, _)| [Quantity::Voltage, Quantity::Duty].contains(&q));
    if !quantities.iter().any(drives) {
        // What a servo was told is what drives it, where nothing nearer to the motor was logged.
        for (guess, said) in quantities.iter_mut().zip(&said) {
            if said.target && said.quantity.is_none_or(|(q, _)| q == Quantity::Angle) {
                *guess = Some((Quantity::Target, 1));
            }
        }
    }
    let mut parts: Vec<Part> = Vec::new();
    for quantity in Quantity::ALL {
        // The plainest name; of equals the first, which moves.
        let candidates = quantities.iter().enumerate().filter_map(|(index, guess)| {
            let (_, plain) = guess.filter(|(q, _)| *q == quantity)?;
            let range = Range::of(values(index));
            let moves = rows.is_empty() || range.high > range.low;
            Some((index, (moves || quantity == Quantity::Supply, plain)))
        });
        let best = candidates.max_by_key(|&(index, rank)| (rank, std::cmp::Reverse(index)));
        let Some((index, _)) = best else { continue };
        let unit = unit_of(quantity, said[index].unit, values(index).collect::<Vec<_>>().as_slice());
        parts.push(Part { quantity, index, rest: None, unit });
    }
    add_fractions(&mut parts, names, rows);
    // A clock adds up no errors.
    if parts.iter().any(|part| part.quantity == Quantity::Time) {
        parts.retain(|part| part.quantity != Quantity::Interval);
    }
    // What was measured nearer to the motor.
    let place = |wanted: Quantity| parts.iter().position(|part| part.quantity == wanted);
    if let (Some(_), Some(duty)) = (place(Quantity::Voltage), place(Quantity::Duty)) {
        parts.remove(duty);
    }
    // The supply is of use beside a duty; an angle that only counts is of use alone, where the speed is in plain units.
    parts
}

/// The unit of a column whose name may say one.
fn unit_of(quantity: Quantity, said: Option<&'static str>, values: &[f64]) -> String {
    let range = Range::of(values.iter().copied());
    let unit = match (quantity, said) {
        (Quantity::Duty, _) => return full_duty(&range, said),
        (_, Some(unit)) => unit,
        (Quantity::Time, None) => time_unit(values, &range),
        (Quantity::Interval, None) if range.peak() < 1.0 => "s",
        (Quantity::Interval, None) if range.peak() < 500.0 => "ms",
        (Quantity::Interval, None) => "us",
        (Quantity::Voltage | Quantity::Supply, None) if range.peak() > 1000.0 => "mV",
        (Quantity::Voltage | Quantity::Supply, None) => "V",
        (Quantity::Angle | Quantity::Target, None) if range.whole && range.high - range.low > 100.0 => "deg",
        (Quantity::Angle | Quantity::Target, None) => "rad",
        (Quantity::Speed, None) => "rad/s",
        (Quantity::Current, None) if range.peak() > 60.0 => "mA",
        (Quantity::Current, None) => "A",
    };
    unit.to_owned()
}

fn full_duty(range: &Range, said: Option<&'static str>) -> String {
    let peak = range.peak();
    let full = [255.0, 400.0, 511.0, 512.0, 1000.0, 1023.0, 2047.0, 4095.0, 10_000.0, 32_767.0, 65_535.0];
    if let Some(unit) = said {
        unit.to_owned()
    } else if peak <= 1.0 {
        "1".into()
    } else if peak <= 100.0 && (range.has_round_tens || !range.whole) {
        "100".into()
    } else {
        full.into_iter().find(|full| peak <= *full).unwrap_or(peak).to_string()
    }
}

/// Seconds that stand still for many rows have their fraction in a column of its own: `sec,nanosec`.
fn add_fractions(parts: &mut [Part], names: &[String], rows: &[Vec<f64>]) {
    const FRACTIONS: [(&str, &str); 8] = [
        ("nanosec", "ns"),
        ("nsec", "ns"),
        ("nanos", "ns"),
        ("_ns", "ns"),
        ("usec", "us"),
        ("microsec", "us"),
        ("_us", "us"),
        ("msec", "ms"),
    ];
    let Some(time) = parts.iter_mut().find(|part| part.quantity == Quantity::Time) else { return };
    let values = |k: usize| rows.iter().map(move |row| row.get(k).copied().unwrap_or(f64::NAN));
    let seconds: Vec<f64> = values(time.index).collect();
    let whole = seconds.iter().all(|v| v.fract() == 0.0);
    let stands = seconds.windows(2).filter(|pair| pair[0] == pair[1]).count();
    if !whole || 2 * stands < rows.len() {
        return;
    }
    let found = names.iter().enumerate().find_map(|(k, name)| {
        let name = name.to_lowercase();
        let ends = |(end, _): &&(&str, &str)| {
            name.ends_with(end) || name.trim_end_matches("onds").trim_end_matches('s').ends_with(end)
        };
        let (_, unit) = FRACTIONS.iter().find(ends)?;
        (k != time.index).then_some((k, *unit))
    });
    if let Some((k, unit)) = found {
        time.rest = Some(k);
        unit.clone_into(&mut time.unit);
    }
}

/// Whole steps are not seconds.
fn time_unit(values: &[f64], range: &Range) -> &'static str {
    let step = super::timing::median_interval(values);
    match step {
        _ if !range.whole || step < 1.0 => "s",
        _ if step < 500.0 => "ms",
        _ if step < 200_000.0 => "us",
        _ => "ns",
    }
}

/// What the values of a column span.
struct Range {
    low: f64,
    high: f64,
    whole: bool,
    /// It holds 100 itself, or nothing but tens: percent.
    has_round_tens: bool,
}

impl Range {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut range =
            Self { low: f64::INFINITY, high: f64::NEG_INFINITY, whole: true, has_round_tens: true };
        for value in values {
            range.low = range.low.min(value);
            range.high = range.high.max(value);
            range.whole &= value.fract() == 0.0;
            range.has_round_tens &= value % 10.0 == 0.0;
        }
        range.has_round_tens |= range.peak() == 100.0;
        if range.low > range.high {
            (range.low, range.high) = (0.0, 0.0);
        }
        range
    }

    fn peak(&self) -> f64 {
        self.low.abs().max(self.high.abs())
    }
}

/// Columns of a plot in the terminal.
const WIDTH: usize = 32;

/// A line that shows what a column would be read as: its range in its own unit and in SI, and its course.
fn preview(names: &[String], rows: &[Vec<f64>], part: &Part) -> String {
    let mut values: Vec<f64> =
        rows.iter().filter_map(|row| row.get(part.index)).copied().filter(|v| v.is_finite()).collect();
    let mut name = names.get(part.index).map_or_else(|| part.index.to_string(), Clone::clone);
    if let Some(rest) = part.rest {
        // Shown in the unit of the fraction, as one number.
        let unit = Unit::parse(Quantity::Time, &part.unit).map_or(1.0, |unit| unit.factor);
        let sum = |row: &Vec<f64>| Some(row.get(part.index)? / unit + row.get(rest)?);
        values = rows.iter().filter_map(sum).filter(|v| v.is_finite()).collect();
        let _ = write!(name, " + {}", names.get(rest).map(String::as_str).unwrap_or_default());
    }
    let range = Range::of(values.iter().copied());
    let of = if part.quantity == Quantity::Duty { "of full duty" } else { "" };
    let per_turn = per_turn_of(part);
    let factor = Unit::parse(part.quantity, &part.unit).map_or(1.0, |unit| unit.factor);
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
        let unit = if of.is_empty() { si } else { of };
        let _ = write!(text, " = {} .. {} {unit}", short(range.low * factor), short(range.high * factor));
    }
    if part.quantity == Quantity::Time {
        let rate = super::timing::rate(&values) / factor;
        let _ = write!(text, ", {} samples a second", short(rate));
    } else if range.high > range.low {
        let _ = write!(text, "  {}", course(&values, range.low, range.high));
    }
    text
}

fn short(x: f64) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Vec<String> {
        text.split(';').map(str::to_owned).collect()
    }

    fn rows(row: impl Fn(f64) -> Vec<f64>) -> Vec<Vec<f64>> {
        (0..300).map(|k| row(f64::from(k))).collect()
    }

    #[test]
    fn an_arduino_log_is_proposed_with_duty_supply_and_units() {
        let rows = rows(|k| vec![10.0 * k, (255.0 * (0.1 * k).sin()).round(), 300.0 * (0.1 * k).sin()]);
        let proposal = propose(&names("t_ms;pwm;rpm"), &rows).unwrap();
        assert_eq!(proposal.options(), "--map time=t_ms:ms,duty=pwm:255,speed=rpm:rpm --supply-volts 12");
        assert!(proposal.preview[0].contains("100 samples a second"), "{:?}", proposal.preview);
        assert!(
            proposal.preview[2].contains("rad/s") && proposal.preview[2].contains('█'),
            "{:?}",
            proposal.preview
        );
    }

    #[test]
    fn names_that_a_shell_would_split_are_quoted_and_unusual_ones_are_numbers() {
        let rows = rows(|k| vec![0.01 * k, k.sin(), k.cos()]);
        let proposal = propose(&names("Time (s);Voltage (V);Position (rad)"), &rows).unwrap();
        assert_eq!(
            proposal.options(),
            "--map \"time=Time (s):s,voltage=Voltage (V):V,angle=Position (rad):rad\""
        );
        let rows: Vec<Vec<f64>> = rows.into_iter().map(|row| [row.as_slice(), &[row[2]]].concat()).collect();
        let proposal = propose(&names("t, s;u;u$;pos"), &rows).unwrap();
        assert_eq!(proposal.map, "time=0:s,voltage=u:V,angle=pos:rad");
    }

    #[test]
    fn counts_need_their_number_a_turn_and_a_column_of_the_supply_is_used() {
        let rows =
            rows(|k| vec![10_000.0 * k, (200.0 * k.sin()).round(), (90.0 * k).round(), 11.8 + 0.1 * k.sin()]);
        let proposal = propose(&names("micros;cmd;enc;Vbat"), &rows).unwrap();
        assert_eq!(
            proposal.options(),
            "--map time=micros:us,duty=cmd:255,angle=enc:counts,supply=Vbat:V --counts-per-rev 1320"
        );
        assert!(proposal.assumptions().contains("1320"));
    }

    #[test]
    fn a_setpoint_is_never_proposed_as_a_measurement() {
        let rows = rows(|k| vec![k, k.sin(), 5.0, k.sin()]);
        let proposal = propose(&names("t;pwm;speed_setpoint;speed"), &rows).unwrap();
        assert!(proposal.map.ends_with("speed=speed:rad/s"), "{}", proposal.map);
        assert_eq!(propose(&names("t;pwm;target_rpm;colour"), &rows), None);
    }

    #[test]
    fn a_servo_is_driven_by_its_target_and_the_volts_beside_it_are_its_supply() {
        let rows = rows(|k| vec![0.02 * k, (0.1 * k).sin(), (0.1 * k - 0.2).sin(), 12.0 + 0.1 * k.sin()]);
        let proposal = propose(&names("timestamp;goal_position;present_position;volts"), &rows).unwrap();
        assert_eq!(
            proposal.map,
            "time=timestamp:s,target=goal_position:rad,angle=present_position:rad,supply=volts:V"
        );
        assert_eq!(proposal.supply_volts, None);
    }

    #[test]
    fn a_table_without_time_is_proposed_with_a_rate() {
        let rows = rows(|k| vec![k.sin(), k.cos()]);
        let proposal = propose(&names("voltage_v;speed_rad_s"), &rows).unwrap();
        assert_eq!(proposal.rate.as_deref(), Some("100"));
        let rows: Vec<Vec<f64>> =
            rows.into_iter().map(|row| [&[9.0 + row[0].round()], row.as_slice()].concat()).collect();
        let proposal = propose(&names("dt_ms;voltage_v;speed_rad_s"), &rows).unwrap();
        assert_eq!(proposal.rate, None);
        assert!(proposal.map.starts_with("interval=dt_ms:ms,"), "{}", proposal.map);
    }

    #[test]
    fn seconds_and_nanoseconds_in_two_columns_are_one_time() {
        let rows = rows(|k| vec![1.7e9 + (0.01 * k).floor(), (k % 100.0) * 1e7, k.sin(), k.cos()]);
        let proposal = propose(&names("header.stamp.sec;header.stamp.nanosec;u;pos"), &rows).unwrap();
        assert!(
            proposal.map.starts_with("time=header.stamp.sec+header.stamp.nanosec:ns,"),
            "{}",
            proposal.map
        );
        assert!(proposal.preview[0].contains("100 samples a second"), "{:?}", proposal.preview);
    }

    #[test]
    fn full_duty_follows_from_the_values() {
        for (peak, step, full) in [
            (0.75, 0.01, "1"),
            (100.0, 1.0, "100"),
            (60.0, 10.0, "100"),
            (180.0, 1.0, "255"),
            (900.0, 1.0, "1000"),
        ] {
            let range = Range::of((0..=100).map(|k| (f64::from(k) / 100.0 * peak / step).round() * step));
            assert_eq!(full_duty(&range, None), full, "{peak}");
        }
    }
}
