//! Data quality problems of a voltage: it is a duty, or a share of one, or lacks its sign; and whether it has one level only.

use super::motion::{correlation, low_pass, peak, speed};
use super::remap::remapped;
use super::suspicion::{Odd, Seen, place_of};
use super::units::Quantity;
use super::unsigned::byte_duty;
use super::{Record, Warning};

/// Whether a mapping says how many volts the numbers of the column are, be it `V*1`: not one that turns it round only.
fn is_scaled(record: &Record) -> bool {
    record.unit_of(Quantity::Voltage).trim_end_matches("*-1").contains(['*', '/'])
}

/// A voltage that never passes 1, or that reaches for 100, is told as volts by nobody but small and large motors.
pub(super) fn duty(records: &[&Record]) -> Option<Warning> {
    let may_be = |r: &&Record| r.supply_v.is_none() && r.meta.get("voltage").is_none() && !is_scaled(r);
    let records = || records.iter().copied().filter(may_be);
    let highest = records().map(|r| peak(&r.voltage_v)).fold(0.0, f64::max);
    let first = records().next()?;
    let (looks, full) = if highest > 0.0 && highest <= 1.0 {
        ("a duty from -1 to 1", "1")
    } else if highest > 60.0 && highest <= 100.0 {
        ("a duty in percent", "100")
    } else {
        return None;
    };
    Some(Warning {
        place: place_of(first, "voltage_v"),
        what: format!(
            "perhaps_duty: the voltage never passes {highest:.3}, as {looks} does; then every gain is wrong by the supply's voltage"
        ),
        fix: format!(
            "if it is a duty, say {} --supply-volts 12 (with the voltage of this drive's supply); if it is in volts, say {} (it is not asked \
             again)",
            remapped(first, &[(Quantity::Voltage, Quantity::Duty, full)]),
            remapped(first, &[(Quantity::Voltage, Quantity::Voltage, "*1")])
        ),
    })
}

/// A full duty of fewer steps than percent have may be turned by one of them.
const PERCENT: f64 = 100.0;
/// The largest share of one, with what a supply that sags makes of it.
const JUST_ABOVE_ONE: f64 = 1.05;

/// The number that the mapping of a record says is full duty; none where it scales it, or says where no duty is.
fn full_duty(record: &Record) -> Option<f64> {
    let mapped = record.source(Quantity::Duty)?;
    mapped.written.parse::<f64>().ok().or((mapped.written == "%").then_some(PERCENT))
}

/// A hundredth of the supply turns no motor: a duty that never passes 1 where 100 or more is said to be full is a share of one.
pub(super) fn share(records: &[&Record]) -> Option<Warning> {
    let duties = || {
        records.iter().filter_map(|record| {
            let full = full_duty(record).filter(|full| *full >= PERCENT)?;
            Some((*record, full, full * peak(&record.voltage_v) / record.mean_supply_v()?))
        })
    };
    let (first, full, _) = duties().next()?;
    let highest = duties().map(|(.., number)| number).fold(0.0, f64::max);
    let is_share = highest > 0.0 && highest <= JUST_ABOVE_ONE;
    let moves = || duties().any(|(record, ..)| peak(&speed(record)) > 0.0);
    (is_share && moves()).then(|| Warning {
        place: place_of(first, "voltage_v"),
        what: format!(
            "perhaps_share: the duty never passes {highest:.3} of {full}, and so little of the supply turns no motor: it looks like a share of one, \
             and then every gain is {full} times too large"
        ),
        fix: format!(
            "if full duty is 1, say {}; if it is {full}, say {} (it is not asked again)",
            remapped(first, &[(Quantity::Duty, Quantity::Duty, "1")]),
            remapped(first, &[(Quantity::Duty, Quantity::Duty, "*1")])
        ),
    })
}

/// Share of the highest voltage within which two voltages are one level: what a supply sags by and a meter scatters by.
pub(super) const SAME_LEVEL: f64 = 0.05;
/// Share of the samples that may lie beyond: the edges of a step, single readings.
const BEYOND: f64 = 0.02;

/// Whether the voltage of `record` has one level from first to last, within the scatter of a measurement.
pub(super) fn is_level(record: &Record) -> bool {
    level_of(record).is_some()
}

/// That level, V, where it has one.
pub(super) fn level_of(record: &Record) -> Option<f64> {
    level(record.voltage_v.clone(), SAME_LEVEL * peak(&record.voltage_v))
}

/// The middle one of `volts`, V, where they are one level within `near`; of none there is none.
pub(super) fn level(mut volts: Vec<f64>, near: f64) -> Option<f64> {
    volts.sort_by(f64::total_cmp);
    let edge = (BEYOND * volts.len() as f64) as usize;
    let (low, middle) = (*volts.get(edge)?, volts[volts.len() / 2]);
    (volts[volts.len() - 1 - edge] - low <= near).then_some(middle)
}

