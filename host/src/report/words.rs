//! The words and tables of a report.

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::falls::{judged, judged_on};
use super::figure::{PAST, change_in_words, in_words};
use super::story::Story;
use crate::diagnose::ladder::Rung;
use crate::findings::{Action, Standing, Yardstick};
use crate::fit::uncertainty::Estimate;
use crate::glossary;
use crate::report::decimate::rounded;

/// A row of the tables of parameters and of combinations.
#[derive(Debug, Serialize)]
pub struct EstimateRow {
    name: String,
    meaning: String,
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

/// A number as a table shows it: a whole one without decimals.
pub fn brief(number: f64) -> String {
    // The sum has no negative zero.
    (number + 0.0).to_string()
}

/// `text` in which no line begins with the unit of the number before it.
pub fn unbroken(text: &str) -> String {
    let mut told = String::with_capacity(text.len());
    for (k, word) in text.split(' ').enumerate() {
        let is_unit = ["%", "x"].contains(&word.trim_end_matches([',', ';', '.']))
            || word.contains(')') && !word.contains('(');
        if k > 0 {
            let joins = is_unit && told.ends_with(|c: char| c.is_ascii_digit());
            told.push(if joins { '\u{a0}' } else { ' ' });
        }
        told += word;
    }
    told
}

/// The first sentence of a headline, which is its verdict, and what is said beside that.
pub fn first_sentence(headline: &str) -> (&str, &str) {
    let mut ends = headline.match_indices(". ").map(|(dot, _)| dot + 1);
    let begins = |end: &usize| headline[*end..].trim_start().starts_with(char::is_uppercase);
    let end = ends.find(begins).unwrap_or(headline.len());
    (&headline[..end], headline[end..].trim_start())
}

/// The errors behind `standing`, in the measured unit.
pub fn summary(ladder: &[Rung], floor: f64, unit: &'static str, standing: &Standing) -> String {
    // Beside a headline that doubts the last step, all steps together would praise it.
    let doubted = [Some(&standing.next), standing.also.as_ref()]
        .into_iter()
        .flatten()
        .any(|step| step.action == Action::Remove);
    let ladder = if doubted { &ladder[ladder.len().saturating_sub(2)..] } else { ladder };
    let (Some(first), Some(last)) = (ladder.first(), ladder.last()) else { return String::new() };
    let (before, after) = (judged(first).rmse, judged(last).rmse);
    let on = judged_on(last);
    let noise = Yardstick::new(floor, &judged(last), unit).noise_in_words();
    if last.effects.is_empty() {
        return format!(
            "Simulation error of the base model on {on}: {} rms; {noise}.",
            in_words(before, unit)
        );
    }
    format!("The simulation error on {on} {} rms; {noise}.", change_in_words(before, after, unit, PAST))
}

/// Said where no effect is worth adding: to a model without any (`plain`), or with some.
pub fn nothing_missing(plain: bool) -> &'static str {
    if plain {
        "No effect of the library predicts blocks held out better than the base model."
    } else {
        "With these effects in the model no further one is worth its parameters."
    }
}

/// Said of a parameter of which the records leave open what it is.
pub const NOT_DETERMINED: &str = "not determined";

/// Whether the ends of the interval of `e` tell anything: those of a parameter that the records do not determine may be any numbers.
pub fn has_interval(e: &Estimate) -> bool {
    e.identifiable && e.low.is_finite() && e.high.is_finite()
}

fn interval(e: &Estimate) -> String {
    if has_interval(e) {
        format!("{} … {}", rounded(e.low, 4), rounded(e.high, 4))
    } else {
        NOT_DETERMINED.to_owned()
    }
}

/// A unit in a table; a plain number has none.
pub fn unit(unit: &str) -> &str {
    if unit == "1" { "" } else { unit }
}

/// Parameters or combinations of a model of these effects, with their intervals.
pub fn estimate_rows(estimates: &[Estimate], effects: &[Kind]) -> Vec<EstimateRow> {
    let terms = glossary::terms(effects);
    let meaning = |name: &str| {
        let term = terms.iter().find(|t| t.name == name);
        term.map_or(String::new(), |t| format!("{}. {}", t.meaning, t.equation))
    };
    let rows = estimates.iter().map(|e| EstimateRow {
        meaning: meaning(&e.name),
        name: e.name.clone(),
        value: rounded(e.value, 5),
        interval: interval(e),
        unit: unit(&e.unit).to_owned(),
        identifiable: if e.identifiable { "yes" } else { "no" },
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
        unit: unit(&e.unit).to_owned(),
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
            role: if shown.unseen { "validation" } else { "fit" },
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
    use crate::findings::NextStep;

    #[test]
    fn a_headline_is_its_first_sentence_and_a_decimal_point_ends_none() {
        let said = first_sentence(
            "Gravity (1.3 V) explains 98 %; what is left is 2.2 x the noise. The size supposes 5 V.",
        );
        assert_eq!(said.0, "Gravity (1.3 V) explains 98 %; what is left is 2.2 x the noise.");
        assert_eq!(said.1, "The size supposes 5 V.");
        assert_eq!(first_sentence("Nothing to say"), ("Nothing to say", ""));
    }

    #[test]
    fn whole_numbers_have_no_decimals_and_no_line_begins_with_a_unit() {
        assert_eq!([3.0, -0.0, 0.37434, 11362.0].map(brief), ["3", "0", "0.37434", "11362"]);
        assert_eq!(
            unbroken("Stribeck (1.26 V), delay (35 ms) explain 72 %; 8.1 x the noise in run 2 (old)"),
            "Stribeck (1.26\u{a0}V), delay (35\u{a0}ms) explain 72\u{a0}%; 8.1\u{a0}x the noise in run 2 (old)"
        );
    }

    #[test]
    fn an_error_that_is_the_same_in_three_digits_stays() {
        assert_eq!(change_in_words(0.36304, 0.36296, "rad", PAST), "stayed at 0.363 rad");
        assert_eq!(change_in_words(0.363, 0.364, "rad", PAST), "rose from 0.363 rad to 0.364 rad");
        assert_eq!(change_in_words(0.363, 0.0123, "rad", PAST), "fell from 0.363 rad to 12.3 mrad");
    }

    #[test]
    fn a_doubted_step_is_not_praised_with_what_the_steps_before_it_gained() {
        let rung = |effects: &[Kind], rmse| Rung::leaving(effects, rmse, None);
        let ladder =
            [rung(&[], 3.04), rung(&[Kind::Delay], 0.7), rung(&[Kind::Delay, Kind::Stribeck], 0.789)];
        let plain = Standing::simulated(&ladder[2].train, 0.1, &[], "");
        assert!(summary(&ladder, 0.1, "rad", &plain).contains("fell from 3.04 rad to 0.789 rad"));
        let next = NextStep::new(Action::Remove, Some(Kind::Stribeck));
        let doubted = Standing { next, ..plain };
        assert!(summary(&ladder, 0.1, "rad", &doubted).contains("rose from 0.7 rad to 0.789 rad"));
    }
}
