//! Parameters of a model whose effects are given, by one of four methods.

mod added;
mod combinations;
mod fast;
pub(crate) mod feedforward;
mod genetic;
mod identifiability;
mod linear;
mod profile;
mod start;

use motorlens_shared::effects::Kind;
use motorlens_shared::simulator::MAX_EFFECTS;

pub use added::{Addition, Errors, Moved, add};
pub use combinations::combinations;
pub use identifiability::{Answer, Identifiability, Unlock, identifiability};
pub use profile::{Profile, profiles};
pub use start::prepare;
use start::{Prepared, timed};

use crate::compare::free_run::simulated;
use crate::compare::measures::Measures;
use crate::diagnose::discover::noise_floor;
use crate::error::{Error, Result};
use crate::findings::Supposed;
use crate::findings::shown_by_fit::ended_of;
use crate::fit::grid::Grid;
use crate::fit::layout::Values;
use crate::fit::search::Problem;
use crate::fit::uncertainty::{Estimate, estimates};
use crate::formula::Library;
use crate::log::{Record, check_all_usable};
use crate::model_file::{Model, Origin};
use crate::motor_file::MotorFile;
use crate::nearest::nearest;

/// How parameters are searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Levenberg-Marquardt from probed starts, seconds at most
    #[default]
    Fast,
    /// The genetic algorithm on the summed IAE
    Ga,
    /// Nonlinear least squares from the nameplate, as a textbook does it
    Conventional,
    /// The genetic algorithm exactly as in the paper; the linear model only
    Paper,
    /// kS, kV and kA by ordinary least squares, the usual model of robotics: what to beat
    Feedforward,
}

/// What to fit, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Search.
    pub method: Method,
    /// Effects of the model, in order.
    pub effects: Vec<Kind>,
    /// Chromosomes of the genetic algorithm.
    pub population: usize,
    /// Its generations.
    pub generations: u32,
    /// Its seed.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self { method: Method::Fast, effects: Vec::new(), population: 80, generations: 800, seed: 1 }
    }
}

/// A fitted model and how good it is.
#[derive(Debug)]
pub struct Fit {
    /// The model.
    pub model: Model,
    /// Its parameters with 95 % intervals.
    pub parameters: Vec<Estimate>,
    /// What voltage and motion alone determine.
    pub combinations: Vec<Estimate>,
    /// Intervals of the parameters whose curvature does not settle them.
    pub profiles: Vec<Profile>,
    /// What stays open, and what would unlock it.
    pub identifiability: Identifiability,
    /// Errors on the records fitted.
    pub train: Measures,
    /// Errors on the records kept out.
    pub validation: Option<Measures>,
    /// What the usual model, kS-kV-kA, leaves on the records fitted and on those kept out; none where a record does not give it.
    pub usual: Option<(Measures, Option<Measures>)>,
    /// Why the records do not give it.
    pub no_usual: Option<String>,
    /// The noise level, rms in the measured unit.
    pub noise_level: f64,
    /// What a sentence about it goes on with where a value stands where its search ends; empty where none does.
    pub ended: String,
    /// What the sizes of its effects rest on that no record tells.
    pub supposed: Supposed,
    /// Best IAE of every generation; one number for methods without generations.
    pub objective_history: Vec<f64>,
    /// Candidates simulated over all records.
    pub evaluations: u64,
    /// The search alone, s.
    pub seconds: f64,
}

/// What a method hands back.
pub(crate) struct Searched {
    pub values: Values,
    pub history: Vec<f64>,
    pub evaluations: u64,
}

/// Fits a model with `options.effects` to `records`. `progress` gets the generation and its best IAE.
///
/// # Errors
/// Records that no fit can use; too many effects; a method that cannot have effects.
pub fn fit(
    records: &[Record],
    validation: &[Record],
    motor: &MotorFile,
    options: &Options,
    progress: &mut dyn FnMut(u32, f64),
) -> Result<Fit> {
    check_effects(&options.effects)?;
    let Prepared { problem, base, known } = start::prepare_for(records, motor, &options.effects)?;
    check_all_usable(validation)?;
    let known = known.filter(|_| options.method == Method::Fast).map(|(searched, s)| (Ok(searched), s));
    let (searched, seconds) =
        known.unwrap_or_else(|| timed(|| by_method(&problem, &base, records, motor, options, progress)));
    let searched = searched?;
    let origin = Origin {
        motorlens: env!("CARGO_PKG_VERSION").into(),
        records: records.iter().map(|r| r.name.clone()).collect(),
        method: format!("fit {:?}", options.method).to_lowercase(),
        seed: matches!(options.method, Method::Ga | Method::Paper).then_some(options.seed),
    };
    let model = Model::fitted(&searched.values, &problem, origin);
    let mut fit = describe(&problem, &searched.values, model, records);
    let kept_out = kept_out(&problem, validation, motor);
    fit.validation = kept_out.as_ref().and_then(|kept_out| simulated(kept_out, &searched.values));
    fit.usual = feedforward::errors(&problem, records, kept_out.as_ref());
    fit.no_usual = feedforward::why_not(&problem, records);
    fit.noise_level = noise_floor(records, validation, &problem);
    fit.supposed = Supposed::by(&searched.values.kinds(), records, motor, &problem.rig);
    (fit.seconds, fit.evaluations) = (seconds, searched.evaluations);
    fit.objective_history = if searched.history.is_empty() { vec![fit.train.iae] } else { searched.history };
    Ok(fit)
}

