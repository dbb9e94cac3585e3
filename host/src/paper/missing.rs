//! The step that the paper does not take: name the missing effect, add it, and make Table 2 anew.

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::data::Data;
use super::tables::Errors;
use crate::compare::free_run::free_runs;
use crate::diagnose::discover::{Options, discover};
use crate::error::Result;
use crate::findings::{Verdict, verdict_of};
use crate::fit::setup;
use crate::model_file::Model;

/// What the diagnosis found and what the model with it leaves.
#[derive(Debug, Clone, Serialize)]
pub struct Missing {
    /// Effects in the order added.
    pub effects: Vec<Kind>,
    /// How the diagnosis ended.
    pub verdict: Verdict,
    /// Sets that these records cannot tell apart.
    pub rivals: Vec<Vec<Kind>>,
    /// Records kept out of its fit, by name.
    pub unseen: Vec<String>,
    /// Errors with the effects, a line for each record in the order of the data.
    pub table_2: Vec<Errors>,
    /// Everything needed to simulate it.
    pub model: Model,
    /// Its runs beside the measurements.
    #[serde(skip)]
    pub predictions: Vec<Vec<f64>>,
}

/// Seeks an effect of `library` in the records, with those between the smallest and the largest voltage kept out of the fit.
///
/// # Errors
/// Records that no fit can use.
pub fn missing_effect(data: &Data, library: &[Kind], progress: &mut dyn FnMut(&str)) -> Result<Missing> {
    let last = data.records.len() - 1;
    let (unseen, fitted): (Vec<_>, Vec<_>) =
        data.records.iter().cloned().enumerate().partition(|(k, _)| *k != 0 && *k != last);
    let names = unseen.iter().map(|(_, r)| r.name.clone()).collect();
    let strip = |numbered: Vec<(usize, _)>| numbered.into_iter().map(|(_, r)| r).collect::<Vec<_>>();
    let options = Options { library: library.to_vec(), ..Options::default() };
    let found = discover(&strip(fitted), &strip(unseen), &data.motor, &options, &mut |step| {
        if let crate::diagnose::discover::Progress::Rung(rung) = step {
            let names: Vec<String> = rung.effects.iter().map(ToString::to_string).collect();
            progress(&format!("with [{}] the average error is {:.4}", names.join(" "), rung.train.ae));
        }
    })?;
    let (all, _) = setup::problem(&data.records, &data.motor);
    let runs = free_runs(&all, &found.model.values());
    Ok(Missing {
        rivals: found.open_sets(),
        verdict: verdict_of(&found),
        effects: found.effects,
        unseen: names,
        table_2: runs.iter().map(|run| run.measures().into()).collect(),
        model: found.model,
        predictions: runs.into_iter().map(|run| run.simulated).collect(),
    })
}
