//! Do two sets of records come from one motor? Records can show a difference; that none shows is no proof that there is none.
//!
//! One model is fitted to either set and to both together. Where one motor made them, the model of both is as good on each set as
//! that set's own, and no parameter differs by more than both intervals explain. A parameter's difference is measured in standard
//! deviations of the difference, from the intervals of [`crate::fit::uncertainty`]; the bar is Bonferroni's for all parameters
//! that both sets determine. Intervals are those of the place that a fit came to: two effects that do alike trade along a curve, and two
//! fits of one motor may end at either end of it. So a difference counts only where the likelihood ratio says so too, that is, where
//! one model of both leaves more error than chance would, taking every sample for independent.
//!
//! A model that does not explain everything gives other values on every record of one motor, which intervals do not know: so each record
//! (or half of the only one) is fitted by itself too, and what parts the records of a set counts as uncertainty of the set, in parameters
//! and in errors. Of a set that is one record nothing tells what another programme would give: where its model does not explain it, no
//! difference is proof.

use std::cell::Cell;

use motorlens_shared::effects::Kind;
use serde::Serialize;

use crate::compare::free_run::simulated;
use crate::compare::problem_as_it_is;
use crate::error::Result;
use crate::estimate::{self, Fit};
use crate::fit::uncertainty::Estimate;
use crate::log::{Record, part};
use crate::model_file::Model;
use crate::motor_file::MotorFile;

/// Loss below which the model of both sets is as good as each set's own.
const AS_GOOD: f64 = 0.1;
/// A loss that is not this many times what parts the records of one set proves nothing.
const TWICE: f64 = 2.0;
/// Two-sided risk of calling any parameter different where none is.
const RISK: f64 = 0.01;
/// A model that leaves more times the noise than this on its own records lacks something.
const UNEXPLAINED: f64 = 2.0;
/// Half a 95 % interval, in standard deviations.
const HALF_WIDTH: f64 = 1.96;

/// One motor or two?
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// No difference shows: the model of both is as good as each one's own, and no parameter that both sets determine differs.
    Same,
    /// A parameter differs, and the model of both is worse.
    Different,
    /// Only one of the two.
    Open,
}

/// A parameter that both sets determine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// `gain`, or `coulomb.level`.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Value and 95 % interval from the first set.
    pub first: [f64; 3],
    /// From the second.
    pub second: [f64; 3],
    /// Difference in standard deviations of the difference.
    pub deviations: f64,
    /// Standard deviation by which the records of each set part among themselves.
    pub scatter: [f64; 2],
    /// Beyond the bar, and one model of both is worse for it than chance would have it.
    pub differs: bool,
}

/// Errors on one set, rms in the measured unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// Of its own model.
    pub own: f64,
    /// Of the model of both sets.
    pub both: f64,
    /// Of the other set's model.
    pub other: f64,
}

/// What was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// One motor or two.
    pub verdict: Verdict,
    /// Why, in a sentence.
    pub why: String,
    /// Effects of the models.
    pub effects: Vec<Kind>,
    /// Errors on the first set and on the second.
    pub errors: [Errors; 2],
    /// Twice the logarithm of the likelihood ratio of a model for each set to one of both, samples taken for independent.
    pub likelihood_ratio: f64,
    /// Share by which a set's model is worse on its own records than the models of single records.
    pub within: f64,
    /// Unit of the errors.
    pub unit: &'static str,
    /// The bar for a difference, standard deviations.
    pub bar: f64,
    /// Parameters that both sets determine, the most different first.
    pub parameters: Vec<Difference>,
    /// Parameters that one set or both leave open.
    pub open: Vec<String>,
}

