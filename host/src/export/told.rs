//! What a target lacks, leaves to others or simplifies, in sentences with the cost in rad.

use super::cost::{Apart, Cost, of_steps};
use super::{Exported, Format, Options, mujoco};
use crate::model_file::Model;
use crate::sentence::capital;

/// Sentences on an export.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Told {
    /// What the target does not have of the model, and what that costs together.
    pub lacking: Vec<String>,
    /// What is in the target only where somebody sees to it, and what else is to be known.
    pub to_know: Vec<String>,
}

/// Whether there is anything that a [`Cost`] would tell of.
pub fn is_simplified(exported: &Exported, model: &Model) -> bool {
    exported.carried != model.values() || !exported.left.is_empty()
}

/// The step, s, where it is longer than the one that the target has without being asked.
pub fn longer_step_s(model: &Model, format: Format, options: &Options) -> Option<f64> {
    let usual_s = match format {
        Format::Mujoco => mujoco::usual_step_s(model),
        _ if format.steps() => Options::default().step_s(),
        _ => return None,
    };
    options.step_s.filter(|step_s| *step_s > usual_s)
}

/// Puts into words what `exported` is beside `model`, at this price where it was worked out.
pub fn told(
    exported: &Exported,
    model: &Model,
    format: Format,
    options: &Options,
    price: Option<&Cost>,
) -> Told {
    let costing = |effect| {
        let own = price.and_then(|price| price.each.iter().find(|of| of.effect == effect));
        let unit = price.map_or("rad", |price| price.unit);
        own.map(|of| much(of.apart, unit))
    };
    let lost = exported.lost.iter().map(|lost| {
        let cost = costing(lost.effect).map_or(String::new(), |cost| format!(", which costs {cost}"));
        format!("{} has no place for {}: {}{cost}.", capital(format.title()), lost.effect, lost.why)
    });
    let whole = exported.carried == model.values();
    let all = price.filter(|price| !whole || price.is_too_high()).map(|price| {
        let what = match price.step_s.filter(|_| whole) {
            Some(step_s) => {
                let by = price.tool.map_or(String::new(), |tool| format!(" by {tool}"));
                format!("Run{by} in its steps of {step_s} s, it parts from the model by")
            }
            None if exported.lost.is_empty() => "What it simplifies costs".into(),
            None => "Together:".into(),
        };
        let above = if price.is_too_high() { ", which is more than a hundredth above it" } else { "" };
        let other = price.better_step_s().map_or(String::new(), |step_s| {
            format!(" (give a step of {step_s} s, in which the model itself runs there)")
        });
        format!("{what} {}{above}{other}.", price.clause())
    });
    let left = exported.left.iter().map(|left| {
        let cost = costing(left.effect).map_or(String::new(), |cost| format!("; its absence costs {cost}"));
        format!("{} {}{cost}.", capital(left.effect.name()), left.why)
    });
    let step_s = longer_step_s(model, format, options);
    let steps = step_s.filter(|_| format.steps()).map(|step_s| {
        let cost = much(of_steps(model, step_s), "rad");
        format!("Steps of {step_s} s instead of 0.001 s cost {cost} on a standard programme of 8 s.")
    });
    let not_run = price.and_then(|price| {
        let why = price.not_run.as_ref()?;
        let target = capital(format.title());
        Some(format!(
            "{target} did not run it on {}: {why}. What its own steps cost in {} only that run tells; other figures are motorlens' own.",
            price.on, price.unit
        ))
    });
    Told {
        lacking: lost.chain(all).collect(),
        to_know: left.chain(not_run).chain(steps).chain(exported.notes.iter().cloned()).collect(),
    }
}

fn much(apart: Apart, unit: &str) -> String {
    format!("{:.3e} {unit} (rms; at most {:.3e})", apart.rms, apart.worst)
}
