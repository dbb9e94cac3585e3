//! Whether a record can teach anything about a motor.
//!
//! The reader takes every well-formed log. The verbs that fit call [`check_usable`]; a diagnosis lists
//! [`content_faults`] instead and goes on where it can.

use super::motion::{mean, peak, span, speed};
use super::quantum::quantum;
use super::refused::other_than_refused;
use super::reversed::{self, SIGN_FLIPPED, reversed};
use super::supply_as_drive::supply_as_drive;
use super::suspicion::place_of;
use super::target_check::target_fault;
use super::{Record, Warning, sysid, unit_check};
use crate::error::{BadInput, Error, Result};

/// Less motion than this in a whole record is none, rad (or rad/s).
const NO_MOTION: f64 = 1e-4;

/// Something about the content of a record that keeps it from being used as it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// A short name for programs.
    pub name: &'static str,
    /// The canonical column at fault.
    pub column: &'static str,
    /// The cause, with figures.
    pub why: String,
    /// What to do.
    pub fix: String,
}

impl Fault {
    /// The fault as it is listed in `data_faults`.
    pub fn to_warning(&self, record: &Record) -> Warning {
        Warning {
            place: place_of(record, self.column),
            what: format!("{}: {}", self.name, self.why),
            fix: self.fix.clone(),
        }
    }
}

/// Refuses records of one motor of which no fit could use one. A reversed sign shows in every record that moves the motor: one that runs
/// against the voltage alone, at less voltage than others that do not, was moved by something else.
///
/// # Errors
/// As [`check_usable`].
pub fn check_all_usable<'a>(records: impl IntoIterator<Item = &'a Record>) -> Result<()> {
    let highest = |record: &Record| peak(&record.voltage_v);
    let judged = content_faults_of(records);
    let aligned = judged.iter().filter(|(_, faults)| faults.is_empty()).map(|(record, _)| highest(record));
    let aligned = aligned.fold(0.0, f64::max);
    let excused =
        |record: &Record, fault: &Fault| fault.name == SIGN_FLIPPED && 2.0 * highest(record) < aligned;
    for (record, faults) in judged {
        if let Some(fault) = faults.into_iter().find(|fault| !excused(record, fault)) {
            return Err(refusal(record, fault));
        }
    }
    Ok(())
}

/// Refuses to begin without any record.
///
/// # Errors
/// Wrong usage.
pub(crate) fn check_some(records: &[Record]) -> Result<()> {
    if records.is_empty() {
        return Err(Error::usage("there is no record", "give at least one, of a motor that turns"));
    }
    Ok(())
}

/// Refuses a record that no fit could use: wrong units, no excitation, no motion, reversed sign.
///
/// # Errors
/// Bad input that names file, first data column at fault, cause and remedy.
pub fn check_usable(record: &Record) -> Result<()> {
    check_all_usable([record])
}

fn refusal(record: &Record, fault: Fault) -> crate::error::Error {
    let why = if record.name == super::stem(&record.path) {
        fault.why
    } else {
        format!("{}: {}", record.name, fault.why)
    };
    let refused = BadInput::new(&record.path, why, fault.fix).in_column(fault.column).into();
    other_than_refused(refused, record.map.as_ref())
}

/// All that is wrong with the content of `record`, the gravest first.
pub fn content_faults(record: &Record) -> Vec<Fault> {
    // A voltage that follows from such a target says nothing.
    if let Some(fault) = target_fault(record) {
        return vec![fault];
    }
    let mut faults = unit_check::unit_faults(record);
    faults.extend(no_excitation(record).or_else(|| supply_as_drive(record)));
    match no_motion(record) {
        Some(fault) => faults.push(fault),
        None => faults.extend(reversed(record)),
    }
    faults
}

/// The content faults of each of `records`, with remedies that are right for the others of them too: a column is turned round for all
/// that are read by one mapping.
pub(super) fn content_faults_of<'a>(
    records: impl IntoIterator<Item = &'a Record>,
) -> Vec<(&'a Record, Vec<Fault>)> {
    let mut judged: Vec<(&Record, Vec<Fault>)> =
        records.into_iter().map(|record| (record, content_faults(record))).collect();
    let right: Vec<&Record> =
        judged.iter().filter(|(_, faults)| faults.is_empty()).map(|(record, _)| *record).collect();
    for (record, faults) in &mut judged {
        let has_right = right.iter().any(|other| other.map == record.map);
        for fault in faults.iter_mut().filter(|fault| fault.name == SIGN_FLIPPED && has_right) {
            fault.fix = reversed::remedy_beside_others(record);
        }
    }
    judged
}

/// The data quality problems that the reader and the judge of its content found in `record`.
pub fn faults(record: &Record) -> Vec<Warning> {
    faults_of([record])
}

/// The data quality problems that the reader and the judge of their content found in `records`, one after the other.
pub(super) fn faults_of<'a>(records: impl IntoIterator<Item = &'a Record>) -> Vec<Warning> {
    let of = |(record, faults): (&Record, Vec<Fault>)| {
        let judged: Vec<Warning> = faults.into_iter().map(|fault| fault.to_warning(record)).collect();
        record.warnings.iter().cloned().chain(judged).collect::<Vec<_>>()
    };
    content_faults_of(records).into_iter().flat_map(of).collect()
}