/// Searches from `base` as `options` say.
fn by_method(
    problem: &Problem,
    base: &Values,
    records: &[Record],
    motor: &MotorFile,
    options: &Options,
    progress: &mut dyn FnMut(u32, f64),
) -> Result<Searched> {
    Ok(match options.method {
        Method::Fast => fast::search(problem, base, &options.effects),
        Method::Conventional if !options.effects.is_empty() => fast::textbook(problem, &options.effects),
        // The linear search takes motors that rest at the start of every record.
        Method::Ga if !options.effects.is_empty() || !problem.grids.iter().all(Grid::rests) => {
            genetic::search(problem, base, options, progress)
        }
        Method::Paper if !options.effects.is_empty() => {
            let why = "--method paper knows the linear model only";
            return Err(Error::usage(why, "leave out --effects, or use --method ga"));
        }
        Method::Feedforward if !options.effects.is_empty() => {
            let why = "--method feedforward has friction as its only effect";
            return Err(Error::usage(why, "leave out --effects, or use --method fast"));
        }
        Method::Feedforward => feedforward::search(problem, records)?,
        Method::Ga | Method::Conventional | Method::Paper => {
            linear::search(problem, records, motor, options, progress)?
        }
    })
}

/// Errors, intervals and combinations of `values` on `problem`.
fn describe(problem: &Problem, values: &Values, model: Model, records: &[Record]) -> Fit {
    let parameters = estimates(problem, values);
    Fit {
        model,
        combinations: combinations(problem, values),
        profiles: profiles(problem, values),
        identifiability: identifiability(&values.base, problem.rig.gear_ratio, records),
        parameters,
        train: simulated(problem, values).unwrap_or_default(),
        validation: None,
        usual: None,
        no_usual: None,
        noise_level: 0.0,
        ended: ended_of(problem, values),
        supposed: Supposed::default(),
        objective_history: Vec::new(),
        evaluations: 0,
        seconds: 0.0,
    }
}

/// The records that the fit of `problem` does not see, laid out like those that it does; none where there are none.
fn kept_out(problem: &Problem, validation: &[Record], motor: &MotorFile) -> Option<Problem> {
    (!validation.is_empty()).then(|| problem.on(problem.lay_out(validation, motor)))
}

/// The effect of that name in `library`.
///
/// # Errors
/// Wrong usage that names the nearest effect.
pub fn effect_by_name(name: &str, library: &Library) -> Result<Kind> {
    library.by_name(name).ok_or_else(|| {
        let remedy = match nearest(name, library.kinds().iter().map(|kind| kind.name())) {
            Some(known) => format!("did you mean {known}? motorlens effects lists all"),
            None => "motorlens effects lists all".to_owned(),
        };
        Error::usage(format!("no effect is called \"{name}\""), remedy)
    })
}

/// Refuses sets of effects that no model can hold.
///
/// # Errors
/// Wrong usage: too many, one twice, two transmissions.
pub fn check_effects(effects: &[Kind]) -> Result<()> {
    if effects.len() > MAX_EFFECTS {
        let why = format!("{} effects, and at most {MAX_EFFECTS} work together", effects.len());
        return Err(Error::usage(why, "leave out the least likely"));
    }
    for (k, effect) in effects.iter().enumerate() {
        if effects[..k].contains(effect) {
            return Err(Error::usage(format!("the effect {effect} is given twice"), "give each effect once"));
        }
    }
    let mut transmissions = effects.iter().filter(|k| k.spec().load_share().is_some());
    if let (Some(a), Some(b)) = (transmissions.next(), transmissions.next()) {
        let why = format!("{a} and {b} both stand between rotor and load");
        return Err(Error::usage(why, "take one of them"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_effect_is_answered_with_the_one_that_was_meant() {
        let by_name = |name| effect_by_name(name, &Library::default());
        assert!(by_name("coulom").unwrap_err().to_string().contains("did you mean coulomb?"));
        assert_eq!(by_name("backlash").unwrap(), Kind::Backlash);
        assert_eq!(by_name("zzz").unwrap_err().exit_code(), 2);
    }

    #[test]
    fn impossible_sets_of_effects_are_refused() {
        check_effects(&[Kind::Coulomb, Kind::Backlash]).unwrap();
        assert!(check_effects(&[Kind::Coulomb, Kind::Coulomb]).is_err());
        assert!(check_effects(&[Kind::Compliance, Kind::Backlash]).is_err());
        assert!(check_effects(&Kind::ALL[..7]).is_err());
    }
}
