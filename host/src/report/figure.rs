//! A plot as data: panels of curves over one horizontal axis, with colours named by their role.
//!
//! The page turns roles into colours of its light or dark scheme and draws with its plotting library, so a figure
//! looks alike in the report file and in the live page, and nothing here knows how it is drawn.

use serde::{Serialize, Serializer};

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
    /// Share of the residual's variance that it accounts for, percent, where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share_percent: Option<f64>,
    /// The horizontal axis of all panels.
    pub x: Axis,
    /// The part of it that is looked at first, where all of it at once would be too dense.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first: Option<[f64; 2]>,
    /// Places along it; a curve says on which of these columns it lies.
    pub columns: Vec<Numbers>,
    /// From top to bottom.
    pub panels: Vec<Panel>,
}

impl Figure {
    /// Whether there is nothing to draw, so that the words stand alone.
    pub fn is_empty(&self) -> bool {
        self.columns.iter().all(|column| column.values.is_empty())
    }

    /// A figure without panels yet.
    pub fn titled(id: impl Into<String>, title: impl Into<String>, reading: String) -> Self {
        let (id, title) = (id.into(), title.into());
        Self {
            id,
            title,
            reading,
            share_percent: None,
            x: Axis::default(),
            first: None,
            columns: Vec::new(),
            panels: Vec::new(),
        }
    }
}

/// An axis.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Axis {
    /// With the unit in brackets.
    pub title: String,
    /// Lowest and highest value shown; else what the curves need.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Distance of the marks; else what fits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
    /// Whether it is logarithmic.
    pub log: bool,
    /// What the places 0, 1, 2... are called, where they are no numbers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<String>,
}

impl Axis {
    /// An axis that shows what its curves need.
    pub fn titled(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// An axis of the angles `at`, degrees, in order: the turn from 0 to 360 where they fill most of it, else what they need.
    pub fn of_angles(title: impl Into<String>, at: &[f64]) -> Self {
        let fills = |low: f64, high: f64| low >= 0.0 && high <= 360.0 && high - low > 180.0;
        match at {
            [low, .., high] if fills(*low, *high) => {
                Self { range: Some([0.0, 360.0]), step: Some(60.0), ..Self::titled(title) }
            }
            _ => Self::titled(title),
        }
    }
}

/// Curves over one vertical axis.
#[derive(Debug, Clone, Serialize)]
pub struct Panel {
    /// The vertical axis.
    pub y: Axis,
    /// Height on the screen, CSS pixels.
    pub height: u32,
    /// Drawn in this order.
    pub curves: Vec<Curve>,
    /// Values between which noise lies; two equal ones are a line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub floor: Option<[f64; 2]>,
}

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Draw {
    /// Straight from point to point.
    Line,
    /// The same, with the points marked.
    Dotted,
    /// Held until the next point.
    Steps,
    /// Points alone, rings.
    Points,
    /// Points alone, many and small.
    Dots,
    /// Bars from the bottom, each with its value in words.
    Bars,
}

/// A curve.
#[derive(Debug, Clone, Serialize)]
pub struct Curve {
    /// What it is, which decides its colour: measured, base, model, voltage, floor.
    pub role: &'static str,
    /// Name in the legend.
    pub name: String,
    /// Which of the figure's columns it lies on.
    pub on: usize,
    /// Its values.
    pub y: Numbers,
    /// How it is drawn.
    pub draw: Draw,
    /// Half the width of the band around it, where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spread: Option<Numbers>,
    /// What the sliders of the live page call it, where they move it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slide: Option<&'static str>,
    /// Each point in words, where they stand beside it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub words: Vec<String>,
}

impl Curve {
    /// A line on the figure's column `on`.
    pub fn line(role: &'static str, name: impl Into<String>, on: usize, y: Numbers) -> Self {
        let draw = Draw::Line;
        Self { role, name: name.into(), on, y, draw, spread: None, slide: None, words: Vec::new() }
    }
}

/// A column of numbers, rounded to what a screen can show.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Numbers {
    values: Vec<f64>,
    digits: i32,
}

impl Numbers {
    /// `values` with so many significant digits.
    pub fn new(values: impl IntoIterator<Item = f64>, digits: i32) -> Self {
        Self { values: values.into_iter().collect(), digits }
    }

    /// The values as they were given.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}

impl Serialize for Numbers {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(self.values.iter().map(|v| rounded(*v, self.digits)))
    }
}

/// `x` with three digits and its unit, small or large numbers with a prefix.
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

/// What an error does, in the present: falls, rises, or stays.
pub const NOW: [&str; 3] = ["falls", "rises", "stays"];
/// The same in the past.
pub const PAST: [&str; 3] = ["fell", "rose", "stayed"];

/// How an error went from `before` to `after`, with the words of `NOW` or `PAST`; what is the same in three digits stays.
pub fn change_in_words(before: f64, after: f64, unit: &str, [falls, rises, stays]: [&str; 3]) -> String {
    let [old, new] = [before, after].map(|error| in_words(error, unit));
    if old == new {
        return format!("{stays} at {old}");
    }
    let way = if after > before { rises } else { falls };
    format!("{way} from {old} to {new}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_have_the_axis_of_a_turn_only_where_they_fill_most_of_it() {
        let range = |at: &[f64]| Axis::of_angles("Angle (deg)", at).range;
        assert_eq!(range(&[4.0, 180.0, 356.0]), Some([0.0, 360.0]));
        assert_eq!(range(&[-100.0, 0.0, 95.0]), None);
        assert_eq!(range(&[1.0, 20.0]), None);
        assert_eq!(range(&[]), None);
    }
}
