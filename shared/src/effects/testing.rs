//! A small motor for the effects' own tests.

use super::{Kind, Rig};
use crate::base::Base;
use crate::simulator::{Motion, Simulator};
use crate::step::State;

pub const BASE: Base<f64> = Base { gain: 0.8, tau_m: 0.05, tau_e: 5e-4, viscous_share: 0.1 };

pub const RIG: Rig = Rig {
    step_s: 1e-3,
    gear_ratio: 50.0,
    encoder_on_motor: true,
    nominal_v: 12.0,
    supply_v: 12.0,
    reference_speed: 9.6,
    count_rad: 0.002,
};

/// Runs one effect over `voltages` (one a millisecond) from `state`; returns the angle read after each step and
/// the last motion.
pub fn run_from(
    state: State<f64>,
    kind: Kind,
    parameters: &[f64],
    voltages: &[f64],
) -> (std::vec::Vec<f64>, Motion<f64>) {
    let simulator = Simulator::new(&BASE, [(kind, parameters)], &RIG);
    let mut motion = simulator.start(state);
    let mut angles = std::vec::Vec::new();
    for k in 0..voltages.len() {
        simulator.advance(&mut motion, voltages, k);
        angles.push(simulator.read(&motion));
    }
    (angles, motion)
}

/// From rest.
pub fn run(kind: Kind, parameters: &[f64], voltages: &[f64]) -> (std::vec::Vec<f64>, Motion<f64>) {
    run_from(State::rest(), kind, parameters, voltages)
}

/// Speed after two seconds at `volts`.
pub fn steady_speed(kind: Kind, parameters: &[f64], volts: f64) -> f64 {
    run(kind, parameters, &[volts; 2000]).1.state.speed
}

pub fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} is not {b} within {tolerance}");
}

/// By what factor half the step lowers the error of where a swinging run ends: 2 for an equation that acts late, 4 for one that
/// acts at the middle of the step.
pub fn gain_of_half_steps(kind: Kind, parameters: &[f64]) -> f64 {
    let end = |per_step: usize| {
        let rig = Rig { step_s: per_step as f64 * 1.25e-4, ..RIG };
        let simulator = Simulator::new(&BASE, [(kind, parameters)], &rig);
        let mut motion = simulator.start(State::rest());
        let voltages = std::vec![3.0; 6400 / per_step];
        for k in 0..voltages.len() {
            simulator.advance(&mut motion, &voltages, k);
        }
        motion.state.angle
    };
    let truth = end(1);
    (end(32) - truth).abs() / (end(16) - truth).abs()
}
