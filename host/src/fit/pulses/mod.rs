//! When the pulses of a slow PWM come: the records show it, as nothing ties it to their clock.
//!
//! To first order the pulses add their first harmonic, whose size follows the command and whose phase turns with the frequency.
//! What the voltages would have to bring for the error to vanish, times that size, is a series whose spectrum peaks at the
//! frequency (and, as commands change at a beat of their own, at its mirrors in that beat): one transform looks at all of them.

mod bridge;
mod leg;
mod refine;
mod spectrum;

use leg::{Leg, Ride, cost, product};
use motorlens_shared::effects::Kind;
use refine::refined;
use rustfft::FftPlanner;
use spectrum::{Spectrum, peaks};

use super::grid::{Grid, Quantity};
use super::layout::Values;
use super::search::Problem;

/// The parameter that the pulses tell.
pub const FREQUENCY: &str = "coast.frequency";

/// Frequencies that are looked at, Hz; above the last the pulses of a motor run into one.
const RANGE_HZ: (f64, f64) = (60.0, 1000.0);
/// A peak of the spectrum is tried where what it foresees is so many times what is seen, at least and at most: a mirror is too large or too small.
const SIZE: (f64, f64) = (0.4, 1.8);
/// Pulses must leave no more than this share of what the law alone leaves.
const WORTH: f64 = 0.97;
/// Phases that are tried of a record to compare frequencies.
pub const ROUGHLY: usize = 7;
/// ... and in the end.
pub const CLOSELY: usize = 24;
/// So many are handed on.
const MOST: usize = 20;

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

    /// Frequencies of the PWM, Hz, under which the bridge of `values` would explain most of what it leaves, most promising first.
    pub fn likely_pulses(&self, values: &Values) -> Vec<f64> {
        if let Some(known) = self.fixed.get(FREQUENCY) {
            return vec![*known];
        }
        let ride = Ride::new(self, values);
        let angles = self.grids.iter().filter(|grid| shows_angle(grid));
        let legs: Vec<Leg> = angles.filter_map(|grid| ride.stripped(grid)).collect();
        let longest = legs.iter().map(|leg| leg.bridge.cells() + 1).max().unwrap_or(1);
        let n = (4 * longest).next_power_of_two();
        let mut planner = FftPlanner::new();
        let spectra: Vec<_> = legs.iter().map(|leg| Spectrum::new(leg, n, &mut planner)).collect();
        // How large the pulses of a frequency are, the record tells best that is fitted worst.
        let each = legs.iter().zip(&spectra);
        let Some((leg, spectrum)) = each.max_by(|a, b| mean_cost(a.0).total_cmp(&mean_cost(b.0))) else {
            return Vec::new();
        };
        let fits = |hz: &f64| {
            let adds = leg.adds(*hz, spectrum.phase(*hz, leg.grid.step_s));
            let size = product(&leg.stripped, &adds) / product(&adds, &adds).max(1e-300);
            (SIZE.0..SIZE.1).contains(&size)
        };
        let shortest = legs.iter().map(|leg| leg.grid.step_s).fold(f64::MAX, f64::min);
        let range = (RANGE_HZ.0, RANGE_HZ.1.min(1.0 / shortest));
        peaks(&spectra, range).into_iter().filter(fits).take(MOST).collect()
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

    /// Lets the pulses of a frequency that is known, Hz, come: beside other records `values` showed it.
    pub fn pulse_at(&mut self, values: &Values, frequency: f64) {
        self.time_pulses(values, frequency, false, CLOSELY);
        self.pulse_hz = Some(frequency);
    }

    /// Lets the pulses come as in `other`, whose records are the same.
    pub fn pulse_like(&mut self, other: &Self) {
        self.pulse_hz = other.pulse_hz;
        for (grid, other) in self.grids.iter_mut().zip(&other.grids) {
            grid.pulses.clone_from(&other.pulses);
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

fn mean_cost(leg: &Leg) -> f64 {
    cost(&leg.lacks) / leg.lacks.len().max(1) as f64
}
