//! Motion that is read as what it is not: an angle as a speed, with its sign turned round from some row on, or by a sensor that hangs.
//!
//! For the first two the motor's own equation decides: the reading that explains the voltage is right ([`super::weak`]).

use super::Record;
use super::motion::{peak, span};
use super::remap::remapped;
use super::suspicion::{Odd, Seen};
use super::times::skip_of;
use super::timing::median_interval;
use super::units::Quantity;
use super::weak::Weak;

/// A reading is right that leaves less than this share of the voltage's variation ...
const EXPLAINS: f64 = 0.35;
/// ... and of what the other one leaves.
const BETTER: f64 = 0.4;
/// What goes on one way in more than this share of its rows goes on at a drive that holds, where a speed settles.
const GOES_ON: f64 = 0.5;
/// Under either sign the motor turns about as far per volt: within this factor.
const ALIKE: f64 = 2.0;

/// Whether a record that is `seen` so must be `other`, since that explains it; in percent what is left of both. Of the other the motor
/// must turn with its voltage; as it was read it may turn against it, since a sign that is turned round is a fault of its own, of which
/// another one tells, and makes no angle a speed.
fn is_rather(seen: &Seen, other: &Record) -> Option<(f64, f64)> {
    // Of a voltage that never changes there is no variation but that of rounding.
    if span(&other.voltage_v) == 0.0 {
        return None;
    }
    let other = Weak::new(other)?.under_any_latency().filter(|best| best.gain > 0.0)?;
    let as_read = seen.weak.as_ref().and_then(Weak::under_any_latency);
    let (right, wrong) = (other.left, as_read.map_or(1.0, |best| best.left));
    (right < EXPLAINS && right < BETTER * wrong).then_some((100.0 * right, 100.0 * wrong.min(1.0)))
}

/// A column that was taken for the speed and is the angle: with it as the angle the voltage is explained, as the speed it is not.
pub(super) fn angle_as_speed(seen: &Seen) -> Option<Odd> {
    let record = seen.record;
    let speed = record.speed_rad_s.as_ref().filter(|_| record.angle_rad.is_none())?;
    let as_angle = Record { angle_rad: Some(speed.clone()), speed_rad_s: None, ..record.clone() };
    let (angle, speed) = is_rather(seen, &as_angle)?;
    Some((
        "angle_as_speed",
        "speed_rad_s",
        format!(
            "as an angle this column explains all but {angle:.0} % of the voltage, as a speed all but {speed:.0} %: it looks like an angle"
        ),
        format!(
            "say {}, with the unit of the angle",
            remapped(record, &[(Quantity::Speed, Quantity::Angle, "rad")])
        ),
    ))
}

/// Whether `values` go one way only, in most rows: so does a counter of a shaft that is driven faster and faster, and no speed.
fn goes_on_one_way(values: &[f64]) -> bool {
    let moved = |way: f64| values.windows(2).filter(|pair| way * (pair[1] - pair[0]) > 0.0).count();
    let [forward, backward] = [moved(1.0), moved(-1.0)];
    forward.min(backward) == 0 && forward.max(backward) as f64 > GOES_ON * values.len() as f64
}

/// Counts that were taken for those of the angle and are those since the row before. Of an angle in other units a stiff spring makes the
/// same.
pub(super) fn speed_as_angle(seen: &Seen) -> Option<Odd> {
    let record = seen.record;
    let counted = record.unit_of(Quantity::Angle).starts_with("counts");
    let is_open = |counts: &&Vec<f64>| counted && record.speed_rad_s.is_none() && !goes_on_one_way(counts);
    let counts = record.angle_rad.as_ref().filter(is_open)?;
    let as_speed = Record { angle_rad: None, speed_rad_s: Some(counts.clone()), ..record.clone() };
    let (speed, angle) = is_rather(seen, &as_speed)?;
    let unit = format!("counts/s*{}", (1e3 / median_interval(&record.time_s)).round() / 1e3);
    Some((
        "speed_as_angle",
        "angle_rad",
        format!(
            "as a speed this column explains all but {speed:.0} % of the voltage, as an angle all but {angle:.0} %: it looks like what was \
             counted since the row before"
        ),
        format!("say {}", remapped(record, &[(Quantity::Angle, Quantity::Speed, &unit)])),
    ))
}

