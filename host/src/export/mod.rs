//! The model for other tools.
//!
//! C, Python and Modelica get the exact step of the model itself, written down by the model while it runs on numbers that
//! record what is computed with them; MuJoCo a joint with armature, damping, friction loss and gear. What a target cannot
//! express is left out and named.

mod expression;
mod modelica;
mod mujoco;
mod program;
mod record;
mod step;

use motorlens_shared::effects::Kind;

use crate::model_file::Model;

/// A target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// MJCF: a hinge with its actuator
    Mujoco,
    /// A Modelica model
    Modelica,
    /// A Python module without dependencies
    Python,
    /// A C99 file without dependencies
    C,
}

/// What a target cannot know from voltage and motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Step of the generated program, s.
    pub step_s: f64,
    /// Stall torque per volt at the output shaft, N m/V; 1 makes torques volt-equivalents.
    pub torque_per_volt: f64,
}

/// A model in another language.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// The file.
    pub text: String,
    /// What it does not have, and why; in whole sentences.
    pub left_out: Vec<String>,
}

impl Exported {
    /// With everything that the model has.
    fn whole(text: String) -> Self {
        Self { text, left_out: Vec::new() }
    }
}

/// Writes `model` in `format`.
pub fn export(model: &Model, format: Format, options: &Options) -> Exported {
    match format {
        Format::Mujoco => mujoco::export(model, options),
        Format::Modelica => modelica::export(model, options),
        Format::Python => program::export(model, options, &program::PYTHON),
        Format::C => program::export(model, options, &program::C),
    }
}

/// The effects with their parameters in the registry's order, in which they apply.
fn effects(model: &Model) -> Vec<(Kind, Vec<f64>)> {
    let mut effects = model.values().effects;
    effects.sort_by_key(|(kind, _)| *kind);
    effects
}

/// The sentence for an effect that a target does not have.
fn not_expressed(kind: Kind, target: &str) -> String {
    format!("{kind} ({}) is left out: {target} has no place for it.", kind.spec().title)
}
