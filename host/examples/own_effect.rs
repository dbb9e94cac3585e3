//! An effect of one's own: a fan on the output shaft, written as a formula, tried among the library's.
//!
//! `cargo run --release --example own_effect`

use std::ops::ControlFlow;

use motorlens::formula::{Written, WrittenParameter, define};
use motorlens::{Measured, Options, discover};

fn main() -> motorlens::Result<()> {
    let fan = define(&Written {
        name: "fan".into(),
        port: "torque".into(),
        formula: "-drag * speed * abs(speed) * (1 + 0.3 * cos(2 * angle))".into(),
        title: "a fan with two blades before a strut".into(),
        signature: String::new(),
        source: String::new(),
        parameters: vec![WrittenParameter {
            name: "drag".into(),
            unit: "V s^2/rad^2".into(),
            meaning: "loss at a speed of 1 rad/s".into(),
            low: 0.0,
            typical: 0.02,
            high: 1.0,
        }],
    })
    .map_err(|wrong| motorlens::Error::usage(wrong.why, wrong.remedy))?;
    let mut options = Options::default();
    options.library.push(fan);

    let (time_s, voltage_v, angle_rad) = measured();
    let found = discover(&time_s, &voltage_v, Measured::Angle(&angle_rad), &options, &mut |_| {
        ControlFlow::Continue(())
    })?;
    let names: Vec<&str> = found.findings.effects.iter().map(|kind| kind.name()).collect();
    println!("{}: {}", found.findings.headline, names.join(", "));
    Ok(())
}

/// 8 s of steps against that fan, 500 samples a second.
fn measured() -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let steps = [6.0, 0.0, -4.0, 2.0, 9.0, -7.0, 3.0, -11.0];
    let time_s: Vec<f64> = (0..4000).map(|k| f64::from(k) * 2e-3).collect();
    let voltage_v: Vec<f64> = (0..4000).map(|k| steps[k / 250 % steps.len()]).collect();
    let (mut angle, mut speed) = (0.0_f64, 0.0_f64);
    let mut angle_rad = Vec::new();
    for volts in &voltage_v {
        angle_rad.push((angle / 1e-3).round() * 1e-3);
        for _ in 0..20 {
            let drag = 0.04 * speed * speed.abs() * (1.0 + 0.3 * (2.0 * angle).cos());
            speed += 1e-4 * (0.9 * (volts - drag) - speed) / 0.05;
            angle += 1e-4 * speed;
        }
    }
    (time_s, voltage_v, angle_rad)
}
