//! Phases and frequency of the pulses, refined together.

use super::leg::{Leg, product};
use crate::fit::cost::robust;

/// A step of Gauss and Newton in the phases and, where that is free, the frequency.
pub(super) struct Step {
    /// What was left before it.
    pub(super) cost: f64,
    pub(super) frequency: f64,
    pub(super) phases: Vec<f64>,
}

pub(super) fn refined(legs: &[Leg], frequency: f64, phases: &[f64], free: bool) -> Step {
    const TURN: f64 = 0.01;
    const MOST: f64 = 0.1;
    struct Slope {
        own: f64,
        shared: f64,
        lacks: f64,
        middle: f64,
    }
    let (mut curvature, mut gradient, mut cost) = (0.0, 0.0, 0.0);
    let slopes: Vec<Slope> = legs
        .iter()
        .zip(phases)
        .map(|(leg, phase)| {
            let middle = 0.5 * leg.grid.step_s * leg.bridge.cells() as f64;
            let change = TURN / middle;
            let lacks = |frequency: f64, phase: f64| -> Vec<f64> {
                leg.lacks(frequency, phase).into_iter().map(robust).collect()
            };
            let here = lacks(frequency, *phase);
            let slope = |there: Vec<f64>, by: f64| -> Vec<f64> {
                there.iter().zip(&here).map(|(a, b)| (b - a) / by).collect()
            };
            let of_phase = slope(lacks(frequency, phase + TURN), TURN);
            let own = product(&of_phase, &of_phase).max(1e-300);
            let toward = product(&of_phase, &here);
            let mut shared = 0.0;
            if free {
                // Turned about the record's middle, so that phase and frequency do not stand for one another.
                let of_frequency = slope(lacks(frequency + change, phase - change * middle), change);
                shared = product(&of_phase, &of_frequency);
                curvature += product(&of_frequency, &of_frequency) - shared * shared / own;
                gradient += product(&of_frequency, &here) - shared * toward / own;
            }
            cost += product(&here, &here);
            Slope { own, shared, lacks: toward, middle }
        })
        .collect();
    let change = if free && curvature > 0.0 { gradient / curvature } else { 0.0 };
    let moved = slopes.iter().zip(phases).map(|(slope, phase)| {
        let turn = ((slope.lacks - slope.shared * change) / slope.own).clamp(-MOST, MOST);
        phase + turn - change * slope.middle
    });
    Step { cost, frequency: frequency + change, phases: moved.collect() }
}
