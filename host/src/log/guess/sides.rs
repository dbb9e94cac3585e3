//! Several motors in one table: what drives the left one turns the left one.

use super::columns::Part;
use super::words;
use crate::log::units::Quantity;

/// Words that tell the motors of a machine apart.
const SIDES: [&str; 12] =
    ["left", "right", "l", "r", "front", "rear", "fl", "fr", "rl", "rr", "links", "rechts"];

/// Which motor a name is of: by a word, or by its number.
fn side(name: &str) -> Option<String> {
    // The digits of a unit number no motor: `speed [m/s2]`, `pwm (8bits)`.
    let name = &words::bracketed(name).0;
    let word = words::of(name).into_iter().find(|word| SIDES.contains(&word.as_str()));
    let digits = || {
        let number: String = name.chars().filter(char::is_ascii_digit).collect();
        (!number.is_empty()).then_some(number)
    };
    word.or_else(digits)
}

/// Whether two columns may be of one motor: neither tells another one than the other does.
pub(super) fn may_be_one(name: &str, other: &str) -> bool {
    side(name).zip(side(other)).is_none_or(|(one, other)| one == other)
}

/// Puts columns of the driven motor in the place of another one's: `among` tells the columns of a quantity, `unit_at` the unit of one.
pub(super) fn pair(
    parts: &mut Vec<Part>,
    names: &[String],
    among: &dyn Fn(Quantity) -> Vec<usize>,
    unit_at: &dyn Fn(Quantity, usize) -> String,
) {
    use Quantity::{Angle, Current, Duty, Speed, Target, Voltage};
    let drives = [Voltage, Duty, Target];
    let drive = drives.iter().find_map(|quantity| parts.iter().find(|part| part.quantity == *quantity));
    let Some((drives, driven)) = drive.and_then(|part| Some((part.quantity, side(&names[part.index])?)))
    else {
        return;
    };
    // Of several motors each has its own motion: that of the robot that they drive is none of theirs.
    let is_of_another = |k: &usize| side(&names[*k]).is_some_and(|own| own != driven);
    let is_own = |k: &usize| side(&names[*k]).as_ref() == Some(&driven);
    let motions = [Angle, Speed];
    let is_nobodys = |part: &Part| motions.contains(&part.quantity) && side(&names[part.index]).is_none();
    let own = motions.iter().find_map(|motion| Some((*motion, among(*motion).into_iter().find(is_own)?)));
    if let Some((quantity, index)) = own.filter(|_| among(drives).iter().any(is_of_another))
        && parts.iter().any(is_nobodys)
    {
        parts.retain(|part| !is_nobodys(part));
        if parts.iter().all(|part| part.quantity != quantity) {
            let (unit, guessed) = (unit_at(quantity, index), words::told(&names[index]).is_none());
            parts.push(Part { quantity, index, rest: None, unit, guessed, turn: None });
        }
    }
    for part in parts.iter_mut().filter(|part| [Duty, Target, Angle, Speed, Current].contains(&part.quantity))
    {
        if side(&names[part.index]).is_none_or(|own| own == driven) {
            continue;
        }
        let own = among(part.quantity).into_iter().find(|k| side(&names[*k]).as_ref() == Some(&driven));
        if let Some(index) = own {
            (part.index, part.unit) = (index, unit_at(part.quantity, index));
        }
    }
    // Another motor's current tells nothing of this one.
    parts.retain(|part| part.quantity != Current || side(&names[part.index]).is_none_or(|own| own == driven));
}

#[cfg(test)]
mod tests {
    use super::super::propose;

    #[test]
    fn a_motor_is_read_with_its_own_voltage() {
        let names = |text: &str| text.split(',').map(str::to_owned).collect::<Vec<_>>();
        for (table, wanted) in [
            ("time,left_pos,right_pos,right_volts,left_volts", "voltage=right_volts:V,angle=right_pos:rad"),
            ("t,v1,v2,angle2,angle1", "voltage=v1:V,angle=angle1:rad"),
            ("t,v1,angle1,current2", "voltage=v1:V,angle=angle1:rad"),
            ("time,voltage,left_pos,right_pos", "voltage=voltage:V,angle=left_pos:rad"),
            ("t,heading,u1,u2,pos,pos1,pos2", "voltage=u1:V,angle=pos1:rad"),
        ] {
            let map = propose(&names(table), &[]).unwrap().map;
            assert!(map.ends_with(wanted), "{map}");
        }
    }
}
