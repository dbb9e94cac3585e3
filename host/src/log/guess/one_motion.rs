//! An angle and a speed of one motion: either tells the unit of the other, and where no unit makes them one, the speed is left out.

use std::f64::consts::TAU;

use super::column_units::FEWEST_COUNTS;
use super::columns::Part;
use super::turns::Turn;
use super::words;
use crate::log::units::{Quantity, Unit};
use crate::log::wraps;

/// The units of an angle and its speed in which the speed is so many times the change of the angle.
pub(super) fn pairs_of(ratio: f64) -> impl Iterator<Item = (&'static str, &'static str)> {
    // Units of a turn, by the size of one.
    const ANGLES: [(&str, f64); 3] = [("rad", TAU), ("deg", 360.0), ("rev", 1.0)];
    let pairs = ANGLES.iter().flat_map(|angle| SPEEDS.iter().map(move |speed| (angle, speed)));
    pairs
        .filter(move |((_, angle), (_, speed))| (ratio * angle / speed - 1.0).abs() < NEAR)
        .map(|((angle, _), (speed, _))| (*angle, *speed))
}

/// Makes an angle and a speed among `parts` one motion: in units in which they are, or without the speed; the angle keeps what the speed says
/// of a turn of its counts. Of each column is `said` what its name says.
pub(super) fn make_one(parts: &mut Vec<Part>, said: &[words::Said], rows: &[Vec<f64>]) {
    let turn = agree(parts, said, rows);
    leave_out_other_motion(parts, rows);
    if let Some(angle) = parts.iter_mut().find(|part| part.quantity == Quantity::Angle) {
        angle.turn = turn;
    }
}

/// Units of a speed, by the size of a turn a second.
const SPEEDS: [(&str, f64); 4] = [("rad/s", TAU), ("deg/s", 360.0), ("rev/s", 1.0), ("rpm", 60.0)];

/// Where a name leaves the unit of angle or speed open, that in which the speed is the change of the angle: a log of turns beside rpm is one
/// of neither rad nor rad/s. Counts are compared too: as many a second, or as many a turn as the speed beside them says, which is returned.
fn agree(parts: &mut [Part], said: &[words::Said], rows: &[Vec<f64>]) -> Option<Turn> {
    let place = |wanted: Quantity| parts.iter().position(|part| part.quantity == wanted);
    let (angle, speed) = (place(Quantity::Angle)?, place(Quantity::Speed)?);
    let (ratio, uncertainty) = ratio(parts, rows)?;
    let is_open = |part: &Part| said[part.index].unit.is_none() && !said[part.index].register;
    let (of_angle, of_speed) = (parts[angle].unit.clone(), parts[speed].unit.clone());
    // Steps of a servo's registers, as many a second.
    if let Some((unit, steps)) = of_angle.split_once('/')
        && said[parts[speed].index].unit.is_none()
        && said[parts[speed].index].register
        && (ratio - 1.0).abs() < EQUAL
    {
        parts[speed].unit = format!("{unit}/s/{steps}");
        parts[speed].guessed = false;
        return None;
    }
    if of_angle == "counts" {
        if is_open(&parts[speed]) && (ratio - 1.0).abs() < EQUAL {
            "counts/s".clone_into(&mut parts[speed].unit);
            parts[speed].guessed = false;
            return None;
        }
        // What reads the speed in a unit that is guessed has to read the angle so that both are one motion.
        let turn = SPEEDS.iter().find(|(unit, _)| *unit == of_speed).map(|(_, turn)| turn / ratio);
        let is_known = |turn: &f64| !is_open(&parts[speed]) || *turn >= FEWEST_COUNTS;
        return turn.filter(is_known).map(|turn| Turn::of(turn, uncertainty));
    }
    let mut pairs = pairs_of(ratio).filter(|(of_one, of_other)| {
        (is_open(&parts[angle]) || *of_one == of_angle) && (is_open(&parts[speed]) || *of_other == of_speed)
    });
    // Of equal numbers nothing tells the units.
    if let (Some((one, other)), None) = (pairs.next(), pairs.next()) {
        let told = [(angle, one), (speed, other)];
        for (k, unit) in told {
            unit.clone_into(&mut parts[k].unit);
            parts[k].guessed = false;
        }
    }
    None
}

