//! What a table leaves open about what drives the motor: it is absent, steady as a supply, or in another unit.

use super::column_units::ANALOG_OUTPUT;
use super::columns::{self, Part};
use super::made;
use super::preview::short;
use super::questions::{guessed_unit, other_rate, steady_beside};
use super::ranges::Range;
use super::{channels, column, duty_range, options_as_if, sides, symbols, unit_names, words};
use crate::log::motion::correlation;
use crate::log::numbered::numbers_rows;
use crate::log::sample::{Sample, numbers};
use crate::log::units::Quantity;

/// A voltage that changes less than this share of it is as steady as a supply's.
const STEADY: f64 = 0.1;
/// No motor of a log has so many volts: they are millivolts.
pub(super) const MOST_VOLTS: f64 = 1000.0;
/// Whole numbers up to here are rather a duty's, those beyond millivolts, but for what registers are full at.
const MOST_OF_A_DUTY: f64 = 4095.0;
const REGISTERS: [f64; 4] = [10_000.0, ANALOG_OUTPUT, 32_767.0, 65_535.0];
const MOST_MILLIVOLTS: f64 = 60_000.0;

/// Percent end here.
const MOST_PERCENT: f64 = 100.0;

/// Columns of one quantity in two units correlate by more than this.
const SAME: f64 = 0.9999;

/// Whether whole numbers that nothing tells the unit of are millivolts rather than a duty.
pub(super) fn are_millivolts(range: &Range) -> bool {
    let peak = range.peak();
    peak > MOST_OF_A_DUTY && peak <= MOST_MILLIVOLTS && !REGISTERS.contains(&peak)
}

/// What is said of a voltage that hardly changes, of whole numbers that may be millivolts or a duty, and of a current in a unit that nothing tells.
pub(super) fn said_of_drive(names: &[String], rows: &[Vec<f64>], part: &Part) -> Option<String> {
    let name = names.get(part.index)?;
    let range = Range::of(numbers(rows, part.index));
    let own = column(names, part.index);
    let called = words::said(name).quantity.map(|(of, _)| of);
    let is_volts = part.unit == "V" || part.unit == "mV";
    match part.quantity {
        Quantity::Voltage if is_volts && range.low > 0.0 && range.high - range.low < STEADY * range.high => {
            let how = if range.high > range.low {
                format!("stays within {} .. {}", short(range.low), short(range.high))
            } else {
                format!("is {} in every row", short(range.low))
            };
            Some(format!(
                "\"{name}\" {how}: if it is the supply's, it drives nothing by itself, so log the duty or voltage at the motor beside it \
                 (supply={own}:{})",
                part.unit
            ))
        }
        Quantity::Voltage if part.unit == "mV" && words::said(name).unit != Some("mV") => Some(format!(
            "\"{name}\" goes to {}, so it is taken for millivolts; where it is a duty, write duty={own}:{} --supply-volts 12",
            short(range.peak()),
            short(range.peak())
        )),
        Quantity::Duty if called == Some(Quantity::Voltage) && range.peak() > MOST_VOLTS => Some(format!(
            "\"{name}\" is taken for a duty because it goes to {}; where it is millivolts, write voltage={own}:mV",
            short(range.peak())
        )),
        Quantity::Current if part.guessed => Some(format!(
            "\"{name}\" goes to {}, so it is taken for mA; where it is amperes, write current={own}:A",
            short(range.peak())
        )),
        // Neither its name nor anything else makes it volts: the power of a robot kit's motor is in percent.
        Quantity::Voltage if called == Some(Quantity::Duty) && words::said(name).unit.is_none() => {
            Some(format!(
                "\"{name}\" is taken for volts because it goes to {} in fractions; where it is percent of full duty, write duty={own}:100 \
                 --supply-volts 12",
                short(range.peak())
            ))
        }
        _ => None,
    }
}

/// The only column of one of two files beside its time, where it is called nothing of what is sought: taken for `quantity` in `unit`, with
/// its name and what it is called in a mapping.
fn alone<'a>(
    sample: &'a Sample,
    parts: &[Part],
    sought: &[Quantity],
    (quantity, unit): (Quantity, &str),
) -> Option<(Part, &'a str, String)> {
    let clock = parts.iter().find(|part| part.quantity == Quantity::Time)?.index;
    let has_values =
        |k: usize| sample.rows.iter().any(|row| row.get(k).is_some_and(|value| value.is_finite()));
    let mut others = (0..sample.names.len()).filter(|k| *k != clock && has_values(*k));
    let (index, None) = (others.next()?, others.next()) else { return None };
    let part = Part { quantity, index, rest: None, unit: unit.into(), guessed: true, turn: None };
    let is_known = parts.iter().any(|part| sought.contains(&part.quantity));
    // A sensor may tell anything in volts.
    let unit_of = words::said(&sample.with_units[index]).unit_of;
    let is_other = unit_of.is_some_and(|of| of != Quantity::Voltage && !sought.contains(&of));
    (!is_known && !is_other).then(|| (part, sample.names[index].as_str(), column(&sample.names, index)))
}

