//! A duty of 8 bits that was printed without its sign: the motion tells it where the motor turns back, and otherwise it is asked.

use super::column;
use super::columns::Part;
use crate::log::sample::{Sample, numbers};
use crate::log::units::{INT8, Quantity};
use crate::log::unsigned;

/// Gives a duty its sign that is a byte without one, as the motor turns back at its large numbers; a direction beside it would have told it.
pub(super) fn give_sign(parts: &mut [Part], rows: &[Vec<f64>]) {
    let Some(place) = parts.iter().position(|part| part.quantity == Quantity::Duty) else { return };
    let duty = &parts[place];
    if duty.rest.is_some() || duty.unit.parse::<u32>().is_err() || has_direction(parts) {
        return;
    }
    let both = drive_and_motion(duty, parts, rows);
    if both.is_some_and(|(drive, motion)| unsigned::is_byte_without_sign(&drive, &motion)) {
        let duty = &mut parts[place];
        duty.unit = format!("{INT8}/{}", duty.unit);
    }
}

fn has_direction(parts: &[Part]) -> bool {
    parts.iter().any(|part| part.quantity == Quantity::Direction)
}

/// What drives the motor and how fast it moves, in the rows that have both; of an angle, its changes.
fn drive_and_motion(part: &Part, parts: &[Part], rows: &[Vec<f64>]) -> Option<(Vec<f64>, Vec<f64>)> {
    let of = |wanted: Quantity| parts.iter().find(|part| part.quantity == wanted);
    let motion = of(Quantity::Speed).or_else(|| of(Quantity::Angle))?;
    let both = |row: &Vec<f64>| Some((*row.get(part.index)?, *row.get(motion.index)?));
    let whole = rows.iter().filter_map(both).filter(|(a, b)| a.is_finite() && b.is_finite());
    let (mut drive, mut moved): (Vec<f64>, Vec<f64>) = whole.unzip();
    if motion.quantity == Quantity::Angle {
        moved = moved.windows(2).map(|pair| pair[1] - pair[0]).collect();
        drive.truncate(moved.len());
    }
    Some((drive, moved))
}

