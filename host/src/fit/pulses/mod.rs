//! When the pulses of a slow PWM come: the records show it, as nothing ties it to their clock.
//!
//! A model that knows the frequency of its bridge is compared with the phase that each record shows.

mod bridge;
mod leg;
mod refine;

use leg::{Leg, Ride, cost};
use motorlens_shared::effects::Kind;
use refine::refined;

use super::grid::{Grid, Quantity};
use super::layout::Values;
use super::search::Problem;

/// The parameter that the pulses tell.
pub const FREQUENCY: &str = "coast.frequency";

/// Frequencies that are looked at, Hz; above the last the pulses of a motor run into one.
const RANGE_HZ: (f64, f64) = (60.0, 1000.0);
/// Pulses must leave no more than this share of what the law alone leaves.
const WORTH: f64 = 0.97;
/// Phases that are tried of a record.
pub const CLOSELY: usize = 24;

impl Problem {
    /// Forgets when pulses come.
    pub fn forget_pulses(&mut self) {
        self.pulse_hz = None;
        self.grids.iter_mut().for_each(|grid| grid.pulses.clear());
    }

    /// Lets the pulses come of which a model of `values` knows the frequency, if it has such a bridge.
    pub fn time_known_pulses(&mut self, values: &Values) {
        if let Some(hz) = frequency_of(values).filter(|hz| *hz < RANGE_HZ.1) {
            self.time_pulses(values, hz, true, CLOSELY);
        }
    }

    /// Lets the pulses of `frequency`, Hz, come in every record of angles when they explain most of what `values` leave; the
    /// frequency is refined where it is `free`, and every phase found by so many `tries`. Without any where they explain nothing.
    pub fn time_pulses(&mut self, values: &Values, frequency: f64, free: bool, tries: usize) {
        const ROUNDS: usize = 3;
        let mut frequency = frequency;
        self.forget_pulses();
        let ride = Ride::new(self, values);
        let angles = self.grids.iter().filter(|grid| shows_angle(grid));
        let legs: Vec<Leg> = angles.filter_map(|grid| ride.leg(grid)).collect();
        let mut phases: Vec<f64> = legs.iter().map(|leg| leg.phase(frequency, tries)).collect();
        let mut step = refined(&legs, frequency, &phases, free);
        for _ in 1..ROUNDS {
            let next = refined(&legs, step.frequency, &step.phases, free);
            if next.cost >= step.cost {
                break;
            }
            (frequency, phases) = (step.frequency, step.phases.clone());
            step = next;
        }
        let least = step.cost;
        let pulses: Vec<Vec<f64>> =
            legs.iter().zip(&phases).map(|(leg, phase)| leg.bridge.beyond(frequency, *phase)).collect();
        let without: f64 = legs.iter().map(|leg| cost(&leg.lacks)).sum();
        if least < WORTH * without {
            self.pulse_hz = Some(frequency);
            for (grid, pulses) in self.grids.iter_mut().filter(|grid| shows_angle(grid)).zip(pulses) {
                grid.pulses = pulses;
            }
        }
    }
}

fn shows_angle(grid: &Grid) -> bool {
    grid.quantity == Quantity::Angle
}

/// Frequency of the PWM that `values` have, Hz, where they have a bridge that coasts.
fn frequency_of(values: &Values) -> Option<f64> {
    values.effects.iter().find(|(kind, _)| *kind == Kind::Coast).map(|(_, p)| p[1])
}