/// Of the first of two files, which is that of what drives the motor, the only column beside the time, and what is said of it.
pub(super) fn drive_alone(input: &Sample, parts: &[Part]) -> Option<(Part, String)> {
    use Quantity::{Duty, Target, Voltage};
    let (part, name, own) = alone(input, parts, &[Duty, Target, Voltage], (Voltage, "V"))?;
    let said = format!(
        "\"{name}\" is taken for the motor's voltage, because it is all that this file holds; where it is a duty, write duty={own}:255 --supply-volts 12"
    );
    Some((part, said))
}

/// Of the second, which is that of the motion, the same.
pub(super) fn motion_alone(output: &Sample, parts: &[Part]) -> Option<(Part, String)> {
    use Quantity::{Angle, Speed};
    let (part, name, own) = alone(output, parts, &[Angle, Speed], (Speed, "rad/s"))?;
    let said = format!(
        "\"{name}\" is taken for the speed, because it is all that this file holds; where it is an angle, write angle={own}:rad (or deg, counts)"
    );
    Some((part, said))
}

/// What is asked of a table of which only the drive or only the motion is recognised, or that has no room for both.
pub(in crate::log) fn half_question(sample: &Sample) -> Option<String> {
    use Quantity::{Angle, Current, Duty, Interval, Speed, Time, Voltage};
    let parts = columns::parts(&sample.with_units, &sample.rows);
    let of = |quantities: &[Quantity]| parts.iter().find(|part| quantities.contains(&part.quantity));
    let known = |k: &usize| parts.iter().any(|part| part.index == *k || part.rest == Some(*k));
    let is_target = |k: &usize| words::said(&sample.names[*k]).target;
    // What numbers the rows neither drives nor moves.
    let is_number = |k: &usize| {
        let values = numbers(&sample.rows, *k);
        numbers_rows(&sample.names[*k], &values.collect::<Vec<_>>())
    };
    let (targets, mut others): (Vec<usize>, Vec<usize>) =
        (0..sample.names.len()).filter(|k| !known(k) && !is_number(k)).partition(is_target);
    // A current follows from the voltage: it neither drives nor moves.
    let is_current = |k: usize| words::said(&sample.names[k]).quantity.is_some_and(|(of, _)| of == Current);
    others.retain(|k| !is_current(*k));
    let name = |k: usize| format!("\"{}\"", sample.names[k]);
    let (drive, motion) = (of(&[Duty, Voltage]), of(&[Angle, Speed]));
    if let Some(own) = drive.or(motion).map(|part| &sample.names[part.index]) {
        let is_own = |k: &usize| sides::may_be_one(own, &sample.names[*k]);
        // Beside what somebody wanted of a motor its current one is no current.
        let is_wanted = |k: usize| words::said(&sample.names[k]).wanted && !is_current(k) && is_own(&k);
        let present =
            |part: &&Part| part.quantity == Current && words::said(&sample.names[part.index]).unit.is_none();
        if (0..sample.names.len()).any(is_wanted) {
            others.extend(parts.iter().filter(present).map(|part| part.index));
        }
        // What drives one motor turns no other.
        others.retain(is_own);
    }
    let sought = if drive.is_some() { [Angle, Speed] } else { [Duty, Voltage] };
    others.retain(|k| !is_of_another(&sample.with_units[*k], &sought));
    if let (None, Some(motion)) = (drive, motion) {
        let columns = made::Columns::of(&sample.rows, of(&[Time]).map(|clock| clock.index));
        let drives = |k: &usize| !words::drives_nothing(&sample.names[*k]) && !columns.is_made(*k);
        // A measured column in a unit of motion is one too, though another is fitted: `RPM_left` beside an angle.
        let is_motion = |k: &usize| {
            let said = words::said(&sample.with_units[*k]);
            let of_motion = said.unit_of.is_some_and(|of| [Angle, Speed].contains(&of));
            *k == motion.index || of_motion && !said.wanted && !said.target
        };
        let motions: Vec<usize> = (0..sample.names.len()).filter(is_motion).collect();
        let again = |k: usize| motions.iter().any(|of| is_motion_again(&sample.rows, *of, k));
        others.retain(|k| drives(k) && !again(*k));
    }
    // The first other column that may be what is absent, and the options for either meaning.
    let meant = |either: &str, or: &str| {
        others.iter().find_map(|&k| {
            let options = |as_if: &str| options_as_if(sample, &[(k, as_if)]);
            Some((name(k), options(either)?, options(or)?))
        })
    };
    // What a mapping that is proposed assumes of the time and of the full duty.
    let assumed = || {
        let of_clock = |clock: &Part| {
            guessed_unit(&sample.names[clock.index], clock).or_else(|| other_rate(sample, clock))
        };
        let of_duty = |duty: &Part| duty_range::question(&sample.names, &sample.rows, duty);
        let said = [of(&[Time]).and_then(of_clock), drive.and_then(of_duty)];
        let said: Vec<String> = said.into_iter().flatten().collect();
        if said.is_empty() { String::new() } else { format!(" ({})", said.join("; ")) }
    };
    let beside_time = |k: &usize| of(&[Time]).is_some_and(|time| time.index != *k) && !is_number(k);
    let mut beside = (0..sample.names.len()).filter(beside_time);
    if let (Some(only), None) = (beside.next(), beside.next()) {
        let apart = if channels::is_channel(&sample.names[only]) {
            "the files of both channels, that of the drive first, as CH1.CSV+CH2.CSV"
        } else {
            "a file of each as drive.csv+motion.csv"
        };
        return Some(format!(
            "beside the time there is only {}, and a fit needs two things: what drove the motor (a duty or voltage) and how it moved (an \
             angle, counts or a speed); log both in every row, or give {apart}",
            name(only)
        ));
    }
    match (drive, motion) {
        (None, Some(motion)) => {
            let mut text = format!(
                "{} is the motion, and no column tells what drove the motor: log its duty or voltage in every row",
                name(motion.index)
            );
            if let Some(target) = targets.first() {
                text += &format!(
                    "; {} is what a controller was to reach, and not what it gave the motor",
                    name(*target)
                );
                // What is wanted of a motion is in its unit; in volts or percent the driver may have been given it.
                let as_if = match words::said(&sample.with_units[*target]).unit_of {
                    Some(Duty) => Some("duty [%]"),
                    Some(Voltage) => Some("voltage [V]"),
                    _ => None,
                };
                if let Some(options) = as_if.and_then(|as_if| options_as_if(sample, &[(*target, as_if)])) {
                    text += &format!("; where the driver was given it, say {options}");
                }
            }
            text += &not_driving(sample, &parts, motion);
            // Beyond 100 there are no percent.
            let is_beyond = |k: &usize| Range::of(numbers(&sample.rows, *k)).peak() > MOST_PERCENT;
            let (as_if, is) = if others.first().is_some_and(is_beyond) {
                ("duty", "a duty with that number for full")
            } else {
                ("duty [%]", "percent")
            };
            if let Some((other, volts, duty)) = meant("voltage [V]", as_if) {
                text +=
                    &format!("; if {other} is that, say {volts} where it is volts, {duty} where it is {is}");
                text += &assumed();
            }
            Some(text)
        }
        (Some(drive), None) => {
            let untimed = of(&[Time, Interval]).is_none();
            if let Some(text) = untimed.then(|| steady_beside(sample, &others)).flatten() {
                return Some(text);
            }
            let mut text = format!(
                "{} drives the motor, and no column tells how it moved: log its angle, counts or speed in every row",
                name(drive.index)
            );
            if let Some((other, speed, count)) = meant("speed [rad/s]", "encoder count") {
                let counts = count.contains(":counts");
                let otherwise = if counts { "counts" } else { "is an angle" };
                text += &format!(
                    "; if {other} is that, say {speed} where it is a speed, {count} where it {otherwise}"
                );
                let place = others.iter().copied().find(|k| name(*k) == other);
                let read = |k: usize| symbols::readings(&sample.names[k], &sample.rows, k);
                for (as_if, means) in place.map(read).unwrap_or_default() {
                    let options = place.and_then(|k| options_as_if(sample, &[(k, as_if)]));
                    text += &options.map_or_else(String::new, |options| format!(", {options} {means}"));
                }
                text += &assumed();
            }
            Some(text)
        }
        _ => None,
    }
}

