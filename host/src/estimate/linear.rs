//! Methods that know the linear model only, on the paper's own search: the genetic algorithm and the textbook's fit.

use motorlens_shared::motor::Combinations;

use super::{Method, Options, Searched};
use crate::error::{BadInput, Error, Result};
use crate::fit::layout::{BaseValues, Values};
use crate::fit::search::Problem;
use crate::log::Record;
use crate::motor_file::MotorFile;
use crate::paper::data::{Data, even, nameplate_start};
use crate::search::dispatch::Level;
use crate::search::{GaOptions, Records, Start, conventional_on, genetic_on};

/// A first generation spans this factor either way of the name plate.
const FACTOR: f64 = 4.0;

/// Searches the base model by `options.method`, which has no effects.
///
/// # Errors
/// Records that the linear search cannot use.
pub(crate) fn search(
    problem: &Problem,
    records: &[Record],
    motor: &MotorFile,
    options: &Options,
    progress: &mut dyn FnMut(u32, f64),
) -> Result<Searched> {
    let data = Data { records: records.to_vec(), motor: motor.clone(), hidden: None };
    let plate = nameplate_start(&data);
    let prepared = Records::new(&even(records), Level::best()).map_err(|e| unusable(records, &e))?;
    let settings = GaOptions {
        population: options.population,
        generations: options.generations,
        seed: options.seed,
        threads: std::thread::available_parallelism().map_or(1, usize::from),
        ..GaOptions::default()
    };
    let share = problem.prior.viscous_share.0;
    let found = |c: &Combinations, history, evaluations| Searched {
        values: Values { base: base_of(c, share), effects: Vec::new() },
        history,
        evaluations,
    };
    Ok(match options.method {
        Method::Conventional => {
            let result = conventional_on(&prepared, &plate);
            found(&result.combinations, vec![result.iae], result.evaluations)
        }
        Method::Paper => {
            let centre = conventional_on(&prepared, &plate).motor;
            let result = genetic_on(&prepared, &Start::Literal { centre }, &settings, progress);
            found(&result.combinations, result.history, result.evaluations)
        }
        Method::Ga | Method::Fast | Method::Feedforward => {
            let start = Start::Logarithmic { centre: plate, factor: FACTOR };
            let result = genetic_on(&prepared, &start, &settings, progress);
            found(&result.combinations, result.history, result.evaluations)
        }
    })
}

/// The base model with these combinations; of the damping, `share` is taken as viscous, which they do not tell.
///
/// a2/a1 = x + share p/x and a3/a1 = p with x = 1/tau_e and p = 1/(tau_e tau_m). Where the poles are complex no
/// such motor exists, and the nearest with equal poles is taken.
fn base_of(c: &Combinations, share: f64) -> BaseValues {
    let (sum, product) = (c.a2_over_a1, c.a3_over_a1);
    let rate = 0.5 * (sum + (sum * sum - 4.0 * share * product).max(0.0).sqrt());
    BaseValues { gain: c.gain(), tau_m: rate / product, tau_e: 1.0 / rate, viscous_share: share }
}

fn unusable(records: &[Record], why: &dyn std::fmt::Display) -> Error {
    let path = records.first().map(|r| r.path.clone()).unwrap_or_default();
    BadInput::new(&path, why.to_string(), "use --method fast, which takes any record").into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_base_model_and_its_combinations_are_the_same_motor() {
        let b = BaseValues { gain: 0.9, tau_m: 0.05, tau_e: 7e-4, viscous_share: 0.08 };
        let product = 1.0 / (b.tau_m * b.tau_e);
        let c = Combinations {
            b_over_a1: b.gain * product,
            a2_over_a1: 1.0 / b.tau_e + b.viscous_share / b.tau_m,
            a3_over_a1: product,
        };
        let again = base_of(&c, 0.08);
        for (x, y) in [(again.gain, b.gain), (again.tau_m, b.tau_m), (again.tau_e, b.tau_e)] {
            assert!((x / y - 1.0).abs() < 1e-9, "{x} {y}");
        }
    }
}
