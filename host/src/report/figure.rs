//! A plot as data: traces and layout of Plotly, with colours named by their role.
//!
//! The page turns roles into colours of its light or dark scheme, so a figure is drawn alike in the report file
//! and in the live page.

use serde::Serialize;
use serde_json::{Value, json};

use super::decimate::rounded;

/// A plot with the line that says what it shows.
#[derive(Debug, Clone, Serialize)]
pub struct Figure {
    /// Name in the page.
    pub id: String,
    /// Heading.
    pub title: String,
    /// What it shows, in one line.
    pub reading: String,
    /// Plotly's traces.
    pub data: Vec<Value>,
    /// Plotly's layout; the page adds colours and fonts.
    pub layout: Value,
    /// Height on the screen, CSS pixels.
    pub height: u32,
}

/// Numbers as the page gets them.
pub fn numbers(values: impl IntoIterator<Item = f64>, digits: i32) -> Value {
    values.into_iter().map(|v| rounded(v, digits)).collect::<Vec<_>>().into()
}

/// A line in the colour of `role`, with its legend.
pub fn line(role: &str, name: &str, x: Value, y: Value) -> Value {
    json!({ "type": "scatter", "mode": "lines", "name": name, "x": x, "y": y, "meta": { "role": role } })
}

/// `trace` with more settings.
pub fn with(mut trace: Value, more: Value) -> Value {
    if let (Some(trace), Value::Object(more)) = (trace.as_object_mut(), more) {
        trace.extend(more);
    }
    trace
}

/// A layout of one pair of axes with these titles.
pub fn axes(x: &str, y: &str) -> Value {
    json!({
        "xaxis": { "title": { "text": x } },
        "yaxis": { "title": { "text": y } },
        "hovermode": "x unified",
    })
}

/// `x` with four digits and its unit, small or large numbers with a prefix.
pub fn in_words(x: f64, unit: &str) -> String {
    let (scale, prefix) = match x.abs() {
        a if a == 0.0 || a >= 0.1 => (1.0, ""),
        a if a >= 1e-4 => (1e3, "m"),
        _ => (1e6, "µ"),
    };
    // A prefix only fits a unit that is one symbol, or begins with one.
    if unit == "1" || unit.is_empty() {
        return format!("{}", rounded(x, 3));
    }
    format!("{} {prefix}{unit}", rounded(x * scale, 3))
}
