//! Records in which the motor stands still: each tells the voltage that friction holds, and nothing else.
//!
//! Such a record scatters by nothing, so that weighed by its own scatter it would outweigh all others, and a model without friction
//! would be biased by it. So it takes no part in a fit. What it tells is said.

use super::motion::{correlation, low_pass, peak, slope, span};
use super::timing::{median, median_interval};
use super::{Record, Warning};

/// Motion of less than this share of that of the set is none ...
const SMALL: f64 = 0.02;
/// ... where it does not follow the voltage either.
const UNRELATED: f64 = 0.3;
const SMOOTHING_S: [f64; 3] = [0.03, 0.1, 0.3];

/// Speed, rad/s, without what a reading shows at rest.
fn motion(record: &Record) -> Vec<f64> {
    match (&record.angle_rad, &record.speed_rad_s) {
        (Some(angle), _) => slope(&record.time_s, angle),
        (None, Some(speed)) => {
            let rest = if span(speed) < SMALL * peak(speed) { median(&mut speed.clone()) } else { 0.0 };
            speed.iter().map(|w| w - rest).collect()
        }
        (None, None) => Vec::new(),
    }
}

fn is_still(record: &Record, motion: &[f64], fastest: f64) -> bool {
    let highest = peak(motion);
    if highest == 0.0 || record.is_empty() {
        return highest == 0.0;
    }
    let follows = SMOOTHING_S.iter().any(|tau| {
        let tau = tau.max(2.0 * median_interval(&record.time_s));
        correlation(&low_pass(&record.time_s, &record.voltage_v, tau), motion).abs() > UNRELATED
    });
    highest < SMALL * fastest && !follows
}

/// Takes the records in which the motor stands still out of those to fit and those to judge by, and says what they tell; where none
/// of those to fit moves all stay, for whoever fits them to refuse.
pub fn set_aside_still(records: &mut Vec<Record>, validation: &mut Vec<Record>) -> Vec<Warning> {
    let stands = still_beside(&records.iter().collect::<Vec<_>>());
    let mut said = Vec::new();
    for set in [records, validation] {
        said.extend(set.iter().filter(|record| stands(record)).map(breakaway));
        set.retain(|record| !stands(record));
    }
    said
}

/// Whether the motor stands still in a record, beside `records` to fit; in none where it moves in none of these.
pub fn still_beside(records: &[&Record]) -> impl Fn(&Record) -> bool + use<> {
    let fastest = records.iter().map(|record| peak(&motion(record))).fold(0.0, f64::max);
    let stands = move |record: &Record| is_still(record, &motion(record), fastest);
    let any_moves = records.iter().any(|record| !stands(record));
    move |record| any_moves && stands(record)
}

/// What a record in which the motor stands still tells.
pub fn breakaway(record: &Record) -> Warning {
    let (low, high) = record.voltage_v.iter().fold((0.0_f64, 0.0_f64), |(l, h), v| (l.min(*v), h.max(*v)));
    let volts = match (low < -0.01 * peak(&record.voltage_v), high > 0.01 * peak(&record.voltage_v)) {
        (true, true) => format!("between {low:.3} V and {high:.3} V"),
        (true, false) => format!("down to {low:.3} V"),
        _ => format!("up to {high:.3} V"),
    };
    Warning {
        place: record.path.display().to_string(),
        what: format!(
            "still_record: the motor of {} stands still {volts}: friction holds it there, its breakaway voltage is higher; the record \
             tells nothing else and takes no part in the fit",
            record.name
        ),
        fix: "nothing, if the motor was free and its driver enabled; else record it again".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::usable::tests::motor;

    fn held(offset: f64) -> Record {
        let mut record = motor();
        record.name = "held".into();
        record.angle_rad = None;
        record.speed_rad_s = Some(vec![offset; record.len()]);
        record.voltage_v.iter_mut().for_each(|v| *v = -0.3 * v.abs());
        record
    }

    #[test]
    fn a_still_record_tells_the_voltage_that_friction_holds_and_leaves_the_set() {
        for offset in [0.0, 0.13] {
            let (mut kept, mut judged) = (vec![motor(), held(offset)], vec![held(offset)]);
            let said = set_aside_still(&mut kept, &mut judged);
            assert_eq!((kept.len(), judged.len(), said.len()), (1, 0, 2), "{offset}");
            assert!(said[0].what.contains("down to -1.800 V"), "{:?}", said[0]);
        }
    }

    #[test]
    fn small_motion_that_follows_its_voltage_is_motion() {
        let mut small = motor();
        small.voltage_v.iter_mut().for_each(|v| *v *= 0.01);
        small.angle_rad.as_mut().unwrap().iter_mut().for_each(|a| *a *= 0.01);
        for mut set in [vec![motor(), small], vec![held(0.0)]] {
            assert_eq!(set_aside_still(&mut set, &mut Vec::new()), []);
        }
    }
}
