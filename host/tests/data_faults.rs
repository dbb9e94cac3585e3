//! Faults of the data, made on purpose in records of clean virtual motors; and none found in the clean ones.

use motorlens::exam::case::{Case, Conditions};
use motorlens::log::{Record, Warning, suspicions};
use motorlens_shared::excitation::{Player, Programme, Shape};
use motorlens_virtual_motor::{Effect, Motor, Run, VirtualMotor};

/// Clean motors looked at; all forty where the whole test run asks for it. A fault may be missed in a tenth of them.
fn seeds() -> std::ops::Range<u64> {
    let most = if std::env::var_os("MOTORLENS_LONG_TESTS").is_some() { 40 } else { 12 };
    500..500 + most
}

fn clean(seed: u64) -> Vec<Record> {
    let case = Case::new(seed, &[], Conditions { disturbed: 0.5, spoilt: 0.25 });
    let mut records = case.records;
    for record in &mut records {
        record.path = format!("{}.csv", record.name).into();
        let known = [("gear_ratio", case.motor.gear_ratio), ("counts_per_rev", case.motor.counts_per_rev)];
        for (key, value) in known {
            record.meta.insert(key, &value.unwrap().to_string()).unwrap();
        }
    }
    records
}

fn names(found: &[Warning]) -> Vec<String> {
    found.iter().map(|w| w.what.split(':').next().unwrap().to_owned()).collect()
}

fn angle(record: &mut Record) -> &mut Vec<f64> {
    record.angle_rad.as_mut().unwrap()
}

/// Moves the voltage down by `rows`: late, or early where negative.
fn shift(record: &mut Record, rows: i64) {
    let old = record.voltage_v.clone();
    let last = old.len() as i64 - 1;
    for (k, v) in record.voltage_v.iter_mut().enumerate() {
        *v = old[(k as i64 - rows).clamp(0, last) as usize];
    }
}

/// Speed beside an angle that lost 6 % of its way.
fn lose(record: &mut Record) {
    let (time, x) = (record.time_s.clone(), record.angle_rad.clone().unwrap());
    let last = x.len() - 1;
    let speed = |k: usize| {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
        (x[b] - x[a]) / (time[b] - time[a])
    };
    record.speed_rad_s = Some((0..x.len()).map(speed).collect());
    angle(record).iter_mut().for_each(|x| *x *= 0.94);
}

/// A new reading only every `every` samples.
fn hold(record: &mut Record, every: usize) {
    let old = record.angle_rad.clone().unwrap();
    for (k, x) in angle(record).iter_mut().enumerate() {
        *x = old[k - k % every];
    }
}

fn interval(record: &Record) -> f64 {
    record.duration_s() / (record.len() - 1) as f64
}

#[test]
fn clean_motors_have_no_fault_and_every_fault_made_is_found() {
    // The programmes that move every motor well: multisine, PRBS, staircase.
    type Edit = fn(&mut Vec<Record>);
    let faults: [(&str, Edit); 10] = [
        ("shifted_samples", |r| r.iter_mut().for_each(|r| shift(r, (0.02 / interval(r)).ceil() as i64 + 1))),
        ("shifted_samples", |r| {
            r.iter_mut().for_each(|r| shift(r, -((0.03 / interval(r)).ceil() as i64) - 2))
        }),
        ("stale_samples", |r| r.iter_mut().for_each(|r| hold(r, 6))),
        ("lost_counts", |r| r.iter_mut().for_each(lose)),
        ("lost_counts", |r| {
            let half = r[2].len() / 2;
            angle(&mut r[2]).iter_mut().skip(half).for_each(|x| *x -= 40.0);
        }),
        ("wrong_gear_ratio", |r| {
            r.iter_mut().for_each(|r| {
                let gear = r.meta.gear_ratio().unwrap();
                angle(r).iter_mut().for_each(|x| *x *= gear);
            })
        }),
        ("commanded_voltage", |r| r.iter_mut().for_each(|r| r.supply_v = Some(vec![4.0; r.len()]))),
        ("commanded_voltage", |r| r[0].meta.insert("voltage", "a duty times 7.9 V").unwrap()),
        ("unsigned_current", |r| {
            let size = |v: &f64| 0.1 * v.abs();
            r[0].current_a = Some(r[0].voltage_v.iter().map(size).collect());
        }),
        ("records_disagree", |r| r[2].voltage_v.iter_mut().for_each(|v| *v *= 1.8)),
    ];
    let (mut missed, mut alarms) = ([0_u32; 10], 0);
    let count = seeds().count() as u32;
    for seed in seeds() {
        let records = clean(seed);
        let odd = suspicions(&records);
        if !odd.is_empty() {
            println!("clean seed {seed}: {odd:?}");
            alarms += 1;
        }
        for (k, (name, edit)) in faults.iter().enumerate() {
            let mut bad = records.clone();
            edit(&mut bad);
            let found = suspicions(&bad);
            if !names(&found).iter().any(|n| n == name) {
                missed[k] += 1;
                println!("seed {seed}: {name} (edit {k}) not in {found:?}");
            }
            assert!(found.iter().all(|w| !w.fix.is_empty() && w.place.contains("column")), "{found:?}");
        }
    }
    println!("missed, of {count} motors: {missed:?}");
    assert_eq!(alarms, 0, "of {count} clean motors");
    assert!(missed.iter().all(|m| *m * 10 <= count), "missed {missed:?} of {count}");
}

/// A driver that gives less than it is told, where the log holds what it was told.
#[test]
fn a_voltage_that_never_reached_the_motor_is_found() {
    for seed in 1..5 {
        let motor = Motor::hidden(seed);
        let volts = motor.nominal_v as f32;
        let shape =
            Shape::Multisine { amplitude_v: 0.9 * volts, low_hz: 0.2, high_hz: 3.0, tones: 8, seed: 3 };
        let programme = Programme::single("multisine", shape, 16.0);
        let told: Vec<f64> = Player::new(&programme, 500).unwrap().map(f64::from).collect();
        let limit = 0.35 * motor.nominal_v;
        let record = |given: &[f64]| {
            let made = VirtualMotor::new(&motor, &[], seed).record(given, &Run::at(500.0));
            Record {
                name: "told".into(),
                time_s: made.time_s,
                voltage_v: told[..made.voltage_v.len()].to_vec(),
                angle_rad: Some(made.angle_rad),
                ..Record::default()
            }
        };
        assert_eq!(names(&suspicions(&[record(&told)])), [""; 0], "seed {seed}");
        let clipped: Vec<f64> = told.iter().map(|v| v.clamp(-limit, limit)).collect();
        let found = suspicions(&[record(&clipped)]);
        assert!(names(&found).contains(&"clipped_voltage".to_owned()), "seed {seed}: {found:?}");
    }
}

/// Under a slow sine friction trails the voltage as a shift would.
#[test]
fn friction_under_slow_sines_is_no_shift() {
    let motor = Motor::paper();
    let friction = [Effect::parse("coulomb=0.4").unwrap()];
    let made = [3.0, 7.0].map(|amplitude| {
        let programme = Programme::paper(amplitude);
        let volts: Vec<f64> = Player::new(&programme, 1000).unwrap().map(f64::from).collect();
        let made = VirtualMotor::new(&motor, &friction, 1).record(&volts, &Run::at(1000.0));
        Record {
            time_s: made.time_s,
            voltage_v: made.voltage_v,
            angle_rad: Some(made.angle_rad),
            ..Record::default()
        }
    });
    let records = [made[0].clone(), made[1].clone(), made[1].clone()];
    assert_eq!(names(&suspicions(&records)), [""; 0]);
}
