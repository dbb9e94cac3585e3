//! The file that holds a user's effect.

use std::path::Path;

use motorlens_shared::effects::Kind;
use serde::Deserialize;
use toml::Spanned;

use super::definition::{Field, Written, WrittenParameter, Wrong};
use super::library::{Library, RENAME, define, two_called};
use crate::error::{BadInput, Result};
use crate::motor_file::{did_you_mean, unknown_key};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    name: Spanned<String>,
    port: Spanned<String>,
    formula: Spanned<String>,
    #[serde(default)]
    title: String,
    #[serde(default)]
    signature: String,
    #[serde(default)]
    source: String,
    #[serde(default)]
    parameter: Vec<RawParameter>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawParameter {
    name: Spanned<String>,
    #[serde(default = "one")]
    unit: String,
    #[serde(default)]
    meaning: String,
    low: f64,
    typical: f64,
    high: f64,
}

fn one() -> String {
    "1".into()
}

const KEYS: [&str; 12] = [
    "name",
    "port",
    "formula",
    "title",
    "signature",
    "source",
    "parameter",
    "unit",
    "meaning",
    "low",
    "typical",
    "high",
];

/// Reads the effect in a file.
///
/// # Errors
/// A file that cannot be read; what is wrong in it, with line and column.
pub fn read(path: &Path) -> Result<Kind> {
    read_beside(path, &Library::default())
}

/// The same where `library` is offered already.
///
/// # Errors
/// Also a name that another effect of `library` has.
pub(super) fn read_beside(path: &Path, library: &Library) -> Result<Kind> {
    let text = std::fs::read_to_string(path).map_err(|e| crate::log::cannot_read(path, &e))?;
    parse(path, &text, library)
}

fn parse(path: &Path, text: &str, library: &Library) -> Result<Kind> {
    let raw: Raw = toml::from_str(text).map_err(|e| {
        let why = e.message().lines().next().unwrap_or_default().to_owned();
        let (why, remedy) = match (unknown_key(&why), why.strip_prefix("missing field `")) {
            (Some(key), _) => (format!("the key \"{key}\" is unknown"), did_you_mean(key, &KEYS)),
            (None, Some(field)) => {
                let field = field.trim_end_matches('`');
                (format!("{field} is missing"), format!("add {field} = ..."))
            }
            _ => (why, "correct this line".to_owned()),
        };
        place(BadInput::new(path, why, remedy), text, e.span().map_or(0, |s| s.start))
    })?;
    let parameters = raw.parameter.iter().map(|p| WrittenParameter {
        name: p.name.get_ref().clone(),
        unit: p.unit.clone(),
        meaning: p.meaning.clone(),
        low: p.low,
        typical: p.typical,
        high: p.high,
    });
    let written = Written {
        name: raw.name.get_ref().clone(),
        port: raw.port.get_ref().clone(),
        formula: raw.formula.get_ref().clone(),
        title: raw.title.clone(),
        signature: raw.signature.clone(),
        source: raw.source.clone(),
        parameters: parameters.collect(),
    };
    let defined = define(&written).and_then(|kind| {
        if !library.has_another(kind) {
            return Ok(kind);
        }
        Err(Wrong { field: Field::Name, why: two_called(&written.name), remedy: RENAME.into() })
    });
    defined.map_err(|Wrong { field, why, remedy }| {
        let start = match field {
            Field::Name => raw.name.span().start,
            Field::Port => raw.port.span().start,
            // Behind the quotation mark; a formula over several lines has its own count of columns.
            Field::Formula(at) => raw.formula.span().start + opening(&text[raw.formula.span()]) + at,
            Field::Parameter(k) => raw.parameter[k].name.span().start,
        };
        place(BadInput::new(path, why, remedy), text, start).into()
    })
}

/// Length of the quotation marks before a string.
fn opening(quoted: &str) -> usize {
    if quoted.starts_with("\"\"\"") || quoted.starts_with("'''") { 3 } else { 1 }
}

fn place(fault: BadInput, text: &str, start: usize) -> BadInput {
    let before = text.get(..start.min(text.len())).unwrap_or(text);
    let line = before.matches('\n').count() as u64 + 1;
    let character = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    fault.at_line(line).at_character(character)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FAN: &str = "name = \"test_fan\"\nport = \"torque\"\nformula = \"-drag * speed * abs(speed)\"\n\
                       [[parameter]]\nname = \"drag\"\nunit = \"V s^2/rad^2\"\nlow = 0\ntypical = 0.01\nhigh = 1\n";

    fn parse(path: &Path, text: &str) -> Result<Kind> {
        super::parse(path, text, &Library::default())
    }

    #[test]
    fn a_file_gives_an_effect_with_its_row_and_reading_it_again_gives_the_same() {
        let kind = parse(Path::new("fan.toml"), FAN).unwrap();
        assert_eq!(kind.name(), "test_fan");
        assert_eq!(kind.spec().parameters[0].high, 1.0);
        assert!(kind.spec().probes.iter().all(|p| p.len() == 1 && p[0] >= 0.0));
        assert_eq!(parse(Path::new("fan.toml"), FAN).unwrap(), kind);
    }

    #[test]
    fn a_formula_repeats_with_the_turns_where_it_takes_the_sine_of_what_depends_on_an_angle() {
        for (formula, is_periodic) in [
            ("-drag * sin(angle)", true),
            ("drag * (1 + cos(3 * motor_angle + 0.5))", true),
            ("drag * tan(max(angle, 0.1))", true),
            ("-drag * angle", false),
            ("drag * sin(time) * angle", false),
            ("-drag * speed * abs(speed)", false),
        ] {
            let text = FAN.replace("test_fan", "test_turns").replace("-drag * speed * abs(speed)", formula);
            assert_eq!(
                parse(Path::new("turns.toml"), &text).unwrap().spec().periodic,
                is_periodic,
                "{formula}"
            );
        }
    }

    #[test]
    fn two_callers_may_describe_different_effects_by_one_name() {
        let (ours, theirs) = (Path::new("ours.toml"), Path::new("theirs.toml"));
        assert_ne!(parse(ours, FAN).unwrap(), parse(theirs, &FAN.replace("0.01", "0.02")).unwrap());
    }

    #[test]
    fn what_is_wrong_is_named_with_line_and_column() {
        for (from, to, place, cause, remedy) in [
            ("speed * abs", "sped * abs", "line 3, column 20", "sped is neither", "did you mean speed?"),
            ("\"torque\"", "\"torqe\"", "line 2, column 8", "no port", "friction"),
            ("\"test_fan\"", "\"coulomb\"", "line 1, column 8", "already", "another name"),
            ("low = 0", "low = 2", "line 5, column 8", "not below high", "unit"),
            ("unit =", "units =", "line 6", "\"units\" is unknown", "did you mean unit?"),
            ("high = 1\n", "", "line 4", "high is missing", "add high"),
            ("-drag * speed * abs(speed)", "-drag * sign(speed)", "line 3, column 20", "chatter", "friction"),
            ("-drag * speed * abs(speed)", "speed", "line 5, column 8", "does not use", "remove it"),
        ] {
            let text =
                FAN.replace("test_fan", "test_other").replace(&from.replace("test_fan", "test_other"), to);
            let shown = parse(Path::new("fan.toml"), &text).unwrap_err().to_string();
            assert!(shown.starts_with(&format!("fan.toml, {place}")), "{shown}");
            assert!(shown.contains(cause) && shown.contains(remedy), "{shown}");
        }
    }
}
