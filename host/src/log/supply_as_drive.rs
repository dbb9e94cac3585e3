//! A supply's voltage in the place of the motor's: a motor that turns forth and back under one voltage is told to by something else.

use super::Record;
use super::motion::{angle, low_pass, peak, span};
use super::timing::median_interval;
use super::units::Quantity;
use super::usable::Fault;
use super::voltages::level_of;

/// A voltage that goes below this share of its highest was switched, and drives.
const SWITCHED: f64 = 0.5;
/// A motion turns where it goes back by this share of its span, which no load that springs back does twice, ...
const BACK: f64 = 0.5;
/// ... and drives both ways where it goes so many times from one end towards the other.
const SWINGS: usize = 3;
/// What is left of a motion, but not of noise, by a filter of so many rows, as a share of its span.
const SMOOTH_ROWS: f64 = 10.0;
const SMOOTH: f64 = 0.5;

/// A mapped voltage of one level, above or below zero in every row, under which the motor turns both ways.
pub(super) fn supply_as_drive(record: &Record) -> Option<Fault> {
    record.source(Quantity::Voltage)?;
    let highest = peak(&record.voltage_v);
    if record.voltage_v.iter().any(|v| v.abs() < SWITCHED * highest) {
        return None;
    }
    let level = level_of(record)?;
    let swings = swings(&angle(record), &record.time_s);
    (swings >= SWINGS).then(|| Fault {
        name: "supply_as_drive",
        column: "voltage_v",
        why: format!(
            "the motor turns {swings} times from one end of its way towards the other under one voltage of {level:.3} V, so that is its supply \
             and drives nothing by itself"
        ),
        fix: "map this column as supply=, and what the motor was told as duty=, voltage= or (of a position servo) target=; where no column has \
              it, log it"
            .into(),
    })
}

/// How often an angle goes by more than half of its span one way before it goes back as far; of noise, never.
fn swings(angle: &[f64], time_s: &[f64]) -> usize {
    let smooth = low_pass(time_s, angle, SMOOTH_ROWS * median_interval(time_s));
    let far = BACK * span(&smooth);
    if far == 0.0 || span(&smooth) < SMOOTH * span(angle) {
        return 0;
    }
    let (mut swings, mut way) = (0, 0.0);
    let (mut low, mut high) = (smooth[0], smooth[0]);
    for x in smooth {
        (low, high) = (low.min(x), high.max(x));
        if way <= 0.0 && x - low > far {
            (swings, way, high) = (swings + 1, 1.0, x);
        } else if way >= 0.0 && high - x > far {
            (swings, way, low) = (swings + 1, -1.0, x);
        }
    }
    swings
}

#[cfg(test)]
mod tests {
    use super::super::usable::check_usable;
    use super::super::usable::tests::motor;
    use super::*;
    use crate::log::read_tests::assert_bad;

    /// A supply that sags by little, and an angle.
    fn record(angle: impl Fn(f64) -> f64) -> Record {
        let mut record = motor();
        let rows = record.len();
        record.voltage_v = (0..rows).map(|k| 4.95 + 0.05 * (k as f64).sin()).collect();
        record.angle_rad = Some((0..rows).map(|k| angle(k as f64)).collect());
        record.map = Some("time=t:s,voltage=Voltage:V,angle=pos:rad".parse().unwrap());
        record
    }

    #[test]
    fn a_motor_that_turns_both_ways_under_one_voltage_has_its_supply_for_its_drive() {
        let swinging = record(|k| (0.03 * k).sin());
        assert_bad(
            &check_usable(&swinging).unwrap_err(),
            "column voltage_v",
            "one voltage of 4.9",
            "supply=",
        );
        let speed = swinging.angle_rad.as_ref().map(|angle| angle.iter().map(|x| 3.0 * x).collect());
        let by_speed = Record { angle_rad: None, speed_rad_s: speed, ..swinging.clone() };
        assert_eq!(supply_as_drive(&by_speed).unwrap().name, "supply_as_drive");
        // A voltage that is called one by the log itself, and one that was switched off.
        assert_eq!(supply_as_drive(&Record { map: None, ..swinging.clone() }), None);
        let mut switched = swinging;
        switched.voltage_v[..20].fill(0.0);
        assert_eq!(supply_as_drive(&switched), None);
    }

    #[test]
    fn a_motor_of_one_way_or_at_rest_and_a_load_that_springs_back_keep_their_drive() {
        let springs = |k: f64| 1.0 - (-0.02 * k).exp() * (0.05 * k).cos();
        let others: [fn(f64) -> f64; 3] = [|k| 0.02 * k, |k| 1e-3 * (k * k).sin(), springs];
        for angle in others {
            assert_eq!(supply_as_drive(&record(angle)), None);
        }
    }
}
