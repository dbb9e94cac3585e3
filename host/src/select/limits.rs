//! Detection limits: for every effect that a model lacks, the smallest size that these records would have shown.
//!
//! The effect is simulated beside the accepted model, at its typical shape and at sizes an octave apart. What the model's own
//! parameters cannot imitate of the change, to first order, is a signal; the error that the model leaves is the noise that it would have
//! stood in. The signal is laid on that error with either sign, and the model that knows it is scored against the one that does not, by the
//! criterion of the selection, block by block: a disturbance that lasts makes a gain large before it makes it sure, and that shows here as it
//! shows there. (A detection limit is a size that would be found, not one that is merely more than nothing: L. Currie, *Analytical
//! Chemistry* 40, 1968.)

use motorlens_shared::effects::{Kind, Search};
use motorlens_shared::excitation::Programme;
use serde::Serialize;

use super::adequacy::Adequacy;
use super::criterion::KNOWN_VOLTAGE;
use super::fitted::Fitted;
use super::forward::lacks;
use super::gain::Gain;
use super::score::Scored;
use crate::diagnose::contained::{extended, parts};
use crate::diagnose::discover::reading_noise;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::plan::{self, Limits};
use crate::diagnose::tangent::Tangent;
use crate::fit::cost::Objective;
use crate::fit::noise::{Noise, coefficients};
use crate::fit::search::Problem;
use crate::fit::simulate::{LANES, predict_one};
use crate::fit::sketch::Sketch;

/// Sizes that are tried, from the highest of the effect's row down, each half of the one before.
const SIZES: usize = 2 * LANES;
/// What of the records is simulated; what more of them would show grows with the samples.
const SKETCH: Sketch = Sketch { samples: 24e3, cell_s: 4.01e-3, interval_s: 0.0 };
/// Halvings of the octave in which the limit lies.
const HALVINGS: usize = 3;

/// What the records could have shown of one effect.
#[derive(Debug, Clone, Serialize)]
pub struct DetectionLimit {
    /// The effect.
    pub effect: Kind,
    /// The parameter that is its size.
    pub parameter: &'static str,
    /// The smallest size that would have been accepted; none where these records cannot show any.
    pub smallest: Option<f64>,
    /// None is shown beside what the model leaves unexplained, in which the effect may be: alone it lowers that too little, or the search gave it
    /// up before its end. With less left these records may show it.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub undecided: bool,
    /// Unit of that size.
    pub unit: &'static str,
    /// What to run to see it, where these records cannot and a programme is known that would.
    pub programme: Option<Programme>,
}

impl DetectionLimit {
    /// Effects of `limits` that the records cannot show at any size.
    pub fn hidden(limits: &[Self]) -> Vec<Kind> {
        limits
            .iter()
            .filter(|limit| limit.is_unseen() && !limit.undecided)
            .map(|limit| limit.effect)
            .collect()
    }

    /// Effects of `limits` that what is left neither shows nor excludes.
    pub fn undecided(limits: &[Self]) -> Vec<Kind> {
        limits.iter().filter(|limit| limit.undecided).map(|limit| limit.effect).collect()
    }

    /// Whether no size would have been accepted.
    fn is_unseen(&self) -> bool {
        self.smallest.is_none()
    }
}

/// Limits of every effect of `library` that `model`, selected from `base`, lacks, on the records of `data`, of which it leaves what `left` says.
pub fn detection_limits(
    data: &Evidence,
    base: &Fitted,
    model: &Fitted,
    library: &[Kind],
    left: Adequacy,
) -> Vec<DetectionLimit> {
    let sketched = data.train.clone().sketch(SKETCH);
    let trial = Trial::new(data, &sketched, base, model);
    let problem = noiseless(sketched, model);
    let found = problem.search(&model.layout, Objective::Scales, &model.x, 0, 1e-3);
    let tangent = Tangent::of(&problem, &model.layout, &found, true, Objective::Scales);
    let missing = library.iter().copied().filter(|kind| lacks(model.kinds(), *kind));
    let mut limits: Vec<DetectionLimit> =
        missing.filter_map(|kind| limit(data, &problem, model, &tangent, kind, &trial)).collect();
    if !left.is_explained() {
        // What cannot be told from all else on any such records does not depend on what is left.
        for limit in limits.iter_mut().filter(|limit| limit.is_unseen() && data.may_show(limit.effect)) {
            limit.undecided = true;
        }
    }
    plan_hidden(data, model, &mut limits, Limits::of(data));
    limits
}

/// Gives each of `limits` that the records cannot show the programme `within` the rig's limits that would show most of it beside `model`.
pub fn plan_hidden(data: &Evidence, model: &Fitted, limits: &mut [DetectionLimit], within: Limits) {
    let unseen: Vec<Kind> = limits.iter().filter(|l| l.is_unseen()).map(|l| l.effect).collect();
    let shown = plan::showing(&data.train, model, &unseen, reading_noise(&data.train), within);
    for (limit, programme) in limits.iter_mut().filter(|l| l.is_unseen()).zip(shown) {
        limit.programme = programme;
    }
}

