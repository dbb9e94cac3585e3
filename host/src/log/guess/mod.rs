//! A guess at which column of a foreign table is what: never applied by itself, proposed as options that work as pasted.
//!
//! Names tell most ([`words`]); the values decide where they leave something open: whole numbers up to 255 are a duty, a
//! time in steps of 10 counts milliseconds, a voltage that never moves beside a duty is the supply.

mod bridge;
pub(super) mod by_numbers;
mod channels;
mod clocks;
mod columns;
mod companions;
mod drive;
mod duty_range;
mod example;
mod leads;
mod look;
mod one_motion;
mod preview;
mod questions;
mod registers;
mod sides;
mod symbols;
mod turns;
pub mod unit_names;
mod vocabulary;
pub mod words;

use std::fmt::Write as _;

pub(super) use channels::channels_question;
pub use columns::{Part, parts};
pub(super) use drive::half_question;
pub(super) use example::example;
pub use look::{Look, look};
use preview::preview;
pub(super) use questions::{
    error_question, levels_question, loop_question, numbers_question, sampled_question,
};
use questions::{
    given_sign, guessed_unit, lost_sign, other_clock, other_rate, size_of_an_error, steady_states, taken_for,
    unknown_unit,
};

use turns::Turn;

use super::sample::Sample;
use super::units::{PerTurn, Quantity, Unit};

/// Options that would read a table, and what they would make of it.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
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
    /// What is asked of columns whose unit is not known.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unknown_units: Vec<String>,
}

impl Proposal {
    /// The options, quoted for any shell.
    pub fn options(&self) -> String {
        let map = (!self.map.is_empty()).then(|| format!(" --map {}", quoted(&self.map)));
        let mut text = map.unwrap_or_default();
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
        text.trim_start().to_owned()
    }

    /// The same where the person told some of it: what is `known` needs no assumption, and a supply that was told none that is guessed.
    #[must_use]
    pub fn with_known(mut self, known: Known) -> Self {
        let assumed = [
            (known.supply_volts, &mut self.supply_volts),
            (known.counts_per_rev, &mut self.counts_per_rev),
            (known.metres_per_rev, &mut self.metres_per_rev),
            (known.rate, &mut self.rate),
        ];
        for (_, assumption) in assumed.into_iter().filter(|(known, _)| *known) {
            *assumption = None;
        }
        if known.supply_volts {
            let parts: Vec<&str> = self.map.split(',').filter(|part| !part.starts_with("supply=")).collect();
            self.map = parts.join(",");
        }
        self
    }

    /// The options, and in brackets what a person has to put in the place of an assumption.
    pub fn told(&self) -> String {
        let assumptions = self.assumptions();
        if assumptions.is_empty() { self.options() } else { format!("{} ({assumptions})", self.options()) }
    }

