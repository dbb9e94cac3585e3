//! A guess at which column of a foreign table is what: never applied by itself, proposed as options that work as pasted.
//!
//! Names tell most ([`words`]); the values decide where they leave something open: whole numbers up to 255 are a duty, a
//! time in steps of 10 counts milliseconds, a voltage that never moves beside a duty is the supply.

mod bridge;
pub(super) mod by_numbers;
mod bytes;
mod channels;
mod clocks;
mod column_units;
mod columns;
mod companions;
mod drive;
mod duty_range;
mod example;
mod garbled_columns;
mod leads;
mod look;
mod made;
mod one_motion;
mod preview;
mod proposal;
mod questions;
mod ranges;
mod registers;
mod settle;
mod sides;
mod since_before;
mod spelling;
mod symbols;
mod time_steps;
mod timed;
mod turns;
pub mod unit_names;
mod vocabulary;
pub mod words;

pub(super) use channels::channels_question;
pub use columns::{Part, parts};
pub(super) use drive::half_question;
pub(super) use example::{example, unmeasured};
pub(super) use garbled_columns::{garbled_question, left_out};
pub use look::{Look, look};
use preview::preview;
pub use proposal::{Known, Proposal};
pub(super) use questions::{
    error_question, levels_question, loop_question, numbers_question, sampled_question, steady_question,
};
use questions::{
    given_sign, guessed_unit, other_clock, other_rate, size_of_an_error, steady_states, taken_for,
    unknown_unit,
};

use timed::parts_of;
pub(crate) use turns::ASSUMED_COUNTS;
use turns::Turn;

use super::formats::interval;
use super::sample::Sample;
use super::units::{PerTurn, Quantity, Unit};

/// The text as one word of a command line, in any usual shell.
pub fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_=:,./+-%@".contains(c);
    if !text.is_empty() && text.chars().all(plain) { text.to_owned() } else { format!("\"{text}\"") }
}

/// Guesses from the beginning of a table, without the columns that are no measurements.
pub(super) fn propose_for(sample: &Sample) -> Option<Proposal> {
    let Some((said, rest)) = left_out(sample) else { return propose_from(sample) };
    let mut proposal = propose_from(&rest)?;
    proposal.unknown_units.insert(0, format!("left out is what measures nothing: {said}"));
    Some(proposal)
}

/// The same from all columns.
fn propose_from(sample: &Sample) -> Option<Proposal> {
    if sample.names.is_empty() {
        return by_numbers::propose_with(&parts_of(sample), &sample.rows, sample.stamped);
    }
    let parts = parts_of(sample);
    let mut proposal =
        proposal(&sample.names, &parts, &sample.rows, sample.stamped)?.at_the_rate_of(sample, &parts);
    if proposal.rate.is_some() {
        proposal.unknown_units.extend(sample.clock.as_ref().map(interval::Clock::question));
    }
    proposal.preview.extend(preview::unused(&sample.names, &sample.rows, &parts));
    proposal.unknown_units.extend(steady_states(sample, &parts));
    proposal.unknown_units.extend(other_clock(sample, &parts));
    proposal.unknown_units.extend(parts.iter().filter_map(|part| other_rate(sample, part)));
    proposal.unknown_units.extend(parts.iter().filter_map(|part| given_sign(sample, part)));
    proposal.unknown_units.extend(parts.iter().filter_map(|part| bytes::lost_sign(sample, part, &parts)));
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
    if words::is_torque(&sample.with_units[index]) {
        return Some(format!(
            "{} is a torque, which follows from the voltage and does not tell it: a motor is fitted here as its voltage drives it, so log the \
             motor's voltage or duty with its motion, also where a controller of the current or the torque gives it",
            column(&sample.names, index)
        ));
    }
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
    let proposal = proposal(&sample.names, &parts, &sample.rows, sample.stamped)?;
    Some(proposal.at_the_rate_of(sample, &parts).options())
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
        Some((column(&sample.names, part.index), part.unit.clone(), (part.index, part.rest)))
    };
    // One mapping must fit both files: times of other names do where they stand in the same place.
    let by_number = match (time(input, &drives), time(output, &moves)) {
        (Some((name, unit, place)), Some((other, other_unit, other_place))) => {
            if unit != other_unit || name != other && (place != other_place || place.1.is_some()) {
                return None;
            }
            (name != other).then(|| (format!("time={name}:"), format!("time={}:", place.0)))
        }
        (None, None) => None,
        _ => return None,
    };
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
    let of_first = match by_number {
        Some((name, number)) => first.map.replacen(&name, &number, 1),
        None => first.map.clone(),
    };
    Some(Proposal {
        map: format!("{of_first},{}", second.map),
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
        counts_per_rev: needs(PerTurn::Counts)
            .then(|| turn.map(|turn| turn.taken.round()).or(wrap).unwrap_or(ASSUMED_COUNTS).to_string()),
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
mod tests;
#[cfg(test)]
mod words_tests;
