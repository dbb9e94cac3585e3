//! Fails unless the effect that was just added is told from all others, on a motor that the library did not simulate.

use std::ops::ControlFlow;

use motorlens::{Measured, Options, discover};

/// Torque per speed, V s/rad, and critical speed, rad/s, of the brake.
const BRAKE: (f64, f64) = (1.5, 1.5);

fn main() -> motorlens::Result<()> {
    let (time_s, voltage_v, angle_rad) = measured();
    let found = discover(&time_s, &voltage_v, Measured::Angle(&angle_rad), &Options::default(), &mut |_| {
        ControlFlow::Continue(())
    })?;
    let names: Vec<&str> = found.findings.effects.iter().map(|kind| kind.name()).collect();
    println!("{}: {}", found.findings.headline, names.join(", "));
    assert_eq!(names, ["eddy_brake"], "the brake alone explains this motor");
    for (name, truth) in [("eddy_brake.drag", BRAKE.0), ("eddy_brake.critical", BRAKE.1)] {
        let value = found.findings.parameters.iter().find(|p| p.name == name).map(|p| p.value);
        assert!(value.is_some_and(|v| (v / truth - 1.0).abs() < 0.1), "{name}: {value:?}, not {truth}");
    }
    Ok(())
}

/// 16 s of steps against the brake, 500 samples a second.
fn measured() -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let steps = [2.0, 0.0, -3.0, 6.0, 0.0, -1.5, 1.0, -9.0, 4.0, -6.0, 11.0, -2.0, 0.0, 3.0, -11.0, 9.0];
    let time_s: Vec<f64> = (0..8000).map(|k| f64::from(k) * 2e-3).collect();
    let voltage_v: Vec<f64> = (0..8000).map(|k| steps[k / 250 % steps.len()]).collect();
    let (mut angle, mut speed) = (0.0_f64, 0.0_f64);
    let mut angle_rad = Vec::new();
    for volts in &voltage_v {
        angle_rad.push((angle / 1e-3).round() * 1e-3);
        for _ in 0..20 {
            let drag = BRAKE.0 * speed / (1.0 + (speed / BRAKE.1).powi(2));
            speed += 1e-4 * (0.9 * (volts - drag) - speed) / 0.05;
            angle += 1e-4 * speed;
        }
    }
    (time_s, voltage_v, angle_rad)
}
