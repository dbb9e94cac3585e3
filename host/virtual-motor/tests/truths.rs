//! The virtual motor against closed forms of the linear model and of each part.

use motorlens_virtual_motor::{Bridge, Effect, Motor, Run, VirtualMotor};

fn plant(motor: &Motor, effects: &[&str]) -> VirtualMotor {
    let effects: Vec<_> = effects.iter().map(|text| Effect::parse(text).unwrap()).collect();
    VirtualMotor::new(motor, &effects, 7)
}

fn close(value: f64, expected: f64, relative: f64) {
    assert!((value - expected).abs() <= relative * expected.abs().max(1e-9), "{value} is not {expected}");
}

#[test]
fn speed_and_current_of_a_step_follow_the_two_pole_response() {
    for motor in [Motor::paper(), Motor::small(), Motor::hidden(3)] {
        let mut plant = plant(&motor, &[]);
        let (r, l, kt, ke) =
            (motor.resistance_ohm, motor.inductance_h, motor.torque_constant, motor.back_emf_constant);
        let (j, b) = (motor.inertia(), motor.damping());
        // s^2 L J + s (R J + L b) + R b + K_t K_e
        let (a, half, c) = (l * j, 0.5 * (r * j + l * b), r * b + kt * ke);
        let root = (half * half - a * c).sqrt();
        let (slow, fast) = ((-half + root) / a, (-half - root) / a);
        let final_speed = kt * 6.0 / c;
        for k in 1..=400 {
            plant.advance(0.5e-3, Bridge::Volts(6.0));
            let t = 0.5e-3 * f64::from(k);
            let rest = (fast * (slow * t).exp() - slow * (fast * t).exp()) / (fast - slow);
            let speed = final_speed * (1.0 - rest);
            assert!((plant.motor_speed_rad_s() - speed).abs() < 1e-3 * final_speed, "{t}");
        }
    }
}

#[test]
fn the_steady_state_is_no_load_speed_and_its_current() {
    let motor = Motor::small();
    let mut plant = plant(&motor, &[]);
    plant.advance(2.0, Bridge::Volts(12.0));
    close(plant.true_speed_rad_s(), motor.no_load_speed(), 1e-6);
    let current = motor.damping() * motor.no_load_speed() * motor.gear_ratio / motor.torque_constant;
    close(plant.current_a(), current, 1e-6);
}

#[test]
fn a_stuck_motor_draws_its_stall_current_and_does_not_move() {
    let motor = Motor::paper();
    let mut plant = plant(&motor, &["coulomb=6"]);
    plant.advance(0.5, Bridge::Volts(5.9));
    close(plant.current_a(), 5.9 / motor.resistance_ohm, 1e-9);
    assert_eq!(plant.true_angle_rad(), 0.0);
    plant.advance(0.1, Bridge::Volts(6.1));
    assert!(plant.true_angle_rad() > 0.0);
}

#[test]
fn coulomb_friction_costs_its_volts_of_speed_and_stops_the_motor_in_finite_time() {
    let motor = Motor::paper();
    let mut plant = plant(&motor, &["coulomb=0.5"]);
    plant.advance(2.0, Bridge::Volts(6.0));
    close(plant.true_speed_rad_s(), motor.gain() * 5.5, 1e-6);
    plant.advance(2.0, Bridge::Volts(0.0));
    assert_eq!(plant.true_speed_rad_s(), 0.0);
    let stands = plant.true_angle_rad();
    plant.advance(1.0, Bridge::Volts(0.4));
    assert_eq!(plant.true_angle_rad(), stands);
}

#[test]
fn electrical_work_is_heat_friction_and_kinetic_energy() {
    let motor = Motor::small();
    let mut plant = plant(&motor, &["coulomb=0.5"]);
    let friction_nm = motor.torque_of_volts(0.5);
    let (mut supplied, mut heat, mut rubbed) = (0.0, 0.0, 0.0);
    let dt = 25e-6;
    for k in 0..80_000 {
        let volts = 8.0 * (2.0 * std::f64::consts::PI * 1.3 * f64::from(k) * dt).sin();
        let (i0, w0) = (plant.current_a(), plant.motor_speed_rad_s());
        plant.advance(dt, Bridge::Volts(volts));
        let (i, w) = (0.5 * (i0 + plant.current_a()), 0.5 * (w0 + plant.motor_speed_rad_s()));
        supplied += volts * i * dt;
        heat += motor.resistance_ohm * i * i * dt;
        rubbed += friction_nm * w.abs() * dt + motor.damping() * w * w * dt;
    }
    let (i, w) = (plant.current_a(), plant.motor_speed_rad_s());
    let stored = 0.5 * motor.inductance_h * i * i + 0.5 * motor.inertia() * w * w;
    close(heat + rubbed + stored, supplied, 1e-4);
}

