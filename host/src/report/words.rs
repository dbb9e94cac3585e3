//! The words and tables of a report.

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::falls::{judged, steps};
use super::figure::in_words;
use super::story::Story;
use crate::diagnose::discover;
use crate::diagnose::ladder::Rung;
use crate::findings::Errors;
use crate::fit::uncertainty::Estimate;
use crate::report::decimate::rounded;

/// A row of the tables of parameters and of combinations.
#[derive(Debug, Serialize)]
pub struct EstimateRow {
    name: String,
    value: f64,
    interval: String,
    unit: String,
    identifiable: &'static str,
}

/// A row of the record table.
#[derive(Debug, Serialize)]
pub struct RecordRow {
    name: String,
    role: &'static str,
    samples: usize,
    seconds: f64,
    base: String,
    model: String,
    fit_percent: f64,
}

/// The whole in one sentence.
pub fn summary(ladder: &[Rung], floor: f64, unit: &str) -> String {
    let (Some(first), Some(last)) = (ladder.first(), ladder.last()) else { return String::new() };
    let error = |m: f64| in_words(m, unit);
    let effects: Vec<String> = last.effects.iter().map(ToString::to_string).collect();
    let (before, after) = (judged(first).rmse, judged(last).rmse);
    if effects.is_empty() {
        return format!("The base model leaves {} rms; the noise floor is {}.", error(before), error(floor));
    }
    format!(
        "Adding {} lowers the error from {} to {} rms; the noise floor is {}.",
        effects.join(" and "),
        error(before),
        error(after),
        error(floor)
    )
}

/// The verdict in one sentence; empty while nothing was searched for.
pub fn verdict(story: &Story) -> String {
    let (Some(found), Some(first), Some(last)) = (story.verdict, story.ladder.first(), story.ladder.last())
    else {
        return String::new();
    };
    let errors = Errors { base: judged(first).rmse, model: judged(last).rmse, noise: story.floor };
    let names: Vec<&str> = last.effects.iter().map(|k| k.name()).collect();
    let verdict = errors.verdict(names.len(), found == discover::Verdict::Explained);
    format!("{}.", errors.headline(&names, verdict))
}

/// Said where no effect is worth adding: to a model without any (`plain`), or with what was taken back.
pub fn nothing_missing(plain: bool, withdrawn: &[Kind]) -> String {
    match (plain, withdrawn) {
        (false, _) => "With these effects in the model nothing more is worth adding.".into(),
        (true, []) => {
            "Nothing worth adding was found: no effect lowers the error both on the records fitted and on those kept out."
                .into()
        }
        (true, withdrawn) => taken_back(withdrawn),
    }
}

/// What `effects`, which were taken back in the end, would have done.
pub fn taken_back(effects: &[Kind]) -> String {
    format!(
        "{} would take a part of the error away, and so may other physics: too much is left to name it.",
        effects.iter().map(ToString::to_string).collect::<Vec<_>>().join(" + ")
    )
}

/// Parameters or combinations with their intervals.
pub fn estimate_rows(estimates: &[Estimate]) -> Vec<EstimateRow> {
    let rows = estimates.iter().map(|e| EstimateRow {
        name: e.name.clone(),
        value: rounded(e.value, 5),
        interval: if e.low.is_finite() && e.high.is_finite() {
            format!("{} … {}", rounded(e.low, 4), rounded(e.high, 4))
        } else {
            "unbounded".into()
        },
        unit: e.unit.clone(),
        identifiable: if e.identifiable { "yes" } else { "no" },
    });
    rows.collect()
}

/// A step of the ladder.
#[derive(Debug, Serialize)]
pub struct RungRow {
    step: String,
    train: String,
    unseen: Option<String>,
}

/// The steps that led to the model.
pub fn rung_rows(story: &Story) -> Vec<RungRow> {
    let rows = steps(&story.ladder).into_iter().zip(&story.ladder).map(|(step, rung)| RungRow {
        step,
        train: in_words(rung.train.rmse, story.unit),
        unseen: rung.validation.map(|m| in_words(m.rmse, story.unit)),
    });
    rows.collect()
}

/// A parameter before and after the effects came.
#[derive(Debug, Serialize)]
pub struct MovedRow {
    name: String,
    before: Option<f64>,
    after: f64,
    unit: String,
}

/// The parameters of the model beside those of the base model.
pub fn moved_rows(story: &Story) -> Vec<MovedRow> {
    let b = &story.base.base;
    let before =
        [("gain", b.gain), ("tau_m", b.tau_m), ("tau_e", b.tau_e), ("viscous_share", b.viscous_share)];
    let was = |name: &str| before.iter().find(|(n, _)| *n == name).map(|(_, value)| rounded(*value, 5));
    let rows = story.parameters.iter().map(|e| MovedRow {
        before: was(&e.name),
        name: e.name.clone(),
        after: rounded(e.value, 5),
        unit: e.unit.clone(),
    });
    rows.collect()
}

/// The record table.
pub fn record_rows(story: &Story) -> Vec<RecordRow> {
    let rows = story.records.iter().map(|shown| {
        let run = &shown.model;
        let m = run.measures();
        let length = run.time_s.last().zip(run.time_s.first()).map_or(0.0, |(b, a)| b - a);
        RecordRow {
            name: run.record.clone(),
            role: if shown.unseen { "unseen" } else { "training" },
            samples: m.samples,
            seconds: rounded(length, 4),
            base: in_words(shown.base.measures().rmse, story.unit),
            model: in_words(m.rmse, story.unit),
            fit_percent: rounded(m.nrmse_fit_percent, 4),
        }
    });
    rows.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_taken_back_is_named_and_nothing_else_is_blamed() {
        let said = nothing_missing(true, &[Kind::DeadZone, Kind::Delay]);
        assert!(said.starts_with("dead_zone + delay would take"), "{said}");
        assert!(nothing_missing(true, &[]).starts_with("Nothing worth adding"));
        assert!(nothing_missing(false, &[]).contains("nothing more"));
    }
}
