//! The model for other tools.
//!
//! C, Python, Modelica and FMU get the exact step of the model itself, written down by the model while it runs on numbers that
//! record what is computed with them; MuJoCo its own motor, and beside it the equations that it lacks. The others take a few numbers.
//! What a target cannot express is never dropped in silence: [`Exported::lost`] names it, [`Exported::left`] what it has only where somebody
//! sees to it, and [`cost`] says what either costs in rad.

mod actuator;
mod bam;
pub mod cost;
mod expression;
mod fmu;
mod hook;
mod in_mujoco;
mod isaac;
mod mjcf_parts;
mod modelica;
mod mujoco;
mod program;
mod record;
mod step;
pub mod told;
mod two_bodies;
mod urdf;
mod wpilib;

use motorlens_shared::effects::Kind;

use crate::diagnose::contained::parts;
use crate::error::{Error, Result};
use crate::fit::layout::Values;
use crate::model_file::Model;

/// A target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// MJCF with MuJoCo 4's dcmotor, and a Python file with the equations that MJCF lacks
    Mujoco,
    /// A Modelica model
    Modelica,
    /// A Python module without dependencies
    Python,
    /// A C99 file without dependencies
    C,
    /// A unit for co-simulation, FMI 3.0 (Simulink, Dymola, FMPy)
    Fmu,
    /// kS, kV, kA and kG for WPILib in Java, C++ and Python
    Wpilib,
    /// Parameters of Rhoban's BAM, models m1 to m6
    Bam,
    /// An actuator configuration for Isaac Lab
    Isaac,
    /// Limits and friction of a URDF joint, with its ros2_control block
    Urdf,
}

impl Format {
    /// What it is called in a sentence.
    pub fn title(self) -> &'static str {
        match self {
            Self::Mujoco => "MuJoCo",
            Self::Modelica => "Modelica",
            Self::Python => "Python",
            Self::C => "C",
            Self::Fmu => "an FMU",
            Self::Wpilib => "WPILib's feedforward",
            Self::Bam => "BAM",
            Self::Isaac => "Isaac Lab's DC motor",
            Self::Urdf => "URDF",
        }
    }

    /// Whether it steps as the model itself does.
    fn steps(self) -> bool {
        matches!(self, Self::C | Self::Python | Self::Modelica | Self::Fmu)
    }
}

/// What a target cannot know from voltage and motion.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Options {
    /// Step of the generated program or of MuJoCo's simulation, s; none takes the target's usual one.
    pub step_s: Option<f64>,
    /// Stall torque per volt at the output shaft, N m/V; none where it is unknown.
    pub torque_per_volt: Option<f64>,
    /// Name of the joint, of BAM's actuator.
    pub name: Option<String>,
    /// Which of BAM's models, m1 to m6; none takes the smallest that holds the effects.
    pub bam_model: Option<u8>,
}

impl Options {
    /// Step of a program, s.
    fn step_s(&self) -> f64 {
        self.step_s.unwrap_or(1e-3)
    }

    /// The torque scale, for targets whose numbers are in N m.
    fn torque(&self, format: Format) -> Result<f64> {
        self.torque_per_volt.ok_or_else(|| {
            let why = format!(
                "{} takes torques in N m, and voltage and motion do not tell how large they are",
                format.title()
            );
            Error::usage(
                why,
                "give --torque-per-volt, the stall torque at the output shaft per volt, in N m/V",
            )
        })
    }
}

/// An effect that a target does not have, or not by itself.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Lost {
    /// Which.
    pub effect: Kind,
    /// Why, as a clause.
    pub why: String,
    /// Whether the target keeps the level of dry friction that the effect contains.
    #[serde(skip)]
    pub level_stays: bool,
}

impl Lost {
    fn new(effect: Kind, why: impl Into<String>) -> Self {
        Self { effect, why: why.into(), level_stays: false }
    }

    /// The same, but for the level of dry friction.
    fn but_for_its_level(self) -> Self {
        Self { level_stays: true, ..self }
    }

