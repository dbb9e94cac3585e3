//! Every effect is visible, in the direction that its name promises; records are spoilt as asked.

use motorlens_virtual_motor::{Bridge, Effect, Kind, Motor, Recording, Run, VirtualMotor};
use proptest::prelude::*;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

fn rms_difference(a: &[f64], b: &[f64]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    (sum / a.len() as f64).sqrt()
}

/// Reversals of two strengths, rests and slow parts: 6 s at 1 kHz.
fn rich() -> Vec<f64> {
    (0..6000)
        .map(|k| {
            let t = f64::from(k) * 1e-3;
            let fast = if (t * 2.3).fract() < 0.5 { 10.0 } else { -6.0 };
            if t < 3.0 { fast } else { 3.0 * (t * 4.0).sin() }
        })
        .collect()
}

fn record(motor: &Motor, effects: &[Effect], run: &Run) -> Recording {
    VirtualMotor::new(motor, effects, 11).record(&rich(), run)
}

#[test]
fn every_typical_effect_moves_the_reading_by_more_than_half_a_count() {
    for motor in [Motor::paper(), Motor::small()] {
        let plain = record(&motor, &[], &Run::at(1000.0));
        for kind in Kind::all() {
            let spoilt = record(&motor, &[Effect::typical(kind)], &Run::at(1000.0));
            let counts = rms_difference(&plain.angle_rad, &spoilt.angle_rad) / motor.count_rad();
            assert!(counts > 0.5, "{}: {counts} counts", kind.row().name);
        }
    }
}

#[test]
fn the_weakest_random_effect_is_visible_and_the_strongest_shows_more() {
    let motor = Motor::small();
    let plain = record(&motor, &[], &Run::at(1000.0));
    for kind in Kind::all() {
        let shown = |strength| {
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let effect = Effect::graded(kind, strength, &mut rng, &motor);
            let spoilt = record(&motor, &[effect], &Run::at(1000.0));
            rms_difference(&plain.angle_rad, &spoilt.angle_rad) / motor.count_rad()
        };
        let weak = shown(0.0);
        assert!(weak > 0.5, "{}: {weak}", kind.row().name);
        assert!(shown(1.0) > weak, "{}", kind.row().name);
    }
}

/// Mean output speed in the last tenth of a second of two seconds at `volts`, as a share of the linear motor's.
fn speed_share(text: &str, volts: f64) -> f64 {
    let motor = Motor::paper();
    let mut plant = VirtualMotor::new(&motor, &[Effect::parse(text).unwrap()], 1);
    plant.advance(1.9, Bridge::Volts(volts));
    let before = plant.true_angle_rad();
    plant.advance(0.1, Bridge::Volts(volts));
    (plant.true_angle_rad() - before) / 0.1 / (motor.gain() * volts)
}

#[test]
fn steady_speeds_change_in_the_promised_direction() {
    for (text, volts, expected) in [
        ("coulomb=0.6", 6.0, 0.9),
        ("coulomb_asymmetric=0.6,asymmetry=0.5", 6.0, 0.85),
        ("coulomb_asymmetric=0.6,asymmetry=0.5", -6.0, 0.95),
        ("stribeck=0.6,excess=0.3,speed=0.01", 6.0, 0.9),
        ("constant_load=0.6", 6.0, 0.9),
        ("constant_load=0.6", -6.0, 1.1),
        ("dead_zone=0.6", 6.0, 0.9),
        ("dead_zone=0.6", -6.0, 0.9),
        ("delay=20", 6.0, 1.0),
        ("compliance=12", 6.0, 1.0),
        ("backlash=2", 6.0, 1.0),
    ] {
        let share = speed_share(text, volts);
        assert!((share - expected).abs() < 0.002, "{text} at {volts} V: {share}");
    }
    for slower in ["quadratic_drag", "voltage_drop", "load_friction", "supply_sag=1"] {
        let share = speed_share(slower, 12.0);
        assert!((0.5..0.999).contains(&share), "{slower}: {share}");
    }
    assert!(speed_share("coast", 6.0) > 1.05);
    assert!(speed_share("freewheel", 6.0) > 1.05);
}

