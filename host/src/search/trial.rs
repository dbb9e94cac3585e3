//! Records for the tests: the paper's three sines on a small 1:104 motor, seen through an encoder.

use super::record::LinearRecord;
use motorlens_shared::linear::{Filter, Hold, Kind, Prepare, State};
use motorlens_shared::motor::PaperMotor;

/// A small 12 V gear motor.
pub const MOTOR: PaperMotor =
    PaperMotor::from_genes([0.0105, 0.0105, 2.1e-3, 3.2, 2e-3, 1.1e-6, 1.5e-6, 2e-3], 104.0);

/// Output-shaft angle of one encoder count, rad: 12 counts per rotor turn, times 4, times the gear.
const COUNT: f64 = core::f64::consts::TAU / (48.0 * 104.0);

/// Three records of 12 s, one for each amplitude of the paper, at `rate` samples per second.
pub fn three_sines(rate: u32, kind: Kind) -> Vec<LinearRecord> {
    let dt = 1.0 / f64::from(rate);
    let record = |amplitude: f64| {
        let voltage: Vec<f64> = (0..12 * rate)
            .map(|k| amplitude * (0.5 * core::f64::consts::PI * f64::from(k) * dt).sin())
            .collect();
        let filter = Filter::new(&MOTOR.combinations(), dt, Hold::First, kind);
        let mut prepare = Prepare::new(dt, Hold::First, kind);
        let mut state = State::default();
        let seen = |x: f64| if kind == Kind::Angle { (x / COUNT).floor() * COUNT } else { x };
        let measured =
            voltage.iter().map(|&v| seen(filter.error(&mut state, prepare.push(v, 0.0)))).collect();
        LinearRecord { dt, voltage, measured, kind, hold: Hold::First }
    };
    [3.0, 5.0, 7.0].map(record).to_vec()
}