/// Whether a name tells a unit that none of these quantities has: an encoder's volts are no speed, and an acceleration is no voltage; or a number of
/// readings, which is neither.
fn is_of_another(name: &str, sought: &[Quantity]) -> bool {
    unit_names::is_of_acceleration(name)
        || words::counts_readings(&words::of(name))
        || words::said(name).unit_of.is_some_and(|of| !sought.contains(&of))
}

/// Whether a column is the `motion` in another unit: it goes with it in every row.
fn is_motion_again(rows: &[Vec<f64>], motion: usize, index: usize) -> bool {
    let both = |row: &Vec<f64>| Some((*row.get(motion)?, *row.get(index)?));
    let finite = |(one, other): &(f64, f64)| one.is_finite() && other.is_finite();
    let (one, other): (Vec<f64>, Vec<f64>) = rows.iter().filter_map(both).filter(finite).unzip();
    correlation(&one, &other).abs() > SAME
}

/// Why columns that may look like it do not drive the motor: one is the speed of the motion, one its supply, one its current.
fn not_driving(sample: &Sample, parts: &[Part], motion: &Part) -> String {
    let mut text = String::new();
    let said = |k: usize| words::said(&sample.with_units[k]).quantity.map(|(of, _)| of);
    let speed = parts.iter().find(|part| part.quantity == Quantity::Speed && part.index != motion.index);
    if let Some(speed) = speed.filter(|speed| said(speed.index) == Some(Quantity::Voltage)) {
        let [speed, angle] = [speed.index, motion.index].map(|k| &sample.names[k]);
        text += &format!("; \"{speed}\" is the change of \"{angle}\", its speed and no voltage");
    }
    if let Some(supply) = parts.iter().find(|part| part.quantity == Quantity::Supply) {
        let name = &sample.names[supply.index];
        text += &if said(supply.index) == Some(Quantity::Supply) {
            format!("; \"{name}\" is the supply's, which drives nothing by itself")
        } else {
            format!(
                "; \"{name}\" is as steady as a supply, which drives nothing by itself (where it is the voltage at the motor, map it so: voltage={}:{})",
                column(&sample.names, supply.index),
                supply.unit
            )
        };
    }
    if let Some(current) = parts.iter().find(|part| part.quantity == Quantity::Current) {
        text += &format!(
            "; \"{}\" is the motor's current, which follows from its voltage, also where a controller sets it",
            sample.names[current.index]
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_an_error_a_controllers_term_and_what_a_sensor_tells_are_not_offered_as_the_drive() {
        let asked = |third: &str| {
            let row = |k: u32| vec![0.01 * f64::from(k), f64::from(k * k % 97), f64::from(k * 7 % 31)];
            let header = format!("Time;Velocity;{third}");
            half_question(&Sample::of(&header, (0..100).map(row).collect())).unwrap()
        };
        let terms = ["Integral", "Derivative", "Proportional", "P term", "I_term", "dTerm", "error_sum"];
        for third in ["Acceleration", "LeftError", "Heading", "clock"].into_iter().chain(terms) {
            let asked = asked(third);
            assert!(asked.contains("no column tells what drove the motor"), "{asked}");
            assert!(!asked.contains("--map"), "{asked}");
        }
        assert!(asked("effect").contains("if \"effect\" is that, say --map "));
    }

    /// A current was offered as volts: a gain of a motor without its own voltage, and no word that it is none.
    #[test]
    fn a_current_and_a_torque_are_no_voltage_whoever_commanded_them() {
        let row = |k: u32| {
            let t = 0.01 * f64::from(k);
            let set = [0.0, 1.5, -0.7][k as usize / 30 % 3];
            vec![t, set, set + 0.01 * f64::from(k % 7), f64::from(k * k % 97)]
        };
        let rows: Vec<Vec<f64>> = (0..120).map(row).collect();
        for header in ["t;current_cmd;current;velocity", "t;iq_set;iq;omega", "t;current_target;current;rpm"]
        {
            let asked = half_question(&Sample::of(header, rows.clone())).unwrap();
            assert!(asked.contains("is the motor's current") && !asked.contains("--map"), "{asked}");
        }
        let sample = Sample::of("t;tau_cmd;tau_meas;qd", rows.clone());
        assert!(super::super::propose_for(&sample).is_none());
        let asked = super::super::effort_question(&sample).unwrap();
        assert!(asked.contains("tau_cmd is a torque") && !asked.contains("--map"), "{asked}");
        // What a motor does beside what was desired of it is called current too.
        let asked = half_question(&Sample::of("t;DESIRED_M1;CURRENT_M1;pwm", rows)).unwrap();
        assert!(asked.contains("if \"CURRENT_M1\" is that, say --map "), "{asked}");
    }

    #[test]
    fn a_current_whose_unit_its_size_alone_tells_is_told_as_a_guess() {
        let said = |name: &str| {
            let names = ["t", "u", "w", name].map(str::to_owned);
            let row = |k: u32| {
                let u = [0.0, 6.0, -3.0][k as usize / 30 % 3];
                vec![0.01 * f64::from(k), u, 3.0 * u, 20.0 * u]
            };
            super::super::propose(&names, &(0..90).map(row).collect::<Vec<_>>()).unwrap().assumptions()
        };
        assert!(said("current").contains("write current=current:A"), "{}", said("current"));
        for told in ["current_mA", "current_A", "current_motor"] {
            assert!(!said(told).contains("taken for mA"), "{told}: {}", said(told));
        }
    }

    #[test]
    fn a_set_point_in_percent_or_volts_may_be_what_the_driver_was_given() {
        let asked = |target: &str| {
            let row = |k: u32| {
                vec![10.0 * f64::from(k), [0.0, 50.0, 25.0][k as usize / 30 % 3], f64::from(k * k % 97)]
            };
            let header = format!("Zeit [ms];{target};Geschwindigkeit [mm/s]");
            half_question(&Sample::of(&header, (0..120).map(row).collect())).unwrap()
        };
        for (target, option) in
            [("Sollwert [%]", "duty=Sollwert [%]:100"), ("Sollwert [V]", "voltage=Sollwert [V]:V")]
        {
            assert!(asked(target).contains(option), "{}", asked(target));
        }
        assert!(!asked("Sollwert [mm/s]").contains("--map"), "{}", asked("Sollwert [mm/s]"));
    }

    #[test]
    fn what_may_be_the_drive_is_proposed_with_the_rate_where_the_times_have_whole_seconds() {
        let row = |k: u32| vec![f64::from(k / 12), f64::from(k * k % 97), f64::from(k * 7 % 31)];
        let sample = Sample::of("Time;Velocity;effect", (0..240).map(row).collect());
        let asked = half_question(&sample).unwrap();
        for options in
            ["voltage=effect:V,speed=Velocity:rad/s --rate 12 where", "--supply-volts 12 --rate 12 where"]
        {
            assert!(asked.contains(options), "{asked}");
        }
    }

    /// The power of a flywheel, in percent, was proposed as volts without a word.
    #[test]
    fn a_command_that_is_taken_for_volts_by_its_size_alone_is_told_as_a_guess() {
        let said = |name: &str| {
            let names = ["t", name, "rpm"].map(str::to_owned);
            let level = |k: u32| [0.0, 30.8, 56.4][(k / 30 % 3) as usize];
            let rows: Vec<Vec<f64>> =
                (0..90).map(|k| vec![0.01 * f64::from(k), level(k), 3.0 * f64::from(k)]).collect();
            super::super::propose(&names, &rows).unwrap()
        };
        for name in ["Power", "Output", "cmd"] {
            let proposal = said(name);
            assert!(proposal.map.contains(&format!("voltage={name}:V")), "{}", proposal.map);
            let told = format!("where it is percent of full duty, write duty={name}:100 --supply-volts 12");
            assert!(proposal.assumptions().contains(&told), "{}", proposal.assumptions());
        }
        for name in ["Power [V]", "u", "voltage"] {
            assert!(!said(name).assumptions().contains("percent"), "{name}");
        }
    }

    #[test]
    fn the_speed_of_a_wheel_is_not_offered_as_its_drive_though_its_angle_is_the_motion() {
        let row = |k: u32| {
            let rpm = f64::from(k * 11 % 53);
            vec![0.01 * f64::from(k), f64::from(k * k % 97), f64::from(k * 7 % 31), rpm, 0.5 * rpm]
        };
        let header = "Time (s);Position_left (deg);Angular_Velocity (deg/s);RPM_left;Speed_left";
        let asked = half_question(&Sample::of(header, (0..100).map(row).collect())).unwrap();
        assert!(
            asked.contains("no column tells what drove the motor") && !asked.contains("--map"),
            "{asked}"
        );
    }
}
