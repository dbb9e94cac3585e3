//! Where the search for an effect begins.

use motorlens_shared::effects::Kind;

use crate::diagnose::contained::parts;
use crate::diagnose::ripple;
use crate::diagnose::tangent::{Projected, Tangent};
use crate::fit::cost::Objective;
use crate::fit::layout::{Layout, Values};
use crate::fit::search::Problem;
use crate::fit::simulate::LANES;

/// Cost, and the search vector.
pub type Start = (f64, Vec<f64>);

/// The model that `kind` extends: `values` without the simpler laws that `kind` contains, and the place and size of each of those in it.
fn extended(values: &Values, kind: Kind) -> (Values, Vec<(usize, f64)>) {
    let kept: Vec<(usize, f64)> = parts(kind)
        .filter_map(|(part, at)| Some((at, values.effects.iter().find(|(k, _)| *k == part)?.1[0])))
        .collect();
    let rest = parts(kind).fold(values.clone(), |values, (part, _)| values.without(part));
    (rest, kept)
}

/// The parameters at which `kind` is tried on the model `values`: the finite sizes of its row, because friction, gaps and dead zones
/// have no derivative at zero.
fn sizes(problem: &Problem, values: &Values, tangent: &Tangent, kind: Kind) -> Vec<Vec<f64>> {
    let spec = kind.spec();
    let scaled = |probe: &&[f64]| -> Vec<f64> {
        probe.iter().zip(spec.parameters).map(|(x, p)| x * p.scale.unit(&problem.rig)).collect()
    };
    let mut sizes: Vec<Vec<f64>> = spec.probes.iter().map(scaled).collect();
    if kind == Kind::Cogging {
        sizes.extend(ripple::answering(problem, tangent, values));
        sizes.extend(ripple::holding(problem, values));
    }
    if kind == Kind::SensorLag
        && let Some(time) = problem.hold_s
    {
        sizes.push(vec![0.0, time]);
    }
    sizes
}

/// `values` with the time constant and the viscous share that are usual, where the fit has bent them far from that: what a model lacks
/// it makes up for by its base, and next to a bent base no law looks right. None where they are near.
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

/// Starts for `values` with `kind` added at the sizes of its row, as they are, cheapest first.
pub fn plain_starts(problem: &Problem, values: &Values, kind: Kind) -> Vec<Start> {
    let spec = kind.spec();
    let (rest, kept) = extended(values, kind);
    let start = |probe: &&[f64]| {
        let scaled = probe.iter().zip(spec.parameters).map(|(x, p)| x * p.scale.unit(&problem.rig));
        let mut parameters: Vec<f64> = scaled.collect();
        kept.iter().for_each(|(at, value)| parameters[*at] = *value);
        rest.with(kind, parameters)
    };
    let tries: Vec<Values> = spec.probes.iter().map(start).collect();
    let Some(first) = tries.first() else { return Vec::new() };
    let layout = problem.layout(&first.kinds());
    let xs: Vec<Vec<f64>> = tries.iter().map(|v| layout.pack(v)).collect();
    let costs = problem.costs(&layout, Objective::Scales, &xs);
    let mut starts: Vec<Start> = costs.into_iter().zip(xs).collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    starts
}

/// Starts for `values` with `kind` added, cheapest first. The model's own parameters give way to first order (`tangent`); what was
/// foreseen so is run.
pub fn starts(problem: &Problem, values: &Values, tangent: &Tangent, kind: Kind) -> (Layout, Vec<Start>) {
    let (rest, kept) = extended(values, kind);
    let tries: Vec<Values> = sizes(problem, values, tangent, kind)
        .into_iter()
        .map(|mut parameters| {
            for (at, value) in &kept {
                parameters[*at] = *value;
            }
            rest.with(kind, parameters)
        })
        .collect();
    let layout = problem.layout(&tries[0].kinds());
    let xs: Vec<Vec<f64>> = tries.iter().map(|v| layout.pack(v)).collect();
    let mut starts: Vec<Start> = Vec::new();
    if kept.is_empty() {
        let foreseen: Vec<(&Vec<f64>, [Projected; 2])> = xs
            .chunks(LANES)
            .flat_map(|chunk| chunk.iter().zip(tangent.project(problem, &layout, chunk)))
            .collect();
        for which in [0, 1] {
            let mut best: Vec<_> = foreseen.iter().map(|(x, p)| (*x, &p[which])).collect();
            best.sort_by(|a, b| a.1.left.total_cmp(&b.1.left));
            let moved: Vec<Vec<f64>> =
                best.into_iter().take(LANES / 2).map(|(x, p)| tangent.moved(&layout, x, p)).collect();
            starts.extend(moved.into_iter().map(|x| (0.0, x)));
        }
    } else {
        starts.extend(xs.into_iter().map(|x| (0.0, x)));
    }
    for chunk in starts.chunks_mut(LANES) {
        let xs: Vec<Vec<f64>> = chunk.iter().map(|s| s.1.clone()).collect();
        for (start, cost) in chunk.iter_mut().zip(problem.costs(&layout, Objective::Scales, &xs)) {
            start.0 = cost;
        }
    }
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    (layout, starts)
}
