//! Where the search for an effect begins.

use std::collections::BTreeSet;

use motorlens_shared::effects::{Kind, Parameter, Search};

use crate::diagnose::contained::{extended, replaces};
use crate::diagnose::ripple;
use crate::diagnose::tangent::{Projected, Tangent};
use crate::fit::cost::Objective;
use crate::fit::layout::{BaseValues, Layout, Values};
use crate::fit::search::Problem;
use crate::fit::simulate::LANES;

/// Cost, and the search vector.
pub type Start = (f64, Vec<f64>);

/// The parameters at which `kind` is tried on the model `values`: the finite sizes of its row, because friction, gaps and dead zones
/// have no derivative at zero.
fn sizes(problem: &Problem, values: &Values, tangent: &Tangent, kind: Kind) -> Vec<Vec<f64>> {
    let spec = kind.spec();
    let mut sizes: Vec<Vec<f64>> = spec.probes_on(&problem.rig).map(Iterator::collect).collect();
    match (spec.search, problem.hold_s) {
        (Search::Orders, _) => {
            sizes.extend(ripple::answering(problem, tangent, values, kind));
            sizes.extend(ripple::holding(problem, values));
        }
        (Search::Hold(name), Some(time)) => {
            let held = |p: &Parameter| if p.name == name { time } else { 0.0 };
            sizes.push(spec.parameters.iter().map(held).collect());
        }
        _ => {}
    }
    sizes
}

/// At how many unrelated places an effect is looked for, where others are looked for at one: of so many the best gains by chance alone.
pub fn places(kind: Kind) -> usize {
    match kind.spec().search {
        Search::Orders => ripple::HIGHEST_ORDER,
        Search::Probes | Search::Hold(_) | Search::Retraced | Search::Damped(_) => shapes(kind),
    }
}

/// How many different shapes an effect is begun with: while it is nothing, the records say nothing of its shape, and the best of them gains
/// by chance (R. Davies, *Biometrika* 74, 1987).
fn shapes(kind: Kind) -> usize {
    let spec = kind.spec();
    let shape = |probe: &&[f64]| -> Vec<u64> {
        spec.parameters.iter().zip(*probe).filter(|(of, _)| !of.strength).map(|(_, x)| x.to_bits()).collect()
    };
    spec.probes.iter().map(shape).collect::<BTreeSet<_>>().len().max(1)
}

/// `values` with the time constant and the viscous share that are usual, where the fit has biased them far from that: what a model lacks
/// it makes up for by its base, and next to a biased base no equation looks right. None where they are near.
pub fn straightened(problem: &Problem, values: &Values) -> Option<Values> {
    let prior = &problem.prior;
    let (tau_e, share) = (values.base.tau_e, values.base.viscous_share);
    let off = |(centre, width): (f64, f64), value: f64| (value - centre).abs() > width;
    let log = (prior.tau_e.0.ln(), prior.tau_e.1);
    if !off(log, tau_e.ln()) && !off(prior.viscous_share, share) {
        return None;
    }
    let mut usual = values.clone();
    (usual.base.tau_e, usual.base.viscous_share) = (prior.tau_e.0, prior.viscous_share.0);
    Some(usual)
}

/// The models from which `kind` is looked for beside `values` itself: with the usual time constants where the fit has biased them, and with the
/// viscous share that the effect asks for.
pub fn besides(problem: &Problem, values: &Values, kind: Kind) -> Vec<Values> {
    let damped = match kind.spec().search {
        Search::Damped(viscous_share) => {
            let base = BaseValues { viscous_share, ..values.base };
            Some(Values { base, ..values.clone() })
        }
        _ => None,
    };
    straightened(problem, values).into_iter().chain(damped).collect()
}

/// The search of `values` with `kind` of each of `sizes` added.
fn laid_out(problem: &Problem, values: &Values, kind: Kind, sizes: Vec<Vec<f64>>) -> (Layout, Vec<Vec<f64>>) {
    let tries: Vec<Values> = sizes.into_iter().map(|size| extended(values, kind, size)).collect();
    let kinds = tries.first().map_or_else(|| values.kinds(), Values::kinds);
    let layout = problem.layout(&kinds);
    let xs = tries.iter().map(|v| layout.pack(v)).collect();
    (layout, xs)
}

/// Starts for `values` with `kind` added at the sizes of its row, as they are, cheapest first.
pub fn plain_starts(problem: &Problem, values: &Values, kind: Kind) -> Vec<Start> {
    let sizes = kind.spec().probes_on(&problem.rig).map(Iterator::collect).collect();
    let (layout, xs) = laid_out(problem, values, kind, sizes);
    problem.costed(&layout, Objective::Scales, xs)
}

/// Starts for `values` with `kind` added, cheapest first. The model's own parameters are partialled out to first order (`tangent`); what was
/// foreseen so is run.
pub fn starts(problem: &Problem, values: &Values, tangent: &Tangent, kind: Kind) -> (Layout, Vec<Start>) {
    let (layout, xs) = laid_out(problem, values, kind, sizes(problem, values, tangent, kind));
    if replaces(&values.kinds(), kind) {
        let starts = problem.costed(&layout, Objective::Scales, xs);
        return (layout, starts);
    }
    let foreseen: Vec<(&Vec<f64>, [Projected; 2])> = xs
        .chunks(LANES)
        .flat_map(|chunk| chunk.iter().zip(tangent.project(problem, &layout, chunk)))
        .collect();
    let mut moved: Vec<Vec<f64>> = Vec::new();
    for which in [0, 1] {
        let mut best: Vec<_> = foreseen.iter().map(|(x, p)| (*x, &p[which])).collect();
        best.sort_by(|a, b| a.1.left.total_cmp(&b.1.left));
        moved.extend(best.into_iter().take(LANES / 2).map(|(x, p)| tangent.moved(&layout, x, p)));
    }
    let starts = problem.costed(&layout, Objective::Scales, moved);
    (layout, starts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_looked_for_at_one_place_and_every_order_and_shape_is_one_more() {
        assert_eq!([Kind::Coulomb, Kind::Delay, Kind::Gravity].map(places), [1; 3]);
        assert_eq!(places(Kind::Coast), 3, "frequencies of the PWM");
        assert_eq!(places(Kind::Cogging), ripple::HIGHEST_ORDER);
    }
}
