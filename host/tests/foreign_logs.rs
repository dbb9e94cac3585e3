//! Logs as people have them: from a foreign table to a verdict with two commands, the second of which the first one prints.

mod program;

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use program::{Ran, run};

/// A geared motor with friction under steps of a PWM duty; rows of time, duty, speed and angle, 100 a second.
fn motion(seconds: f64, mut row: impl FnMut(f64, f64, f64, f64)) {
    let dt = 1e-3;
    let (mut w, mut x, mut duty) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut state = 12_345_u32;
    for k in 0..(seconds / dt) as usize {
        if k % 400 == 0 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            duty = f64::from((state >> 16) % 511) - 255.0;
        }
        if k % 10 == 0 {
            row(k as f64 * dt, duty, w, x);
        }
        let volts = 12.0 * duty / 255.0;
        let friction = if w == 0.0 { volts.clamp(-0.8, 0.8) } else { 0.8 * w.signum() };
        let next = w + dt / 0.08 * (2.5 * (volts - friction) - w);
        w = if w != 0.0 && next * w < 0.0 { 0.0 } else { next };
        x += dt * w;
    }
}

/// The command that a refusal proposes, without the program's own name.
fn proposed(refused: &Ran) -> String {
    let (_, command) =
        refused.err.split_once("so the whole command is\n").unwrap_or_else(|| panic!("{}", refused.err));
    let line = command.trim().lines().next().unwrap_or_default();
    line.trim().strip_prefix("motorlens ").expect("a command of this program").to_owned()
}

fn verdict(directory: &Path, first: &str) -> serde_json::Value {
    let refused = run(directory, first).ends(3);
    let second = proposed(&refused);
    assert!(second.starts_with(first), "{second}");
    run(directory, &format!("{second} --json")).ends(0).json()
}

#[test]
fn an_arduino_log_comes_to_a_verdict_with_two_commands() {
    let directory = tempfile::tempdir().unwrap();
    let mut text = "millis,pwm,rpm\n".to_owned();
    motion(12.0, |t, duty, w, _| writeln!(text, "{:.0},{duty:.0},{:.2}", 1e3 * t, w * 60.0 / TAU).unwrap());
    std::fs::write(directory.path().join("log.csv"), text).unwrap();
    let found = verdict(directory.path(), "discover log.csv");
    assert_eq!(found["effects"][0], "coulomb", "{found}");
    let gain = found["parameters"].as_array().unwrap().iter().find(|p| p["name"] == "gain").unwrap();
    assert!((gain["value"].as_f64().unwrap() / 2.5 - 1.0).abs() < 0.03, "{gain}");
}

#[test]
fn counts_are_proposed_with_their_number_a_turn_and_a_setpoint_is_left_alone() {
    let directory = tempfile::tempdir().unwrap();
    let mut text = "t_ms;setpoint;pwm;enc;vbat\n".to_owned();
    motion(12.0, |t, duty, _, x| {
        writeln!(
            text,
            "{:.0};40;{duty:.0};{:.0};{:.2}",
            1e3 * t,
            x * 1320.0 / TAU,
            12.0 + 0.01 * (31.0 * t).sin()
        )
        .unwrap();
    });
    std::fs::write(directory.path().join("log.csv"), text).unwrap();
    let refused = run(directory.path(), "fit log.csv").ends(3);
    assert!(
        refused
            .err
            .contains("--map time=t_ms:ms,duty=pwm:255,angle=enc:counts,supply=vbat:V --counts-per-rev 1320"),
        "{}",
        refused.err
    );
    assert!(refused.err.contains("100 samples a second"), "{}", refused.err);
    run(directory.path(), &proposed(&refused)).ends(0);
}

#[test]
fn ranges_are_left_out_or_judged_by_in_every_verb_that_reads_logs() {
    let directory = tempfile::tempdir().unwrap();
    let mut text = "time_s,voltage_v,speed_rad_s\n".to_owned();
    motion(12.0, |t, duty, w, _| {
        // A hand on the shaft.
        let w = if (3.2..4.0).contains(&t) { 0.0 } else { w };
        writeln!(text, "{t:.3},{:.4},{w:.4}", 12.0 * duty / 255.0).unwrap();
    });
    std::fs::write(directory.path().join("log.csv"), text).unwrap();
    let fit = |options: &str| run(directory.path(), &format!("fit log.csv {options} --json")).ends(0).json();
    let spoilt = fit("");
    let clean = fit("--skip 3.15..4.3");
    let rmse = |v: &serde_json::Value| v["train"]["rmse"].as_f64().unwrap();
    assert!(rmse(&clean) < 0.8 * rmse(&spoilt), "{clean} {spoilt}");
    let judged = fit("--skip log:3.15..4.3 --judge-by 9..");
    let samples = |part: &str| judged[part]["samples"].as_u64().unwrap();
    assert!((290..=300).contains(&samples("validation")) && samples("train") < 800, "{judged}");
    let wrong = run(directory.path(), "discover log.csv --skip 40..50").ends(2);
    assert!(
        wrong.err.contains("touches no record") && wrong.err.contains("log 0.000..11.990"),
        "{}",
        wrong.err
    );
}

