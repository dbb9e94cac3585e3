//! The paper's motor and its three sines: the records on which searches are timed and compared.

use std::f64::consts::PI;

use motorlens_shared::linear::{Hold, Kind};
use motorlens_shared::motor::PaperMotor;
use motorlens_virtual_motor::{Motor, Run, VirtualMotor};

use crate::search::LinearRecord;

/// Seconds of each record.
pub const SECONDS: u32 = 12;

/// The paper's motor as the virtual motor has it, in the paper's eight parameters and gear ratio.
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

/// What its encoder says under V = 3, 5, 7 sin(0.5 pi t) V, `rate` samples a second, without any hidden effect.
pub fn records(rate: u32) -> Vec<LinearRecord> {
    let mut plant = VirtualMotor::new(&Motor::paper(), &[], 1);
    let per_second = f64::from(rate);
    [3.0, 5.0, 7.0]
        .map(|amplitude| {
            let volt = |k: u32| amplitude * (0.5 * PI * f64::from(k) / per_second).sin();
            let voltage: Vec<f64> = (0..SECONDS * rate).map(volt).collect();
            let measured = plant.record(&voltage, &Run::at(per_second)).angle_rad;
            LinearRecord { dt: 1.0 / per_second, voltage, measured, kind: Kind::Angle, hold: Hold::Zero }
        })
        .to_vec()
}
