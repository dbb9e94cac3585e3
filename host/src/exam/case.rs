//! Hidden cases: a random motor with known effects, driven through the default protocol.

use motorlens_shared::excitation::{Player, Programme};
use motorlens_virtual_motor as plant;
use plant::{Effect, EncoderShaft as Shaft, Kind, Motor, Run, VirtualMotor};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::compare::free_run::within_a_count;
use crate::log::repeats::differences;
use crate::log::{EncoderShaft, Record};
use crate::motor_file::{MotorFile, Nameplate};

/// How far a case is from the ideal laboratory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// Share of cases with a torque disturbance of 1-5 % of stall.
    pub disturbed: f64,
    /// Share of cases with noise on the logged voltage, one that begins in motion, jitter; each on its own.
    pub spoilt: f64,
}

/// A case: what is hidden, and the logs.
#[derive(Debug)]
pub struct Case {
    /// Names of the hidden effects.
    pub truth: Vec<&'static str>,
    /// Their sizes, in words.
    pub sizes: String,
    /// The motor's logs to fit.
    pub records: Vec<Record>,
    /// A log to keep out.
    pub held_out: Vec<Record>,
    /// What the user knows.
    pub motor: MotorFile,
    /// Noise level, rad: counting and disturbance, measured by a second run, and what the motor
    /// would have made of the noise on the logged voltage.
    pub floor_rad: f64,
    /// Deviation of the torque disturbance, as a share of the stall torque.
    pub disturbance: f64,
    /// Conditions, in words.
    pub conditions: String,
}

/// Which training programme is run twice: the multisine.
const REPEATED: usize = 2;
/// Runs of the programme kept out from which the floor is measured.
const SECOND_RUNS: [u64; 4] = [101, 102, 103, 104];
/// Sampling rates of the cases, Hz.
const RATES: [u32; 4] = [100, 200, 500, 1000];

impl Case {
    /// Case `seed` with `kinds` hidden.
    pub fn new(seed: u64, kinds: &[Kind], conditions: Conditions) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let motor = if rng.random::<f64>() < 0.2 { Motor::paper() } else { Motor::hidden(seed) };
        let effects: Vec<Effect> = kinds.iter().map(|k| Effect::random(*k, &mut rng, &motor)).collect();
        let rate = RATES[rng.random_range(0..RATES.len())];
        let mut run = Run::at(f64::from(rate));
        let mut words = vec![format!("{rate} Hz, gear {:.0}", motor.gear_ratio)];
        if rng.random::<f64>() < conditions.disturbed {
            run.disturbance = rng.random_range(0.01..0.05);
            words.push(format!("disturbance {:.1} %", 100.0 * run.disturbance));
        }
        if rng.random::<f64>() < conditions.spoilt {
            run.voltage_noise_v = motor.nominal_v * rng.random_range(0.002..0.01);
            words.push(format!("voltage noise {:.0} mV", 1e3 * run.voltage_noise_v));
        }
        if rng.random::<f64>() < conditions.spoilt {
            run.start_v = motor.nominal_v * rng.random_range(-0.6..0.6);
            words.push("begins in motion".into());
        }
        if rng.random::<f64>() < conditions.spoilt {
            run.jitter = rng.random_range(0.05..0.4);
            words.push(format!("jitter {:.0} %", 100.0 * run.jitter));
        }
        let protocol = Programme::default_protocol(motor.nominal_v as f32);
        let make = |programme: &Programme, again: u64| {
            let mut plant = VirtualMotor::new(&motor, &effects, seed.wrapping_mul(31).wrapping_add(again));
            record(&mut plant, programme, rate, &run)
        };
        let mut records: Vec<Record> =
            protocol.training.iter().enumerate().map(|(k, p)| make(p, k as u64)).collect();
        records.push(make(&protocol.training[REPEATED], 99));
        let held_out = vec![make(&protocol.held_out, 100)];
        // Runs at even stamps: between jittering ones a second run would have to be interpolated.
        let even = Run { voltage_noise_v: 0.0, jitter: 0.0, ..run.clone() };
        let calm = Run { disturbance: 0.0, ..even.clone() };
        let noise = |again: u64| {
            let mut plant = VirtualMotor::new(&motor, &effects, seed.wrapping_mul(31).wrapping_add(again));
            record(&mut plant, &protocol.held_out, rate, &even)
        };
        let repeated = scatter(&SECOND_RUNS.map(noise), motor.count_rad());
        let counting = motor.count_rad() / 12.0_f64.sqrt();
        let would = |volts: &[f64]| VirtualMotor::new(&motor, &effects, seed).record(volts, &calm);
        let of_noise = if run.voltage_noise_v > 0.0 {
            let meant = would(&volts(&protocol.held_out, rate)).true_angle_rad;
            let logged = would(&held_out[0].voltage_v).true_angle_rad;
            let apart: Vec<f64> = meant.iter().zip(&logged).map(|(a, b)| a - b).collect();
            rms(&apart, motor.count_rad())
        } else {
            0.0
        };
        let floor_rad = repeated.max(counting).hypot(of_noise);
        Self {
            truth: kinds.iter().map(|k| k.row().name).collect(),
            sizes: effects.iter().map(|e| e.to_string()).collect::<Vec<_>>().join(" "),
            records,
            held_out,
            motor: known(&motor, &mut rng),
            floor_rad,
            disturbance: run.disturbance,
            conditions: words.join(", "),
        }
    }
}