#[test]
fn backlash_shows_as_its_gap_between_motor_and_output() {
    let motor = Motor::paper();
    let mut plant = plant(&motor, &["backlash=2,share=0.3", "constant_load=0.0"]);
    let mut twists = Vec::new();
    let mut motor_angle = 0.0;
    let dt = 25e-6;
    for k in 0..120_000 {
        let volts = if (k / 20_000) % 2 == 0 { 5.0 } else { -5.0 };
        let before = plant.motor_speed_rad_s();
        plant.advance(dt, Bridge::Volts(volts));
        motor_angle += 0.5 * dt * (before + plant.motor_speed_rad_s());
        if k % 20_000 == 19_990 {
            twists.push((motor_angle / motor.gear_ratio - plant.true_angle_rad()).to_degrees());
        }
    }
    for pair in twists.windows(2) {
        assert!(((pair[0] - pair[1]).abs() - 2.0).abs() < 0.1, "{twists:?}");
    }
}

#[test]
fn a_compliant_load_swings_at_its_frequency_when_the_rotor_is_held() {
    // Friction holds the rotor; a load that was moving then swings at the stated frequency.
    let motor = Motor::paper();
    let mut plant = plant(&motor, &["compliance=8,share=0.5,damping=0.01", "coulomb=4"]);
    plant.advance(1.0, Bridge::Volts(8.0));
    plant.advance(0.5, Bridge::Volts(0.0));
    let mut crossings = Vec::new();
    let mut last = plant.true_speed_rad_s();
    for k in 0..20_000 {
        plant.advance(50e-6, Bridge::Volts(0.0));
        assert_eq!(plant.motor_speed_rad_s(), 0.0);
        let speed = plant.true_speed_rad_s();
        if last < 0.0 && speed >= 0.0 {
            crossings.push(f64::from(k) * 50e-6);
        }
        last = speed;
    }
    let periods = (crossings.len() - 1) as f64;
    close(periods / (crossings[crossings.len() - 1] - crossings[0]), 8.0, 0.01);
}

#[test]
fn counts_are_the_floor_of_the_true_angle() {
    let motor = Motor::paper();
    let mut plant = plant(&motor, &["coulomb=0.3"]);
    let volts: Vec<f64> = (0..2000).map(|k| 7.0 * (f64::from(k) * 0.01).sin()).collect();
    let recording = plant.record(&volts, &Run::at(1000.0));
    let per_count = motor.count_rad();
    let excess: Vec<f64> = recording
        .true_angle_rad
        .iter()
        .zip(&recording.counts)
        .map(|(angle, counts)| angle / per_count - *counts as f64)
        .collect();
    let (low, high) = excess.iter().fold((f64::MAX, f64::MIN), |(l, h), e| (l.min(*e), h.max(*e)));
    assert!(high - low < 1.0 + 1e-9 && high - low > 0.9);
    for (angle, counts) in recording.angle_rad.iter().zip(&recording.counts) {
        close(*angle, *counts as f64 * per_count, 1e-12);
    }
}

#[test]
fn a_coasting_bridge_does_not_brake_and_a_braking_one_does() {
    let motor = Motor::small();
    let after = |effects: &[&str]| {
        let mut plant = plant(&motor, effects);
        plant.advance(1.0, Bridge::Volts(8.0));
        plant.advance(0.1, Bridge::Volts(0.0));
        plant.true_speed_rad_s() / (motor.gain() * 8.0)
    };
    let viscous = motor.damping() / motor.inertia();
    assert!(after(&["coast"]) > (-0.1 * viscous).exp() * 0.9);
    assert!(after(&[]) < (-0.1 / motor.mechanical_time_constant()).exp() * 1.2);
    let mut floating = plant(&motor, &[]);
    floating.advance(1.0, Bridge::Volts(8.0));
    let speed = floating.true_speed_rad_s();
    floating.advance(0.1, Bridge::Floating);
    assert_eq!(floating.current_a(), 0.0);
    close(floating.true_speed_rad_s(), speed * (-0.1 * viscous).exp(), 0.02);
}

