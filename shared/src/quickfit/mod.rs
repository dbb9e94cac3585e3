//! The quick fit: a small genetic search and a least-squares polish, on the board as on the host.
//!
//! The board keeps up to [`KEPT`] samples of a run ([`Keeper`]), searches gain and time constants with the compact
//! genetic algorithm ([`crate::ga`]) on the linear model, and polishes the best by Levenberg-Marquardt, where Coulomb
//! friction can join. Everything that reaches the result is addition, multiplication, division, square root or libm's
//! software, so the same samples and seed give the same bits on a Cortex-M4F and on the host.

mod arithmetic;
mod discrete;
mod keeper;
mod polish;
mod search;

pub use arithmetic::{Arithmetic, Fixed, Float, Record};
pub use keeper::{KEPT, Keeper};

use crate::scalar::Scalar;
use polish::Model;
use serde::{Deserialize, Serialize};

/// The fewest kept samples that are fitted.
pub const FEWEST: usize = 50;

/// What to fit, and how hard to search.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Chromosomes: 2 to 64.
    pub population: u8,
    /// Generations, the first included: 1 to 1000.
    pub generations: u16,
    /// The same seed gives the same result.
    pub seed: u32,
    /// Whether Coulomb friction is fitted too.
    pub coulomb: bool,
    /// The output shaft's turn per encoder count, rad.
    pub rad_per_count: f32,
}

impl Default for Request {
    fn default() -> Self {
        Self { population: 16, generations: 40, seed: 1, coulomb: false, rad_per_count: 1.0 }
    }
}

/// How far a fit is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Generations done.
    pub generation: u16,
    /// Of so many.
    pub generations: u16,
    /// The best integral of absolute error so far, rad s.
    pub iae: f32,
}

/// A parameter and how well the samples determine it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Its value.
    pub value: f32,
    /// Standard error, of the same unit, as if the errors of the samples were independent. They are not quite, so it
    /// is a lower bound.
    pub standard_error: f32,
}

/// What a fit found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct QuickFit {
    /// No-load speed per volt, rad/s per V. Negative where the encoder counts against the voltage.
    pub gain: Estimate,
    /// Mechanical time constant, s.
    pub tau_m: Estimate,
    /// Electrical time constant, s.
    pub tau_e: Estimate,
    /// Coulomb friction, V; `None` when it was not asked for.
    pub coulomb: Option<Estimate>,
    /// Integral of the absolute error, rad s.
    pub iae: f32,
    /// The same after the search alone, before the polish.
    pub iae_search: f32,
    /// Root mean square of the error, rad.
    pub rmse: f32,
    /// Samples used.
    pub samples: u16,
    /// Simulations made.
    pub evaluations: u32,
    /// How long it all took, us; 0 where nobody measured it.
    pub micros: u32,
    /// How long the search alone took, us.
    pub micros_search: u32,
}

/// A kept sample: mean voltage to the next (V), its integral so far (V s), counts since the first.
pub type Kept = [f32; 3];

/// Fits samples kept every `step_s` seconds, searching in the numbers of `A`. `progress` is told after each generation,
/// and the last of them again after each sweep of the polish. `working` is called after every few candidates and every
/// few samples of a sweep: a generation takes most of a second where integers and software must do, and a watchdog is
/// not fed by what comes so seldom. `None` when there are fewer than [`FEWEST`] samples or nothing moved.
pub fn fit<A: Arithmetic>(
    samples: &[Kept],
    step_s: f32,
    request: &Request,
    mut progress: impl FnMut(Progress),
    mut working: impl FnMut(),
) -> Option<QuickFit> {
    if samples.len() < FEWEST {
        return None;
    }
    let gain = search::rough_gain(samples)?;
    let area = f64::from(step_s) * f64::from(request.rad_per_count.abs());
    let mut evaluations = 0;
    let mut last = Progress { generation: 0, generations: request.generations, iae: 0.0 };
    let peak_v = samples.iter().fold(0.0_f32, |peak, sample| peak.max(Scalar::abs(sample[0])));
    let record = Record { samples, step_s, gain, peak_v };
    let mut generation_done = |generation: u16, sum: f64| {
        last = Progress { generation, iae: (sum * area) as f32, ..last };
        progress(last);
    };
    let found = search::run::<A>(&record, request, &mut evaluations, &mut generation_done, &mut working);
    let mut count = || {
        evaluations += polish::SIMULATIONS;
        progress(last);
    };
    let polished = if request.coulomb {
        let starts = [0.0, 0.02, 0.1].map(|share| Model { coulomb: share * peak_v, ..found.model });
        // The search knows nothing of friction, so its time constants may be far off: several starts, the best wins.
        let ends = starts.map(|start| polish::run(samples, step_s, start, true, &mut count, &mut working));
        ends.into_iter()
            .reduce(|best, other| if other.square_sum < best.square_sum { other } else { best })?
    } else {
        polish::run(samples, step_s, found.model, false, &mut count, &mut working)
    };
    let scale = request.rad_per_count;
    let relative =
        |value: f32, error: f64| Estimate { value, standard_error: Scalar::abs(value) * error as f32 };
    let (model, errors) = (polished.model, polished.standard_errors);
    Some(QuickFit {
        gain: relative(model.gain * scale, errors[0]),
        tau_m: relative(model.tau_m, errors[1]),
        tau_e: relative(model.tau_e, errors[2]),
        coulomb: request
            .coulomb
            .then_some(Estimate { value: model.coulomb, standard_error: errors[3] as f32 }),
        iae: (polished.absolute_sum * area) as f32,
        iae_search: (found.absolute_sum * area) as f32,
        rmse: (libm::sqrt(polished.square_sum / samples.len() as f64) * f64::from(scale.abs())) as f32,
        samples: samples.len() as u16,
        evaluations,
        micros: 0,
        micros_search: 0,
    })
}

#[cfg(test)]
mod tests;