/// Time constant by which a voltage is smoothed before the motion is compared with it, s.
pub(super) const SMOOTHING_S: f64 = 0.1;
/// Share of what goes either way that goes in the less frequent direction, at least.
const BOTH_WAYS: f64 = 0.1;
/// Correlation of the voltage with the magnitude of the speed, at least, and how much more that is than with the speed.
const FOLLOWS: f64 = 0.5;
const MORE: f64 = 0.3;

/// Whether `values` are of either sign for more than a small share of all they sum up to.
pub(super) fn goes_both_ways(values: &[f64]) -> bool {
    let (forth, back) =
        values.iter().fold((0.0, 0.0), |(forth, back), x| (forth + x.max(0.0), back - x.min(0.0)));
    forth.min(back) > BOTH_WAYS * (forth + back)
}

/// A voltage that is never negative drives a motor one way: where it runs both ways as fast as the voltage asks, the sign stands
/// elsewhere.
pub(super) fn unsigned(record: &Record) -> Option<Odd> {
    let volts = &record.voltage_v;
    if volts.iter().any(|v| *v < 0.0) || peak(volts) == 0.0 {
        return None;
    }
    let motion = speed(record);
    let smooth = low_pass(&record.time_s, volts, SMOOTHING_S);
    let magnitude: Vec<f64> = motion.iter().map(|w| w.abs()).collect();
    let with_magnitude = correlation(&smooth, &magnitude);
    let follows = with_magnitude > FOLLOWS && with_magnitude > correlation(&smooth, &motion).abs() + MORE;
    (goes_both_ways(&motion) && follows).then(|| {
        (
            "unsigned_voltage",
            "voltage_v",
            "the voltage is never negative, and the motor runs both ways as fast as it asks: its sign is not in this column".into(),
            "say which column holds the direction: --map ...,direction=COLUMN (1 and -1, 1 and 0, FWD and REV); or log the voltage (or the duty) with \
             its sign"
                .into(),
        )
    })
}

/// The load that half of the full duty makes up for, of the supply's voltage, and how near it must come.
const HALF: (f64, f64) = (0.5, 0.07);

/// A bridge that is driven by locked antiphase stands still at half of the full duty, drives one way above and the other way below.
pub(super) fn antiphase(Seen { record, weak }: &Seen) -> Option<Odd> {
    let full = full_duty(record)?;
    let supply_v = record.mean_supply_v()?;
    // A byte that lost its sign is never negative either.
    if record.voltage_v.iter().any(|v| *v < 0.0) || byte_duty(record).is_some() {
        return None;
    }
    let motion = speed(record);
    let motor = weak.as_ref()?.under_any_latency()?;
    let half = (motor.load_v / supply_v - HALF.0).abs() < HALF.1;
    (goes_both_ways(&motion) && motor.gain > 0.0 && half).then(|| {
        (
            "locked_antiphase",
            "voltage_v",
            format!("the motor stands still at half of the full duty ({}) and turns the other way below: the bridge is driven by locked antiphase", 0.5 * full),
            format!(
                "say where no duty is: {}",
                remapped(record, &[(Quantity::Duty, Quantity::Duty, &format!("{}..{full}", 0.5 * full))])
            ),
        )
    })
}

/// A speed below this share of the fastest is none, whatever its sign.
const NO_SPEED: f64 = 0.02;