fn volts(programme: &Programme, rate: u32) -> Vec<f64> {
    Player::new(programme, rate).map(|player| player.map(f64::from).collect()).unwrap_or_default()
}

/// Plays `programme` and keeps what a log would hold.
pub(crate) fn record(plant: &mut VirtualMotor, programme: &Programme, rate: u32, run: &Run) -> Record {
    let made = plant.record(&volts(programme, rate), run);
    Record {
        name: programme.name.as_str().into(),
        time_s: made.time_s,
        voltage_v: made.voltage_v,
        angle_rad: Some(made.angle_rad),
        ..Record::default()
    }
}

/// The noise level of each of `runs` of one programme: rms(difference) / sqrt(2) over all pairs, judged as an open-loop
/// simulation is.
fn scatter(runs: &[Record], count_rad: f64) -> f64 {
    let pairs =
        runs.iter().enumerate().flat_map(|(k, first)| runs[..k].iter().map(move |second| (first, second)));
    let apart: Vec<f64> = pairs
        .filter_map(|(first, second)| differences(first, second))
        .map(|apart| rms(&apart, count_rad).powi(2))
        .collect();
    (0.5 * apart.iter().sum::<f64>() / apart.len().max(1) as f64).sqrt()
}

/// Root mean square of `d`, rad, as an open-loop simulation is judged: begun anywhere within a count.
fn rms(d: &[f64], count_rad: f64) -> f64 {
    let offset = within_a_count(d.iter().copied(), count_rad);
    (d.iter().map(|d| (d - offset).powi(2)).sum::<f64>() / d.len() as f64).sqrt()
}

/// A nameplate: true within 15 %.
fn known(motor: &Motor, rng: &mut ChaCha8Rng) -> MotorFile {
    let mut about = |x: f64| Some(x * rng.random_range(0.85..1.15));
    let nameplate = Nameplate {
        voltage_v: Some(motor.nominal_v),
        no_load_speed_rad_s: about(motor.no_load_speed()),
        stall_current_a: about(motor.stall_current()),
        resistance_ohm: about(motor.resistance_ohm),
        inductance_h: about(motor.inductance_h),
        ..Nameplate::default()
    };
    let shaft = match motor.encoder_shaft {
        Shaft::Motor => EncoderShaft::Motor,
        Shaft::Output => EncoderShaft::Output,
    };
    MotorFile {
        gear_ratio: Some(motor.gear_ratio),
        counts_per_rev: Some(motor.counts_per_output_turn()),
        encoder_shaft: Some(shaft),
        nameplate,
        ..MotorFile::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_that_begins_elsewhere_within_a_count_is_no_error_and_one_that_walks_away_is() {
        assert!(rms(&[0.09; 5], 0.1) < 1e-12);
        assert!((rms(&[0.3; 5], 0.1) - 0.2).abs() < 1e-12);
        assert!((rms(&[-0.1, 0.1, -0.1, 0.1], 0.1) - 0.1).abs() < 1e-12);
    }

    /// Four runs that lag one another: six pairs, whose squares are 1, 1, 1, 4, 4 and 9 of a lag's.
    #[test]
    fn what_runs_differ_by_is_shared_by_both_of_each_pair() {
        let run = |lag: f64| {
            let time_s: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k)).collect();
            let voltage_v = time_s.iter().map(|t| (3.0 * t).sin()).collect();
            let angle_rad = time_s.iter().map(|t| lag * (5.0 * t).sin()).collect();
            Record { time_s, voltage_v, angle_rad: Some(angle_rad), ..Record::default() }
        };
        let runs = [0.0, 1.0, 2.0, 3.0].map(run);
        let of_one = rms(runs[1].angle_rad.as_ref().unwrap(), 0.0);
        let expected = of_one * (20.0_f64 / 6.0 / 2.0).sqrt();
        let found = scatter(&runs, 0.0);
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} for {expected}");
        assert_eq!(scatter(&runs[..1], 0.1), 0.0);
    }
}
