//! The judgement of a log's content, on motors of an independent simulator: a motor with any physical effect is
//! accepted, and the same log with reversed sign or wrong units is not.

use motorlens::log::quantum::quantum;
use motorlens::log::repeats::{find_repeats, noise_floor};
use motorlens::log::{Record, content_faults};
use motorlens_shared::excitation::{Player, Programme};
use motorlens_virtual_motor::{Effect, Kind, Motor, Run, VirtualMotor};

const RATE_HZ: u32 = 500;

fn record(motor: &Motor, effects: &[Effect], programme: &Programme, seed: u64) -> Record {
    recorded(motor, effects, programme, seed, 0.01)
}

fn recorded(motor: &Motor, effects: &[Effect], programme: &Programme, seed: u64, disturbance: f64) -> Record {
    let volts: Vec<f64> = Player::new(programme, RATE_HZ).unwrap().map(f64::from).collect();
    let run = Run { disturbance, jitter: 0.1, ..Run::at(f64::from(RATE_HZ)) };
    let made = VirtualMotor::new(motor, effects, seed).record(&volts, &run);
    let mut record = Record {
        name: programme.name.as_str().to_owned(),
        time_s: made.time_s,
        voltage_v: made.voltage_v,
        angle_rad: Some(made.angle_rad),
        ..Record::default()
    };
    let counts = motor.counts_per_output_turn().to_string();
    record.meta.insert("counts_per_rev", &counts).unwrap();
    record
}

fn programmes(volts: f64) -> Vec<Programme> {
    let protocol = Programme::default_protocol(volts as f32);
    protocol.training.into_iter().chain([protocol.held_out, Programme::paper(0.5 * volts as f32)]).collect()
}

fn names(record: &Record) -> Vec<&'static str> {
    content_faults(record).iter().map(|fault| fault.name).collect()
}

#[test]
fn every_effect_on_every_programme_is_accepted_and_its_falsified_log_is_not() {
    let mut missed = Vec::new();
    let mut logs = 0;
    for (index, kind) in Kind::all().enumerate() {
        let motor = Motor::hidden(index as u64 + 1);
        for programme in programmes(motor.nominal_v) {
            let good = record(&motor, &[Effect::typical(kind)], &programme, 7);
            let context = format!("{} under {}", kind.row().name, programme.name);
            logs += 1;
            let found = names(&good);
            if found == ["no_motion"] {
                // A small triangle may rightly fail to overcome friction; what is stuck cannot be judged further.
                assert_eq!(programme.name, "triangle", "{context}");
                continue;
            }
            assert!(found.is_empty(), "{context}: {:?}", content_faults(&good));
            let edit = |change: &dyn Fn(&mut Record)| {
                let mut bad = good.clone();
                change(&mut bad);
                names(&bad)
            };
            let scale =
                |values: &mut [f64], factor: f64| values.iter_mut().for_each(|value| *value *= factor);
            let falsified = [
                ("sign_flipped", edit(&|r| scale(r.angle_rad.as_mut().unwrap(), -1.0))),
                (
                    "wrong_units",
                    edit(&|r| scale(r.angle_rad.as_mut().unwrap(), 360.0 / std::f64::consts::TAU)),
                ),
                ("wrong_units", edit(&|r| scale(&mut r.time_s, 1e3))),
                ("wrong_units", edit(&|r| scale(&mut r.voltage_v, 1e3))),
                ("constant_voltage", edit(&|r| r.voltage_v.fill(3.0))),
                ("no_motion", edit(&|r| r.angle_rad.as_mut().unwrap().fill(3.0))),
            ];
            missed.extend(
                falsified
                    .iter()
                    .filter(|(fault, found)| !found.contains(fault))
                    .map(|(fault, found)| format!("{context}: {fault} not in {found:?}")),
            );
        }
    }
    assert!(missed.is_empty(), "{} of {} falsified logs passed: {missed:#?}", missed.len(), logs * 6);
}

#[test]
fn a_repeat_is_recognised_among_other_programmes_and_gives_the_disturbance() {
    let motor = Motor::hidden(3);
    let programmes = programmes(motor.nominal_v);
    let mut records: Vec<Record> =
        programmes.iter().map(|programme| record(&motor, &[], programme, 1)).collect();
    records.push(record(&motor, &[], &programmes[2], 2));
    let (first, last) = (2, records.len() - 1);
    assert_eq!(find_repeats(&records), [(first, last)]);
    let floor = noise_floor(&records[first], &records[last]).unwrap();
    let undisturbed = recorded(&motor, &[], &programmes[2], 3, 0.0);
    let one = noise_floor(&records[first], &undisturbed).unwrap();
    let other = noise_floor(&records[last], &undisturbed).unwrap();
    // Independent deviations add in squares.
    let expected = one.hypot(other);
    assert!((0.5..1.5).contains(&(floor / expected)), "{floor} against {expected}");
    let count = quantum(records[first].angle_rad.as_ref().unwrap()).unwrap();
    assert!((count / motor.count_rad() - 1.0).abs() < 1e-3, "{count} {}", motor.count_rad());
}
