//! Orders of torque ripple: to which of them the records answer.
//!
//! A guided run answers linearly to the sine and the cosine of a ripple, because its phase is that of the measured
//! shaft. So one small probe of each tells the best size of both, and what it would be worth, order by order.

use motorlens_shared::effects::Kind;

use super::tangent::Tangent;
use crate::fit::layout::Values;
use crate::fit::search::Problem;
use crate::fit::simulate::LANES;

/// Highest order looked for, periods per motor revolution.
const HIGHEST_ORDER: usize = 24;
/// Size of a probe, V of a 12 V motor.
const PROBE_V: f64 = 0.02;
/// Orders that are tried in earnest.
const MOST: usize = 3;

/// Parameters of a pure sine; its harmonic is left to the search.
fn ripple(sine: f64, cosine: f64, order: f64) -> Vec<f64> {
    vec![sine, cosine, 0.0, 0.0, order]
}

/// Starting parameters (sine, cosine, order) of the orders that take most away from the error of `model`.
pub fn starts(problem: &Problem, tangent: &Tangent, model: &Values) -> Vec<Vec<f64>> {
    let probe = PROBE_V * problem.rig.nominal_v / 12.0;
    let kinds = [model.kinds(), vec![Kind::Cogging]].concat();
    let layout = problem.layout(&kinds);
    let orders: Vec<f64> = (1..=HIGHEST_ORDER).map(|order| order as f64).collect();
    let mut found: Vec<(f64, Vec<f64>)> = Vec::new();
    for orders in orders.chunks(LANES / 2) {
        let with = |sine: f64, cosine: f64, order: f64| {
            layout.pack(&model.with(Kind::Cogging, ripple(sine, cosine, order)))
        };
        let xs: Vec<Vec<f64>> =
            orders.iter().flat_map(|order| [with(probe, 0.0, *order), with(0.0, probe, *order)]).collect();
        let gains = tangent.pairs(problem, &layout, &xs);
        found.extend(
            orders
                .iter()
                .zip(gains)
                .map(|(order, (gain, [s, c]))| (gain, ripple(s * probe, c * probe, *order))),
        );
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<Vec<f64>> = Vec::new();
    for (_, start) in found {
        let order = start[start.len() - 1];
        // Half of a chosen order would only imitate it by its harmonic.
        if chosen.len() < MOST && !chosen.iter().any(|c| c[c.len() - 1] == 2.0 * order) {
            chosen.push(start);
        }
    }
    chosen
}
