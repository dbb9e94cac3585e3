//! Step 3, What is missing: a card for every suspect, the best with its evidence drawn.

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::fails::{Side, view};
use super::figure::Figure;
use super::story::{Suspect, Torques};
use crate::compare::residual_views::Binned;

/// A suspect as it is shown.
#[derive(Debug, Clone, Serialize)]
pub struct Card {
    /// Name that users type.
    pub effect: String,
    /// Registry's line of plain words.
    pub title: &'static str,
    /// Registry's law.
    pub equation: &'static str,
    /// What it looks like in data.
    pub signature: &'static str,
    /// Share of the error that it takes away, percent.
    pub gain_percent: f64,
    /// What the diagnosis says.
    pub evidence: String,
    /// Effects that these records cannot tell from it.
    pub rivals: Vec<String>,
    /// Whether it is in the model.
    pub added: bool,
    /// Name of the figure that shows it.
    pub figure: Option<String>,
}

/// What suspects are told against.
#[derive(Debug)]
pub struct Setting<'a> {
    /// Name and residual torques of the model that they were tried on.
    pub tried_on: (&'a str, &'a Torques),
    /// Sets that these records cannot tell apart.
    pub rivals: &'a [Vec<Kind>],
    /// Effects that are in the model by now.
    pub in_model: Vec<Kind>,
    /// Motor turns per turn of the output shaft.
    pub gear_ratio: f64,
}

/// Cards in order, and the figures of those that have one.
pub fn cards(suspects: &[Suspect], setting: &Setting) -> (Vec<Card>, Vec<Figure>) {
    let mut figures = Vec::new();
    let cards = suspects
        .iter()
        .map(|suspect| {
            let kind = suspect.ranked.effect;
            let spec = kind.spec();
            let evidence = evidence(suspect, setting);
            let rivals = setting.rivals.iter().filter(|set| set.contains(&kind)).flatten();
            let card = Card {
                effect: spec.name.into(),
                title: spec.title,
                equation: spec.equation,
                signature: spec.signature,
                gain_percent: (1000.0 * suspect.ranked.score).round() / 10.0,
                evidence: suspect.ranked.evidence.clone(),
                rivals: rivals.filter(|r| **r != kind).map(ToString::to_string).collect(),
                added: setting.in_model.contains(&kind),
                figure: evidence.as_ref().map(|f| f.id.clone()),
            };
            figures.extend(evidence);
            card
        })
        .collect();
    (cards, figures)
}

/// The side from which the effect takes most of the residual torque away.
fn evidence(suspect: &Suspect, setting: &Setting) -> Option<Figure> {
    let with = suspect.torques.as_ref()?;
    let (name_before, before) = setting.tried_on;
    let square =
        |seen: &Binned| seen.mean_v.iter().map(|m| m * m).sum::<f64>() / seen.mean_v.len().max(1) as f64;
    let sides = Side::ALL.into_iter().map(|side| {
        let [base, candidate] = [before, with].map(|torques| side.binned(torques, setting.gear_ratio));
        (square(&base) - square(&candidate), side, base, candidate)
    });
    let (_, side, base, candidate) = sides.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let name = suspect.ranked.effect.spec().name;
    let names = [name_before, &format!("with {name}")];
    let mut figure = view(side, &format!("evidence-{name}"), &base, &candidate, names);
    figure.reading = format!("What {name} takes away, seen {}.", figure.title.to_lowercase());
    Some(figure)
}