/// Target and angle are all there is: the controller is found, and the motor behind it with its friction.
#[test]
fn a_servo_that_logs_only_target_and_angle_is_fitted() {
    let directory = tempfile::tempdir().unwrap();
    for motor in [0.8, 1.6] {
        std::fs::write(directory.path().join("servo.csv"), servo(motor, 0.0)).unwrap();
        let refused = run(directory.path(), "fit servo.csv").ends(3);
        assert!(
            refused
                .err
                .contains("--map time=t:s,target=goal_position:rad,angle=position:rad --supply-volts 12"),
            "{}",
            refused.err
        );
        let map = "fit servo.csv --map time=t,target=goal_position,angle=position --supply-volts 7.4 --effects coulomb --json";
        for known in ["", " --servo-gain 4"] {
            let fitted = run(directory.path(), &format!("{map}{known}")).ends(0);
            assert_eq!(fitted.err.contains("servo_gain"), known.is_empty(), "{}", fitted.err);
            let parameters = fitted.json()["parameters"].clone();
            let value = |name: &str| {
                let all = parameters.as_array().unwrap();
                all.iter().find(|p| p["name"] == name).unwrap()["value"].as_f64().unwrap()
            };
            let (gain, friction) = (value("gain"), value("coulomb.level"));
            assert!((gain / motor - 1.0).abs() < 0.05, "{known}: {gain} of {motor}");
            // Too small a gain of the controller would take the place of friction.
            assert!((friction / 0.4 - 1.0).abs() < 0.05, "{known}: {friction} V of 0.4 V at {motor}");
        }
    }
}

/// A dead time within the loop makes it swing, and no gain stands for it: it is what is missing.
#[test]
fn a_servo_whose_voltage_acts_late_is_diagnosed_as_a_delay() {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("servo.csv"), servo(0.8, 0.02)).unwrap();
    let map = "--map time=t,target=goal_position,angle=position --supply-volts 7.4";
    let found = run(directory.path(), &format!("discover servo.csv {map} --json")).ends(0);
    assert!(found.err.contains("late_voltage") && found.err.contains("tells a gain"), "{}", found.err);
    let document = found.json();
    let effects: Vec<&str> =
        document["effects"].as_array().unwrap().iter().filter_map(|e| e.as_str()).collect();
    assert!(effects.contains(&"delay") && effects.contains(&"coulomb"), "{effects:?}");
    let all = document["parameters"].as_array().unwrap();
    let value = |name: &str| all.iter().find(|p| p["name"] == name).unwrap()["value"].as_f64().unwrap();
    assert!((value("delay.time") - 0.02).abs() < 0.003, "{document}");
    assert!((value("gain") / 0.8 - 1.0).abs() < 0.05, "{document}");
}

/// A motor of this gain, rad/s/V, with 0.4 V of friction in a position loop whose voltage acts this much late, s; target and angle, 100 a second.
/// The target goes to and fro within some rows: at an instant between two it would do what no log tells.
fn servo(motor: f64, dead_s: f64) -> String {
    let (gain, supply, dt) = (4.0, 7.4, 2e-4);
    let dead = (dead_s / dt).round() as usize;
    let mut asked = Vec::new();
    let mut text = "t;goal_position;position\n".to_owned();
    let (mut w, mut x) = (0.0_f64, 0.0_f64);
    for k in 0..100_000_u32 {
        let t = f64::from(k) * dt;
        let target = 1.4 * ((20.0 * (0.9 * t).sin()).tanh() * 0.6 + 0.4 * (2.3 * t).sin());
        if k % 50 == 0 {
            writeln!(text, "{t:.4};{target:.5};{:.5}", (x * 4096.0 / TAU).round() * TAU / 4096.0).unwrap();
        }
        asked.push(f64::clamp(gain * (target - x), -1.0, 1.0));
        let v = supply * (k as usize).checked_sub(dead).map_or(0.0, |then| asked[then]);
        let friction = if w == 0.0 { v.clamp(-0.4, 0.4) } else { 0.4 * w.signum() };
        let next = w + dt / 0.05 * (motor * (v - friction) - w);
        w = if w != 0.0 && next * w < 0.0 { 0.0 } else { next };
        x += dt * w;
    }
    text
}