/// A motion that never goes back, of a motor that is driven both ways and turns as fast as either asks: one channel of an encoder, or a
/// magnitude.
pub(super) fn unsigned_motion(record: &Record) -> Option<Odd> {
    let (volts, motion) = (&record.voltage_v, speed(record));
    let lowest = motion.iter().fold(0.0, |low: f64, w| low.min(*w));
    if lowest < -NO_SPEED * peak(&motion) || !goes_both_ways(volts) {
        return None;
    }
    let smooth = low_pass(&record.time_s, volts, SMOOTHING_S);
    let magnitude: Vec<f64> = smooth.iter().map(|v| v.abs()).collect();
    let with_magnitude = correlation(&magnitude, &motion);
    let follows = with_magnitude > FOLLOWS && with_magnitude > correlation(&smooth, &motion).abs() + MORE;
    let column = if record.angle_rad.is_some() { "angle_rad" } else { "speed_rad_s" };
    follows.then(|| {
        (
            "unsigned_motion",
            column,
            "the motor is driven both ways and its motion never goes back: the sign of the motion is not in this column".into(),
            "read the encoder by both its channels, or log the speed with its sign; else fit to records of one direction (--skip)".into(),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::usable::tests::motor;

    #[test]
    fn a_voltage_as_small_as_a_duty_is_asked_about_until_the_mapping_says_how_many_volts_it_is() {
        let mut record = motor();
        let highest = peak(&record.voltage_v);
        record.voltage_v.iter_mut().for_each(|v| *v /= highest);
        let asked = duty(&[&record]).unwrap();
        assert!(asked.fix.contains("--map \"voltage=voltage_v:V*1\""), "{}", asked.fix);
        let mut is_asked = |map: &str| {
            record.map = Some(map.parse().unwrap());
            duty(&[&record]).is_some()
        };
        assert!(is_asked("voltage=u:V,angle=x:rad") && is_asked("voltage=u:V*-1,angle=x:rad"));
        assert!(!is_asked("voltage=u:V*1,angle=x:rad") && !is_asked("voltage=u:V/255*7.9,angle=x:rad"));
    }

    #[test]
    fn a_duty_that_is_a_thousandth_of_what_is_said_to_be_full_is_asked_about_until_a_scale_says_that_it_is() {
        let mut record = motor();
        record.meta.insert("voltage", "it is the duty times 12 V, whatever the supply did").unwrap();
        let highest = peak(&record.voltage_v);
        let mut asked = |map: &str, most: f64| {
            record.voltage_v.iter_mut().for_each(|v| *v *= most / highest);
            record.map = Some(map.parse().unwrap());
            let asked = share(&[&record]);
            record.voltage_v.iter_mut().for_each(|v| *v *= highest / most);
            asked
        };
        let said = asked("time=t:s,duty=pwm:100,angle=x:rad", 0.012).unwrap();
        assert!(said.what.starts_with("perhaps_share: the duty never passes 0.100 of 100"), "{}", said.what);
        assert!(said.fix.contains("duty=pwm:1,") && said.fix.contains("duty=pwm:100*1,"), "{}", said.fix);
        assert!(asked("time=t:s,duty=pwm:255,angle=x:rad", 12.0 / 255.0).is_some());
        for (map, most) in [
            ("time=t:s,duty=pwm:100*1,angle=x:rad", 0.012),
            ("time=t:s,duty=pwm:100,angle=x:rad", 1.2),
            ("time=t:s,duty=pwm:1,angle=x:rad", 0.012),
            ("time=t:s,voltage=u:V,angle=x:rad", 0.012),
        ] {
            assert_eq!(asked(map, most), None, "{map}");
        }
    }

    #[test]
    fn a_voltage_without_its_sign_is_told_and_a_load_that_turns_the_motor_back_is_not() {
        let mut record = motor();
        assert_eq!(unsigned(&record), None);
        record.voltage_v.iter_mut().for_each(|v| *v = v.abs());
        assert_eq!(unsigned(&record).unwrap().0, "unsigned_voltage");
        let mut hoist = motor();
        hoist.voltage_v.iter_mut().for_each(|v| *v += 7.0);
        assert_eq!(unsigned(&hoist), None);
    }

    #[test]
    fn a_bridge_in_locked_antiphase_is_told_with_where_no_duty_is() {
        let mut record = motor();
        record.map = Some("time=t:s,duty=pwm:255,angle=x:rad".parse().unwrap());
        record.meta.insert("voltage", "it is the duty times 20 V, whatever the supply did").unwrap();
        assert_eq!(antiphase(&Seen::of(&record)), None);
        let high = peak(&record.voltage_v);
        assert!(high < 10.0, "{high}");
        record.voltage_v.iter_mut().for_each(|v| *v += 10.0);
        let (name, _, _, fix) = antiphase(&Seen::of(&record)).unwrap();
        assert!(name == "locked_antiphase" && fix.contains("duty=pwm:127.5..255"), "{fix}");
        // A load that a motor holds at a third of its supply is a load.
        record.voltage_v.iter_mut().for_each(|v| *v -= 3.0);
        assert_eq!(antiphase(&Seen::of(&record)), None);
    }

    #[test]
    fn a_motion_without_its_sign_is_told_and_a_motor_that_runs_one_way_is_not() {
        let mut record = motor();
        assert_eq!(unsigned_motion(&record), None);
        let magnitude = speed(&record).iter().map(|w| w.abs()).collect();
        (record.angle_rad, record.speed_rad_s) = (None, Some(magnitude));
        assert_eq!(unsigned_motion(&record).unwrap().0, "unsigned_motion");
        record.voltage_v.iter_mut().for_each(|v| *v = v.abs());
        assert_eq!(unsigned_motion(&record), None);
    }
}
