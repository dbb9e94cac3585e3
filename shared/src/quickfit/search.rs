//! The genetic search on the linear model.

use super::polish::Model;
use super::{Kept, Request};
use crate::ga::{Genetic, Settings, Space};
use crate::lanes::Lanes;
use crate::linear::{Filter, Hold, Kind, absolute_error};
use crate::motor::Combinations;

/// Candidates that share one pass over the samples. Two fit the registers of a Cortex-M4F.
const LANES: usize = 2;
/// The largest population.
const POPULATION: usize = 64;

/// The best model of a search and its sum of absolute errors, counts.
pub struct Found {
    pub model: Model,
    pub absolute_sum: f64,
}

/// Counts per volt second, as if the motor followed the voltage at once: the least-squares slope of the angle over the
/// voltage's integral. `None` when nothing moved or nothing was applied.
pub fn rough_gain(samples: &[Kept]) -> Option<f32> {
    let (mut product, mut square) = (0.0_f64, 0.0_f64);
    // Blocks in f32, sums in f64: soft double arithmetic is slow.
    for block in samples.chunks(16) {
        let mut sums = [0.0_f32; 2];
        for [_, integral, count] in block {
            sums[0] += integral * count;
            sums[1] += integral * integral;
        }
        product += f64::from(sums[0]);
        square += f64::from(sums[1]);
    }
    let gain = product / square;
    (square > 0.0 && gain.is_finite() && gain != 0.0).then_some(gain as f32)
}

/// Searches gain (a quarter to four times `gain`), mechanical time constant (5 ms to 2 s) and electrical time constant
/// (a twentieth of a step, or 50 us, to 20 ms), all logarithmic.
pub fn run(
    samples: &[Kept],
    step_s: f32,
    gain: f32,
    request: &Request,
    evaluations: &mut u32,
    mut progress: impl FnMut(u16, f64),
) -> Found {
    let step = f64::from(step_s);
    let middle = libm::log(f64::from(gain.abs()));
    let width = libm::log(4.0);
    let shortest = libm::log((step / 20.0).max(5e-5));
    let space = Space::within(
        [middle - width, libm::log(5e-3), shortest],
        [middle + width, libm::log(2.0), libm::log(0.02)],
    );
    let mut objective = |chromosomes: &[[f64; 3]], objectives: &mut [f64]| {
        evaluate(samples, step, gain < 0.0, chromosomes, objectives);
    };
    let settings = Settings {
        generations: request.generations.into(),
        seed: request.seed.into(),
        ..Settings::default()
    };
    let size = usize::from(request.population);
    let anywhere = |stream: &mut crate::random::Stream| {
        core::array::from_fn(|k| stream.between(space.low[k], space.high[k]))
    };
    let mut search = Genetic::<POPULATION, 3>::start(&settings, &space, size, anywhere, &mut objective);
    progress(1, search.best_objective());
    while search.generation() < settings.generations {
        search.advance(&settings, &space, &mut objective);
        progress(search.generation() as u16, search.best_objective());
    }
    *evaluations += search.evaluations();
    let [gain, tau_m, tau_e] = motor_of(search.best(), gain < 0.0).map(|value| value as f32);
    let model = Model { gain, tau_m, tau_e, coulomb: 0.0, offset: 0.0 };
    Found { model, absolute_sum: search.best_objective() }
}

/// Gain, tau_m and tau_e of a chromosome.
fn motor_of(genes: &[f64; 3], backwards: bool) -> [f64; 3] {
    let [size, tau_m, tau_e] = genes.map(libm::exp);
    [if backwards { -size } else { size }, tau_m, tau_e]
}

/// Sums of absolute errors, counts. Not generic, so that it is compiled, and optimised, with this crate.
#[inline(never)]
fn evaluate(samples: &[Kept], step: f64, backwards: bool, chromosomes: &[[f64; 3]], objectives: &mut [f64]) {
    for (chromosomes, objectives) in chromosomes.chunks(LANES).zip(objectives.chunks_mut(LANES)) {
        let filters = core::array::from_fn::<_, LANES, _>(|lane| {
            let [gain, tau_m, tau_e] = motor_of(&chromosomes[lane.min(chromosomes.len() - 1)], backwards);
            // Without viscous friction: tau_e tau_m s^2 + tau_m s + 1.
            let beta = 1.0 / (tau_e * tau_m);
            let motor = Combinations { b_over_a1: gain * beta, a2_over_a1: 1.0 / tau_e, a3_over_a1: beta };
            Filter::new(&motor, step, Hold::Zero, Kind::Angle)
        });
        let mut sums = [0.0; LANES];
        absolute_error(&Filter::<Lanes<f32, LANES>>::gather(&filters), samples, &mut sums);
        objectives.copy_from_slice(&sums[..objectives.len()]);
    }
}
