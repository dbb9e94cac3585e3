//! The records of the run: the virtual motor's, or the user's own.

use motorlens_shared::excitation::Programme;
use motorlens_shared::linear::{Hold as LinearHold, Kind as LinearKind};
use motorlens_shared::motor::{Nameplate, PaperMotor};
use motorlens_virtual_motor::{Effect, EncoderShaft, Motor};

use super::PaperArgs;
use crate::error::{Error, Result};
use crate::log::motion::peak;
use crate::log::{self, Hold, Record};
use crate::motor_file::{self, MotorFile};
use crate::search::LinearRecord;
use crate::simulate::{Play, Role, Scenario};

/// Amplitudes of the paper's three sines, V.
pub const AMPLITUDES_V: [f32; 3] = [3.0, 5.0, 7.0];

/// What the virtual motor hides: a fan on the shaft, whose drag grows with the square of the speed. The level
/// (V at the no-load speed) makes the linear model's error at 7 V the share of the motion that Table 2 shows.
pub const HIDDEN: &str = "quadratic_drag=5";

/// Records and what is known of the motor before any fit.
#[derive(Debug, Clone)]
pub struct Data {
    /// In rising order of their largest voltage.
    pub records: Vec<Record>,
    /// Name plate and rig.
    pub motor: MotorFile,
    /// What was hidden, where this program knows.
    pub hidden: Option<&'static str>,
}

/// The user's logs where there are any, else the virtual motor's.
///
/// # Errors
/// Bad input in logs or motor file.
pub fn data(args: &PaperArgs) -> Result<Data> {
    let mut data = if args.on.is_empty() { virtual_records(args)? } else { own_records(args)? };
    data.records.sort_by(|a, b| peak(&a.voltage_v).total_cmp(&peak(&b.voltage_v)));
    log::check_all_usable(&data.records)?;
    Ok(data)
}

fn own_records(args: &PaperArgs) -> Result<Data> {
    let records = log::load(&args.on, &args.reading)?.records;
    Ok(Data { records, motor: args.reading.motor_file()?, hidden: None })
}

fn virtual_records(args: &PaperArgs) -> Result<Data> {
    let effect = Effect::parse(HIDDEN).map_err(|error| Error::Usage {
        why: error.to_string(),
        remedy: "choose an effect that `motorlens effects` lists".into(),
    })?;
    let mut scenario = Scenario::new(Motor::paper(), vec![effect], args.seed);
    scenario.rate_hz = rate_hz(args)?;
    scenario.run.rate_hz = f64::from(scenario.rate_hz);
    let plays = AMPLITUDES_V.map(|amplitude| {
        let shape = Programme::paper(amplitude);
        let name = format!("{amplitude}-sin-0.5-pi-t");
        let programme = Programme::single(&name, shape.segments[0].shape, shape.seconds());
        Play { role: Role::Training, programme }
    });
    Ok(Data { records: scenario.records(&plays)?, motor: data_sheet(), hidden: Some(HIDDEN) })
}

/// Samples per second of the virtual motor's logs where nothing else is asked.
const RATE_HZ: f64 = 100.0;

/// Samples per second of the virtual motor's logs.
fn rate_hz(args: &PaperArgs) -> Result<u32> {
    let rate = args.reading.rate.unwrap_or(RATE_HZ);
    if rate.fract() == 0.0 && (20.0..=10_000.0).contains(&rate) {
        return Ok(rate as u32);
    }
    Err(Error::usage(
        format!("the virtual motor cannot be sampled at {rate} Hz"),
        "give a whole number from 20 to 10000 with --rate",
    ))
}

/// What a data sheet would say of the virtual motor: rounded, of the series and not of this piece.
fn data_sheet() -> MotorFile {
    MotorFile {
        gear_ratio: Some(104.0),
        counts_per_rev: Some(5000.0),
        encoder_shaft: Some(motor_file_shaft(Motor::paper().encoder_shaft)),
        nameplate: motor_file::Nameplate {
            voltage_v: Some(12.0),
            no_load_speed_rad_s: Some(6.0),
            stall_current_a: Some(2.0),
            inductance_h: Some(3e-3),
            mechanical_time_constant_s: Some(0.03),
            ..motor_file::Nameplate::default()
        },
        ..MotorFile::default()
    }
}

fn motor_file_shaft(shaft: EncoderShaft) -> log::EncoderShaft {
    match shaft {
        EncoderShaft::Motor => log::EncoderShaft::Motor,
        EncoderShaft::Output => log::EncoderShaft::Output,
    }
}

