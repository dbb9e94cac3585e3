//! One stage of the diagnosis: every effect that the model lacks is tried on it.
//!
//! 1. *Probe*: each effect at a few finite sizes, old parameters free to give way to first order. Derivatives at
//!    zero rank wrongly, because friction, gaps and dead zones have none there. The best are run as they stand.
//! 2. *Heats*: a step of the search for every effect, since what an old parameter had absorbed (a lag in the electrical
//!    time constant, a sagging supply in the gain) comes free only then; then a few more for those that lead.
//! 3. *Final*: the best effects are searched further and judged on records kept out; those that lead, to the
//!    end.

use motorlens_shared::effects::Kind;

use super::candidate::Candidate;
use super::evidence::Evidence;
use super::ripple;
use super::shake::{shake, swapped};
use super::tangent::{Projected, Tangent};
use super::teeth::settle_teeth;
use crate::fit::cost::Objective;
use crate::fit::layout::{Layout, Values};
use crate::fit::search::Problem;
use crate::fit::simulate::LANES;

/// How much work a stage does.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Starts of an effect in the first heat ...
    pub starts: usize,
    /// ... which cost at most so many times more than its best, ...
    pub as_cheap: f64,
    /// ... and its steps.
    pub heat: usize,
    /// Effects in the second heat.
    pub leaders: usize,
    /// Steps of the second heat.
    pub race: usize,
    /// Effects that reach the final.
    pub finalists: usize,
    /// Steps of the final.
    pub last: usize,
}

impl Effort {
    /// On the base model.
    pub const FIRST: Self =
        Self { starts: 2, as_cheap: 1.25, heat: 1, leaders: 9, race: 2, finalists: 6, last: 8 };
    /// On a model with effects.
    pub const LATER: Self =
        Self { starts: 2, as_cheap: 1.25, heat: 1, leaders: 8, race: 2, finalists: 6, last: 8 };
    /// On a model that is far from explaining what is seen, where the usual work finds nothing more.
    pub const DEEP: Self =
        Self { starts: 4, as_cheap: 4.0, heat: 3, leaders: 10, race: 3, finalists: 6, last: 12 };
}

/// After the first heat an effect that costs so many times more than the best has lost ...
const OUT_OF_REACH: f64 = 20.0;
/// ... unless it is among the first so many.
const SHOWN: usize = 3;

/// Something shows in coarse cells where the best effect leaves less than this share of the cost.
const SHOWS: f64 = 0.95;

/// Tries every effect of `library` that `model` lacks; best first.
pub fn run(
    evidence: &Evidence,
    model: &Candidate,
    library: &[Kind],
    effort: Effort,
    tick: &mut dyn FnMut(Kind),
) -> Vec<Candidate> {
    let lacking = |kind: &&Kind| {
        let has = model.kinds();
        let two_masses = has.iter().any(|k| k.spec().load_share().is_some());
        let second_gap = two_masses && kind.spec().load_share().is_some();
        !(has.contains(kind) || second_gap)
    };
    let programmes = evidence.programmes();
    // What is missing bends the viscous share; what stands between two masses, and every further effect, is tried without that.
    let straight = evidence.straightened(model);
    let bent = model.kinds().is_empty().then(|| Tangent::new(&programmes, model, true));
    let held = Tangent::new(&programmes, &straight, false);
    let mut heat: Vec<(Layout, Start)> = Vec::new();
    for kind in library.iter().filter(lacking) {
        tick(*kind);
        let (from, tangent) = match &bent {
            Some(bent) if kind.spec().load_share().is_none() => (model, bent),
            _ => (&straight, &held),
        };
        let (layout, starts) = probe(&programmes, from, tangent, *kind);
        // On the base model, where no start is better than it, one shows as well as another where the way goes down.
        let known = bent.as_ref().map_or(f64::MAX, |bent| bent.own);
        let second = (effort.as_cheap * starts[0].0).min(known);
        let near = starts.iter().take(effort.starts).enumerate().filter(|(k, s)| *k == 0 || s.0 <= second);
        let best = near
            .map(|(_, (_, x))| programmes.race(&layout, x, effort.heat))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        heat.extend(best.map(|found| (layout, found)));
    }
    let cheapest_first = |a: &(Layout, Start), b: &(Layout, Start)| a.1.0.total_cmp(&b.1.0);
    heat.sort_by(cheapest_first);
    let reach = OUT_OF_REACH * heat.first().map_or(0.0, |best| best.1.0);
    let mut raced: Vec<(Layout, Start)> = heat
        .into_iter()
        .enumerate()
        .take(effort.leaders)
        .filter(|(place, (_, (cost, _)))| *place < SHOWN || *cost < reach)
        .map(|(_, (layout, (_, x)))| {
            let found = programmes.race(&layout, &x, effort.race);
            (layout, found)
        })
        .collect();
    raced.sort_by(cheapest_first);
    let train = &evidence.train;
    train.simulations.set(train.simulations.get() + programmes.simulations.get());
    raced.truncate(effort.finalists);
    let shows = raced.first().is_some_and(|best| best.1.0 < SHOWS * held.own);
    if !shows && library.iter().filter(lacking).any(|kind| *kind == Kind::SensorLag) {
        raced.extend(late_by_little(train, model, held.own, &raced));
    }
    finals(evidence, raced, effort.last)
}