fn no_excitation(record: &Record) -> Option<Fault> {
    let voltage = &record.voltage_v;
    // The dynamic tests of SysId hold the voltage from rest on; their ramps supply what they lack.
    if record.meta.get(sysid::TEST_KEY).is_some() || span(voltage) > 1e-6 * peak(voltage).max(1e-3) {
        return None;
    }
    if rises(record) {
        return None;
    }
    let level = voltage.first().copied().unwrap_or_default();
    let against = if turns_against(record, level) {
        "; and the motor turns the other way, so the sign of the motion or of the voltage is reversed, or something else drives it"
    } else if level == 0.0 && peak(&speed(record)) > 0.0 {
        "; a motor that runs out tells its friction beside its inertia and no gain (log what drove it before in the same record)"
    } else {
        ""
    };
    Some(Fault {
        name: "constant_voltage",
        column: "voltage_v",
        why: format!(
            "the voltage is {level:.3} V from the first line to the last, so nothing shows how the motor answers to it{against}"
        ),
        fix: "record a programme that changes the voltage (motorlens plan writes one), and check that this column is the applied voltage".into(),
    })
}

/// Share of all that a motor turns under one voltage that is against it, from which it turns the other way.
const AGAINST: f64 = 0.6;

/// Whether the motor turns mostly against the one voltage that it has.
fn turns_against(record: &Record, level: f64) -> bool {
    let motion = speed(record);
    let against: f64 = motion.iter().map(|w| (-w * level.signum()).max(0.0)).sum();
    against > AGAINST * motion.iter().map(|w| w.abs()).sum::<f64>() && level != 0.0
}

/// Whether the record begins near rest under its one voltage and runs up: a step from the first row on.
fn rises(record: &Record) -> bool {
    let motion = speed(record);
    let fifth = motion.len() / 5;
    let (first, last, highest) =
        (mean(&motion[..fifth]), mean(&motion[motion.len() - fifth..]), peak(&motion));
    let start = motion.first().copied().unwrap_or_default();
    let voltage = record.voltage_v.first().copied().unwrap_or_default();
    voltage != 0.0
        && last * voltage > 0.0
        && last.abs() > 0.7 * highest
        && start.abs() < 0.5 * highest
        && first.abs() < last.abs()
}

fn no_motion(record: &Record) -> Option<Fault> {
    let (column, moved, values) = match (&record.angle_rad, &record.speed_rad_s) {
        (Some(angle), _) => ("angle_rad", span(angle), angle),
        // A reading that rests beside zero while the voltage changes is no motion either.
        (None, Some(speed)) if span(&record.voltage_v) > 0.0 && span(speed) == 0.0 => {
            ("speed_rad_s", 0.0, speed)
        }
        (None, Some(speed)) => ("speed_rad_s", peak(speed), speed),
        (None, None) => return None,
    };
    if moved > NO_MOTION.max(2.0 * quantum(values).unwrap_or(0.0)) {
        return None;
    }
    Some(Fault {
        name: "no_motion",
        column,
        why: format!(
            "the motor never moves although the voltage reaches {:.3} V: its breakaway voltage is higher, or it is not driven",
            peak(&record.voltage_v)
        ),
        fix: "raise the voltage above the friction; check the motor's supply, the enable line and the encoder's plug; beside records \
              that move, this one is taken to tell the breakaway voltage and nothing else"
            .into(),
    })
}

#[cfg(test)]
pub(in crate::log) mod tests {
    use super::*;
    use crate::log::motion::slope;
    use crate::log::read_tests::assert_bad;

    /// A first-order motor under a staircase that reverses, 100 Hz, 20 s.
    pub(in crate::log) fn motor() -> Record {
        let time: Vec<f64> = (0..2000).map(|i| i as f64 * 0.01).collect();
        let voltage: Vec<f64> = (0..2000).map(|i| (((i / 100) * 7) % 13) as f64 - 6.0).collect();
        let (mut speed, mut angle) = (0.0, 0.0);
        let mut angles = Vec::new();
        for v in &voltage {
            angles.push(angle);
            speed += 0.1 * (0.6 * v - speed);
            angle += 0.01 * speed;
        }
        Record {
            name: "run".into(),
            path: "run.csv".into(),
            time_s: time,
            voltage_v: voltage,
            angle_rad: Some(angles),
            ..Record::default()
        }
    }

    pub(in crate::log) fn as_speed(mut record: Record) -> Record {
        record.speed_rad_s = record.angle_rad.take().map(|angle| slope(&record.time_s, &angle));
        record
    }

    #[test]
    fn a_moving_motor_is_usable_by_angle_speed_or_both() {
        let both = Record { angle_rad: motor().angle_rad, ..as_speed(motor()) };
        for record in [motor(), as_speed(motor()), both] {
            assert_eq!(content_faults(&record), []);
            check_usable(&record).unwrap();
        }
    }

    #[test]
    fn a_constant_voltage_is_refused_unless_it_is_a_sysid_step() {
        let mut record = motor();
        record.voltage_v.fill(5.0);
        assert_bad(
            &check_usable(&record).unwrap_err(),
            "run.csv, column voltage_v",
            "5.000 V from the first",
            "plan",
        );
        record.angle_rad = Some(record.time_s.iter().map(|t| -3.0 * t).collect());
        assert_bad(&check_usable(&record).unwrap_err(), "column voltage_v", "turns the other way", "plan");
        record.voltage_v.fill(0.0);
        assert_bad(&check_usable(&record).unwrap_err(), "column voltage_v", "runs out", "plan");
        record.meta.insert(sysid::TEST_KEY, "fast-forward").unwrap();
        assert!(no_excitation(&record).is_none());
    }

    #[test]
    fn a_motor_that_never_moves_is_refused_even_if_a_count_flickers() {
        let mut record = motor();
        record.angle_rad = Some((0..2000).map(|i| 1.0 + f64::from(i % 2) * 1e-5).collect());
        assert_bad(&check_usable(&record).unwrap_err(), "column angle_rad", "never moves", "enable line");
        let mut record = as_speed(record);
        record.speed_rad_s = Some(vec![0.0; 2000]);
        assert_bad(&check_usable(&record).unwrap_err(), "column speed_rad_s", "never moves", "encoder");
    }
}
