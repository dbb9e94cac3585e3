//! What voltage and motion alone determine of the paper's eight parameters: three ratios and the gain.

use crate::fit::layout::{BASE_PARAMETERS, BaseValues, Values};
use crate::fit::search::Problem;
use crate::fit::uncertainty::{Estimate, Spread};

/// A function of the base parameters, as people read it.
type Row = (&'static str, &'static str, fn(&BaseValues) -> f64);

/// b/a1, a2/a1, a3/a1 of the paper's transfer function b / (a1 s^3 + a2 s^2 + a3 s), and the gain b/a3.
const ROWS: [Row; 4] = [
    ("b/a3", "rad/s/V", |b| b.gain),
    ("b/a1", "rad/(V s^3)", |b| b.gain / (b.tau_m * b.tau_e)),
    ("a2/a1", "1/s", |b| 1.0 / b.tau_e + b.viscous_share / b.tau_m),
    ("a3/a1", "1/s^2", |b| 1.0 / (b.tau_m * b.tau_e)),
];

/// The combinations with 95 % intervals.
pub fn combinations(problem: &Problem, values: &Values) -> Vec<Estimate> {
    let spread = Spread::of(problem, values);
    let at: Vec<f64> = spread.x[..BASE_PARAMETERS].to_vec();
    let base = |x: &[f64]| BaseValues {
        gain: x[0].exp(),
        tau_m: x[1].exp(),
        tau_e: x[2].exp(),
        viscous_share: x[3],
    };
    ROWS.iter()
        .map(|(name, unit, f)| {
            let log = |x: &[f64]| f(&base(x)).ln();
            let slope: Vec<f64> = (0..at.len())
                .map(|k| {
                    let (mut up, mut down) = (at.clone(), at.clone());
                    up[k] += 1e-5;
                    down[k] -= 1e-5;
                    (log(&up) - log(&down)) / 2e-5
                })
                .collect();
            spread.ratio(name, unit, f(&base(&at)), &slope)
        })
        .collect()
}
