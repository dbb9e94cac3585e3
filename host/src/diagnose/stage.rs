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
use super::tangent::{Projected, Tangent};
use super::teeth::{settle_teeth, turn};
use crate::fit::cost::Objective;
use crate::fit::layout::{Layout, Values};
use crate::fit::search::Problem;
use crate::fit::simulate::LANES;

/// How much work a stage does.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Effects whose probes promise most: the others stay only where the first heat makes leaders of them.
    pub promising: usize,
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
    pub const FIRST: Self = Self {
        starts: 2,
        as_cheap: 1.25,
        heat: 1,
        promising: 18,
        leaders: 9,
        race: 2,
        finalists: 6,
        last: 8,
    };
    /// On a model with effects.
    pub const LATER: Self = Self {
        starts: 2,
        as_cheap: 1.25,
        heat: 1,
        promising: 16,
        leaders: 8,
        race: 2,
        finalists: 6,
        last: 8,
    };
    /// On a model that is far from explaining what is seen, where the usual work finds nothing more.
    pub const DEEP: Self = Self {
        starts: 4,
        as_cheap: 4.0,
        heat: 3,
        promising: 20,
        leaders: 10,
        race: 3,
        finalists: 6,
        last: 12,
    };
}

/// After the first heat an effect that costs so many times more than the best has lost ...
const OUT_OF_REACH: f64 = 20.0;
/// ... unless it is among the first so many.
const SHOWN: usize = 3;

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
    let tangent = Tangent::new(&programmes, model);
    let mut starters: Vec<(Layout, Vec<Start>)> = Vec::new();
    for kind in library.iter().filter(lacking) {
        tick(*kind);
        starters.push(probe(&programmes, model, &tangent, *kind));
    }
    starters.sort_by(|a, b| a.1[0].0.total_cmp(&b.1[0].0));
    let mut heat: Vec<(Layout, Start)> = Vec::new();
    let mut late: Vec<Kind> = Vec::new();
    for (place, (layout, starts)) in starters.into_iter().enumerate() {
        late.extend(layout.kinds.last().filter(|_| place >= effort.promising));
        // On the base model, where no start is better than it, one shows as well as another where the way goes down.
        let known = if model.kinds().is_empty() { tangent.own } else { f64::MAX };
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
        .filter(|(place, (layout, _))| {
            *place < SHOWN || !layout.kinds.last().is_some_and(|k| late.contains(k))
        })
        .take(effort.leaders)
        .filter(|(place, (_, (cost, _)))| *place < SHOWN || *cost < reach)
        .map(|(_, (layout, (_, x)))| {
            let found = programmes.race(&layout, &x, effort.race);
            (layout, found)
        })
        .collect();
    raced.sort_by(cheapest_first);
    let mut finals: Vec<Candidate> = Vec::new();
    let train = &evidence.train;
    train.simulations.set(train.simulations.get() + programmes.simulations.get());
    let hopeless = HOPELESS * raced.first().map_or(0.0, |best| best.1.0);
    for (layout, (cost, x)) in raced.into_iter().take(effort.finalists) {
        let lost = cost > hopeless && finals.iter().any(Candidate::explains);
        let steps = if lost { 1 } else { effort.last };
        let found = train.search(&layout, Objective::Increments, &x, steps, 3e-4);
        if lost {
            finals.extend(evidence.judge(&layout, vec![found]));
        } else {
            finals.push(evidence.polish(layout, found));
        }
    }
    finals.sort_by(|a, b| a.merit().total_cmp(&b.merit()));
    let settled = finals.first().is_some_and(Candidate::explains);
    for leader in finals.iter_mut().take(WINNERS).filter(|_| !settled) {
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
/// So many leaders are searched on where the first does not explain what is seen: laws of many parameters come down slowly.
const WINNERS: usize = 2;
/// ... by so many steps.
const TO_THE_END: usize = 20;

/// An electrical time constant that is further than this, as a logarithm, from the name plate's is also begun anew.
const BENT: f64 = 0.5;

/// Searches `leader` again from beside where it ended, where the cost of its last law has more than one lowest place.
fn shake(evidence: &Evidence, leader: &mut Candidate) {
    let values = leader.values();
    let Some((kind, last)) = values.effects.last() else { return };
    for beside in beside(*kind, last) {
        if leader.explains() {
            return;
        }
        let layout = leader.layout.clone();
        let start = layout.pack(&values.without(*kind).with(*kind, beside));
        let found = evidence.train.search(&layout, Objective::Increments, &start, SHAKES, 3e-4);
        let again = evidence.polish(layout, found);
        if again.merit() < leader.merit() {
            *leader = again;
        }
    }
}

/// From where a law is searched again: kinks make valleys along the size, teeth along the phase.
fn beside(kind: Kind, parameters: &[f64]) -> Vec<Vec<f64>> {
    let with = |change: &dyn Fn(&mut [f64])| {
        let mut changed = parameters.to_vec();
        change(&mut changed);
        changed
    };
    match kind {
        Kind::Coast | Kind::DeadZone | Kind::Backlash => {
            SHARES.iter().map(|share| with(&|p| p[0] *= share)).collect()
        }
        Kind::Cogging => ANGLES.iter().map(|angle| with(&|p| turn(p, *angle))).collect(),
        _ => Vec::new(),
    }
}

/// Shares of the first parameter, and angles (rad) of a ripple, from which a leader is searched again ...
const SHARES: [f64; 4] = [0.85, 1.15, 0.7, 1.4];
const ANGLES: [f64; 4] = [-0.3, 0.3, -0.6, 0.6];
/// ... and the steps of each search.
const SHAKES: usize = 10;

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
    let xs: Vec<Vec<f64>> = tries.iter().map(|v| layout.pack(v)).collect();
    let foreseen: Vec<(&Vec<f64>, [Projected; 2])> = xs
        .chunks(LANES)
        .flat_map(|chunk| chunk.iter().zip(tangent.project(problem, &layout, chunk)))
        .collect();
    // What was foreseen to first order may be far off: the most promising are run.
    let run = |which: usize| -> Vec<Start> {
        let mut best: Vec<_> = foreseen.iter().map(|(x, projected)| (*x, &projected[which])).collect();
        best.sort_by(|a, b| a.1.left.total_cmp(&b.1.left));
        let xs: Vec<Vec<f64>> =
            best.into_iter().take(LANES).map(|(x, projected)| tangent.moved(&layout, x, projected)).collect();
        problem.costs(&layout, Objective::Increments, &xs).into_iter().zip(xs).collect()
    };
    let mut starts = run(0);
    if starts.iter().all(|(cost, _)| *cost > tangent.own) {
        // Every probe is too large: what is left to find is small.
        starts.extend(run(1));
    }
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    (layout, starts)
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
        sizes.extend(ripple::starts(problem, tangent, values));
    }
    if kind == Kind::SensorLag
        && let Some(time) = problem.hold_s
    {
        sizes.push(vec![0.0, time]);
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_searched_again_at_other_widths_teeth_at_other_phases_and_friction_not_at_all() {
        assert_eq!(beside(Kind::Backlash, &[0.1, 0.3])[1], [0.1 * 1.15, 0.3]);
        let turned = beside(Kind::Cogging, &[0.3, 0.0, 0.0, 0.0, 12.0]);
        for (p, angle) in turned.iter().zip(ANGLES) {
            assert!((p[1].atan2(p[0]) - angle).abs() < 1e-12 && p[4] == 12.0);
        }
        assert!(beside(Kind::Coulomb, &[0.3]).is_empty());
    }
}