    /// What is left of `values`.
    fn of(&self, values: &Values) -> Values {
        let lost = values.effects.iter().find(|(kind, _)| *kind == self.effect);
        let level = lost.filter(|_| self.level_stays).and_then(|(kind, p)| level(*kind, p));
        let rest = values.without(self.effect);
        match level {
            Some(level) => rest.with(Kind::Coulomb, vec![level]),
            None => rest,
        }
    }
}

/// What steps an exported model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stepper {
    /// The program that it is, in steps of so many s.
    Program(f64),
    /// MuJoCo, in steps of so many s.
    Mujoco(f64),
    /// Another simulator, as its user sets it up.
    Other,
}

/// A model for another tool.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// The file: text, or an archive.
    pub content: Vec<u8>,
    /// A second file and its ending.
    pub beside: Option<(&'static str, String)>,
    /// What to know of it, in whole sentences.
    pub notes: Vec<String>,
    /// Effects that it does not have.
    pub lost: Vec<Lost>,
    /// Effects that it has only where somebody sees to it: a load that belongs to the robot, a program that runs beside.
    pub left: Vec<Lost>,
    /// The model that it does have.
    pub carried: Values,
    /// What steps it.
    pub stepper: Stepper,
}

impl Exported {
    /// A program with everything that `model` has, in steps of `step_s`.
    fn whole(text: String, model: &Model, step_s: f64) -> Self {
        let carried = model.values();
        Self {
            content: text.into_bytes(),
            beside: None,
            notes: Vec::new(),
            lost: Vec::new(),
            left: Vec::new(),
            carried,
            stepper: Stepper::Program(step_s),
        }
    }

    /// A file for a simulator that takes a few numbers, which has `carried` of a model.
    fn numbers(text: String, carried: Values, notes: Vec<String>, lost: Vec<Lost>, left: Vec<Lost>) -> Self {
        let content = text.into_bytes();
        Self { content, beside: None, notes, lost, left, carried, stepper: Stepper::Other }
    }

    /// The file as text.
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.content).into_owned()
    }
}

/// Writes `model` in `format`. Whether it may lack what [`Exported::lost`] names is for the caller to decide.
///
/// # Errors
/// A target that needs a number which `options` do not have.
///
/// ```
/// use motorlens::export::{Format, Options, export};
/// # let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/model.json");
/// let model = motorlens::Model::read(path.as_ref())?;
/// let exported = export(&model, Format::Python, &Options::default())?;
/// assert!(exported.lost.is_empty() && exported.text().contains("class Motor"));
/// # Ok::<(), motorlens::Error>(())
/// ```
pub fn export(model: &Model, format: Format, options: &Options) -> Result<Exported> {
    Ok(match format {
        Format::Mujoco => mujoco::export(model, options)?,
        Format::Modelica => modelica::export(model, options),
        Format::Python => program::export(model, options, &program::PYTHON),
        Format::C => program::export(model, options, &program::C),
        Format::Fmu => fmu::export(model, options)?,
        Format::Wpilib => wpilib::export(model),
        Format::Bam => bam::export(model, options)?,
        Format::Isaac => isaac::export(model, options)?,
        Format::Urdf => urdf::export(model, options)?,
    })
}

/// The effects with their parameters in the registry's order, in which they apply.
fn effects(model: &Model) -> Vec<(Kind, Vec<f64>)> {
    let mut effects = model.values().effects;
    effects.sort_by_key(|(kind, _)| *kind);
    effects
}

/// The level of dry friction that an effect of `kind` contains, V; none where it contains none.
fn level(kind: Kind, parameters: &[f64]) -> Option<f64> {
    let (_, place) = parts(kind).find(|(part, _)| *part == Kind::Coulomb)?;
    parameters.get(place).copied()
}

/// `text` as the value of an XML attribute.
fn xml(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// What stands between rotor and load among `effects`, with its parameters.
fn transmission<S>(effects: &[(Kind, Vec<S>)]) -> Option<&(Kind, Vec<S>)> {
    effects.iter().find(|(kind, _)| kind.is_transmission())
}
