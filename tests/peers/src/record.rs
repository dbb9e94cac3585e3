//! The data that everyone searches on: the paper's three sines through the virtual motor and its encoder.

use motorlens::search::LinearRecord;
use motorlens_shared::linear::{Hold, Kind};
use motorlens_shared::motor::PaperMotor;
use motorlens_virtual_motor::{Motor, Run, VirtualMotor};
use std::f64::consts::PI;

/// Seconds of each record.
pub const SECONDS: u32 = 12;

/// Centre of everyone's region: the virtual motor's own parameters.
pub fn motor() -> PaperMotor {
    let m = Motor::paper();
    PaperMotor {
        torque_constant: m.torque_constant,
        back_emf_constant: m.back_emf_constant,
        inductance: m.inductance_h,
        resistance: m.resistance_ohm,
        shaft_inertia: m.load_inertia,
        rotor_inertia: m.rotor_inertia,
        rotor_damping: m.rotor_damping,
        shaft_damping: m.load_damping,
        gear_ratio: m.gear_ratio,
    }
}

/// V = 3, 5, 7 sin(0.5 pi t), at `rate` samples per second.
pub fn paper(rate: u32) -> Vec<LinearRecord> {
    let mut plant = VirtualMotor::new(&Motor::paper(), &[], 1);
    [3.0, 5.0, 7.0]
        .map(|amplitude| {
            let rate = f64::from(rate);
            let volts: Vec<f64> = (0..SECONDS * rate as u32)
                .map(|k| amplitude * (0.5 * PI * f64::from(k) / rate).sin())
                .collect();
            let recording = plant.record(&volts, &Run::at(rate));
            LinearRecord {
                dt: 1.0 / rate,
                voltage: volts,
                measured: recording.angle_rad,
                kind: Kind::Angle,
                hold: Hold::Zero,
            }
        })
        .to_vec()
}
