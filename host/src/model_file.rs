//! The model file: everything needed to simulate, and where it came from.

use std::path::Path;

use motorlens_shared::effects::{Kind, Rig};
use motorlens_shared::simulator::MAX_EFFECTS;
use serde::{Deserialize, Serialize};

use crate::atomic_file;
use crate::error::{BadInput, Error, Result};
use crate::fit::grid::Quantity;
use crate::fit::layout::{BaseValues, Prior, Values};
use crate::fit::search::Problem;
use crate::formula::{self, Written};

/// Version of the file's layout.
pub const SCHEMA: u32 = 1;

/// A fitted motor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Model {
    /// Layout of this file.
    pub schema: u32,
    /// The rig it was fitted on.
    pub rig: RigValues,
    /// Beliefs about the base, kept for later refits.
    pub prior: PriorValues,
    /// The base model.
    pub base: BaseValues,
    /// Effects in the order they were added.
    pub effects: Vec<EffectValues>,
    /// Where it came from.
    pub origin: Origin,
}

/// The rig, as stored.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RigValues {
    /// Motor revolutions per output revolution.
    pub gear_ratio: f64,
    /// The encoder sits on the motor shaft.
    pub encoder_on_motor: bool,
    /// Nominal voltage, V.
    pub nominal_v: f64,
    /// Supply voltage, V.
    pub supply_v: f64,
    /// Speed scale of bounds and probes, rad/s.
    pub reference_speed_rad_s: f64,
    /// One encoder count, rad of the output shaft.
    pub count_rad: f64,
    /// What the speeds are that it was fitted to; none of a model fitted to angles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_reading: Option<Quantity>,
}

/// Beliefs, as stored: centre and spread.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PriorValues {
    /// Electrical time constant, s, and the spread of its logarithm.
    pub tau_e: (f64, f64),
    /// Viscous share and its spread.
    pub viscous_share: (f64, f64),
}

/// An effect with its parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "WrittenEffect")]
pub struct EffectValues {
    /// Which.
    pub effect: Kind,
    /// Its parameters in the registry's order.
    pub parameters: Vec<NamedValue>,
    /// What a user wrote of it, where it is not of the library.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub formula: Option<Written>,
}

/// An effect as it stands in the file.
#[derive(Deserialize)]
struct WrittenEffect {
    effect: String,
    parameters: Vec<NamedValue>,
    #[serde(default)]
    formula: Option<Written>,
}

impl TryFrom<WrittenEffect> for EffectValues {
    type Error = String;

    fn try_from(written: WrittenEffect) -> std::result::Result<Self, String> {
        let WrittenEffect { effect: name, parameters, formula } = written;
        let effect = match &formula {
            Some(own) => {
                formula::define(own).map_err(|w| format!("effect {name}: {}; {}", w.why, w.remedy))?
            }
            None => Kind::by_name(&name)
                .ok_or_else(|| format!("\"{name}\" is no effect (motorlens effects lists them)"))?,
        };
        if effect.name() != name {
            return Err(format!("effect {name} has the formula of {effect}"));
        }
        Ok(Self { effect, parameters, formula })
    }
}

/// A parameter as people read it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedValue {
    /// Name in the registry.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Unit.
    pub unit: String,
}

/// The [`Origin::method`] of a model whose effects were looked for.
pub const DISCOVERED: &str = "discover";

/// Where a model came from.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// Version of motorlens.
    pub motorlens: String,
    /// Records fitted.
    pub records: Vec<String>,
    /// Verb and method.
    pub method: String,
    /// Seed of a random search.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
}

impl Model {
    /// A model of `values` as they were fitted to the records of `problem`, whose speeds are read as they are there.
    pub(crate) fn fitted(values: &Values, problem: &Problem, origin: Origin) -> Self {
        let mut model = Self::new(values, &problem.rig, &problem.prior, origin);
        model.rig.speed_reading = problem.speeds();
        model
    }

    /// A model of `values` on `rig`.
    pub fn new(values: &Values, rig: &Rig, prior: &Prior, origin: Origin) -> Self {
        let effects = values.effects.iter().map(|(kind, parameters)| EffectValues {
            effect: *kind,
            parameters: kind
                .spec()
                .parameters
                .iter()
                .zip(parameters)
                .map(|(p, x)| NamedValue { name: p.name.into(), value: *x, unit: p.unit.into() })
                .collect(),
            formula: formula::written(*kind),
        });
        Self {
            schema: SCHEMA,
            rig: RigValues {
                gear_ratio: rig.gear_ratio,
                encoder_on_motor: rig.encoder_on_motor,
                nominal_v: rig.nominal_v,
                supply_v: rig.supply_v,
                reference_speed_rad_s: rig.reference_speed,
                count_rad: rig.count_rad,
                speed_reading: None,
            },
            prior: PriorValues { tau_e: prior.tau_e, viscous_share: prior.viscous_share },
            base: values.base,
            effects: effects.collect(),
            origin,
        }
    }