/// Compares `first` and `second` by models with `effects`. `progress` is told after each fit what share of all is done, 0 to 1.
///
/// # Errors
/// Records that no fit can use.
///
/// ```
/// use motorlens::same::{Verdict, same};
/// use motorlens::{Measured, motor_file::MotorFile, record};
/// # let time: Vec<f64> = (0..1000).map(|k| f64::from(k) * 2e-3).collect();
/// # let run = |name: &str, steps: [f64; 5], gain: f64| {
/// #     let volts: Vec<f64> = (0..1000).map(|k| steps[k / 100 % 5]).collect();
/// #     let (mut angle, mut x, mut w) = (vec![0.0], 0.0_f64, 0.0_f64);
/// #     for k in 0..999 {
/// #         for _ in 0..20 {
/// #             w += 1e-4 * (gain * volts[k] - w) / 0.05;
/// #             x += 1e-4 * w;
/// #         }
/// #         angle.push((x / 1e-3).round() * 1e-3);
/// #     }
/// #     record(name, &time, &volts, Measured::Angle(&angle))
/// # };
/// # let one = run("one", [6.0, 0.0, -4.0, 2.0, 9.0], 0.9)?;
/// # let other = run("other", [-3.0, 7.0, 0.0, -8.0, 4.0], 1.2)?;
/// // Two records, of motors that turn 0.9 and 1.2 rad/s per volt.
/// let found = same(&[one], &[other], &MotorFile::default(), &[], &|share| eprintln!("{:.0} %", 100.0 * share))?;
/// assert_eq!(found.verdict, Verdict::Different);
/// # Ok::<(), motorlens::Error>(())
/// ```
pub fn same(
    first: &[Record],
    second: &[Record],
    motor: &MotorFile,
    effects: &[Kind],
    progress: &dyn Fn(f64),
) -> Result<Comparison> {
    let how = estimate::Options { effects: effects.to_vec(), ..estimate::Options::default() };
    let sets = [first, second];
    let pieces = sets.map(pieces);
    let fits = 3 + pieces.iter().map(Vec::len).sum::<usize>();
    let done = Cell::new(0_usize);
    let fit = |records: &[Record]| {
        let fitted = estimate::fit(records, &[], motor, &how, &mut |_, _| {});
        done.set(done.get() + 1);
        progress(done.get() as f64 / fits as f64);
        fitted
    };
    let [own, other] = [fit(first)?, fit(second)?];
    let all: Vec<Record> = sets.concat();
    let both = fit(&all)?;
    let error = |records: &[Record], model: &Model| rmse(records, model, motor);
    let errors = [
        Errors { own: own.train.rmse, both: error(first, &both.model)?, other: error(first, &other.model)? },
        Errors {
            own: other.train.rmse,
            both: error(second, &both.model)?,
            other: error(second, &own.model)?,
        },
    ];
    let alone = pieces.map(|pieces| Alone::new(pieces, &fit));
    let within = alone
        .iter()
        .zip([&own, &other])
        .map(|(alone, set)| alone.loss(&set.model, motor))
        .fold(0.0, f64::max);
    let likelihood_ratio = errors
        .iter()
        .zip([&own, &other])
        .map(|(e, set)| 2.0 * set.train.samples as f64 * (e.both / e.own.max(f64::MIN_POSITIVE)).ln())
        .sum();
    let (mut parameters, open, bar) = differences(&own, &other, &alone);
    for parameter in &mut parameters {
        parameter.differs &= likelihood_ratio > bar * bar;
    }
    let left = |(set, fit): (&[Record], &Fit)| {
        (set.len() == 1).then(|| fit.train.rmse / fit.noise_level.max(f64::MIN_POSITIVE))
    };
    let lone = sets.into_iter().zip([&own, &other]).filter_map(left).fold(0.0, f64::max);
    let (verdict, why) = judge(&errors, [within, lone], &parameters, bar);
    let unit = if first.iter().any(|r| r.angle_rad.is_some()) { "rad" } else { "rad/s" };
    let effects = effects.to_vec();
    Ok(Comparison { verdict, why, effects, errors, likelihood_ratio, within, unit, bar, parameters, open })
}

fn rmse(records: &[Record], model: &Model, motor: &MotorFile) -> Result<f64> {
    let problem = problem_as_it_is(model, records, motor)?;
    Ok(simulated(&problem, &model.values()).unwrap_or_default().rmse)
}

/// The records of a set, or the halves of the only one.
fn pieces(records: &[Record]) -> Vec<Record> {
    match records {
        [only] => {
            let middle = only.len() / 2;
            vec![part(only, 0..middle, 1), part(only, middle..only.len(), 2)]
        }
        several => several.to_vec(),
    }
}

/// The pieces of a set, each with a fit of its own.
struct Alone(Vec<(Record, Fit)>);

impl Alone {
    fn new(pieces: Vec<Record>, fit: &dyn Fn(&[Record]) -> Result<Fit>) -> Self {
        // A piece that teaches nothing by itself tells nothing of how pieces differ.
        Self(
            pieces
                .into_iter()
                .filter_map(|piece| fit(std::slice::from_ref(&piece)).ok().map(|fit| (piece, fit)))
                .collect(),
        )
    }

    /// Standard error of the set's value of a parameter, from how its pieces part.
    fn scatter(&self, name: &str) -> f64 {
        let of = |(_, fit): &(Record, Fit)| {
            fit.parameters.iter().find(|p| p.name == name && p.identifiable).map(|p| p.value)
        };
        let values: Vec<f64> = self.0.iter().filter_map(of).collect();
        let n = values.len() as f64;
        if n < 2.0 {
            return 0.0;
        }
        let mean = values.iter().sum::<f64>() / n;
        (values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / ((n - 1.0) * n)).sqrt()
    }

    /// By which share the set's model is worse on its pieces than their own.
    fn loss(&self, model: &Model, motor: &MotorFile) -> f64 {
        let squares =
            |of: &dyn Fn(&(Record, Fit)) -> f64| self.0.iter().map(|piece| of(piece).powi(2)).sum::<f64>();
        let own = squares(&|(_, fit)| fit.train.rmse);
        let of_the_set = squares(&|(record, fit)| {
            rmse(std::slice::from_ref(record), model, motor).unwrap_or(fit.train.rmse)
        });
        (of_the_set / own.max(f64::MIN_POSITIVE)).sqrt() - 1.0
    }
}

