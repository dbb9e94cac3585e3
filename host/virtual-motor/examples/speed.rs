//! How many times faster than real time each effect runs: `cargo run --release -p motorlens-virtual-motor --example speed`.

use motorlens_virtual_motor::{Effect, Kind, Motor, Run, VirtualMotor};
use std::time::Instant;

fn main() {
    let volts: Vec<f64> = (0..10_000).map(|k| 8.0 * (f64::from(k) * 0.004).sin()).collect();
    let measure = |name: &str, effects: &[Effect]| {
        let mut plant = VirtualMotor::new(&Motor::paper(), effects, 1);
        let start = Instant::now();
        let recording = plant.record(&volts, &Run::at(1000.0));
        let seconds = start.elapsed().as_secs_f64();
        println!("{name:20} {:6.0} x real time, {} rows", 10.0 / seconds, recording.time_s.len());
    };
    measure("none", &[]);
    for kind in Kind::all() {
        measure(kind.row().name, &[Effect::typical(kind)]);
    }
}