/// What is asked of a duty, a voltage or a speed that may be one of 8 bits without its sign.
pub(super) fn lost_sign(sample: &Sample, part: &Part, parts: &[Part]) -> Option<String> {
    let values = numbers(&sample.rows, part.index);
    let name = sample.names.get(part.index)?;
    let own = column(&sample.names, part.index);
    let is_near = unsigned::may_be_bytes(values.clone());
    if let Some((_, full)) = part.unit.split_once('/').filter(|(unit, _)| *unit == INT8) {
        let how = if is_near {
            "stays near 0 and near 255, and the motor turns back where it is near 255"
        } else {
            "goes from 0 to 255 at most, and the motor turns back where it is above 127"
        };
        return Some(format!(
            "\"{name}\" {how}: its negative numbers were printed as an unsigned byte, so 255 is read as -1; if it is not, write duty={own}:{full}"
        ));
    }
    let full = if part.unit.parse::<u32>().is_ok() { part.unit.as_str() } else { "100" };
    let is_duty = part.quantity == Quantity::Duty && part.rest.is_none();
    let may_be = if is_near {
        [Quantity::Duty, Quantity::Voltage, Quantity::Speed].contains(&part.quantity)
    } else {
        is_duty && unsigned::may_be_far_bytes(values)
    };
    // The sign of what drives the motor is known by the direction beside it, or by a motion that goes with it.
    let has_sign = || {
        has_direction(parts)
            || drive_and_motion(part, parts, &sample.rows)
                .is_some_and(|(drive, motion)| unsigned::goes_as_written(&drive, &motion))
    };
    if may_be && (part.quantity == Quantity::Speed || !has_sign()) {
        let how = if is_near { "stays near 0 and near 255" } else { "jumps between low and large numbers" };
        let otherwise = match part.quantity {
            Quantity::Duty => format!(": then write duty={own}:{INT8}/{full}"),
            _ => String::new(),
        };
        return Some(format!(
            "\"{name}\" {how}, as negative numbers of 8 bits do without their sign: print it with its sign (int8_t) if 255 is -1{otherwise}"
        ));
    }
    if !is_duty || has_direction(parts) {
        return None;
    }
    let (drive, motion) = drive_and_motion(part, parts, &sample.rows)?;
    unsigned::leaves_direction_open(&drive, &motion).then(|| {
        format!(
            "the motor turns both ways, and \"{name}\" is never negative and does not go with it: if it is a byte whose negative numbers lost \
             their sign, write duty={own}:{INT8}/{full}; else log the direction beside it (direction=COLUMN)"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::super::{propose, propose_for};
    use crate::log::sample::Sample;

    /// A duty as it is printed, and the speed of a motor that follows what it was.
    fn sample(drive: impl Fn(usize) -> f64, speed: impl Fn(usize) -> f64) -> Sample {
        let row = |k: usize| vec![0.01 * k as f64, drive(k).rem_euclid(256.0), speed(k)];
        Sample::of("t;pwm;rpm", (0..600).map(row).collect())
    }

    const LEVELS: [f64; 8] = [60.0, -40.0, 90.0, 0.0, -80.0, 30.0, 120.0, -120.0];

    #[test]
    fn a_duty_far_from_zero_gets_the_sign_that_a_byte_lost_where_the_motor_turns_back() {
        let drive = |k: usize| LEVELS[k / 40 % 8];
        let sample = sample(drive, |k| 3.0 * drive(k.saturating_sub(4)));
        let proposal = propose(&sample.names, &sample.rows).unwrap();
        assert!(proposal.map.contains("duty=pwm:int8/255"), "{}", proposal.map);
        let said = propose_for(&sample).unwrap().assumptions();
        assert!(said.contains("the motor turns back where it is above 127"), "{said}");
    }

    #[test]
    fn where_no_motion_decides_it_is_asked_whether_a_byte_lost_its_sign() {
        // A sine whose motion has no sign either; levels that the motion follows too late.
        let sine = sample(
            |k| (110.0 * (0.03 * k as f64).sin()).round(),
            |k| (110.0 * (0.03 * k as f64).sin()).abs(),
        );
        let late = sample(|k| LEVELS[k / 4 % 8], |k| LEVELS[(k + 18) / 4 % 8]);
        for (sample, said) in [(sine, "jumps between low and large"), (late, "does not go with it")] {
            let proposal = propose_for(&sample).unwrap();
            assert!(!proposal.map.contains("int8"), "{}", proposal.map);
            let asked = proposal.assumptions();
            assert!(asked.contains(said) && asked.contains("duty=pwm:int8/255"), "{asked}");
        }
        // A duty that the motion goes with has its sign.
        let half =
            sample(|k| (127.5 + LEVELS[k / 40 % 8]).round(), |k| 3.0 * LEVELS[k.saturating_sub(4) / 40 % 8]);
        assert!(!propose_for(&half).unwrap().assumptions().contains("int8"));
    }

    fn speaks_of_bytes(sample: &Sample) -> bool {
        let proposal = propose_for(sample).unwrap();
        format!("{} {}", proposal.map, proposal.assumptions()).contains("int8")
    }

    /// Levels near both ends of a byte, and levels that reach further.
    const NEAR: [f64; 8] = [5.0, 230.0, 10.0, 250.0, 20.0, 200.0, 30.0, 240.0];
    const FAR: [f64; 8] = [20.0, 180.0, 60.0, 230.0, 10.0, 190.0, 70.0, 240.0];

    #[test]
    fn a_duty_with_a_direction_beside_it_lost_no_sign() {
        // A lift takes little down and much up; another drive has any level either way.
        for (levels, rows) in [(NEAR, 40), (FAR, 160)] {
            let sign = |k: usize| if (k / rows).is_multiple_of(2) { 1.0 } else { -1.0 };
            let drive = |k: usize| levels[k / 40 % 8];
            let late = |k: usize| k.saturating_sub(4);
            let mut sample = sample(drive, |k| 3.0 * sign(late(k)) * drive(late(k)));
            assert!(speaks_of_bytes(&sample));
            sample.names.push("dir".into());
            sample.with_units.push("dir".into());
            sample.rows.iter_mut().enumerate().for_each(|(k, row)| row.push(sign(k)));
            assert!(!speaks_of_bytes(&sample));
        }
    }

    #[test]
    fn a_duty_that_the_motion_goes_with_as_it_is_written_is_not_asked_about() {
        for (levels, encoder) in [(NEAR, 1.0), (FAR, 1.0), (FAR, -1.0)] {
            let drive = |k: usize| levels[k / 40 % 8];
            assert!(!speaks_of_bytes(&sample(drive, |k| 3.0 * encoder * drive(k.saturating_sub(4)))));
        }
    }
}