/// What both determine, the most different first; what stays open; the bar.
fn differences(first: &Fit, second: &Fit, alone: &[Alone; 2]) -> (Vec<Difference>, Vec<String>, f64) {
    let (mut pairs, mut open): (Vec<(&Estimate, &Estimate)>, Vec<String>) = (Vec::new(), Vec::new());
    for a in &first.parameters {
        match second.parameters.iter().find(|b| b.name == a.name) {
            Some(b) if a.identifiable && b.identifiable => pairs.push((a, b)),
            _ => open.push(a.name.clone()),
        }
    }
    let bar = normal_quantile(1.0 - RISK / (2.0 * pairs.len().max(1) as f64));
    let mut parameters: Vec<Difference> = pairs
        .into_iter()
        .map(|(a, b)| {
            // Intervals of logarithms are not even: the side that faces the other value counts.
            let (low, high) = if a.value < b.value { (a, b) } else { (b, a) };
            let intervals = (low.high - low.value).hypot(high.value - high.low) / HALF_WIDTH;
            let scatter = [0, 1].map(|set| alone[set].scatter(&a.name));
            let spread = intervals.hypot(scatter[0]).hypot(scatter[1]);
            let deviations = (high.value - low.value) / spread.max(f64::MIN_POSITIVE);
            Difference {
                name: a.name.clone(),
                unit: a.unit.clone(),
                first: [a.value, a.low, a.high],
                second: [b.value, b.low, b.high],
                deviations,
                scatter,
                differs: deviations > bar,
            }
        })
        .collect();
    parameters.sort_by(|a, b| b.deviations.total_cmp(&a.deviations));
    (parameters, open, bar)
}

/// `within` is the share by which the model of a set is worse than those of its records, `lone` how many times the noise a set's model leaves where
/// the set is one record.
fn judge(
    errors: &[Errors; 2],
    [within, lone]: [f64; 2],
    parameters: &[Difference],
    bar: f64,
) -> (Verdict, String) {
    let loss = errors.iter().map(|e| e.both / e.own.max(f64::MIN_POSITIVE) - 1.0).fold(0.0, f64::max);
    let names: Vec<&str> = parameters.iter().filter(|p| p.differs).map(|p| p.name.as_str()).collect();
    let percent = 100.0 * loss;
    if loss >= AS_GOOD && loss < TWICE * within {
        let why = format!(
            "one model of both leaves up to {percent:.0} % more error, but one model of a set does so too, {:.0} % more than models of \
             its single records: the effects of the model do not explain these records (motorlens discover tells)",
            100.0 * within
        );
        return (Verdict::Open, why);
    }
    let elsewhere: Vec<&str> =
        parameters.iter().filter(|p| p.deviations > bar && !p.differs).map(|p| p.name.as_str()).collect();
    match (names.is_empty(), loss < AS_GOOD) {
        (true, true) if !elsewhere.is_empty() => (
            Verdict::Same,
            format!(
                "one model is within {percent:.1} % of each set's own, no worse than chance would have it: other values of {} fit \
                 no better",
                elsewhere.join(", ")
            ),
        ),
        (true, true) => (
            Verdict::Same,
            format!(
                "one model is within {percent:.1} % of each set's own, and no parameter differs beyond its interval"
            ),
        ),
        (false, false) if lone > UNEXPLAINED => (
            Verdict::Open,
            format!(
                "one model of both leaves up to {percent:.0} % more error, and {} differ, but the model of a single record leaves {lone:.1} x \
                 the noise: it lacks something, and then one motor has other values in every programme (give each set a second record, or \
                 the effects that motorlens discover finds)",
                names.join(", ")
            ),
        ),
        (false, false) => (
            Verdict::Different,
            format!(
                "one model of both leaves up to {percent:.0} % more error, and {} differ",
                names.join(", ")
            ),
        ),
        (false, true) => (
            Verdict::Open,
            format!(
                "{} differ beyond their intervals, but one model of both costs {percent:.1} % at most: a difference too small to matter here",
                names.join(", ")
            ),
        ),
        (true, false) => (
            Verdict::Open,
            format!(
                "one model of both leaves up to {percent:.0} % more error, but no parameter differs beyond its interval: \
                 the effects of the model may be wrong (motorlens discover tells), or the records are too short"
            ),
        ),
    }
}

/// The standard normal's quantile above one half: Abramowitz and Stegun 26.2.23, to 4.5e-4.
fn normal_quantile(p: f64) -> f64 {
    let t = (-2.0 * (1.0 - p).ln()).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    t - above / below
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_normal_quantiles_are_those_of_the_tables() {
        for (p, z) in [(0.975, 1.959_964), (0.995, 2.575_829), (0.999, 3.090_232)] {
            assert!((normal_quantile(p) - z).abs() < 4.5e-4, "{p}");
        }
    }
}
