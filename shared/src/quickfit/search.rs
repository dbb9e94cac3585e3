//! The genetic search on the linear model.

use super::arithmetic::LANES;
use super::polish::Model;
use super::{Arithmetic, Kept, Record, Request};
use crate::ga::{Genetic, Settings, Space};
use crate::random::Stream;

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

/// Searches gain (a quarter to four times the rough one), mechanical time constant (5 ms to 2 s) and electrical time
/// constant (a twentieth of a step, or 50 us, to 20 ms), all logarithmic. `working` is called after each pass over the samples.
pub fn run<A: Arithmetic>(
    record: &Record<'_>,
    request: &Request,
    evaluations: &mut u32,
    progress: &mut dyn FnMut(u16, f64),
    working: &mut dyn FnMut(),
) -> Found {
    let backwards = record.gain < 0.0;
    let objective = |chromosomes: &[[f64; 3]], objectives: &mut [f64]| {
        for (chromosomes, objectives) in chromosomes.chunks(LANES).zip(objectives.chunks_mut(LANES)) {
            let mut motors = [[1.0; 3]; LANES];
            for (motor, genes) in motors.iter_mut().zip(chromosomes) {
                *motor = motor_of(genes, backwards);
            }
            A::absolute_sums(record, &motors[..chromosomes.len()], objectives);
            working();
        }
    };
    let (best, absolute_sum) = genetic(record, request, evaluations, objective, progress);
    let [gain, tau_m, tau_e] = motor_of(&best, backwards);
    Found { model: Model { gain, tau_m, tau_e, coulomb: 0.0, offset: 0.0 }, absolute_sum }
}

/// The best chromosome and its objective. Generic, so that a board's image decides how it is optimised: the sorting
/// alone takes 12 KiB where it is compiled for speed, and gains nothing.
fn genetic(
    record: &Record<'_>,
    request: &Request,
    evaluations: &mut u32,
    mut objective: impl FnMut(&[[f64; 3]], &mut [f64]),
    progress: &mut dyn FnMut(u16, f64),
) -> ([f64; 3], f64) {
    let middle = libm::log(f64::from(record.gain.abs()));
    let width = libm::log(4.0);
    let shortest = libm::log((f64::from(record.step_s) / 20.0).max(5e-5));
    let space = Space::within(
        [middle - width, libm::log(5e-3), shortest],
        [middle + width, libm::log(2.0), libm::log(0.02)],
    );
    let settings = Settings {
        generations: request.generations.into(),
        seed: request.seed.into(),
        ..Settings::default()
    };
    let anywhere =
        |stream: &mut Stream| core::array::from_fn(|k| stream.between(space.low[k], space.high[k]));
    let size = usize::from(request.population);
    let mut search = Genetic::<POPULATION, 3>::start(&settings, &space, size, anywhere, &mut objective);
    progress(1, search.best_objective());
    while search.generation() < settings.generations {
        search.advance(&settings, &space, &mut objective);
        progress(search.generation() as u16, search.best_objective());
    }
    *evaluations += search.evaluations();
    (*search.best(), search.best_objective())
}

/// Gain, tau_m and tau_e of a chromosome. In `f32`, like all that is done for every candidate.
fn motor_of(genes: &[f64; 3], backwards: bool) -> [f32; 3] {
    let [size, tau_m, tau_e] = genes.map(|gene| libm::expf(gene as f32));
    [if backwards { -size } else { size }, tau_m, tau_e]
}
