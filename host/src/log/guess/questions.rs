//! What a proposal leaves open and says: units that nothing tells, clocks of which there are two, signs that were given.

use super::columns::Part;
use super::{column, unit_names, words};
use crate::log::sample::Sample;
use crate::log::timing;
use crate::log::units::Quantity;
use crate::log::unsigned;

/// What is said of a duty, a voltage or a motion whose numbers got the signs that their type took away.
pub(super) fn given_sign(sample: &Sample, part: &Part) -> Option<String> {
    let (_, width) = sample.signed.iter().find(|(column, _)| *column == part.index)?;
    if part.quantity == Quantity::Time {
        return None;
    }
    let name = &sample.names.get(part.index)?;
    let (minus_one, column) = (width - 1.0, column(&sample.names, part.index));
    let otherwise = match part.quantity {
        Quantity::Duty => format!("; where it is full duty, write duty={column}:{minus_one}"),
        _ => String::new(),
    };
    Some(format!("{minus_one} in \"{name}\" is read as -1{otherwise}"))
}

/// What is asked of a duty, a voltage or a speed that may be one of 8 bits without its sign.
pub(super) fn lost_sign(sample: &Sample, part: &Part) -> Option<String> {
    let has_sign = [Quantity::Duty, Quantity::Voltage, Quantity::Speed].contains(&part.quantity);
    let values = sample.rows.iter().filter_map(|row| row.get(part.index)).copied().filter(|v| v.is_finite());
    let name = sample.names.get(part.index)?;
    (has_sign && unsigned::may_be_bytes(values)).then(|| {
        format!(
            "\"{name}\" stays near 0 and near 255, as negative numbers of 8 bits do without their sign: print it with its sign (int8_t) if \
             255 is -1"
        )
    })
}

/// What is asked where another column has the clock's name and other times: each signal has its own.
pub(super) fn other_clock(sample: &Sample, parts: &[Part]) -> Option<String> {
    let clock = parts.iter().find(|part| part.quantity == Quantity::Time)?.index;
    let name = sample.names.get(clock)?;
    let times = |k: usize| sample.rows.iter().map(move |row| row.get(k).copied().unwrap_or(f64::NAN));
    let interval = timing::median_interval(&times(clock).collect::<Vec<_>>());
    let furthest = |k: &usize| times(clock).zip(times(*k)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let other = (0..sample.names.len())
        .find(|k| *k != clock && sample.names[*k] == *name && furthest(k) > SAME_TIME * interval)?;
    Some(format!(
        "column {other} is called \"{name}\" too and tells other times, up to {:.0} % of an interval apart: where each signal has its own, \
         export them with one column of times",
        100.0 * furthest(&other) / interval
    ))
}

/// Times of one row that are further apart than this share of an interval are two.
const SAME_TIME: f64 = 0.01;

/// What is asked where a name tells a unit, as in `speed (furlongs)` or `speed [%]`, that is none of those known of such a quantity, so
/// that the one of `part` stands in its place.
pub(super) fn unknown_unit(name: &str, part: &Part) -> Option<String> {
    let taken = &part.unit;
    let of_another = |unit: &str| {
        [Quantity::Angle, Quantity::Speed].contains(&part.quantity)
            && unit_names::unit_named(unit).is_some_and(|(of, _)| of != part.quantity)
    };
    let unknown = |unit: &String| !unit.is_empty() && (!unit_names::is_unit(unit) || of_another(unit));
    let unit = words::bracketed(name).1.filter(unknown)?;
    Some(format!(
        "\"{unit}\" of the column \"{name}\" is no unit that is known here: {taken} stands in its place; put the right one, or its scale ({taken}*1000)"
    ))
}

/// What is said of a unit that nothing tells.
pub(super) fn guessed_unit(name: &str, part: &Part) -> Option<String> {
    let taken = &part.unit;
    let others = match (part.quantity, taken.as_str()) {
        (Quantity::Angle, "rad") => "deg, rev or counts",
        (Quantity::Angle, "deg") => "rad, rev or counts",
        (Quantity::Angle, _) => "rad, deg or rev",
        (Quantity::Time, "s") => "ms, us or ns (or --rate for it, where it numbers the rows)",
        (Quantity::Time, "ms") => "s, us or ns (or --rate for it, where it numbers the rows)",
        (Quantity::Time, _) => "s or ms (or --rate for it, where it numbers the rows)",
        _ => "rpm, deg/s, rev/s or counts/s",
    };
    let asked = part.guessed && unknown_unit(name, part).is_none();
    asked.then(|| format!("nothing tells the unit of \"{name}\": {taken} is a guess; put {others} in its place where it is that"))
}