    /// Base and effects.
    pub fn values(&self) -> Values {
        let effects = self.effects.iter().map(|e| (e.effect, e.parameters.iter().map(|p| p.value).collect()));
        Values { base: self.base, effects: effects.collect() }
    }

    /// The rig, for cells of `step_s`.
    pub fn rig(&self, step_s: f64) -> Rig {
        Rig {
            step_s,
            gear_ratio: self.rig.gear_ratio,
            encoder_on_motor: self.rig.encoder_on_motor,
            nominal_v: self.rig.nominal_v,
            supply_v: self.rig.supply_v,
            reference_speed: self.rig.reference_speed_rad_s,
            count_rad: self.rig.count_rad,
        }
    }

    /// Beliefs about the base.
    pub fn prior(&self) -> Prior {
        Prior { tau_e: self.prior.tau_e, viscous_share: self.prior.viscous_share }
    }

    /// Reads a model file.
    ///
    /// # Errors
    /// No such file, not JSON, another schema, or parameters that do not fit their effect.
    ///
    /// ```
    /// # let directory = tempfile::tempdir().expect("a directory");
    /// # let (path, copy) = (concat!(env!("CARGO_MANIFEST_DIR"), "/examples/model.json"), directory.path().join("copy.json"));
    /// let model = motorlens::Model::read(path.as_ref())?;
    /// println!("{} rad/s per volt", model.base.gain);
    /// model.write(&copy)?;
    /// assert_eq!(motorlens::Model::read(&copy)?, model);
    /// # Ok::<(), motorlens::Error>(())
    /// ```
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|e| crate::log::cannot_read(path, &e))?;
        Self::of(path, &text)
    }

    /// The model that the content of a model file describes.
    ///
    /// # Errors
    /// As [`Model::read`].
    pub fn from_json(text: &str) -> Result<Self> {
        Self::of("model".as_ref(), text)
    }

    fn of(path: &Path, text: &str) -> Result<Self> {
        let bad = |why: String, remedy: &str| Error::from(BadInput::new(path, why, remedy));
        let refit = "make it anew with motorlens fit or motorlens discover --out model.json";
        let json: serde_json::Value = serde_json::from_str(text).map_err(|e| {
            let place = BadInput::new(path, format!("this is not a model file: {e}"), refit);
            Error::from(place.at_line(e.line() as u64).at_character(e.column()))
        })?;
        match json.get("schema").and_then(serde_json::Value::as_u64) {
            Some(s) if s == u64::from(SCHEMA) => {}
            Some(s) => {
                let why = format!("this model has schema {s}, and this motorlens reads schema {SCHEMA}");
                return Err(bad(why, refit));
            }
            None => return Err(bad("this JSON has no schema number, so it is no model file".into(), refit)),
        }
        let model: Self = serde_json::from_str(text).map_err(|e| {
            let place = BadInput::new(path, format!("the model cannot be used: {e}"), refit);
            Error::from(place.at_line(e.line() as u64).at_character(e.column()))
        })?;
        model.check().map_err(|why| bad(why, refit))?;
        Ok(model)
    }

    /// Whether every number can be simulated.
    fn check(&self) -> std::result::Result<(), String> {
        let b = &self.base;
        let positive = [("gain", b.gain), ("tau_m", b.tau_m), ("tau_e", b.tau_e)];
        if let Some((name, x)) = positive.iter().find(|(_, x)| !(x.is_finite() && *x > 0.0)) {
            return Err(format!("base parameter {name} is {x}, and must be positive"));
        }
        if self.effects.len() > MAX_EFFECTS {
            return Err(format!("{} effects, and at most {MAX_EFFECTS} work together", self.effects.len()));
        }
        for e in &self.effects {
            let names = e.effect.spec().parameters.iter().map(|p| p.name);
            if !names.eq(e.parameters.iter().map(|p| p.name.as_str())) {
                return Err(format!("effect {} does not have its parameters in order", e.effect));
            }
            if let Some(p) = e.parameters.iter().find(|p| !p.value.is_finite()) {
                return Err(format!("parameter {}.{} is not a number", e.effect, p.name));
            }
        }
        Ok(())
    }

    /// Writes the model file, whole or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        atomic_file::write(path, text + "\n")
    }
}