#[test]
fn a_delayed_motor_starts_late_by_the_delay() {
    let motor = Motor::paper();
    let moved = |text: &str| {
        let mut plant = VirtualMotor::new(&motor, &[Effect::parse(text).unwrap()], 1);
        (0..1000).find(|_| {
            plant.advance(1e-4, Bridge::Volts(12.0));
            plant.true_angle_rad() > 1e-3
        })
    };
    let late = moved("delay=15").unwrap() - moved("delay=0").unwrap();
    assert!((149..=151).contains(&late));
}

#[test]
fn gravity_and_spring_pull_the_released_motor_back() {
    let motor = Motor::paper();
    for text in ["gravity=1.0", "spring=20"] {
        let mut plant = VirtualMotor::new(&motor, &[Effect::parse(text).unwrap()], 1);
        plant.advance(1.0, Bridge::Volts(0.6));
        let held = plant.true_angle_rad();
        assert!(held > 0.1 * motor.gain() && held < 0.65 * motor.gain(), "{text}: {held}");
        plant.advance(3.0, Bridge::Volts(0.0));
        assert!(plant.true_angle_rad() < 0.2 * held, "{text}");
    }
}

#[test]
fn the_same_seed_gives_the_same_record_and_another_seed_another() {
    let run = Run { disturbance: 0.03, missing: 0.02, jitter: 0.1, voltage_noise_v: 0.05, ..Run::at(1000.0) };
    let effects = [Effect::typical(Kind::LostCounts), Effect::typical(Kind::Stribeck)];
    let make = |seed| VirtualMotor::new(&Motor::small(), &effects, seed).record(&rich(), &run);
    assert_eq!(make(4), make(4));
    assert_ne!(make(4).angle_rad, make(5).angle_rad);
}

#[test]
fn a_record_is_spoilt_as_asked() {
    let motor = Motor::paper();
    let plain = record(&motor, &[], &Run::at(1000.0));
    assert_eq!(plain.voltage_v, rich());
    let shifted = record(&motor, &[], &Run { voltage_shift: 3, ..Run::at(1000.0) });
    assert_eq!(shifted.voltage_v[3..], rich()[..5997]);
    assert_eq!(shifted.angle_rad, plain.angle_rad);
    let missing = record(&motor, &[], &Run { missing: 0.1, ..Run::at(1000.0) });
    assert!((5300..5500).contains(&missing.time_s.len()));
    let jittered = record(&motor, &[], &Run { jitter: 0.5, ..Run::at(1000.0) });
    let periods: Vec<f64> = jittered.time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(periods.iter().all(|period| (0.49e-3..1.51e-3).contains(period)));
    assert!(periods.iter().any(|period| *period > 1.3e-3));
    let moving = record(&motor, &[], &Run { start_v: 6.0, ..Run::at(1000.0) });
    assert!((moving.true_speed_rad_s[0] / (6.0 * motor.gain()) - 1.0).abs() < 1e-3);
    let disturbed = record(&motor, &[], &Run { disturbance: 0.05, ..Run::at(1000.0) });
    let counts = rms_difference(&disturbed.angle_rad, &plain.angle_rad) / motor.count_rad();
    assert!((3.0..500.0).contains(&counts), "{counts}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn random_motors_with_random_effects_stay_finite_and_within_reason(
        seed in any::<u64>(), first in 0usize..21, second in 0usize..21,
    ) {
        let motor = Motor::hidden(seed);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let kinds: Vec<Kind> = Kind::all().collect();
        let effects = [first, second].map(|index| Effect::random(kinds[index], &mut rng, &motor));
        let recording = record(&motor, &effects, &Run { disturbance: 0.05, ..Run::at(500.0) });
        let fastest = 1.6 * motor.no_load_speed() + 5.0 * motor.gain();
        prop_assert!(recording.true_speed_rad_s.iter().all(|w| w.abs() < fastest), "{effects:?}");
        let strongest = 4.0 * motor.stall_current();
        prop_assert!(recording.current_a.iter().all(|i| i.abs() < strongest), "{effects:?}");
        prop_assert!(recording.angle_rad.iter().all(|a| a.is_finite()));
    }
}
