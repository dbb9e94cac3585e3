//! One step of the selection: every effect is tried on a model, with the same work for each (successive halving).

use motorlens_shared::effects::Kind;

use super::fitted::Fitted;
use super::starts::{Start, besides, plain_starts, starts};
use crate::diagnose::contained::{extended, may_join};
use crate::diagnose::evidence::Evidence;
use crate::diagnose::tangent::Tangent;
use crate::fit::cost::Objective;
use crate::fit::instants::built_on;
use crate::fit::layout::{Layout, Values};
use crate::fit::scales::CHOOSING;
use crate::fit::search::Problem;
use crate::fit::sketch::Sketch;

/// The records in the first round, and in the second.
const ROUGH: Sketch = Sketch { samples: 24e3, cell_s: 4.01e-3, interval_s: 4.01e-3 };
const FINE: Sketch = Sketch { samples: 24e3, cell_s: 2.01e-3, interval_s: 0.0 };
/// Effects of which more than the trial evaluations is seen.
const TRIALS: usize = 14;
/// Starts of an effect that are searched.
const STARTS: usize = 2;
/// Steps of the first screening round, for every effect.
const FIRST: usize = 2;
/// Shares of the best's gain, or of the gain that is asked, with which an effect goes on after the first round and after the second.
const HOPEFUL: f64 = 0.1;
const NEAR: f64 = 0.25;
/// Effects in the second round, and its steps.
const SECOND: (usize, usize) = (8, 4);
/// Effects of which every two are tried together.
const PAIRED: usize = 5;
/// Effects that are fitted on all records, rounds of weighing and steps of each.
const FULL: (usize, usize, usize) = (5, 2, 6);

/// Whether `kind` may join a model of `kinds`: it is not covered by them, and two effects do not stand between rotor and load.
pub fn lacks(kinds: &[Kind], kind: Kind) -> bool {
    let two_masses = kinds.iter().any(|k| k.spec().load_share().is_some());
    may_join(kinds, kind) && !(two_masses && kind.spec().load_share().is_some())
}

/// Fits `model` with every effect of `library` that it lacks; best score first. Those that cannot come to a gain of `asked`, nor near the
/// best, are given up on the way.
pub fn forward(
    data: &Evidence,
    model: &Fitted,
    library: &[Kind],
    asked: f64,
    tick: &mut dyn FnMut(Kind),
) -> Vec<Fitted> {
    tried(data, model, library, asked, tick).0
}

/// [`forward`], and the models with each effect that came near, as they were before all records were fitted.
pub fn tried(
    data: &Evidence,
    model: &Fitted,
    library: &[Kind],
    asked: f64,
    tick: &mut dyn FnMut(Kind),
) -> (Vec<Fitted>, Vec<Values>) {
    let values = model.values();
    let rough = Screen::new(data, model, ROUGH, FIRST);
    let at = rough.problem.search(&model.layout, Objective::Scales, &model.x, 0, 1e-3);
    let tangent = Tangent::of(&rough.problem, &model.layout, &at, true, Objective::Scales);
    let mut trials: Vec<(Layout, Vec<Start>)> = Vec::new();
    for kind in library.iter().filter(|kind| lacks(model.kinds(), **kind)) {
        tick(*kind);
        let (layout, mut starts) = starts(&rough.problem, &values, &tangent, *kind);
        starts.truncate(STARTS);
        for other in besides(&data.train, &values, *kind) {
            starts.extend(plain_starts(&rough.problem, &other, *kind).into_iter().take(STARTS));
        }
        trials.push((layout, starts));
    }
    trials.sort_by(|a, b| a.1[0].0.total_cmp(&b.1[0].0));
    let mut round: Vec<(Layout, Start)> = Vec::new();
    for (layout, starts) in trials.into_iter().take(TRIALS) {
        let search = |(_, x): &Start| rough.problem.race(&layout, Objective::Scales, x, FIRST, 1e-3);
        let best = starts.iter().map(search).min_by(|a, b| a.0.total_cmp(&b.0));
        round.extend(best.map(|start| (layout.clone(), start)));
    }
    finals(data, model, &rough, round, asked)
}

