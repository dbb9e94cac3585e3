//! A current that lost its sign, beside a voltage that has one: a magnitude, or what the supply gives.

use super::Record;
use super::guess::quoted;
use super::motion::{ends, mean, peak};
use super::suspicion::Odd;
use super::units::Quantity;

/// A current below this share of the highest is none, whatever its sign.
const NO_CURRENT: f64 = 0.02;
/// The motor is driven back by more than this share of the highest voltage, in so large a share of the samples at least, ...
const BACK: f64 = 0.5;
const SHARE: f64 = 0.05;
/// ... and meanwhile the mean current is more than this share of the highest.
const FLOWS: f64 = 0.1;

/// What is said of a current that is never negative and flows while the voltage is.
pub(super) fn unsigned_current(record: &Record) -> Option<Odd> {
    let current = record.current_a.as_ref()?;
    let (full_v, most) = (peak(&record.voltage_v), peak(current));
    if ends(current).0 < -NO_CURRENT * most {
        return None;
    }
    let is_back = |(volts, amperes): (&f64, &f64)| (*volts < -BACK * full_v).then_some(*amperes);
    let back: Vec<f64> = record.voltage_v.iter().zip(current).filter_map(is_back).collect();
    let flows = back.len() as f64 > SHARE * current.len() as f64 && mean(&back) > FLOWS * most;
    flows.then(|| {
        let without = match &record.map {
            Some(map) => format!("--map {}", quoted(&map.without(Quantity::Current).written())),
            None => "call its column otherwise".to_owned(),
        };
        (
            "unsigned_current",
            "current_a",
            "the current is never negative, and flows while the voltage is: its sign is not in this column, or it is the supply's current and not \
             the motor's"
                .into(),
            format!("log the motor's current with the sign that the voltage drives it with; until then leave it out: {without}"),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::usable::tests::motor;

    #[test]
    fn a_current_without_its_sign_is_told_and_the_motors_own_is_not() {
        let mut record = motor();
        assert_eq!(unsigned_current(&record), None, "none was logged");
        let motors: Vec<f64> = record.voltage_v.iter().map(|v| 0.1 * v).collect();
        let sizes = |of: &[f64]| Some(of.iter().map(|amperes| amperes.abs()).collect::<Vec<f64>>());
        record.current_a = Some(motors.clone());
        assert_eq!(unsigned_current(&record), None);
        record.current_a = sizes(&motors);
        let (name, column, _, fix) = unsigned_current(&record).unwrap();
        assert_eq!((name, column), ("unsigned_current", "current_a"));
        assert!(fix.ends_with("call its column otherwise"), "{fix}");
        record.map = Some("time=t:s,duty=power:1,speed=velo:rad/s,current=i:A".parse().unwrap());
        let (_, _, _, fix) = unsigned_current(&record).unwrap();
        assert!(fix.ends_with("leave it out: --map time=t:s,duty=power:1,speed=velo:rad/s"), "{fix}");
        // Driven one way: forth it has no sign to lose, back it has.
        let forth = record.voltage_v.clone();
        record.voltage_v.iter_mut().for_each(|v| *v = v.abs());
        assert_eq!(unsigned_current(&record), None);
        record.voltage_v.iter_mut().for_each(|v| *v = -*v);
        assert!(unsigned_current(&record).is_some());
        // A sensor that reads nothing.
        (record.voltage_v, record.current_a) = (forth, Some(vec![0.0; motors.len()]));
        assert_eq!(unsigned_current(&record), None);
    }
}