/// A filtered reading among the finalists where it is not: coarse cells do not show how it is late by little.
fn late_by_little(
    train: &Problem,
    model: &Candidate,
    cost: f64,
    raced: &[(Layout, Start)],
) -> Option<(Layout, Start)> {
    let lag = Kind::SensorLag;
    if raced.iter().any(|(layout, _)| layout.kinds.last() == Some(&lag)) {
        return None;
    }
    let layout = train.layout(&[model.kinds(), &[lag]].concat());
    let start = given_back(&model.values(), train.prior.tau_e.0, lag).into_iter().next()?;
    let x = layout.pack(&start);
    Some((layout, (cost, x)))
}

/// The finalists, cheapest first as `raced`, searched on by at most `steps`; best first.
///
/// Where one explains what is seen, the others are only to be ranked behind it.
fn finals(evidence: &Evidence, raced: Vec<(Layout, Start)>, steps: usize) -> Vec<Candidate> {
    let train = &evidence.train;
    let mut finals: Vec<Candidate> = Vec::new();
    let hopeless = HOPELESS * raced.first().map_or(0.0, |best| best.1.0);
    for (layout, (cost, x)) in raced {
        let best = finals.iter().filter(|c| c.explains()).map(|c| c.train.increments).reduce(f64::min);
        let lost = best.is_some() && cost > hopeless;
        let tolerance = if best.is_some() { ROUGHLY } else { CLOSELY };
        let steps = if lost { 0 } else { steps };
        let mut found = train.search(&layout, Objective::Increments, &x, steps, tolerance);
        if let Some(start) = swapped(&layout.unpack(&found.x), train.prior.tau_e.0).filter(|_| !lost) {
            let other = train.search(&layout, Objective::Increments, &layout.pack(&start), steps, tolerance);
            found = if other.cost < found.cost { other } else { found };
        }
        let beaten = best.and_then(|best| {
            let rough = evidence.judge(&layout, vec![found.clone()]).swap_remove(0);
            (lost || rough.train.increments > BEATEN * best).then_some(rough)
        });
        finals.push(beaten.unwrap_or_else(|| evidence.polish(layout, found)));
    }
    finals.sort_by(|a, b| a.merit().total_cmp(&b.merit()));
    if finals.first().is_some_and(Candidate::explains) {
        return finals;
    }
    for leader in finals.iter_mut().take(WINNERS) {
        let (layout, x) = (leader.layout.clone(), &leader.found.x);
        let found = train.search(&layout, Objective::Increments, x, TO_THE_END, 3e-5);
        let settled = evidence.polish(layout, found);
        if settled.merit() < leader.merit() {
            *leader = settled;
        }
        shake(evidence, leader);
        *leader = settle_teeth(evidence, leader.clone());
    }
    finals.sort_by(|a, b| a.merit().total_cmp(&b.merit()));
    finals
}

