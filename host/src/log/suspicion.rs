//! Data quality problems in the content of records, though each could be used as it is.
//!
//! A fault of the data mimics physics: a shifted column is a delay, a stale one a filter, a record in other volts a
//! nonlinear motor. So they are looked for first, and told beside every answer. Nothing here refuses a record.

use super::beyond_full::beyond_full;
use super::clipped::clipped;
use super::disagreeing::disagreeing;
use super::early::early;
use super::held_back::held_back;
use super::hold::hold;
use super::low_active::inverted;
use super::mistaken::{angle_as_speed, frozen, speed_as_angle, turned_round};
use super::one_level::one_level;
use super::quantum::quantum;
use super::readings::{blind_near_zero, speed_beside_angle};
use super::remap::remapped;
use super::shifted::shifted;
use super::stale::stale_voltage;
use super::stands_amid::stands_amid;
use super::stops::hard_stop;
use super::switched_off::switched_off;
use super::target_as_drive::target_as_drive;
use super::timing::{median_interval, quantile};
use super::turned_from_outside::turned_from_outside;
use super::units::Quantity;
use super::unsigned::byte_duty;
use super::unsigned_current::unsigned_current;
use super::usable::faults_of;
use super::voltages::{antiphase, duty, share, unsigned, unsigned_motion};
use super::weak::Weak;
use super::{Record, Warning, together};

/// A finding about one record: short name, column, cause, remedy.
pub(super) type Odd = (&'static str, &'static str, String, String);

/// A record and its regression, where it moves enough for one.
pub(super) struct Seen<'a> {
    pub record: &'a Record,
    pub weak: Option<Weak<'a>>,
}

impl<'a> Seen<'a> {
    pub fn of(record: &'a Record) -> Self {
        Self { record, weak: Weak::new(record) }
    }
}

/// The data quality problems that reader and judge found, and those of the content: all that is told before any physics.
pub fn data_faults<'a>(records: impl IntoIterator<Item = &'a Record> + Clone) -> Vec<Warning> {
    together(faults_of(records.clone()).into_iter().chain(suspicions(records)))
}

/// Data quality problems of `records`, each by itself and against each other.
pub fn suspicions<'a>(records: impl IntoIterator<Item = &'a Record>) -> Vec<Warning> {
    let alone = [
        beyond_full,
        beyond_supply,
        constant_supply,
        stale_voltage,
        stale,
        jumps,
        hard_stop,
        held_back,
        driver_off,
        turned_from_outside,
        speed_beside_angle,
        blind_near_zero,
        byte_duty,
        inverted,
        target_as_drive,
        unsigned,
        unsigned_motion,
        unsigned_current,
        frozen,
    ];
    let regressed = [clipped, wrong_gear, angle_as_speed, speed_as_angle, turned_round, antiphase];
    let seen: Vec<Seen> = records.into_iter().map(Seen::of).collect();
    let mut found = Vec::new();
    for one in &seen {
        let odd = alone.iter().filter_map(|check| check(one.record));
        for (name, column, why, fix) in odd.chain(regressed.iter().filter_map(|check| check(one))) {
            found.push(Warning { place: place_of(one.record, column), what: format!("{name}: {why}"), fix });
        }
    }
    let all: Vec<&Record> = seen.iter().map(|one| one.record).collect();
    // By whole rows, or by a part of one.
    found.extend(shifted(&seen).or_else(|| early(&all)));
    found.extend(disagreeing(&seen));
    found.extend(duty(&all));
    found.extend(share(&all));
    found.extend(one_level(&all));
    found
}

/// The driver was off at times: steady motion ended without a change of the drive, or the motor stood while that went to both sides.
fn driver_off(record: &Record) -> Option<Odd> {
    switched_off(record).or_else(|| stands_amid(record))
}

/// The `column` of `record`, as a data problem has its place.
pub(crate) fn place_of(record: &Record, column: &str) -> String {
    let file = record.path.display().to_string();
    format!("{}, column {column}", if file.is_empty() { &record.name } else { &file })
}

/// Said of a voltage that the supply cannot give, so that nothing was driven by it.
pub(crate) const BEYOND_SUPPLY: &str = "lie above the supply's own voltage";

/// Said of motion that no effect explains: none acts before its cause.
pub(crate) const BEFORE_ITS_VOLTAGE: &str = "before its voltage";

/// A voltage that the supply cannot give is a command.
fn beyond_supply(record: &Record) -> Option<Odd> {
    let supply = record.supply_v.as_ref()?;
    let beyond = record.voltage_v.iter().zip(supply).filter(|(v, s)| v.abs() > 1.05 * s.abs()).count();
    (beyond as f64 > 0.005 * record.len() as f64).then(|| {
        (
            "commanded_voltage",
            "voltage_v",
            format!("{beyond} samples {BEYOND_SUPPLY}, so this is the command and not what was applied"),
            "give the duty instead: --map duty=COLUMN:FULL,supply=SUPPLY, which follows the supply".into(),
        )
    })
}