/// A first guess of all eight parameters: the name plate where it speaks, else the data, else the ordinary.
pub fn nameplate_start(data: &Data) -> PaperMotor {
    let plate = &data.motor.nameplate;
    let voltage = plate.voltage_v.unwrap_or(12.0);
    let no_load_speed =
        plate.no_load_speed_rad_s.unwrap_or_else(|| voltage * speed_per_volt(&data.records).max(1e-6));
    let stall_current = plate.stall_current_a.or(plate.resistance_ohm.map(|r| voltage / r)).unwrap_or(1.0);
    Nameplate {
        voltage,
        no_load_speed,
        stall_current,
        gear_ratio: data.motor.gear_ratio.unwrap_or(1.0),
        mechanical_time_constant: plate.mechanical_time_constant_s.unwrap_or(0.05),
        inductance: plate.inductance_h.unwrap_or(1e-3 * voltage / stall_current),
    }
    .first_guess()
}

/// Where no plate tells: how far the motor went for what it was given.
fn speed_per_volt(records: &[Record]) -> f64 {
    let span = |x: &[f64]| {
        let (low, high) = x.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        high - low
    };
    let of = |record: &Record| match (&record.angle_rad, &record.speed_rad_s) {
        (Some(angle), _) => {
            let mut integral = 0.0;
            let steps = record.time_s.windows(2).map(|t| t[1] - t[0]);
            let path: Vec<f64> = steps
                .zip(&record.voltage_v)
                .map(|(dt, v)| {
                    integral += dt * v;
                    integral
                })
                .collect();
            span(angle) / span(&path).max(1e-9)
        }
        (None, Some(speed)) => peak(speed) / peak(&record.voltage_v).max(1e-9),
        (None, None) => 0.0,
    };
    records.iter().map(of).fold(0.0, f64::max)
}

/// The records on an even grid, as the linear search needs them.
pub fn even(records: &[Record]) -> Vec<LinearRecord> {
    records.iter().filter_map(even_record).collect()
}

/// Interpolates where the time stamps are uneven; angle where it was measured, else speed.
fn even_record(record: &Record) -> Option<LinearRecord> {
    let (measured, kind) = match (&record.angle_rad, &record.speed_rad_s) {
        (Some(angle), _) => (angle, LinearKind::Angle),
        (None, Some(speed)) => (speed, LinearKind::Speed),
        (None, None) => return None,
    };
    let dt = log::timing::median_interval(&record.time_s);
    let first = *record.time_s.first()?;
    let count = (record.duration_s() / dt + 1e-6) as usize + 1;
    let mut voltage = Vec::with_capacity(count);
    let mut values = Vec::with_capacity(count);
    let mut k = 0;
    for n in 0..count {
        let t = first + n as f64 * dt;
        // Half a millionth of a step keeps rounding of the stamps from choosing the sample before.
        while k + 1 < record.len() && record.time_s[k + 1] <= t + 0.5e-6 * dt {
            k += 1;
        }
        let next = (k + 1).min(record.len() - 1);
        let gap = record.time_s[next] - record.time_s[k];
        let part = if gap > 0.0 { ((t - record.time_s[k]) / gap).clamp(0.0, 1.0) } else { 0.0 };
        let between = |x: &[f64]| x[k] + part * (x[next] - x[k]);
        values.push(between(measured));
        voltage.push(match record.hold {
            Hold::Zero => record.voltage_v[k],
            Hold::First => between(&record.voltage_v),
        });
    }
    let hold = match record.hold {
        Hold::Zero => LinearHold::Zero,
        Hold::First => LinearHold::First,
    };
    Some(LinearRecord { dt, voltage, measured: values, kind, hold })
}

#[cfg(test)]
mod tests {
    use super::{even, speed_per_volt};
    use crate::log::Record;

    #[test]
    fn uneven_stamps_come_to_an_even_grid_with_the_voltage_still_held() {
        let record = Record {
            time_s: vec![0.0, 0.1, 0.2, 0.35, 0.4],
            voltage_v: vec![1.0, 2.0, 3.0, 4.0, 5.0],
            angle_rad: Some(vec![0.0, 1.0, 2.0, 3.5, 4.0]),
            ..Record::default()
        };
        let grid = &even(&[record])[0];
        assert!((grid.dt - 0.1).abs() < 1e-12);
        assert_eq!(grid.voltage, [1.0, 2.0, 3.0, 3.0, 5.0]);
        for (value, truth) in grid.measured.iter().zip([0.0, 1.0, 2.0, 3.0, 4.0]) {
            assert!((value - truth).abs() < 1e-9);
        }
    }

    #[test]
    fn speed_per_volt_is_what_the_motor_went_for_what_it_got() {
        let record = Record {
            time_s: (0..100).map(|k| f64::from(k) * 0.01).collect(),
            voltage_v: vec![2.0; 100],
            angle_rad: Some((0..100).map(|k| f64::from(k) * 0.01).collect()),
            ..Record::default()
        };
        assert!((speed_per_volt(&[record]) - 0.5).abs() < 0.02);
    }
}
