//! A motor that seems to turn against its voltage, or a speed against its angle: one sign is turned round, and which one to turn back.

use super::Record;
use super::motion::{alignment, correlation, low_pass, slope, speed};
use super::remap::{Change, remapped};
use super::units::Quantity;
use super::unsigned::byte_duty;
use super::usable::Fault;
use super::weak::Weak;

/// A motor that turns against its voltage.
pub(super) const SIGN_FLIPPED: &str = "sign_flipped";
/// Time constants by which the voltage is smoothed before the motion is compared with it, s.
const SMOOTHING_S: [f64; 6] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0];

/// A motion of the wrong sign in `record`, with the mapping that turns it round.
pub(super) fn reversed(record: &Record) -> Option<Fault> {
    if let (Some(angle), Some(measured)) = (&record.angle_rad, &record.speed_rad_s)
        && correlation(&slope(&record.time_s, angle), measured) < -0.5
    {
        // The one that turns against the voltage: to turn the other would leave both against it.
        let by_angle = Record { speed_rad_s: None, ..record.clone() };
        let (quantity, column) = match opposed(&by_angle) {
            Some(_) => (Quantity::Angle, "angle_rad"),
            None => (Quantity::Speed, "speed_rad_s"),
        };
        return Some(Fault {
            name: "angle_against_speed",
            column,
            why: "the speed has the opposite sign of the change of the angle".into(),
            fix: format!("turn one of them round: {}", remapped(record, &[(quantity, quantity, "*-1")])),
        });
    }
    let correlation = opposed(record)?;
    // The other way about are only the numbers that lost their sign.
    if let Some((name, column, why, fix)) = byte_duty(record) {
        return Some(Fault { name, column, why, fix });
    }
    Some(Fault {
        name: SIGN_FLIPPED,
        column: motions(record).next().map_or("angle_rad", |(_, column)| column),
        why: format!(
            "the motor turns against its voltage (correlation {correlation:.2}): the sign of the encoder or of the voltage is reversed"
        ),
        fix: format!(
            "swap the encoder's A and B or the motor's wires, or turn the column round with {}",
            turned(record)
        ),
    })
}

/// What to do about a motor that turns against its voltage in `record` and with it in others that are read alike.
pub(super) fn remedy_beside_others(record: &Record) -> String {
    let others = "other records turn with their voltage, and a column that is turned round is so in them too";
    if record.voltage_v.iter().all(|v| *v >= 0.0) {
        return format!(
            "{others}; as this voltage is never negative, its sign stands elsewhere: add direction=COLUMN:sign to --map (1 and -1, 1 and 0, FWD \
             and REV), or log the drive with its sign"
        );
    }
    format!("{others}: leave this record out, or read it by itself with {}", turned(record))
}

/// The columns of motion that `record` has.
fn motions(record: &Record) -> impl Iterator<Item = (Quantity, &'static str)> {
    let present = [
        (Quantity::Angle, "angle_rad", record.angle_rad.is_some()),
        (Quantity::Speed, "speed_rad_s", record.speed_rad_s.is_some()),
    ];
    present.into_iter().filter(|(.., present)| *present).map(|(quantity, column, _)| (quantity, column))
}

/// The mapping with every motion turned round.
fn turned(record: &Record) -> String {
    let changes: Vec<Change> = motions(record).map(|(quantity, _)| (quantity, quantity, "*-1")).collect();
    remapped(record, &changes)
}