/// The records as they were had `model` been all there is and nothing disturbed it, weighted by its noise.
fn noiseless(mut problem: Problem, model: &Fitted) -> Problem {
    // The likelihood alone: no plain square beside it.
    model.noise.with_all_left().weigh(&mut problem, 0.0);
    let plain = model.layout.all_plain(&model.x);
    for grid in &mut problem.grids {
        grid.measured = predict_one(&model.layout.kinds, &plain, &problem.rig, grid);
    }
    problem
}

/// The selection on records in which an effect would have been.
struct Trial<'a> {
    model: &'a Fitted,
    explained: f64,
    /// Highest voltage, V.
    highest: f64,
    noise: Noise,
    /// What the model leaves, and its scores.
    left: Scored,
    left_scores: Vec<f64>,
    /// Samples of the records over those that are looked at.
    more: f64,
}

impl<'a> Trial<'a> {
    fn new(data: &Evidence, problem: &Problem, base: &Fitted, model: &'a Fitted) -> Self {
        let noise = model.noise.with_all_left();
        let left = Scored::unfitted(problem, coefficients(problem, &model.layout, &model.x));
        let more = data.train.samples() as f64 / problem.samples().max(1) as f64;
        let explained = model.gain_over(base).total;
        let highest = data.highest_voltage();
        Self { model, explained, highest, left_scores: left.under(&noise), noise, left, more }
    }

    /// Whether `kind` would be accepted where it adds `factor` times `signal`, in units of the noise, to what the model leaves.
    fn accepts(&self, kind: Kind, signal: &[Vec<f64>], factor: f64) -> bool {
        [factor, -factor].into_iter().all(|factor| {
            let without = self.left.with(signal, factor, &self.noise);
            let gain = Gain::of(&self.left_scores, &without.under(&self.noise));
            let whole = Gain { total: self.more * gain.total, sure: self.more.sqrt() * gain.sure };
            self.model.would_accept(kind, whole, self.explained)
        })
    }
}

fn limit(
    data: &Evidence,
    problem: &Problem,
    model: &Fitted,
    tangent: &Tangent,
    kind: Kind,
    trial: &Trial,
) -> Option<DetectionLimit> {
    let spec = kind.spec();
    let kinds = model.kinds();
    // What a simpler equation of the model has already is not looked for.
    let there =
        |name: &str| parts(kind).any(|(part, at)| kinds.contains(&part) && spec.parameters[at].name == name);
    let size = spec.parameters.iter().position(|p| p.strength && !there(p.name))?;
    let of = &spec.parameters[size];
    let values = model.values();
    let layout = problem.layout(&extended(&values, kind, vec![0.0; spec.parameters.len()]).kinds());
    let at = |factor: f64| -> Vec<f64> {
        let value = |p: &motorlens_shared::effects::Parameter| {
            let plain = p.plain(p.typical, &problem.rig);
            // A reading that is held is another effect of the sensor than one that is filtered.
            if spec.search == Search::Hold(p.name) {
                0.0
            } else if p.strength {
                factor * plain
            } else {
                plain
            }
        };
        layout.pack(&extended(&values, kind, spec.parameters.iter().map(value).collect()))
    };
    let limit = |smallest| DetectionLimit {
        effect: kind,
        parameter: of.name,
        smallest,
        undecided: false,
        unit: of.unit,
        programme: None,
    };
    if !data.may_show(kind) {
        return Some(limit(None));
    }
    // No search looks below the row's lowest size.
    let [low, high] = of.bounds(&problem.rig);
    let lowest = (low / of.typical).max(0.0);
    let halved = (0..SIZES).map(|k| high.abs() / of.typical.abs() * 0.5_f64.powi(k as i32));
    let factors: Vec<f64> = halved.filter(|f| *f >= lowest).collect();
    let xs: Vec<Vec<f64>> = factors.iter().map(|f| at(*f)).collect();
    let signals: Vec<Vec<Vec<f64>>> =
        xs.chunks(LANES).flat_map(|chunk| tangent.leaves(problem, &layout, chunk)).collect();
    let typical = of.plain(of.typical.abs(), &problem.rig);
    // A motor that runs away in the simulation would have been seen, but has no signal to tell a limit from.
    let is_bounded = |signal: &Vec<Vec<f64>>| signal.iter().flatten().all(|s| s.is_finite());
    // The smallest size that shows: larger ones do too.
    let shows = |signal: &Vec<Vec<f64>>| !is_bounded(signal) || trial.accepts(kind, signal, 1.0);
    let last = signals.partition_point(shows).checked_sub(1).filter(|k| is_bounded(&signals[*k]));
    let smallest = last.map(|k| {
        // Between two sizes an octave apart the signal is taken for proportional to the size.
        let (mut hidden, mut shows) = (0.5, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (hidden + shows);
            *(if trial.accepts(kind, &signals[k], middle) { &mut shows } else { &mut hidden }) = middle;
        }
        let shown = (factors[k] * shows).max(lowest) * typical;
        // A trifle is not accepted, however sure.
        if of.unit == "V" { shown.max(KNOWN_VOLTAGE * trial.highest) } else { shown }
    });
    Some(limit(smallest))
}
