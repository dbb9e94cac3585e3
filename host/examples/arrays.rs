//! Which effect does a motor have, from plain arrays? Here a motor whose driver swallows the first volt.
//!
//! `cargo run --release --example arrays`

use std::ops::ControlFlow;

use motorlens::{Event, Measured, Options, discover};

fn main() -> motorlens::Result<()> {
    let (time_s, voltage_v, angle_rad) = measured();
    let found =
        discover(&time_s, &voltage_v, Measured::Angle(&angle_rad), &Options::default(), &mut |event| {
            if let Event::Model { effects, rmse } = event {
                eprintln!("{effects:?}: {rmse:.5} rad");
            }
            ControlFlow::Continue(())
        })?;
    println!("{}", found.findings.headline);
    for p in &found.findings.parameters {
        println!("{} = {:.4} {}", p.name, p.value, p.unit);
    }
    Ok(())
}

/// 8 s of steps, 500 samples a second, from an encoder of 6283 counts a turn.
fn measured() -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let steps = [6.0, 0.0, -4.0, 2.0, 9.0, -7.0, 1.5, -1.2];
    let time_s: Vec<f64> = (0..4000).map(|k| f64::from(k) * 2e-3).collect();
    let voltage_v: Vec<f64> = (0..4000).map(|k| steps[k / 250 % steps.len()]).collect();
    let (mut angle, mut speed) = (0.0_f64, 0.0_f64);
    let mut angle_rad = Vec::new();
    for volts in &voltage_v {
        angle_rad.push((angle / 1e-3).round() * 1e-3);
        for _ in 0..20 {
            let passed = volts.signum() * (volts.abs() - 1.0).max(0.0);
            speed += 1e-4 * (0.9 * passed - speed) / 0.05;
            angle += 1e-4 * speed;
        }
    }
    (time_s, voltage_v, angle_rad)
}