    /// What a person has to put in the place of an assumption.
    pub fn assumptions(&self) -> String {
        let mut all = self.unknown_units.clone();
        if let Some(volts) = &self.supply_volts {
            all.push(format!("put your supply's voltage in the place of {volts}"));
        }
        let duty = self.map.split(',').find_map(|part| part.strip_prefix("duty=")?.rsplit_once(':'));
        // Percent where the column says so; else a pulse-width register may have any number for full duty.
        let is_told = |column: &str, full: &str| {
            full == "1"
                || full == "100" && words::said(column).unit == Some(full)
                || duty_range::told(column).is_some_and(|told| told.to_string() == full)
        };
        if let Some((_, full)) = duty.filter(|(column, full)| !is_told(column, full)) {
            all.push(match full.split_once("..") {
                Some(_) => format!("put the pulses of no and of full duty, us, in the place of {full}"),
                None => {
                    let number = full.rsplit_once('/').map_or(full, |(_, number)| number);
                    format!("put the number that is full duty in the place of {number}")
                }
            });
        }
        if self.map.contains(&format!(":{}", vocabulary::ELECTRICAL)) {
            all.push("put the motor's pole pairs in the place of 7".into());
        }
        if self.map.contains(":rev/4096") {
            all.push("put the steps of one turn of the servo in the place of 4096".into());
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

/// What a person told beside the table, so that nothing is assumed in its place.
#[derive(Debug, Clone, Copy, Default)]
pub struct Known {
    /// The supply's voltage.
    pub supply_volts: bool,
    /// The counts per turn of the output shaft.
    pub counts_per_rev: bool,
    /// The metres per turn of the output shaft.
    pub metres_per_rev: bool,
    /// The samples per second.
    pub rate: bool,
}

/// The text as one word of a command line, in any usual shell.
pub fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_=:,./+-%@".contains(c);
    if !text.is_empty() && text.chars().all(plain) { text.to_owned() } else { format!("\"{text}\"") }
}

/// Guesses from the beginning of a table.
pub(super) fn propose_for(sample: &Sample) -> Option<Proposal> {
    if sample.names.is_empty() {
        return by_numbers::propose(&sample.rows);
    }
    let parts = parts(&sample.with_units, &sample.rows);
    let mut proposal = proposal(&sample.names, &parts, &sample.rows, sample.stamped)?;
    if let (Some(rate), Some(told)) = (&mut proposal.rate, sample.rate) {
        *rate = told.to_string();
    }
    proposal.preview.extend(preview::unused(&sample.names, &sample.rows, &parts));
    proposal.unknown_units.extend(steady_states(sample, &parts));
    proposal.unknown_units.extend(other_clock(sample, &parts));
    proposal.unknown_units.extend(parts.iter().filter_map(|part| other_rate(sample, part)));
    proposal.unknown_units.extend(parts.iter().filter_map(|part| given_sign(sample, part)));
    proposal.unknown_units.extend(parts.iter().filter_map(|part| lost_sign(sample, part)));
    proposal.unknown_units.extend(parts.iter().filter_map(|part| size_of_an_error(sample, part)));
    Some(proposal)
}

/// Guesses from the names and the first rows of a table; fields that are no numbers are NaN. None where too little is recognised:
/// what drives the motor and what it does must both be.
pub fn propose(names: &[String], rows: &[Vec<f64>]) -> Option<Proposal> {
    proposal(names, &parts(names, rows), rows, false)
}

/// Where nothing but an effort may drive the motor: what that leaves open, and the options for either meaning.
pub(super) fn effort_question(sample: &Sample) -> Option<String> {
    let index = sample.with_units.iter().position(|name| words::said(name).effort)?;
    let meaning = |as_if: &str| options_as_if(sample, &[(index, as_if)]);
    let (volts, duty) = (meaning("voltage [V]")?, meaning("duty [%]")?);
    Some(format!(
        "{} is a torque in ROS, and whatever a drive is commanded elsewhere, so nothing here surely tells the voltage: log the motor's voltage \
         or duty with its motion; if this is one of them, say {} where it is volts, {} where it is percent of full duty",
        column(&sample.names, index),
        volts,
        duty
    ))
}

/// The options that a table would be read with if those columns were called so; none where that is too little.
fn options_as_if(sample: &Sample, called: &[(usize, &str)]) -> Option<String> {
    let mut with_units = sample.with_units.clone();
    for (index, name) in called {
        (*name).clone_into(&mut with_units[*index]);
    }
    let parts = parts(&with_units, &sample.rows);
    proposal(&sample.names, &parts, &sample.rows, sample.stamped).map(|proposal| proposal.options())
}

/// Whether columns of these names may be all that a fit needs, if an effort drives the motor.
pub(super) fn may_suffice(names: &[String]) -> bool {
    let as_if = |name: &String| if words::said(name).effort { "voltage".to_owned() } else { name.clone() };
    propose(&names.iter().map(as_if).collect::<Vec<_>>(), &[]).is_some()
}

/// Whether the first table has only what drives the motor, and the second only what it does.
pub(super) fn are_apart(input: &Sample, output: &Sample) -> bool {
    use Quantity::{Angle, Duty, Speed, Voltage};
    let has = |sample: &Sample, quantities: &[Quantity]| {
        parts(&sample.with_units, &sample.rows).iter().any(|part| quantities.contains(&part.quantity))
    };
    let (drives, moves) = ([Duty, Voltage], [Angle, Speed]);
    has(input, &drives) && !has(input, &moves) && has(output, &moves) && !has(output, &drives)
}

/// Guesses from the beginnings of two tables, the first of what drives the motor, the second of what it does.
pub(super) fn propose_apart(input: &Sample, output: &Sample) -> Option<Proposal> {
    use Quantity::{Angle, Current, Duty, Interval, Speed, Target, Time, Voltage};
    // Columns without names go by their places.
    let (input, output) = (&input.with_places(), &output.with_places());
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
    let taken = drive::drive_alone(input, &drives);
    drives.extend(taken.as_ref().map(|(part, _)| part.clone()));
    let alone = drive::motion_alone(output, &moves);
    moves.retain(|part| [Angle, Speed, Current].contains(&part.quantity));
    moves.extend(alone.as_ref().map(|(part, _)| part.clone()));
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
        unknown_units: [
            first.unknown_units,
            second.unknown_units,
            taken.into_iter().chain(alone).map(|(_, said)| said).collect(),
        ]
        .concat(),
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
    let turn = parts.iter().find_map(|part| part.turn);
    let wrap = parts.iter().find_map(|part| turns::of_wrap(part, rows));
    let duty_alone = (has(Quantity::Duty) || has(Quantity::Target)) && !has(Quantity::Supply);
    let map: Vec<String> = parts
        .iter()
        .map(|part| {
            let rest = |rest| format!("{}{}", part.sign(), column(names, rest));
            let rest = part.rest.map(rest).unwrap_or_default();
            format!("{}={}{rest}:{}", part.quantity, column(names, part.index), part.unit)
        })
        .collect();
    Proposal {
        map: map.join(","),
        supply_volts: duty_alone.then(|| "12".into()),
        counts_per_rev: needs(PerTurn::Counts).then(|| {
            turn.map(|turn| turn.taken.round()).or(wrap).map_or("1320".into(), |turn| turn.to_string())
        }),
        metres_per_rev: needs(PerTurn::Metres).then(|| "0.008".into()),
        rate: (!stamped && !has(Quantity::Time) && !has(Quantity::Interval)).then(|| "100".into()),
        preview: parts.iter().map(|part| preview(names, rows, part)).collect(),
        unknown_units: parts
            .iter()
            .filter_map(|part| unknown_unit(&names[part.index], part))
            .chain(parts.iter().filter_map(|part| guessed_unit(&names[part.index], part)))
            .chain(parts.iter().filter_map(|part| taken_for(names, part, parts, rows)))
            .chain(parts.iter().filter_map(|part| drive::said_of_drive(names, rows, part)))
            .chain(parts.iter().filter_map(|part| duty_range::question(names, rows, part)))
            .chain(turn.map(Turn::said))
            .chain(wrap.filter(|_| turn.is_none()).map(turns::said_of_wrap))
            .chain(bridge::question(parts, names, rows))
            .collect(),
    }
}

fn per_turn_of(part: &Part) -> Option<PerTurn> {
    Unit::parse(part.quantity, &part.unit).ok()?.per_turn
}

/// A column as a mapping names it: by its name where a shell and the mapping leave that alone, else by its number.
fn column(names: &[String], index: usize) -> String {
    let name = names.get(index).map(String::as_str).unwrap_or_default();
    let is_difference =
        name.contains('-') && names.iter().any(|other| name.starts_with(&format!("{other}-")));
    let awkward = name.is_empty()
        || is_difference
        || name.contains([',', '+', '"', '\'', '$', '`', '\\', '!', '\u{fffd}'])
        || name.parse::<f64>().is_ok()
        || name != name.trim()
        || names.iter().filter(|other| *other == name).count() > 1;
    if awkward { index.to_string() } else { name.to_owned() }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

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
    fn a_duty_that_goes_with_the_size_of_an_error_is_asked_for_its_sign() {
        let swing = |k: f64| 20.0 * (0.1 * k).sin();
        let said = |duty: fn(f64) -> f64| {
            let rows =
                rows(|k| vec![10.0 * k, 45.0, 45.0 - swing(k), duty(15.0 * swing(k)).clamp(-255.0, 255.0)]);
            let names = names("ms;target;current;pwm");
            let sample = Sample {
                with_units: names.clone(),
                names,
                rows,
                texts: Vec::new(),
                stamped: false,
                signed: Vec::new(),
                rate: None,
            };
            let part = Part {
                quantity: Quantity::Duty,
                index: 3,
                rest: None,
                unit: "255".into(),
                guessed: false,
                turn: None,
            };
            size_of_an_error(&sample, &part)
        };
        assert!(said(f64::abs).is_some_and(|said| said.contains("\"pwm\" is never negative")));
        assert_eq!(said(|u| u), None);
        assert_eq!(said(|u| u + 255.0), None);
    }

    #[test]
    fn a_servo_that_is_told_degrees_is_no_servo_of_many_turns() {
        let rows = rows(|k| vec![0.02 * k, 90.5 * (0.1 * k).sin(), 90.1 * (0.1 * k - 0.2).sin()]);
        let proposal = propose(&names("timestamp;goal_position;present_position"), &rows).unwrap();
        assert_eq!(proposal.map, "time=timestamp:s,target=goal_position:deg,angle=present_position:deg");
    }

    #[test]
    fn pins_of_a_bridge_are_no_voltages_and_steps_of_a_counter_no_angle() {
        let pin = |on: bool| f64::from(u8::from(on));
        let sign = |k: f64| (0.1 * k).sin();
        let row = |k: f64| {
            vec![k, pin(sign(k) > 0.0), pin(sign(k) < 0.0), (200.0 * sign(k).abs()).round(), 9.0 * k]
        };
        let proposal = propose(&names("ms;in1;in2;ena;count"), &rows(row)).unwrap();
        assert_eq!(proposal.map, "time=ms:ms,duty=ena:255,direction=in1:sign,angle=count:counts");
        let rows = rows(|k| vec![10.0 * k, (100.0 * sign(k)).round(), (5.0 * sign(k)).round()]);
        // What was counted since the row before is a speed.
        let proposal = propose(&names("t_ms;pwm;delta_count"), &rows).unwrap();
        assert_eq!(proposal.map, "time=t_ms:ms,duty=pwm:100,speed=delta_count:counts/s*100");
    }

    #[test]
    fn what_a_person_told_is_not_assumed_and_multiples_are_divided() {
        let rows =
            rows(|k| vec![4.0 * k, (200.0 * (0.1 * k).sin()).round(), 900.0 * (0.1 * k - 0.3).sin(), 80.0]);
        let proposal = propose(&names("ms;pwm;speed_rpm_x10;battery"), &rows).unwrap();
        assert_eq!(proposal.map, "time=ms:ms,duty=pwm:255,speed=speed_rpm_x10:rpm/10,supply=battery:V");
        let told = Known { supply_volts: true, ..Known::default() };
        assert_eq!(
            proposal.with_known(told).options(),
            "--map time=ms:ms,duty=pwm:255,speed=speed_rpm_x10:rpm/10"
        );
        let rows: Vec<Vec<f64>> = rows.iter().map(|row| row.iter().map(|v| v.round()).collect()).collect();
        let counted = propose(&names("ms;pwm;counts"), &rows).unwrap();
        assert!(
            counted.options().contains("--counts-per-rev") && counted.options().contains("--supply-volts")
        );
        let told = Known { supply_volts: true, counts_per_rev: true, ..Known::default() };
        assert_eq!(counted.with_known(told).options(), "--map time=ms:ms,duty=pwm:255,angle=counts:counts");
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
    fn angle_and_speed_that_are_one_motion_tell_each_others_units() {
        let wave = |k: f64| 40.0 * (0.02 * k).sin();
        let change = |k: f64| 0.8 * (0.02 * k).cos() * 100.0;
        for (table, [of_angle, of_speed], map, counts) in [
            (
                "ms;pwm;position;velocity",
                [60.0, 60.0],
                "angle=position:counts,speed=velocity:counts/s",
                "1320",
            ),
            ("ms;pwm;enc;rpm", [500.0, 60.0], "angle=enc:counts,speed=rpm:rpm", "500"),
            ("ms;pwm;enc;velocity", [558.0, TAU], "angle=enc:counts,speed=velocity:rad/s", "558"),
            ("ms;pwm;pos_deg;speed", [360.0, 60.0], "angle=pos_deg:deg,speed=speed:rpm", ""),
            ("ms;pwm;pos;speed [rpm]", [1.0, 60.0], "angle=pos:rev,speed=speed [rpm]:rpm", ""),
            ("ms;pwm;pos;speed", [1.0, 1.0], "angle=pos:rad,speed=speed:rad/s", ""),
        ] {
            let row = |k: f64| {
                let turns = of_angle * wave(k);
                let angle = if of_angle > 400.0 || of_angle == of_speed && of_angle > 1.0 {
                    turns.round()
                } else {
                    turns
                };
                vec![10.0 * k, (200.0 * (0.1 * k).sin()).round(), angle, of_speed * change(k)]
            };
            let proposal = propose(&names(table), &rows(row)).unwrap();
            assert!(proposal.map.ends_with(map), "{}", proposal.map);
            let told = proposal.counts_per_rev.as_deref().unwrap_or_default();
            let near = |a: &str, b: &str| {
                a == b
                    || a.parse::<f64>()
                        .is_ok_and(|a| b.parse::<f64>().is_ok_and(|b| (a / b - 1.0).abs() < 0.01))
            };
            assert!(near(told, counts), "{told} {counts}");
        }
    }

    #[test]
    fn pulses_of_a_servo_are_no_clock_and_the_output_is_what_turns() {
        let swing = |k: f64| (0.1 * k).sin();
        let pulses = rows(|k| vec![10.0 * k, 1500.0 + (400.0 * swing(k)).round(), 60.0 * swing(k)]);
        let proposal = propose(&names("ms;servo_us;rpm"), &pulses).unwrap();
        assert_eq!(proposal.map, "time=ms:ms,duty=servo_us:1500..2000,speed=rpm:rpm");
        let geared = rows(|k| vec![0.01 * k, 9.0 * swing(k), 1800.0 * swing(k), 60.0 * swing(k)]);
        let proposal = propose(&names("t;V;motor_rpm;output_rpm"), &geared).unwrap();
        assert_eq!(proposal.map, "time=t:s,voltage=V:V,speed=output_rpm:rpm");
        let counted = rows(|k| vec![10.0 * k, (200.0 * swing(k)).round(), (50.0 * swing(k)).round()]);
        let proposal = propose(&names("ms;pwm;ticks_per_loop"), &counted).unwrap();
        assert_eq!(proposal.map, "time=ms:ms,duty=pwm:255,speed=ticks_per_loop:counts/s*100");
    }

    #[test]
    fn what_was_counted_since_the_row_before_is_a_speed_with_an_interval_too() {
        let rows = rows(|k| vec![10.0, (200.0 * (0.1 * k).sin()).round(), (5.0 * (0.1 * k).sin()).round()]);
        let proposal = propose(&names("dt_ms;pwm;delta_ticks"), &rows).unwrap();
        assert_eq!(proposal.map, "interval=dt_ms:ms,duty=pwm:255,speed=delta_ticks:counts/s*100");
    }

    #[test]
    fn a_set_value_that_the_angle_goes_far_beyond_is_no_target_and_the_number_of_a_row_no_current() {
        let sent = |k: f64| (200.0 * (0.05 * k).sin()).round();
        let counted = rows(|k| vec![10.0 * k, sent(k), 40.0 * k]);
        assert_eq!(propose(&names("ms;set;enc"), &counted), None);
        let reached = rows(|k| vec![10.0 * k, sent(k), sent(k - 3.0)]);
        assert!(propose(&names("ms;set;enc"), &reached).is_some_and(|p| p.map.contains("target=set")));
        let numbered = rows(|k| vec![k, 10.0 * k, sent(k), 30.0 * (0.05 * k).sin()]);
        let proposal = propose(&names("i;ms;pwm;rpm"), &numbered).unwrap();
        assert_eq!(proposal.map, "time=ms:ms,duty=pwm:255,speed=rpm:rpm");
    }

    #[test]
    fn the_fine_angle_behind_the_gear_is_the_motion() {
        let angle = |k: f64| 1500.0 * (0.02 * k).sin();
        let apart = rows(|k| {
            vec![
                10.0 * k,
                (200.0 * (0.1 * k).sin()).round(),
                (angle(k) / 360.0).floor(),
                angle(k).rem_euclid(360.0),
            ]
        });
        let map = propose(&names("ms;pwm;turns;deg"), &apart).unwrap().map;
        assert!(map.ends_with("angle=deg:deg"), "{map}");
        // 30 turns of the motor are one of the shaft.
        let rpm = |k: f64| 30.0 * 1500.0 * 0.02 * (0.02 * k).cos() * 100.0 / 6.0;
        let geared = rows(|k| vec![0.01 * k, 6.0 * (0.02 * k).cos(), rpm(k), angle(k)]);
        let map = propose(&names("t;u;motor_rpm;out_deg"), &geared).unwrap().map;
        assert_eq!(map, "time=t:s,voltage=u:V,angle=out_deg:deg");
        let pins = rows(|k| {
            vec![
                10.0 * k,
                f64::from(u8::from((0.1 * k).sin() > 0.0)),
                (200.0 * (0.1 * k).sin().abs()).round(),
                9.0 * k,
            ]
        });
        let map = propose(&names("ms;in1;en;count"), &pins).unwrap().map;
        assert_eq!(map, "time=ms:ms,duty=en:255,direction=in1:sign,angle=count:counts");
    }

    #[test]
    fn an_angle_in_tenths_is_in_degrees() {
        let tenths =
            rows(|k| vec![0.01 * k, 6.0 * (0.02 * k).sin(), (9000.0 * (0.02 * k).sin()).round() / 10.0]);
        let proposal = propose(&names("t;u;position"), &tenths).unwrap();
        assert!(proposal.map.ends_with("angle=position:deg"), "{}", proposal.map);
        assert!(proposal.assumptions().contains("deg is a guess"));
    }

    #[test]
    fn columns_that_no_name_tells_are_proposed_by_their_numbers() {
        let mut speed = 0.0;
        let rows = (0..300).map(|k| {
            let volts = [6.0, -3.0, 0.0, 4.5][k / 50 % 4];
            speed += 0.1 * (2.0 * volts - speed);
            vec![0.01 * k as f64, volts, 0.01 * k as f64, speed]
        });
        let sample = Sample {
            with_units: names("time;value;time;value"),
            names: names("time;value;time;value"),
            rows: rows.collect(),
            texts: Vec::new(),
            stamped: false,
            signed: Vec::new(),
            rate: None,
        };
        assert_eq!(propose_for(&sample), None);
        let asked = questions::numbers_question(&sample).unwrap();
        assert!(asked.contains("--map time=0:s,voltage=1:V,speed=3:rad/s"), "{asked}");
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
}
