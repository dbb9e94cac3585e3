//! A model in use: over a whole voltage, and step by step under a controller.
//!
//! `cargo run --release --example simulate -- model.json`

use std::path::Path;

use motorlens::Model;

fn main() -> motorlens::Result<()> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "model.json".into());
    let model = Model::read(Path::new(&path))?;

    let time_s: Vec<f64> = (0..1000).map(|k| f64::from(k) * 1e-3).collect();
    let angle_rad = model.simulate(&time_s, &[3.0; 1000], 0.0)?;
    println!("after a second of 3 V: {:.3} rad", angle_rad[999]);

    let mut motor = model.start(1e-3, 0.0);
    while motor.time_s() < 1.0 {
        let error = 1.0 - motor.angle_rad();
        motor.step((20.0 * error - 0.5 * motor.speed_rad_s()).clamp(-12.0, 12.0));
    }
    println!("a second after a step of the set point to 1 rad: {:.3} rad", motor.angle_rad());
    Ok(())
}