/// The correlation of motion and voltage where the motor turns against it. Compares them after several smoothings, so that neither delay
/// nor inertia matters; a record that looks reversed so is fitted with friction, a load and a pendulum beside the motor, which may drive it
/// backwards. Where both mostly have one sign it is no reversed one: a loop that holds a speed or nears its target lowers the voltage as
/// the speed rises.
fn opposed(record: &Record) -> Option<f64> {
    let motion = speed(record);
    let smoothed = SMOOTHING_S.map(|tau| low_pass(&record.time_s, &record.voltage_v, tau));
    let together = smoothed.iter().map(|voltage| correlation(voltage, &motion));
    let reach = |(low, high): (f64, f64), c: f64| (low.min(c), high.max(c));
    let (lowest, highest) = together.fold((0.0, 0.0), reach);
    let aligned = smoothed.iter().map(|voltage| alignment(voltage, &motion));
    let (same_sign, of_one_sign) = aligned.fold((1.0, -1.0), reach);
    let opposed = highest.max(of_one_sign) < 0.2 && (lowest < -0.5 || same_sign < -0.8);
    let driven = || Weak::new(record).and_then(|weak| weak.gain_under_load()).is_some_and(|gain| gain > 0.0);
    (opposed && !driven()).then_some(lowest.min(same_sign))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::read_tests::assert_bad;
    use crate::log::usable::tests::{as_speed, motor};
    use crate::log::{check_all_usable, check_usable, content_faults, data_faults};

    #[test]
    fn a_flipped_encoder_is_refused_and_the_remedy_turns_it_round() {
        let mut record = motor();
        record.angle_rad.as_mut().unwrap().iter_mut().for_each(|angle| *angle = -*angle);
        assert_bad(
            &check_usable(&record).unwrap_err(),
            "column angle_rad",
            "against its voltage",
            "angle_rad:rad*-1",
        );
        assert_bad(
            &check_usable(&as_speed(record.clone())).unwrap_err(),
            "speed_rad_s",
            "against",
            "rad/s*-1",
        );
        // A drive in one direction only, seen backwards.
        record.voltage_v.iter_mut().for_each(|v| *v = v.abs() + 3.0);
        record.angle_rad = Some(record.time_s.iter().map(|t| -3.0 * t - 0.01 * (5.0 * t).sin()).collect());
        assert!(check_usable(&record).is_err());
    }

    #[test]
    fn a_speed_that_contradicts_the_angle_is_refused() {
        let mut record = as_speed(motor());
        record.speed_rad_s.as_mut().unwrap().iter_mut().for_each(|speed| *speed = -*speed);
        record.angle_rad = motor().angle_rad;
        assert_eq!(content_faults(&record)[0].name, "angle_against_speed");
    }

    /// A servo that lets a pendulum down: its voltage holds against the motion nearly all the time.
    #[test]
    fn a_pendulum_that_is_lowered_is_no_flipped_encoder_and_a_flipped_one_is_found() {
        let mut record = motor();
        let (mut angle, mut speed) = (2.5_f64, 0.0);
        let mut angles = Vec::new();
        for (k, v) in record.voltage_v.iter_mut().enumerate() {
            angles.push(angle);
            let target = 1.4 + 1.2 * (0.4 * 0.01 * k as f64).cos();
            let falling = 6.0 * angle.sin();
            *v = 8.0 * (target - angle) + falling - 0.4 * speed;
            speed += 0.1 * (0.6 * (*v - falling) - speed);
            angle += 0.01 * speed;
        }
        let lowered = Record { angle_rad: Some(angles.clone()), ..record.clone() };
        assert_eq!(content_faults(&lowered), []);
        let flipped: Vec<f64> = angles.iter().map(|angle| -angle).collect();
        let gain = |angles: &[f64]| {
            let record = Record { angle_rad: Some(angles.to_vec()), ..record.clone() };
            Weak::new(&record).and_then(|weak| weak.gain_under_load())
        };
        assert!((gain(&angles).unwrap() / 0.6 - 1.0).abs() < 0.2, "{:?}", gain(&angles));
        assert!((gain(&flipped).unwrap() / 0.6 + 1.0).abs() < 0.2, "{:?}", gain(&flipped));
    }

    /// The regulator lowers the voltage when the wheel runs too fast.
    #[test]
    fn a_speed_that_a_loop_holds_against_disturbances_is_no_flipped_sign() {
        let mut record = as_speed(motor());
        let pushed = |k: usize| 0.8 * (0.07 * k as f64).sin();
        record.speed_rad_s = Some((0..record.len()).map(|k| 12.0 + pushed(k)).collect());
        record.voltage_v = (0..record.len()).map(|k| 3.0 - 0.5 * pushed(k)).collect();
        assert_eq!(content_faults(&record), []);
    }

    #[test]
    fn a_load_that_drives_the_motor_is_no_flipped_encoder() {
        // A hoist that is let down: voltage and speed opposed on the whole, together in their changes.
        let mut record = motor();
        let lowered: Vec<f64> =
            record.angle_rad.as_ref().unwrap().iter().zip(&record.time_s).map(|(a, t)| a - 2.0 * t).collect();
        record.voltage_v.iter_mut().for_each(|v| *v += 7.0);
        record.angle_rad = Some(lowered);
        assert_eq!(content_faults(&record), []);
    }

    #[test]
    fn of_a_speed_against_its_angle_the_one_that_turns_against_the_voltage_is_turned() {
        let back = |values: &mut Option<Vec<f64>>| values.iter_mut().flatten().for_each(|x| *x = -*x);
        let both = Record { angle_rad: motor().angle_rad, ..as_speed(motor()) };
        let (mut angle, mut speed) = (both.clone(), both);
        back(&mut angle.angle_rad);
        back(&mut speed.speed_rad_s);
        for (record, advice) in [
            (angle, "angle=angle_rad:rad*-1,speed=speed_rad_s:rad/s\""),
            (speed, "angle=angle_rad:rad,speed=speed_rad_s:rad/s*-1\""),
        ] {
            let fault = &content_faults(&record)[0];
            assert!(fault.name == "angle_against_speed" && fault.fix.ends_with(advice), "{}", fault.fix);
        }
    }

    /// Runs one way each, of a drive whose sign is in a column that was not read.
    #[test]
    fn where_other_records_turn_with_their_voltage_no_column_is_to_be_turned_round() {
        let one_way = |sign: f64| {
            let mut record = motor();
            record.voltage_v.iter_mut().for_each(|v| *v = v.abs());
            let (mut speed, mut angle) = (0.0, 0.0);
            let course = record.voltage_v.iter().map(|v| {
                speed += 0.1 * (0.6 * sign * v - speed);
                angle += 0.01 * speed;
                angle
            });
            record.angle_rad = Some(course.collect());
            record
        };
        let records = [one_way(1.0), one_way(-1.0)];
        assert!(data_faults(&records[1..]).iter().any(|w| w.fix.contains("rad*-1")));
        let told = data_faults(&records);
        let flipped = told.iter().find(|w| w.what.starts_with(SIGN_FLIPPED)).unwrap();
        assert!(
            flipped.fix.contains("direction=COLUMN:sign") && !flipped.fix.contains("*-1"),
            "{}",
            flipped.fix
        );
        let refused = check_all_usable(&records).unwrap_err().to_string();
        assert!(refused.contains("direction=COLUMN:sign"), "{refused}");
    }
}