/// The diodes only let the current run out: it falls all the way to zero and stays there.
#[test]
fn the_current_of_a_floating_winding_falls_to_zero_and_never_rises() {
    let motors = (1..20).map(Motor::hidden).chain([Motor::paper(), Motor::small()]);
    for motor in motors {
        let mut plant = plant(&motor, &[]);
        // Once from the current of a steady run, once from that of a start.
        for seconds in [0.5, 0.001] {
            plant.advance(seconds, Bridge::Volts(0.7 * motor.nominal_v));
            let mut before = plant.current_a().abs();
            for _ in 0..1200 {
                plant.advance(25e-6, Bridge::Floating);
                let now = plant.current_a().abs();
                assert!(now <= before, "{now} A after {before} A in {motor:?}");
                before = now;
            }
            assert_eq!(before, 0.0, "{motor:?}");
        }
    }
}

#[test]
fn a_slow_coasting_pwm_has_the_steady_speed_of_its_averaged_torque() {
    // The period is long against the winding's time constant: mean current d (V - e) / R, and K_t i = b w.
    let mut motor = Motor::paper();
    motor.inductance_h *= 0.02;
    let mut plant = plant(&motor, &["coast=1,pwm_hz=400"]);
    plant.advance(3.0, Bridge::Volts(6.0));
    let (kt, ke, r) = (motor.torque_constant, motor.back_emf_constant, motor.resistance_ohm);
    let speed = 0.5 * kt * 12.0 / (r * motor.damping() + 0.5 * kt * ke);
    close(plant.motor_speed_rad_s(), speed, 0.01);
}

/// The period is long against the winding's time constant: each pulse has its current to itself, d (V - e) / R in the mean.
#[test]
fn a_slow_freewheeling_pwm_has_the_steady_speed_of_its_pulses() {
    let mut motor = Motor::paper();
    motor.inductance_h *= 0.02;
    let mut plant = plant(&motor, &["freewheel=400"]);
    plant.advance(3.0, Bridge::Volts(6.0));
    let (kt, ke, r) = (motor.torque_constant, motor.back_emf_constant, motor.resistance_ohm);
    let speed = 0.5 * kt * 12.0 / (r * motor.damping() + 0.5 * kt * ke);
    close(plant.motor_speed_rad_s(), speed, 0.01);
}

/// The period is short: the current never ends while the motor drives, and none flows while it is faster than its voltage.
#[test]
fn a_fast_freewheeling_pwm_drives_as_its_mean_and_does_not_brake() {
    let motor = Motor { inductance_h: 20.0 * Motor::small().inductance_h, ..Motor::small() };
    let mut plant = plant(&motor, &["freewheel=10000"]);
    plant.advance(3.0, Bridge::Volts(8.0));
    let fast = plant.true_speed_rad_s();
    close(fast, motor.gain() * 8.0, 0.02 * fast);
    let viscous = motor.damping() / motor.inertia();
    plant.advance(0.1, Bridge::Volts(2.0));
    close(plant.true_speed_rad_s(), fast * (-0.1 * viscous).exp(), 0.03 * fast);
}

#[test]
fn heat_stays_from_record_to_record_where_asked_and_cools_in_the_pause() {
    let mut plant = plant(&Motor::paper(), &["winding_heating=0.5", "coulomb=6"]);
    let volts = [6.0; 500];
    let cold = plant.motor().resistance_ohm;
    plant.record(&volts, &Run::at(100.0));
    let warm = plant.resistance_ohm();
    assert!(warm > 1.2 * cold);
    plant.record(&[0.0; 2], &Run { pause_s: Some(0.0), ..Run::at(100.0) });
    close(plant.resistance_ohm(), warm, 0.01);
    plant.record(&[0.0; 2], &Run { pause_s: Some(60.0), ..Run::at(100.0) });
    assert!(plant.resistance_ohm() < 0.5 * (warm + cold));
    plant.record(&[0.0; 2], &Run::at(100.0));
    close(plant.resistance_ohm(), cold, 1e-9);
}
