//! The second examination: realistic benches around a plant of other forms (`motorlens_bench_motor`), told by kind of bench.

mod marks;
mod trial;
mod write;

pub use marks::{Marks, table};
pub use motorlens_bench_motor::Bench;
pub use trial::{Answer, Paper, examine};
pub use write::write_cases;

use motorlens_bench_motor::{Case, Known, Log};
use motorlens_shared::excitation::{Player, Programme};

use crate::log::{EncoderShaft, Record};
use crate::motor_file::{MotorFile, Nameplate};

/// The default protocol as voltages; the programme kept out last.
fn protocol(supply_v: f64, rate_hz: f64) -> Vec<(String, Vec<f64>)> {
    let protocol = Programme::default_protocol(supply_v as f32);
    let played = |programme: &Programme| {
        let volts = Player::new(programme, rate_hz as u32).map(|p| p.map(f64::from).collect());
        (programme.name.as_str().to_owned(), volts.unwrap_or_default())
    };
    protocol.training.iter().chain([&protocol.held_out]).map(played).collect()
}

/// The case of `bench` with this seed.
pub fn case(bench: Bench, seed: u64) -> Case {
    Case::new(bench, seed, &protocol)
}

/// A log as the program reads it.
fn record(log: &Log) -> Record {
    Record {
        name: log.name.clone(),
        time_s: log.time_s.clone(),
        voltage_v: log.voltage_v.clone(),
        angle_rad: log.angle_rad.clone(),
        speed_rad_s: log.speed_rad_s.clone(),
        ..Record::default()
    }
}

/// What is known, as a motor file.
fn motor_file(known: &Known) -> MotorFile {
    let shaft = |output| if output { EncoderShaft::Output } else { EncoderShaft::Motor };
    MotorFile {
        gear_ratio: known.gear_ratio,
        counts_per_rev: known.counts_per_rev,
        encoder_shaft: known.encoder_on_output.map(shaft),
        nameplate: Nameplate {
            voltage_v: known.voltage_v,
            no_load_speed_rad_s: known.no_load_speed_rad_s,
            stall_current_a: known.stall_current_a,
            resistance_ohm: known.resistance_ohm,
            ..Nameplate::default()
        },
        ..MotorFile::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motorlens_shared::effects::Kind;

    #[test]
    fn every_effect_of_the_library_can_be_hidden_and_none_of_those_outside_is_in_it() {
        for kind in Kind::ALL {
            let is = |row: &motorlens_bench_motor::Row| row.name == kind.name();
            assert!(motorlens_bench_motor::LIBRARY.iter().any(is), "{} cannot be hidden", kind.name());
        }
        assert!(motorlens_bench_motor::OUTSIDE.iter().all(|row| Kind::by_name(row.name).is_none()));
    }

    #[test]
    fn the_program_takes_the_records_of_every_bench() {
        for bench in Bench::ALL.into_iter().filter(|b| *b != Bench::Protocol) {
            let case = case(bench, 2);
            for log in case.training.iter().chain(&case.held_out) {
                assert!(crate::log::check_usable(&record(log)).is_ok(), "{bench:?} {}", log.name);
            }
        }
    }
}