/// The motor turns with its voltage up to some row and against it from there on.
pub(super) fn turned_round(Seen { record, weak }: &Seen) -> Option<Odd> {
    let weak = weak.as_ref()?;
    let whole = weak.regress(0.0, |v| v)?;
    let (at_s, [first, second]) = weak.best_parts()?;
    let explained = [first, second].iter().all(|part| part.left < EXPLAINS);
    let factor = (first.gain / second.gain).abs();
    let alike = factor.max(factor.recip()) < ALIKE;
    let turned = first.gain * second.gain < 0.0 && explained && alike;
    (turned && first.left.max(second.left) < BETTER * whole.left).then(|| {
        let (with, against) = if first.gain > 0.0 { ("before", "after") } else { ("after", "before") };
        let wrong = if first.gain > 0.0 {
            (at_s, record.time_s.last().copied().unwrap_or(at_s))
        } else {
            (record.time_s.first().copied().unwrap_or(0.0), at_s)
        };
        (
            "sign_flipped",
            if record.angle_rad.is_some() { "angle_rad" } else { "speed_rad_s" },
            format!(
                "the motor turns with its voltage {with} about {at_s:.2} s and against it {against}: the sign of one of them was turned round on the way"
            ),
            format!(
                "leave one part out: {}, or give each part a file and a sign of its own",
                skip_of(record, &[wrong])
            ),
        )
    })
}

/// A speed that stands still by its digits for so long, s and samples, while the voltage goes through this share of its range.
const FROZEN: (f64, usize, f64) = (0.1, 8, 0.3);

