//! The report: one HTML file with everything inside it, that opens without a network.
//!
//! A [`Story`] is gathered once; each step of the work turns its part into [`figure::Figure`]s, which the page
//! draws with the plotting library that comes along. The live page shows the same figures.

pub mod decimate;
pub mod evidence;
pub mod fails;
pub mod falls;
pub mod figure;
pub mod missing;
pub mod records;
mod story;
pub mod words;

use std::path::Path;

use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment};
use motorlens_shared::effects::Kind;
use serde::Serialize;
use serde_json::json;

pub use story::{DRAWN, Shown, Story, Suspect, Torques, title, torques};

use crate::atomic_file;
use crate::error::{Error, Result};
use crate::glossary;
use crate::log::Warning;
use crate::sentence::listed;
use figure::Figure;

/// How the pages look.
pub const STYLE: &str = include_str!("assets/style.css");
/// How figures are drawn in the colours of the page.
pub const PLOTS: &str = include_str!("assets/plots.js");
/// The strip below a record that shows which part of it is looked at.
pub const OVERVIEW: &str = include_str!("assets/overview.js");
const PAGE: &str = include_str!("assets/report.html");

/// The plotting library, uPlot 1.6.32 (MIT), which comes along with its licence.
pub const LIBRARY: &str = include_str!("assets/uplot/uPlot.iife.min.js");

/// What the plotting library wants of the style sheet.
pub const LIBRARY_STYLE: &str = include_str!("assets/uplot/uPlot.min.css");

/// The figures of every step.
#[derive(Debug, Serialize)]
pub struct Figures {
    /// Step 1, one a record.
    pub compare: Vec<Figure>,
    /// Step 2.
    pub fails: Vec<Figure>,
    /// Step 3, those of the cards.
    pub missing: Vec<Figure>,
    /// Step 5.
    pub falls: Vec<Figure>,
}

/// Figures and cards of `story`.
pub fn figures(story: &Story) -> (Figures, Vec<missing::Card>) {
    let compare = story.records.iter().enumerate();
    let compare = compare.map(|(k, shown)| records::whole(&format!("record-{k}"), shown, story.floor));
    let shown: Vec<&Shown> = story.records.iter().collect();
    let torques = [&story.base_torques, &story.model_torques];
    let setting = missing::Setting { rivals: &story.rivals, in_model: in_model(story) };
    let (cards, missing) = missing::cards(&story.suspects, &setting);
    let figures = Figures {
        compare: compare.collect(),
        fails: fails::figures(&shown, torques, story.model.rig.gear_ratio),
        missing,
        falls: vec![ladder(story).figure()],
    };
    (figures, cards)
}

/// Effects of the model.
fn in_model(story: &Story) -> Vec<Kind> {
    story.model.effects.iter().map(|e| e.effect).collect()
}

fn ladder(story: &Story) -> falls::Ladder<'_> {
    falls::Ladder {
        rungs: &story.ladder,
        rises: &story.rises,
        baseline: story.baseline.as_ref(),
        noise: story.floor,
        unit: story.unit,
    }
}

/// The effects of `set`, as users type them.
fn in_a_sentence(set: &[Kind]) -> String {
    listed(&set.iter().map(|kind| kind.name()).collect::<Vec<_>>())
}

/// Data problems as people read them.
fn told(faults: &[Warning]) -> Vec<Warning> {
    faults.iter().map(|fault| Warning { what: fault.told(), ..fault.clone() }).collect()
}

/// The report as HTML.
///
/// # Errors
/// None that a user can cause; a fault of the template is reported as the machine's.
pub fn html(story: &Story) -> Result<String> {
    let (figures, cards) = figures(story);
    // "</" would end the script element that carries the data.
    let data = serde_json::to_string(&figures).unwrap_or_default().replace("</", "<\\/");
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_filter("brief", words::brief);
    environment.add_filter("unbroken", words::unbroken);
    let fault = |e: minijinja::Error| Error::Io {
        doing: "cannot lay out the report".into(),
        source: std::io::Error::other(e),
    };
    environment.add_template("report", PAGE).map_err(fault)?;
    let template = environment.get_template("report").map_err(fault)?;
    let style = [LIBRARY_STYLE, STYLE].concat();
    let content = json!({
        "title": story.title,
        "summary": words::summary(&story.ladder, story.floor, story.unit, &story.standing),
        "standing": story.standing,
        "headline": words::first_sentence(&story.standing.headline),
        "figures": figures,
        "cards": cards,
        "nothing_missing": words::nothing_missing(story.model.effects.is_empty()),
        "faults": told(&story.faults),
        "parameters": words::estimate_rows(&story.parameters, &in_model(story)),
        "combinations": words::estimate_rows(&story.combinations, &in_model(story)),
        "records": words::record_rows(story),
        "rivals": story.rivals.iter().map(|set| in_a_sentence(set)).collect::<Vec<_>>(),
        "next": story.next,
        "rungs": ladder(story).rows(),
        "terms": glossary::terms(&in_model(story)),
        "words": glossary::WORDS,
        "equations": glossary::BASE_EQUATIONS,
        "moved": words::moved_rows(story),
        "version": env!("CARGO_PKG_VERSION"),
        "style": style,
        "library": LIBRARY,
        "plots": PLOTS,
        "overview": OVERVIEW,
        "data": data,
    });
    template.render(Serde(&content)).map_err(fault)
}

/// Writes the report to `path`, whole or not at all.
///
/// # Errors
/// The file cannot be written.
pub fn write(story: &Story, path: &Path) -> Result<()> {
    atomic_file::write(path, html(story)?)
}

#[cfg(test)]
mod tests;