/// A duty times one number is a command too.
fn constant_supply(record: &Record) -> Option<Odd> {
    let how = record.meta.get("voltage")?;
    Some((
        "commanded_voltage",
        "voltage_v",
        format!("the voltage was not measured: {how}"),
        "log the supply's voltage with every sample (--map supply=COLUMN), or the motor's own; until then a sag of the \
         supply looks like a property of the motor"
            .into(),
    ))
}

/// The motion is read less often than it is logged.
fn stale(record: &Record) -> Option<Odd> {
    let (column, values) = measured(record)?;
    let hold = hold(&record.time_s, values)?;
    let samples = hold.time_s / median_interval(&record.time_s);
    (samples > HELD).then(|| {
        (
            "stale_samples",
            column,
            format!(
                "a new reading comes only every {:.3} ms, {samples:.1} samples, and the last one is repeated in between",
                1e3 * hold.time_s
            ),
            "log at the rate at which the sensor is read, or only when it is; else the effect sensor_lag takes part of \
             it"
                .into(),
        )
    })
}

/// Readings are called stale where they are held for more samples than this.
const HELD: f64 = 1.5;

/// A change of angle this many times that of the fastest motion is none; of all changes this share are not larger than that motion makes.
const JUMP: f64 = 8.0;
const FASTEST: f64 = 0.995;

/// The counter was reset, overflowed, or a reading was garbled.
fn jumps(record: &Record) -> Option<Odd> {
    let angle = record.angle_rad.as_ref()?;
    let steps: Vec<f64> = angle.windows(2).map(|p| (p[1] - p[0]).abs()).collect();
    let usual = quantile(&mut steps.clone(), FASTEST);
    let count = quantum(angle).unwrap_or(0.0);
    let limit = JUMP * usual.max(count) + 4.0 * count;
    let far: Vec<usize> = (0..steps.len()).filter(|k| steps[*k] > limit && usual > 0.0).collect();
    let first = *far.first()?;
    // Worse data gets no fewer words.
    (far.len() < 1 + steps.len() / 20).then(|| {
        (
            "lost_counts",
            "angle_rad",
            format!(
                "the angle jumps {} times, first by {:.3} rad at {:.3} s, which no motion explains: the counter was reset, overflowed or lost counts",
                far.len(),
                angle[first + 1] - angle[first],
                record.time_s[first + 1]
            ),
            "read the counter in full width and without pauses; cut the file at the jumps and give the parts as records".into(),
        )
    })
}

/// The encoder's count shows on which side of the gears the angle is.
fn wrong_gear(Seen { record, weak }: &Seen) -> Option<Odd> {
    let gear = record.meta.gear_ratio().filter(|g| *g > 1.5)?;
    let told = record.angle_rad.as_ref().and_then(|angle| {
        let ratio = quantum(angle)? * record.meta.counts_per_rev()? / std::f64::consts::TAU;
        [(gear, "the motor's shaft"), (1.0 / gear, "geared down twice")]
            .into_iter()
            .find(|(factor, _)| (ratio / factor - 1.0).abs() < 0.03)
            .map(|(factor, what)| (format!("one encoder count is {ratio:.4} times what it is at the output shaft: the angle is of {what}"), factor))
    });
    let by_plate = || {
        let plate = record.meta.no_load_gain()?;
        let ratio = weak.as_ref()?.regress(0.0, |v| v)?.gain / plate;
        [gear, 1.0 / gear]
            .into_iter()
            .find(|factor| gear > 4.0 && (ratio / factor).ln().abs() < 0.35)
            .map(|factor| (format!("the motor turns {ratio:.3} times as far per volt as its name plate says, which is the gear ratio"), factor))
    };
    let (why, factor) = told.or_else(by_plate)?;
    let column = if record.angle_rad.is_some() { "angle_rad" } else { "speed_rad_s" };
    let quantity = if record.angle_rad.is_some() { Quantity::Angle } else { Quantity::Speed };
    let turn = if factor > 1.0 { format!("/{gear}") } else { format!("*{gear}") };
    Some((
        "wrong_gear_ratio",
        column,
        why,
        format!(
            "say {}, or correct gear_ratio and counts_per_rev",
            remapped(record, &[(quantity, quantity, &turn)])
        ),
    ))
}

fn measured(record: &Record) -> Option<(&'static str, &Vec<f64>)> {
    let angle = record.angle_rad.as_ref().map(|a| ("angle_rad", a));
    angle.or_else(|| record.speed_rad_s.as_ref().map(|s| ("speed_rad_s", s)))
}