/// The models `near`, of which the first that takes up each effect stands in the place of the accepted one, two at a time: what one effect
/// alone can only imitate, two may be. `accepted` itself is left to [`forward`]; best score first.
///
/// Where no effect was accepted, every two of `near` join the model itself.
pub fn pairs(data: &Evidence, accepted: &Fitted, near: &[Values], asked: f64) -> Vec<Fitted> {
    let last = |values: &Values| values.effects.last().cloned();
    let others = near.iter().filter(|v| last(v).is_some_and(|(kind, _)| !accepted.kinds().contains(&kind)));
    let others: Vec<&Values> = others.take(PAIRED).collect();
    if others.len() < 2 {
        return Vec::new();
    }
    let rough = Screen::new(data, accepted, ROUGH, FIRST);
    let mut round: Vec<(Layout, Start)> = Vec::new();
    for (k, one) in others.iter().enumerate() {
        for (kind, parameters) in others[k + 1..].iter().filter_map(|other| last(other)) {
            if lacks(&one.kinds(), kind) {
                let pair = extended(one, kind, parameters);
                let layout = data.train.layout(&pair.kinds());
                let x = layout.pack(&pair);
                let start = rough.problem.race(&layout, Objective::Scales, &x, SECOND.1, 1e-3);
                round.push((layout, start));
            }
        }
    }
    if round.is_empty() { Vec::new() } else { finals(data, accepted, &rough, round, asked).0 }
}

/// The second round for `round`, and fits to all records; and all that came near.
fn finals(
    data: &Evidence,
    model: &Fitted,
    rough: &Screen,
    mut round: Vec<(Layout, Start)>,
    asked: f64,
) -> (Vec<Fitted>, Vec<Values>) {
    rough.keep(&mut round, SECOND.0, HOPEFUL, asked);
    let near = round.iter().map(|(layout, (_, x))| layout.unpack(x)).collect();
    let fine = Screen::new(data, model, FINE, SECOND.1);
    for (layout, start) in &mut round {
        *start = fine.problem.race(layout, Objective::Scales, &start.1, SECOND.1, 1e-3);
    }
    fine.keep(&mut round, FULL.0, NEAR, asked);
    for screen in [rough, &fine] {
        data.train.count_passes_of(&screen.problem);
    }
    let all = |(layout, (_, x)): (Layout, Start)| {
        let found = Fitted::new(data, layout, &x, FULL.1, FULL.2);
        // One that ends at a bound has ended at no minimum: what the new effect should have taken up is still in the time constants.
        let again = found.from_usual(data, FULL.1, FULL.2);
        found.or_better(again)
    };
    let mut fitted: Vec<Fitted> = round.into_iter().map(all).collect();
    fitted.sort_by(|a, b| b.score().total_cmp(&a.score()));
    (fitted, near)
}

/// Less of the records, on which candidates are compared.
struct Screen {
    problem: Problem,
    /// What the model itself leaves here after as many steps.
    own: f64,
    /// How many times as many samples all records have.
    whole: f64,
}

impl Screen {
    fn new(data: &Evidence, model: &Fitted, sketch: Sketch, steps: usize) -> Self {
        let problem = data.sketch(sketch, model);
        let (own, _) = problem.race(&model.layout, Objective::Scales, &model.x, steps, 1e-3);
        let whole = data.train.samples() as f64 / problem.samples().max(1) as f64;
        Self { problem, own, whole }
    }

    /// The gain that a cost here comes to on all records, natural logarithms.
    fn gain(&self, (cost, _): &Start) -> f64 {
        0.5 * self.whole * (self.own - cost) / (1.0 + CHOOSING)
    }

    /// Sorts `round` by cost, and keeps at most `most`, of which each comes to a `share` of the gain that the best has or that is `asked`; and
    /// what is only late, which nearly every log is, by however little.
    fn keep(&self, round: &mut Vec<(Layout, Start)>, most: usize, share: f64, asked: f64) {
        round.sort_by(|a, b| a.1.0.total_cmp(&b.1.0));
        let best = round.first().map_or(0.0, |(_, start)| self.gain(start));
        let least = share * asked.max(best);
        let hopeful = round.iter().take_while(|(_, start)| self.gain(start) > least).count();
        let rest = round.split_off(hopeful.clamp(1, most).min(round.len()));
        round.extend(
            rest.into_iter()
                .filter(|(layout, _)| layout.kinds.last().is_some_and(|kind| kind.spec().is_late())),
        );
    }
}

/// `model` with `kind` added; none where that cannot join it.
pub fn with(data: &Evidence, model: &Fitted, kind: Kind) -> Option<Fitted> {
    forward(data, model, &[kind], 0.0, &mut |_| ()).into_iter().next().map(|found| found.settled(data))
}

/// Of `fitted`, best score first, the one to believe: of those that do as well as the best the smallest, and of equally small ones the equation
/// on which most others of the library build: it is the usual one.
pub fn simplest(data: &Evidence, fitted: &[Fitted], base: &Fitted) -> Option<usize> {
    let best = fitted.first()?;
    let built_on = |model: &Fitted| model.kinds().last().map_or(0, |kind| built_on(*kind));
    let mut order: Vec<usize> = (0..fitted.len()).collect();
    order.sort_by_key(|k| (fitted[*k].size(), std::cmp::Reverse(built_on(&fitted[*k])), *k));
    // Simplest first: those that come after the one that is taken need not be cross-validated.
    order.into_iter().find(|k| *k == 0 || fitted[*k].is_as_good_as(best, data, base))
}