/// A sensor that hangs: the shaft turns, the voltage changes, and the reading does not.
pub(super) fn frozen(record: &Record) -> Option<Odd> {
    let (time, volts, speed) = (&record.time_s, &record.voltage_v, record.speed_rad_s.as_ref()?);
    let (least_s, fewest, share) = FROZEN;
    let range = span(volts);
    let mut begin = 0;
    for end in 1..=speed.len() {
        if end < speed.len() && speed[end] == speed[begin] {
            continue;
        }
        let long = end - begin >= fewest && time[end - 1] - time[begin] > least_s;
        // The motor had as long to answer to the change.
        let answered = begin + time[begin..end].partition_point(|t| *t <= time[end - 1] - least_s);
        if long && speed[begin].abs() > 0.1 * peak(speed) && span(&volts[begin..answered]) > share * range {
            let (from, to) = (time[begin], time[end - 1]);
            let skip = skip_of(record, &[(from, to)]);
            return Some((
                "frozen_sensor",
                "speed_rad_s",
                format!(
                    "the speed stands at {:.4} rad/s from {from:.3} s to {to:.3} s while the voltage changes: the sensor hung",
                    speed[begin]
                ),
                format!("leave that time out with {skip}, and check the sensor's cable"),
            ));
        }
        begin = end;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::mapping::Mapping;
    use crate::log::motion::speed;
    use crate::log::timing::median_interval;
    use crate::log::usable::tests::motor;

    #[test]
    fn an_angle_in_the_place_of_a_speed_is_told_and_a_speed_is_not() {
        let clean = motor();
        assert_eq!(angle_as_speed(&Seen::of(&clean)), None);
        let right = Record { speed_rad_s: Some(speed(&clean)), angle_rad: None, ..clean.clone() };
        assert_eq!(angle_as_speed(&Seen::of(&right)), None);
        let wrong = Record { speed_rad_s: clean.angle_rad.clone(), angle_rad: None, ..clean };
        assert_eq!(angle_as_speed(&Seen::of(&wrong)).unwrap().0, "angle_as_speed");
        let map: Option<Mapping> = "time=t:s,voltage=u:V,angle=ticks:counts".parse().ok();
        let counted =
            Record { angle_rad: right.speed_rad_s.clone(), speed_rad_s: None, map: map.clone(), ..right };
        let (name, _, _, fix) = speed_as_angle(&Seen::of(&counted)).unwrap();
        assert!(name == "speed_as_angle" && fix.contains("speed=ticks:counts/s*"), "{fix}");
        assert_eq!(speed_as_angle(&Seen::of(&Record { map: map.clone(), ..motor() })), None);
        // One that is turned round is an angle too, and told by its sign alone.
        let mut turned = Record { map, ..motor() };
        turned.angle_rad.iter_mut().flatten().for_each(|x| *x = -*x);
        assert_eq!(speed_as_angle(&Seen::of(&turned)), None);
    }

    /// A step that had begun before the first row: nothing but rounding varies in its voltage, and as an angle the speed "explained" that.
    #[test]
    fn under_one_voltage_a_speed_that_still_rises_is_not_called_an_angle() {
        let speeds = (0..200).map(|k| 10.0 + 30.0 * (1.0 - (-f64::from(k) / 60.0).exp())).collect();
        let record = Record {
            time_s: (0..200).map(|k| 0.01 * f64::from(k)).collect(),
            voltage_v: vec![12.0; 200],
            speed_rad_s: Some(speeds),
            angle_rad: None,
            ..motor()
        };
        assert_eq!(angle_as_speed(&Seen::of(&record)), None);
    }

    /// The wheels of a robot whose drive rises in steps, and whose driver goes off at the end though the command stays.
    #[test]
    fn a_counter_that_only_rises_is_no_speed_and_a_speed_settles() {
        let driven = |k: usize| if k < 180 { (12 * (k / 30)) as f64 } else { 0.0 };
        let mut counted = 0.0;
        let count = |k: usize| {
            counted += driven(k);
            counted
        };
        let counts: Vec<f64> = (0..200).map(count).collect();
        assert!(goes_on_one_way(&counts));
        let backward: Vec<f64> = counts.iter().map(|x| -x).collect();
        assert!(goes_on_one_way(&backward));
        let settling: Vec<f64> = (0..180).map(driven).collect();
        assert!(!goes_on_one_way(&settling) && !goes_on_one_way(&[5.0; 200]));
        let scattering: Vec<f64> = (0..200).map(|k| driven(k) + (k as f64).sin()).collect();
        assert!(!goes_on_one_way(&scattering));
    }

    #[test]
    fn a_sign_that_is_turned_round_on_the_way_is_told_with_its_time() {
        let mut record = motor();
        assert_eq!(turned_round(&Seen::of(&record)), None);
        let half = record.len() / 3;
        let angle = record.angle_rad.as_mut().unwrap();
        let there = angle[half];
        angle[half..].iter_mut().for_each(|x| *x = 2.0 * there - *x);
        let (name, _, why, fix) = turned_round(&Seen::of(&record)).unwrap();
        assert_eq!(name, "sign_flipped");
        let told = why.split_once("about ").and_then(|(_, rest)| rest.split_once(" s ")).unwrap().0;
        let told: f64 = told.parse().unwrap();
        assert!((told - record.time_s[half]).abs() < 1.0, "{why} {fix}");
        // Turned round all the way it is the sign of the whole.
        record.voltage_v[..half].iter_mut().for_each(|v| *v = -*v);
        assert_eq!(turned_round(&Seen::of(&record)), None);
    }

    #[test]
    fn a_speed_that_hangs_while_the_voltage_changes_is_told_and_an_even_one_is_not() {
        let clean = motor();
        let mut record = Record { speed_rad_s: Some(speed(&clean)), angle_rad: None, ..clean };
        assert_eq!(frozen(&record), None);
        let interval = median_interval(&record.time_s);
        let held = (1.0 / interval) as usize;
        let w = record.speed_rad_s.as_mut().unwrap();
        let begin = (0..w.len() - held).max_by(|a, b| w[*a].abs().total_cmp(&w[*b].abs())).unwrap();
        let value = w[begin];
        w[begin..begin + held].fill(value);
        let (name, _, _, fix) = frozen(&record).unwrap();
        assert!(name == "frozen_sensor" && fix.contains("--skip"), "{fix}");
        // Under an even voltage an even speed is none.
        let v = record.voltage_v[begin];
        record.voltage_v[begin..begin + held].fill(v);
        assert_eq!(frozen(&record), None);
    }
}