/// In the final an effect that costs so many times more than one that explains what is seen is only shown.
const HOPELESS: f64 = 10.0;
/// ... and so many times more after the final: its error itself is not corrected.
const BEATEN: f64 = 1.2;
/// A search in the final ends where a step gains less than this share of the cost, beside one that explains and else.
const ROUGHLY: f64 = 3e-3;
const CLOSELY: f64 = 3e-4;
/// So many leaders are searched on where the first does not explain what is seen: laws of many parameters come down slowly.
const WINNERS: usize = 2;
/// ... by so many steps.
const TO_THE_END: usize = 20;

/// An electrical time constant that is further than this, as a logarithm, from the name plate's is also begun anew.
const BENT: f64 = 0.5;

/// Cost, and the search vector.
type Start = (f64, Vec<f64>);

/// Starts for `model` with `kind` added, most promising first; one at least.
fn probe(problem: &Problem, model: &Candidate, tangent: &Tangent, kind: Kind) -> (Layout, Vec<Start>) {
    let values = model.values();
    let layout = problem.layout(&[model.kinds(), &[kind]].concat());
    let sizes = sizes(problem, &values, tangent, kind);
    let mut tries: Vec<Values> = sizes.iter().map(|p| values.with(kind, p.clone())).collect();
    let name_plate = problem.prior.tau_e.0;
    if (values.base.tau_e / name_plate).ln().abs() > BENT {
        // What the model lacks may have bent the electrical time constant out of reach of the search.
        let mut anew = values.clone();
        anew.base.tau_e = name_plate;
        tries.extend(sizes.into_iter().map(|p| anew.with(kind, p)));
    }
    tries.extend(given_back(&values, name_plate, kind));
    let xs: Vec<Vec<f64>> = tries.iter().map(|v| layout.pack(v)).collect();
    let foreseen: Vec<(&Vec<f64>, [Projected; 2])> = xs
        .chunks(LANES)
        .flat_map(|chunk| chunk.iter().zip(tangent.project(problem, &layout, chunk)))
        .collect();
    // What was foreseen to first order may be far off: the most promising are run.
    let run = |which: usize| -> Vec<Start> {
        let mut best: Vec<_> = foreseen.iter().map(|(x, projected)| (*x, &projected[which])).collect();
        best.sort_by(|a, b| a.1.left.total_cmp(&b.1.left));
        let most = if kind == Kind::Cogging { 2 * LANES } else { LANES };
        let xs: Vec<Vec<f64>> =
            best.into_iter().take(most).map(|(x, projected)| tangent.moved(&layout, x, projected)).collect();
        let costs = xs.chunks(LANES).flat_map(|xs| problem.costs(&layout, Objective::Increments, xs));
        costs.zip(xs.iter().cloned()).collect()
    };
    let mut starts = run(0);
    if starts.iter().all(|(cost, _)| *cost > tangent.own) {
        // Every probe is too large: what is left to find is small.
        starts.extend(run(1));
    }
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    (layout, starts)
}

/// Starts of a late or filtered reading that give it half and all of what the electrical time constant took of it beyond
/// `name_plate`: the two follow one another.
fn given_back(values: &Values, name_plate: f64, kind: Kind) -> Vec<Values> {
    let taken = values.base.tau_e - name_plate;
    let start = |share: f64| {
        let mut given = values.clone();
        given.base.tau_e -= share * taken;
        let shape = if kind == Kind::SensorLag { vec![share * taken, 0.0] } else { vec![share * taken] };
        given.with(kind, shape)
    };
    let late = matches!(kind, Kind::SensorLag | Kind::Delay) && taken > 0.0;
    if late { [0.5, 1.0].map(start).into() } else { Vec::new() }
}

/// The parameters at which `kind` is tried on the model `values`.
fn sizes(problem: &Problem, values: &Values, tangent: &Tangent, kind: Kind) -> Vec<Vec<f64>> {
    let spec = kind.spec();
    let scaled = |probe: &&[f64]| -> Vec<f64> {
        probe.iter().zip(spec.parameters).map(|(x, p)| x * p.scale.unit(&problem.rig)).collect()
    };
    let mut sizes: Vec<Vec<f64>> = spec.probes.iter().map(scaled).collect();
    if kind == Kind::Cogging {
        // The order cannot be searched downhill.
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