/// How many times the change of the angle a second the speed is, where they are one motion, and to what share of it that is certain.
pub(super) fn ratio(parts: &[Part], rows: &[Vec<f64>]) -> Option<(f64, f64)> {
    let of = |wanted: Quantity| parts.iter().find(|part| part.quantity == wanted);
    let time = of(Quantity::Time).filter(|time| time.rest.is_none())?;
    let (angle, speed) = (of(Quantity::Angle)?.index, of(Quantity::Speed)?.index);
    let second = Unit::parse(Quantity::Time, &time.unit).ok()?.factor;
    let at = |row: &[f64], k: usize| row.get(k).copied().unwrap_or(f64::NAN);
    let whole: Vec<[f64; 3]> = rows
        .iter()
        .map(|row| [at(row, time.index) * second, at(row, angle), at(row, speed)])
        .filter(|row| row.iter().all(|value| value.is_finite()))
        .collect();
    let angles: Vec<f64> = whole.iter().map(|row| row[1]).collect();
    let turn = wraps::turn_of(&angles);
    let unwrapped = |change: f64| turn.map_or(change, |turn| change - turn * (change / turn).round());
    let (mut product, mut changes, mut speeds) = (0.0, 0.0, 0.0);
    for rows in whole.windows(3) {
        let change = unwrapped(rows[2][1] - rows[0][1]) / (rows[2][0] - rows[0][0]);
        // Where the clock begins anew, another run does.
        let is_one_run = rows.windows(2).all(|pair| pair[1][0] >= pair[0][0]);
        if change.is_finite() && is_one_run {
            let speed = rows[1][2];
            (product, changes, speeds) =
                (product + change * speed, changes + change * change, speeds + speed * speed);
        }
    }
    // Readings that jump tell no ratio. Two standard errors of the slope, of which each row has a part in three changes.
    let together = product / (changes * speeds).sqrt();
    let own = whole.len() as f64 / 3.0;
    let uncertainty = 2.0 * ((together.powi(-2) - 1.0).max(0.0) / own).sqrt();
    (together > ONE_MOTION).then_some((product / changes, uncertainty))
}

/// Correlation of an angle's change with the speed of the same motion, and how near the ratio of both must come to that of two units: 60 and
/// 57.3 are 5 % apart.
const ONE_MOTION: f64 = 0.95;
pub(super) const NEAR: f64 = 0.02;
/// Of two columns in units that nothing tells, equal numbers: nearer to 1 than to 60 / 57.3, the next ratio of two units. A speed that is filtered
/// falls short by some percent.
const EQUAL: f64 = 0.5 * (60.0 * TAU / 360.0 - 1.0);
/// In the units of a proposal a speed is this many times the change of its angle at least, and at most: beyond, a reader refuses both.
const ALIKE: (f64, f64) = (0.5, 2.0);

/// Takes off a speed that is the change of the angle beside it by a factor that is none of a unit: what it changes by from row to row, or on
/// the other side of the gears. The angle suffices. A speed whose unit its name tells stays where another unit would make them one.
fn leave_out_other_motion(parts: &mut Vec<Part>, rows: &[Vec<f64>]) {
    let of = |wanted: Quantity| parts.iter().find(|part| part.quantity == wanted);
    let (Some(angle), Some(speed)) = (of(Quantity::Angle), of(Quantity::Speed)) else { return };
    let factor = |part: &Part| {
        Unit::parse(part.quantity, &part.unit)
            .ok()
            .filter(|unit| unit.per_turn.is_none())
            .map(|unit| unit.factor)
    };
    let Some((ratio, _)) = ratio(parts, rows) else { return };
    // Where the names tell both units and no other ones make them one motion, they are of two shafts.
    let may_be_other = speed.guessed || pairs_of(ratio).next().is_none();
    if let (Some(of_angle), Some(of_speed)) = (factor(angle), factor(speed))
        && may_be_other
        && !(ALIKE.0..ALIKE.1).contains(&(ratio * of_speed / of_angle))
    {
        parts.retain(|part| part.quantity != Quantity::Speed);
    }
}

#[cfg(test)]
mod tests {
    use super::super::propose;

    #[test]
    fn a_register_of_steps_a_second_is_told_by_the_steps_beside_it_which_wrap() {
        let names = ["time", "duty", "present_speed", "present_position"].map(str::to_owned);
        let row = |k: u32| {
            let t = 0.02 * f64::from(k);
            let (speed, position) = (3000.0 + 500.0 * t.sin(), 3000.0 * t - 500.0 * t.cos());
            vec![t, (50.0 + 9.0 * t.sin()).round(), speed.round(), position.round().rem_euclid(4096.0)]
        };
        let map = propose(&names, &(0..300).map(row).collect::<Vec<_>>()).unwrap().map;
        assert!(map.ends_with("angle=present_position:rev/4096,speed=present_speed:rev/s/4096"), "{map}");
    }

    #[test]
    fn a_speed_beside_an_angle_is_proposed_where_a_unit_makes_them_one_motion() {
        let names = ["t_ms", "pwm", "pos", "vel"].map(str::to_owned);
        let map = |times: f64| {
            let row = |k: u32| {
                let t = 0.01 * f64::from(k);
                vec![
                    1e3 * t,
                    (200.0 * (3.0 * t).sin()).round(),
                    4.0 * (2.0 * t).sin(),
                    times * 8.0 * (2.0 * t).cos(),
                ]
            };
            propose(&names, &(0..300).map(row).collect::<Vec<_>>()).unwrap().map
        };
        assert!(map(1.0).ends_with("angle=pos:rad,speed=vel:rad/s"), "{}", map(1.0));
        assert!(map(60.0).ends_with("angle=pos:rev,speed=vel:rpm"), "{}", map(60.0));
        // The change in a row of 10 ms, and the motor's side of gears of 1:43.
        for times in [0.01, 43.0] {
            assert!(map(times).ends_with("angle=pos:rad"), "{}", map(times));
        }
    }
}
