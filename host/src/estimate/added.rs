//! One more effect in a model that exists: what it changes, and whether it is worth its parameters.

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::{check_effects, kept_out};
use crate::compare::free_run::simulated;
use crate::compare::measures::Measures;
use crate::compare::problem_of;
use crate::diagnose::contained::{covers, parts};
use crate::diagnose::discover::Progress;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::ladder::Rung;
use crate::error::{Error, Result};
use crate::findings::Supposed;
use crate::findings::shown_by_fit::ended_of;
use crate::fit::layout::Values;
use crate::fit::uncertainty::{Estimate, estimates};
use crate::log::{Record, check_all_usable};
use crate::model_file::{Model, Origin};
use crate::motor_file::MotorFile;
use crate::select;
use crate::sentence::listed;

/// Errors of one model.
#[derive(Debug, Clone, Serialize)]
pub struct Errors {
    /// On the records fitted.
    pub train: Measures,
    /// On records kept out, where there are any.
    pub validation: Option<Measures>,
}

impl Errors {
    /// Those of a model with `effects`, for whoever watches.
    fn of_model(&self, effects: Vec<Kind>) -> Progress {
        Progress::Rung(Rung { effects, train: self.train, validation: self.validation })
    }
}

/// A parameter before and after.
#[derive(Debug, Clone, Serialize)]
pub struct Moved {
    /// Its name.
    pub name: String,
    /// Unit of both values.
    pub unit: String,
    /// In the model given.
    pub before: f64,
    /// In the model with the effect.
    pub after: f64,
}

/// What adding an effect did.
#[derive(Debug)]
pub struct Addition {
    /// The effect.
    pub effect: Kind,
    /// It lowers the error enough, on the records fitted and on unseen ones.
    pub worth: bool,
    /// The same in words.
    pub why: String,
    /// The model as it was given.
    pub given: Errors,
    /// The same effects, refitted to these records: what the new effect is held against.
    pub before: Errors,
    /// With the effect.
    pub after: Errors,
    /// The old parameters.
    pub moved: Vec<Moved>,
    /// All parameters of the new model.
    pub parameters: Vec<Estimate>,
    /// What the sizes of its effects rest on that no record tells.
    pub supposed: Supposed,
    /// The new model.
    pub model: Model,
}

/// Adds `effect` to `model` and refits everything to `records`; the `validation` records are only scored. `progress` is told of the model refitted
/// as it is, of the trial, and of the model with the effect.
///
/// # Errors
/// An effect that the model has already or cannot have; records that no fit can use.
pub fn add(
    model: &Model,
    effect: Kind,
    records: &[Record],
    validation: &[Record],
    motor: &MotorFile,
    progress: &mut dyn FnMut(Progress),
) -> Result<Addition> {
    let values = model.values();
    if values.kinds().contains(&effect) {
        let remedy = "motorlens diagnose shows what else is missing";
        return Err(Error::usage(format!("the model has {effect} already"), remedy));
    }
    check_effects(&[values.kinds(), vec![effect]].concat())?;
    check_all_usable(validation)?;
    let problem = problem_of(model, records, motor)?;
    let evidence = Evidence::new(problem, records, validation, motor);
    let whole = &evidence.whole;
    let unseen = kept_out(whole, validation, motor);
    let errors = |v: &Values| Errors {
        train: simulated(whole, v).unwrap_or_default(),
        validation: unseen.as_ref().and_then(|unseen| simulated(unseen, v)),
    };

    let old = select::fitted_from(&evidence, &values);
    let before = errors(&old.simulating(&evidence).values());
    progress(before.of_model(values.kinds()));
    progress(Progress::Trying { depth: values.effects.len(), effect });
    let new = select::with(&evidence, &old, effect);
    let new = new.ok_or_else(|| cannot_join(&values.kinds(), effect))?;
    let better = new.beats(&old, &evidence, &old);
    let new_values = new.simulating(&evidence).values();
    let after = errors(&new_values);
    progress(after.of_model(new_values.kinds()));

    let gain = new.gain_over(&old);
    let why = format!(
        "with {effect} the likelihood of blocks held out gains {gain}, and the cross-validated simulation error is {:.0} % of what it was{}",
        100.0 * (new.crossed(&evidence) - old.crossed(&evidence)).exp(),
        if better { "" } else { "; that is not worth its parameters" }
    ) + &ended_of(whole, &new_values);
    let origin = Origin {
        motorlens: env!("CARGO_PKG_VERSION").into(),
        records: records.iter().map(|r| r.name.clone()).collect(),
        method: format!("add {effect}"),
        seed: None,
    };
    let parameters = estimates(whole, &new_values);
    let moved = estimates_of(&whole.layout(&values.kinds()), &values)
        .into_iter()
        .zip(&parameters)
        .map(|((name, before), after)| Moved { name, unit: after.unit.clone(), before, after: after.value })
        .collect();
    Ok(Addition {
        effect,
        worth: better,
        why,
        given: errors(&values),
        before,
        after,
        moved,
        parameters,
        supposed: Supposed::by(&new_values.kinds(), records, motor, &whole.rig),
        model: Model::fitted(&new_values, whole, origin),
    })
}

/// Why `effect` does not join a model of `kinds`, and what would.
fn cannot_join(kinds: &[Kind], effect: Kind) -> Error {
    let list = |kinds: Vec<Kind>| listed(&kinds.iter().map(|kind| kind.name()).collect::<Vec<_>>());
    let (there, rest): (Vec<Kind>, Vec<Kind>) =
        parts(effect).map(|(part, _)| part).partition(|part| covers(kinds, *part));
    if effect.spec().is_sum() && !rest.is_empty() && !there.is_empty() {
        let sum = list(parts(effect).map(|(part, _)| part).collect());
        return Error::usage(
            format!("{effect} is {sum} together, and the model has {} already", list(there)),
            format!("add {}, the rest of it", list(rest)),
        );
    }
    let richer = kinds.iter().copied().filter(|kind| kind.spec().holds(effect.name())).collect::<Vec<_>>();
    if !richer.is_empty() || covers(kinds, effect) {
        let by = if richer.is_empty() { parts(effect).map(|(part, _)| part).collect() } else { richer };
        return Error::usage(
            format!("what {effect} does is in the model already, by {}", list(by)),
            "motorlens diagnose shows what else is missing",
        );
    }
    let between = kinds.iter().copied().filter(|kind| kind.is_transmission()).collect();
    Error::usage(
        format!("{effect} cannot be added: {} stands between rotor and load", list(between)),
        format!("fit a model without it, and add {effect} to that"),
    )
}

/// Names and plain values, in the layout's order.
fn estimates_of(layout: &crate::fit::layout::Layout, values: &Values) -> Vec<(String, f64)> {
    let x = layout.pack(values);
    layout.axes.iter().enumerate().map(|(k, a)| (a.name.clone(), layout.plain(k, x[k]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_effect_that_cannot_join_is_refused_with_the_reason_and_what_would() {
        use Kind::{Backlash, Compliance, ConstantLoad, Coulomb, CoulombAsymmetric, Stribeck};
        let told = |kinds: &[Kind], effect| cannot_join(kinds, effect).to_string();
        assert!(told(&[Coulomb], CoulombAsymmetric).contains("the model has coulomb already"));
        assert!(told(&[Coulomb], CoulombAsymmetric).contains("add constant_load"));
        assert!(told(&[Stribeck], Coulomb).contains("by stribeck"));
        assert!(told(&[Coulomb, ConstantLoad], CoulombAsymmetric).contains("by coulomb and constant_load"));
        assert!(told(&[Backlash], Compliance).contains("backlash stands between"));
    }
}
