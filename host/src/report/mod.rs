//! The report: one HTML file with everything inside it, that opens without a network.
//!
//! A [`Story`] is gathered once; each step of the work turns its part into [`figure::Figure`]s, which the page
//! draws with the plotting library that comes along. The live page shows the same figures.

pub mod decimate;
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
use serde::Serialize;
use serde_json::json;

pub use story::{Shown, Story, Suspect, Torques, faults, shown, title, torques};

use crate::atomic_file;
use crate::error::{Error, Result};
use figure::Figure;

/// How the pages look.
pub const STYLE: &str = include_str!("assets/style.css");
/// How figures are drawn in the colours of the page.
pub const PLOTS: &str = include_str!("assets/plots.js");
const PAGE: &str = include_str!("assets/report.html");

/// The plotting library, from the crate that embeds it.
pub fn plotting_library() -> &'static str {
    static LIBRARY: std::sync::LazyLock<String> = std::sync::LazyLock::new(|| {
        let sources = plotly::Plot::offline_js_sources();
        // The crate gives Plotly and a typesetter for formulas as two script elements; the first is Plotly.
        let begin = sources.find('>').map_or(0, |k| k + 1);
        let end = sources[begin..].find("</script>").map_or(sources.len(), |k| begin + k);
        sources[begin..end].to_owned()
    });
    &LIBRARY
}

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
    let compare = story.records.iter().enumerate().map(|(k, shown)| {
        let torques = [&story.base_torques.records[k], &story.model_torques.records[k]];
        records::figure(&format!("record-{k}"), shown, torques, story.floor, None)
    });
    let (cards, missing) = missing::cards(story);
    let figures = Figures {
        compare: compare.collect(),
        fails: fails::figures(story),
        missing,
        falls: vec![falls::figure(&story.ladder, story.floor, story.unit)],
    };
    (figures, cards)
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
    let fault = |e: minijinja::Error| Error::Io {
        doing: "cannot lay out the report".into(),
        source: std::io::Error::other(e),
    };
    environment.add_template("report", PAGE).map_err(fault)?;
    let template = environment.get_template("report").map_err(fault)?;
    let content = json!({
        "title": story.title,
        "summary": words::summary(story),
        "verdict": words::verdict(story),
        "figures": figures,
        "cards": cards,
        "nothing_missing": words::nothing_missing(story),
        "faults": story.faults,
        "parameters": words::estimate_rows(&story.parameters),
        "combinations": words::estimate_rows(&story.combinations),
        "records": words::record_rows(story),
        "version": env!("CARGO_PKG_VERSION"),
        "style": STYLE,
        "library": plotting_library(),
        "plots": PLOTS,
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
