//! What the columns that were taken for a quantity each settle among each other: units that one tells of another, two that are one quantity
//! together, and those that measure nothing beside others.

use super::clocks::{add_fractions, rate_of};
use super::column_units::unit_of;
use super::columns::Part;
use super::one_motion::make_one;
use super::ranges::Range;
use super::time_steps::tell_ticks;
use super::{bridge, bytes, sides, words};
use crate::log::direction;
use crate::log::sample::numbers;
use crate::log::units::Quantity;

/// Settles the `parts` of a table; `quantities` are what each of its columns may measure.
pub(super) fn settle(
    parts: &mut Vec<Part>,
    names: &[String],
    said: &[words::Said],
    rows: &[Vec<f64>],
    quantities: &[Option<(Quantity, u8)>],
) {
    let values = |index: usize| numbers(rows, index);
    let counted = || (0..names.len()).find(|k| said[*k].since_before && Range::of(values(*k)).whole);
    if parts.iter().all(|part| ![Quantity::Angle, Quantity::Speed].contains(&part.quantity))
        && let Some(index) = counted()
        && let Some(rate) = rate_of(parts, rows)
    {
        let unit = format!("counts/s*{rate}");
        parts.push(Part { quantity: Quantity::Speed, index, rest: None, unit, guessed: false, turn: None });
    }
    let unit_at = |quantity: Quantity, index: usize| {
        unit_of(quantity, said[index].unit, &values(index).collect::<Vec<_>>())
    };
    let among = |quantity: Quantity| {
        let of = |k: &usize| quantities[*k].is_some_and(|(q, _)| q == quantity);
        (0..names.len()).filter(of).collect::<Vec<_>>()
    };
    sides::pair(parts, names, &among, &unit_at);
    // A servo's angle is told in the unit of its target.
    let of_target = parts.iter().find(|part| part.quantity == Quantity::Target).map(|part| part.unit.clone());
    let angle = parts.iter_mut().find(|part| part.quantity == Quantity::Angle);
    if let (Some(unit), Some(angle)) = (of_target, angle)
        && said[angle.index].unit.is_none()
    {
        angle.unit = unit;
    }
    add_fractions(parts, names, rows);
    tell_ticks(parts, names, rows);
    make_one(parts, said, rows);
    bridge::join(parts, names, rows);
    leave_out_needless(parts, rows);
}

/// Takes those out that tell nothing beside the others, and gives a duty that stays the sign of its bytes where they lost it.
fn leave_out_needless(parts: &mut Vec<Part>, rows: &[Vec<f64>]) {
    let values = |index: usize| numbers(rows, index);
    // A direction is one only beside a drive, or a speed, that has no sign of its own.
    let unsigned = parts.iter().any(|part| {
        [Quantity::Voltage, Quantity::Duty, Quantity::Speed].contains(&part.quantity)
            && part.rest.is_none()
            && Range::of(values(part.index)).low >= 0.0
    });
    parts.retain(|part| {
        let is_one = || direction::signs(&values(part.index).collect::<Vec<_>>()).is_ok();
        part.quantity != Quantity::Direction || unsigned && is_one()
    });
    // A clock adds up no errors.
    if parts.iter().any(|part| part.quantity == Quantity::Time) {
        parts.retain(|part| part.quantity != Quantity::Interval);
    }
    // What was measured nearer to the motor.
    let duty = parts.iter().position(|part| part.quantity == Quantity::Duty);
    if let (Some(duty), true) = (duty, parts.iter().any(|part| part.quantity == Quantity::Voltage)) {
        parts.remove(duty);
    }
    bytes::give_sign(parts, rows);
    // A current that never flows was not measured.
    parts.retain(|part| {
        part.quantity != Quantity::Current || rows.is_empty() || values(part.index).any(|value| value != 0.0)
    });
    let place = |wanted: Quantity| parts.iter().position(|part| part.quantity == wanted);
    // Of two motions one that never changes is none.
    let still = |part: &Part| {
        let range = Range::of(values(part.index));
        !rows.is_empty() && range.high <= range.low
    };
    if let (Some(angle), Some(speed)) = (place(Quantity::Angle), place(Quantity::Speed)) {
        let is_still = [angle, speed].map(|k| still(&parts[k]));
        if is_still != [true, true] {
            let mut place = 0;
            parts.retain(|_| {
                place += 1;
                !(place - 1 == angle && is_still[0] || place - 1 == speed && is_still[1])
            });
        }
    }
}
