//! A field of the mapping dialogue: what may stand in it, and what that says of how a log is read.

use clap::{Arg, Command};
use serde_json::{Value, json};

use crate::error::{Error, Result};
use crate::log::ReadOptions;
use crate::log::mapping::Mapping;

/// A field of the dialogue.
pub struct Field {
    /// The option of the command line that says the same, or the key of the motor file, with underscores.
    pub name: &'static str,
    /// What stands beside it.
    pub label: &'static str,
    /// What it shows while it is empty.
    pub empty: &'static str,
    /// Whether few logs need it: then it is folded away.
    pub is_rare: bool,
    /// What it is for; none where the help of its option says it.
    pub help: Option<&'static str>,
    /// What may stand in it.
    pub holds: Holds,
}

/// What may stand in a field.
pub enum Holds {
    /// A positive number.
    Number {
        /// Whether 0 may stand there.
        or_zero: bool,
        /// Where it is kept.
        place: fn(&mut ReadOptions) -> &mut Option<f64>,
    },
    /// One of these values, each with its words; the first is empty.
    Choice {
        /// Value and words.
        choices: &'static [(&'static str, &'static str)],
        /// Which of them options say; none where that is the first.
        said: fn(&ReadOptions) -> Option<String>,
        /// Lets options say one of them.
        say: fn(&mut ReadOptions, &str),
    },
    /// Which rows of the table are read, as a mapping says it behind `only=`.
    Rows,
}

/// A number above 0.
pub const fn positive(place: fn(&mut ReadOptions) -> &mut Option<f64>) -> Holds {
    Holds::Number { or_zero: false, place }
}

impl Field {
    /// What `options` say of it, as the field shows it.
    pub fn said(&self, options: &ReadOptions) -> Option<String> {
        match &self.holds {
            // The place is one to write to, so it is that of a copy.
            Holds::Number { place, .. } => place(&mut options.clone()).map(|value| value.to_string()),
            Holds::Choice { said, .. } => said(options),
            Holds::Rows => {
                let only = options.map.as_ref().and_then(Mapping::only);
                only.map(|only| format!("{}:{}", only.column, only.value))
            }
        }
    }

    /// Lets `options` say what stands in the field; an empty one says nothing.
    ///
    /// # Errors
    /// What cannot stand there, with the field's label.
    pub fn say(&self, options: &mut ReadOptions, text: &str) -> Result<()> {
        let text = text.trim();
        let refused = |remedy: &str| {
            Error::usage(format!("\"{}\" is \"{text}\"", self.label), format!("{remedy}, or leave it empty"))
        };
        match &self.holds {
            Holds::Number { or_zero, place } => {
                let fits = |value: &f64| value.is_finite() && (*value > 0.0 || *or_zero && *value == 0.0);
                let value = text.parse::<f64>().ok().filter(fits);
                if value.is_none() && !text.is_empty() {
                    let wanted =
                        if *or_zero { "give a number of 0 or more" } else { "give a positive number" };
                    return Err(refused(wanted));
                }
                *place(options) = value;
            }
            Holds::Choice { choices, say, .. } => {
                if choices.iter().all(|(value, _)| *value != text) {
                    let known: Vec<&str> = choices.iter().skip(1).map(|(value, _)| *value).collect();
                    return Err(refused(&format!("take {}", known.join(" or "))));
                }
                say(options, text);
            }
            Holds::Rows => {
                if text.is_empty() {
                    return Ok(());
                }
                let mapping = format!("only={text}").parse::<Mapping>().ok().filter(|_| !text.contains(','));
                let only = mapping.as_ref().and_then(Mapping::only).cloned().ok_or_else(|| {
                    refused("give a column, a colon and the value that it has there, such as id:3")
                })?;
                options.map = Some(options.map.take().unwrap_or_default().with_only(only));
            }
        }
        Ok(())
    }

    /// What it is for; `reading` has the options of the command line.
    pub fn help(&self, reading: &Command) -> String {
        let of_option = || {
            let option = reading.get_arguments().find(|option| *option.get_id() == self.name);
            option.and_then(Arg::get_help).map(ToString::to_string)
        };
        self.help.map(str::to_owned).or_else(of_option).unwrap_or_default()
    }

    /// As the page's template takes it.
    pub fn to_json(&self, reading: &Command) -> Value {
        let (lowest, choices) = match &self.holds {
            Holds::Number { or_zero, .. } => (Some(if *or_zero { "0" } else { "1e-9" }), None),
            Holds::Choice { choices, .. } => (None, Some(*choices)),
            Holds::Rows => (None, None),
        };
        json!({ "name": self.name, "id": self.name.replace('_', "-"), "label": self.label, "empty": self.empty,
                "rare": self.is_rare, "help": self.help(reading), "lowest": lowest, "choices": choices })
    }
}
