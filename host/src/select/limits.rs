//! Detection limits: for every effect that a model lacks, the smallest size that these records would have shown.
//!
//! The effect is simulated beside the accepted model, at its typical shape and at sizes an octave apart. What the model's own
//! parameters cannot imitate of the change, to first order, is a known signal in known noise; the log-likelihood that it would gain
//! is half its energy over the noise, scale by scale (S. Kay, *Fundamentals of Statistical Signal Processing*, vol. 2, 1998, ch. 4).
//! Where that reaches what the selection asks of an effect, it would have been accepted.

use motorlens_shared::effects::{Kind, Search};
use motorlens_shared::excitation::Programme;
use serde::Serialize;

use super::fitted::Fitted;
use super::forward::lacks;
use super::noise::FREEDOM;
use crate::diagnose::contained::{extended, parts};
use crate::diagnose::discover::reading_noise;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::plan::{self, Limits};
use crate::diagnose::tangent::Tangent;
use crate::fit::cost::Objective;
use crate::fit::search::Problem;
use crate::fit::simulate::{LANES, predict_one};
use crate::fit::sketch::Sketch;

/// Sizes that are tried, from the highest of the effect's row down, each half of the one before.
const SIZES: usize = 2 * LANES;
/// What of the records is simulated; what more of them would show grows with the samples.
const SKETCH: Sketch = Sketch { samples: 24e3, cell_s: 4.01e-3, interval_s: 0.0 };
/// Of the information of normal errors a Student t distribution keeps so much (K. Lange, R. Little, J. Taylor, *JASA* 84, 1989).
const KEPT: f64 = (FREEDOM + 1.0) / (FREEDOM + 3.0);

/// What the records could have shown of one effect.
#[derive(Debug, Clone, Serialize)]
pub struct DetectionLimit {
    /// The effect.
    pub effect: Kind,
    /// The parameter that is its size.
    pub parameter: &'static str,
    /// The smallest size that would have been accepted; none where these records cannot show any.
    pub smallest: Option<f64>,
    /// Unit of that size.
    pub unit: &'static str,
    /// What to run to see it, where these records cannot and a programme is known that would.
    pub programme: Option<Programme>,
}

impl DetectionLimit {
    /// Effects of `limits` that the records cannot show at any size.
    pub fn hidden(limits: &[Self]) -> Vec<Kind> {
        limits.iter().filter(|limit| limit.smallest.is_none()).map(|limit| limit.effect).collect()
    }
}

/// Limits of every effect of `library` that `model`, selected from `base`, lacks, on the records of `data`; programmes stay below `volts`.
pub fn detection_limits(
    data: &Evidence,
    base: &Fitted,
    model: &Fitted,
    library: &[Kind],
    volts: f64,
) -> Vec<DetectionLimit> {
    let problem = noiseless(data, model);
    let found = problem.search(&model.layout, Objective::Scales, &model.x, 0, 1e-3);
    let tangent = Tangent::of(&problem, &model.layout, &found, true, Objective::Scales);
    let asked = model.asks(base) * problem.samples() as f64 / data.train.samples() as f64;
    let missing = library.iter().copied().filter(|kind| lacks(model.kinds(), *kind));
    let mut limits: Vec<DetectionLimit> =
        missing.filter_map(|kind| limit(&problem, model, &tangent, kind, asked)).collect();
    let hidden = DetectionLimit::hidden(&limits);
    let shown =
        plan::showing(&problem, model, &hidden, reading_noise(&data.train), Limits { volts, seconds: 8.0 });
    for (limit, programme) in limits.iter_mut().filter(|l| l.smallest.is_none()).zip(shown) {
        limit.programme = programme;
    }
    limits
}

/// The records as they were had `model` been all there is and nothing disturbed it, weighted by its noise.
fn noiseless(data: &Evidence, model: &Fitted) -> Problem {
    let mut problem = data.train.clone().sketch(SKETCH);
    // The likelihood alone: no plain square beside it.
    model.noise.with_all_left().weigh(&mut problem, 0.0);
    let plain = model.layout.all_plain(&model.x);
    for grid in &mut problem.grids {
        grid.measured = predict_one(&model.layout.kinds, &plain, &data.train.rig, grid);
    }
    problem
}

fn limit(
    problem: &Problem,
    model: &Fitted,
    tangent: &Tangent,
    kind: Kind,
    asked: f64,
) -> Option<DetectionLimit> {
    let spec = kind.spec();
    let kinds = model.kinds();
    // What a simpler law of the model has already is not looked for.
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
    // No search looks below the row's lowest size.
    let lowest = (of.low / of.typical).max(0.0);
    let halved = (0..SIZES).map(|k| of.high.abs() / of.typical.abs() * 0.5_f64.powi(k as i32));
    let factors: Vec<f64> = halved.filter(|f| *f >= lowest).collect();
    let xs: Vec<Vec<f64>> = factors.iter().map(|f| at(*f)).collect();
    let gains: Vec<f64> = xs
        .chunks(LANES)
        .flat_map(|chunk| tangent.project(problem, &layout, chunk))
        .map(|[whole, _]| 0.5 * KEPT * whole.left)
        .collect();
    let typical = of.plain(of.typical.abs(), &problem.rig);
    let shows = |k: usize| gains[k] > asked;
    // The smallest size from which on every larger one shows too.
    let last = (0..factors.len()).take_while(|k| shows(*k)).last();
    let smallest = last.map(|k| {
        let next = gains.get(k + 1).copied().unwrap_or(0.0).max(1e-12);
        // Between two sizes an octave apart the gain is taken for a power of the size.
        let power = (gains[k] / next).log2().clamp(0.5, 4.0);
        (factors[k] * (asked / gains[k]).powf(1.0 / power).max(0.5)).max(lowest) * typical
    });
    Some(DetectionLimit { effect: kind, parameter: of.name, smallest, unit: of.unit, programme: None })
}
