//! Step 3, What is missing: the candidates ranked, and a card for each, the best and the accepted with their evidence drawn.

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::falls::{judged, judged_on};
use super::figure::{Figure, PAST, change_in_words};
use super::story::Suspect;
use crate::diagnose::ladder::{Ranked, Rung};

/// A suspect as it is shown.
#[derive(Debug, Clone, Serialize)]
pub struct Card {
    /// Name that users type.
    pub effect: String,
    /// Registry's line of plain words.
    pub title: &'static str,
    /// Registry's equation.
    pub equation: &'static str,
    /// What it looks like in data.
    pub signature: &'static str,
    /// Its place among those that are not in the model, from 1; indistinguishable ones share theirs.
    pub rank: usize,
    /// Share of the error that it explains, on blocks held out too, percent.
    pub gain_percent: f64,
    /// What the diagnosis says.
    pub evidence: String,
    /// Effects that these records cannot tell from it.
    pub rivals: Vec<String>,
    /// Whether it is in the model.
    pub added: bool,
    /// Names of the figures that show it.
    pub figures: Vec<String>,
}

/// What suspects are told against.
#[derive(Debug)]
pub struct Setting<'a> {
    /// Sets that these records cannot tell apart.
    pub rivals: &'a [Vec<Kind>],
    /// Effects that are in the model by now.
    pub in_model: Vec<Kind>,
}

/// Cards in order, and the figures of those that have one.
pub fn cards(suspects: &[Suspect], setting: &Setting) -> (Vec<Card>, Vec<Figure>) {
    let mut figures = Vec::new();
    let mut cards: Vec<Card> = suspects
        .iter()
        .map(|suspect| {
            let kind = suspect.ranked.effect;
            let spec = kind.spec();
            let rivals = setting.rivals.iter().filter(|set| set.contains(&kind)).flatten();
            let card = Card {
                effect: spec.name.into(),
                title: spec.title,
                equation: spec.equation,
                signature: spec.signature,
                rank: 0,
                gain_percent: (1000.0 * suspect.ranked.score).round() / 10.0,
                evidence: suspect.ranked.evidence.clone(),
                rivals: rivals.filter(|r| **r != kind).map(ToString::to_string).collect(),
                added: setting.in_model.contains(&kind),
                figures: suspect.figures.iter().map(|f| f.id.clone()).collect(),
            };
            figures.extend(suspect.figures.iter().cloned());
            card
        })
        .collect();
    rank(&mut cards);
    (cards, figures)
}

/// Gives every candidate its place: indistinguishable ones follow each other and share the first one's.
fn rank(cards: &mut Vec<Card>) {
    let mut left: Vec<Card> = std::mem::take(cards);
    let mut place = 0;
    while !left.is_empty() {
        let mut card = left.remove(0);
        place += usize::from(!card.added);
        let set: Vec<String> = card.rivals.clone();
        card.rank = place;
        let alone = card.added;
        cards.push(card);
        let (same, others) = left.into_iter().partition(|c| !alone && !c.added && set.contains(&c.effect));
        left = others;
        for mut card in same {
            card.rank = place;
            cards.push(card);
        }
    }
}

/// An effect of the model as the ladder tells its coming; `figures` show it.
pub fn accepted(kind: Kind, ladder: &[Rung], unit: &str, figures: Vec<Figure>) -> Suspect {
    let has = |rung: &Rung| rung.effects.contains(&kind);
    let came = ladder.windows(2).find(|pair| !has(&pair[0]) && has(&pair[1]));
    let (score, evidence) = came.map_or_else(
        || (0.0, "it was in the model from the start".into()),
        |pair| {
            let [before, after] = [&pair[0], &pair[1]].map(|rung| judged(rung).rmse);
            let on = judged_on(&pair[1]);
            let change = change_in_words(before, after, unit, PAST);
            let evidence = format!("when {kind} came in, the error {change} on {on}");
            ((1.0 - after / before.max(1e-300)).clamp(0.0, 1.0), evidence)
        },
    );
    Suspect { ranked: Ranked { effect: kind, score, validation: None, evidence }, figures }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indistinguishable_candidates_share_a_place_and_follow_each_other() {
        let suspect = |effect| Suspect {
            ranked: Ranked { effect, score: 0.5, validation: None, evidence: String::new() },
            figures: Vec::new(),
        };
        let all = [Kind::Coulomb, Kind::Delay, Kind::DeadZone, Kind::Gravity].map(suspect);
        let rivals = [vec![Kind::Coulomb, Kind::DeadZone]];
        let (cards, _) = cards(&all, &Setting { rivals: &rivals, in_model: Vec::new() });
        let told: Vec<(&str, usize)> = cards.iter().map(|c| (c.effect.as_str(), c.rank)).collect();
        assert_eq!(told, [("coulomb", 1), ("dead_zone", 1), ("delay", 2), ("gravity", 3)]);
    }

    #[test]
    fn an_accepted_effect_is_told_by_the_step_that_brought_it() {
        let rung = |effects: &[Kind], rmse| Rung::leaving(effects, rmse, None);
        let ladder =
            [rung(&[], 0.4), rung(&[Kind::Coulomb], 0.2), rung(&[Kind::Coulomb, Kind::Gravity], 0.05)];
        let told = accepted(Kind::Gravity, &ladder, "rad", Vec::new()).ranked;
        assert!((told.score - 0.75).abs() < 1e-12);
        assert_eq!(
            told.evidence,
            "when gravity came in, the error fell from 0.2 rad to 50 mrad on the records fitted"
        );
        assert_eq!(accepted(Kind::Coulomb, &ladder[1..], "rad", Vec::new()).ranked.score, 0.0);
    }
}
