//! The fields of the mapping dialogue beside the columns: what the command line says of a log by its options, and the motor file of its motor.
//!
//! A row of [`FIELDS`] is all that a field takes: the page is laid out with it, requests are read by it, and advice that names its option or its key
//! is told on the page by its label.

use clap::{Args, Command, ValueEnum};
use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment};
use serde_json::{Value, json};

use super::field::{Field, Holds, positive};
use crate::error::{Error, Result};
use crate::log::{EncoderShaft, Format, ReadArgs};

/// All fields, in the order in which the page has them.
pub static FIELDS: [Field; 14] = [
    Field {
        name: "gear_ratio",
        label: "Gear ratio",
        empty: "unknown",
        is_rare: false,
        help: Some("Turns of the motor per turn of the output shaft"),
        holds: positive(|options| &mut options.motor.gear_ratio),
    },
    Field {
        name: "encoder_shaft",
        label: "Encoder sits on",
        empty: "",
        is_rare: false,
        help: Some("The shaft with each turn of which a fault of the encoder's disc comes again"),
        holds: Holds::Choice {
            choices: &[("", "motor shaft"), ("output", "output shaft")],
            said: |options| {
                let shaft = options.motor.encoder_shaft.filter(|shaft| *shaft == EncoderShaft::Output);
                shaft.map(|shaft| shaft.to_string())
            },
            say: |options, text| options.motor.encoder_shaft = text.parse().ok(),
        },
    },
    Field {
        name: "counts_per_rev",
        label: "Counts per output turn",
        empty: "unknown",
        is_rare: false,
        help: None,
        holds: positive(|options| &mut options.motor.counts_per_rev),
    },
    Field {
        name: "metres_per_rev",
        label: "Metres per output turn",
        empty: "linear axes",
        is_rare: false,
        help: None,
        holds: positive(|options| &mut options.motor.metres_per_rev),
    },
    Field {
        name: "rate",
        label: "Samples per second",
        empty: "without times",
        is_rare: false,
        help: None,
        holds: positive(|options| &mut options.rate_hz),
    },
    Field {
        name: "supply_volts",
        label: "Supply (V), for a duty",
        empty: "",
        is_rare: false,
        help: None,
        holds: positive(|options| &mut options.supply_volts),
    },
    Field {
        name: "voltage_lead",
        label: "Voltage acts before its row by (s)",
        empty: "",
        is_rare: true,
        help: None,
        holds: positive(|options| &mut options.voltage_lead_s),
    },
    Field {
        name: "hold",
        label: "Voltage between two rows",
        empty: "",
        is_rare: true,
        help: None,
        holds: Holds::Choice {
            choices: &[
                ("", "stays, if the log says nothing else"),
                ("zero", "stays until the next row"),
                ("first", "runs straight to the next row"),
            ],
            said: |options| options.hold.as_ref().and_then(written),
            say: |options, text| options.hold = text.parse().ok(),
        },
    },
    Field {
        name: "servo_gain",
        label: "Servo gain (duty per rad)",
        empty: "by the motion",
        is_rare: true,
        help: None,
        holds: positive(|options| &mut options.servo_gain),
    },
    Field {
        name: "servo_damping",
        label: "Servo damping (duty per rad/s)",
        empty: "by the motion",
        is_rare: true,
        help: None,
        holds: Holds::Number { or_zero: true, place: |options| &mut options.servo_damping },
    },
    Field {
        name: "only",
        label: "Only the rows of",
        empty: "id:3",
        is_rare: true,
        help: Some(
            "Of a table with the rows of several motors those of one: the column that tells them apart, a colon, and what stands there",
        ),
        holds: Holds::Rows,
    },
    Field {
        name: "format",
        label: "Layout of the file",
        empty: "",
        is_rare: true,
        help: None,
        holds: Holds::Choice {
            choices: &[
                ("", "as its content tells"),
                ("wpilib-sysid", "WPILib's SysId"),
                ("bam-json", "Rhoban's BAM"),
            ],
            said: |options| written(&options.format).filter(|_| options.format != Format::default()),
            say: |options, text| options.format = Format::from_str(text, false).unwrap_or_default(),
        },
    },
    Field {
        name: "resistance_ohm",
        label: "Winding resistance (Ohm)",
        empty: "unknown",
        is_rare: true,
        help: Some("By the data sheet; with the inductance it tells how late the current is"),
        holds: positive(|options| &mut options.motor.nameplate.resistance_ohm),
    },
    Field {
        name: "inductance_h",
        label: "Winding inductance (H)",
        empty: "unknown",
        is_rare: true,
        help: Some("By the data sheet"),
        holds: positive(|options| &mut options.motor.nameplate.inductance_h),
    },
];

/// The value of an option as the command line writes it.
fn written<V: ValueEnum>(value: &V) -> Option<String> {
    value.to_possible_value().map(|value| value.get_name().to_owned())
}

/// The options by which the command line reads logs.
fn reading() -> Command {
    ReadArgs::augment_args(Command::new("motorlens"))
}

/// The page of this `template`, with all fields in its dialogue.
///
/// # Errors
/// None that a user can cause; a fault of the template is reported as the machine's.
pub fn laid_out(template: &str) -> Result<String> {
    let fault = |e: minijinja::Error| Error::Io {
        doing: "cannot lay out the page".into(),
        source: std::io::Error::other(e),
    };
    let reading = reading();
    let fields: Vec<Value> = FIELDS.iter().map(|field| field.to_json(&reading)).collect();
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.render_str(template, Serde(&json!({ "fields": fields }))).map_err(fault)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::ReadOptions;

    fn field(name: &str) -> &'static Field {
        FIELDS.iter().find(|field| field.name == name).unwrap()
    }

    #[test]
    fn every_option_of_reading_has_a_field_or_another_place_on_the_page() {
        // The choices below the columns, the fields of the motor file, the roles of the records and what is brushed out of them.
        const ELSEWHERE: [&str; 5] = ["map", "motor", "validate", "skip", "judge_by"];
        for option in reading().get_arguments() {
            let name = option.get_id().as_str();
            let is_field = FIELDS.iter().any(|field| field.name == name);
            assert!(is_field != ELSEWHERE.contains(&name), "{name}");
        }
    }

    #[test]
    fn every_field_is_laid_out_with_its_label_and_the_help_of_its_option() {
        let page = laid_out(include_str!("assets/page.html")).unwrap();
        for field in &FIELDS {
            let id = format!("id=\"log-{}\" name=\"{}\"", field.name.replace('_', "-"), field.name);
            assert_eq!(page.matches(&id).count(), 1, "{id}");
            // What the template escapes is left out.
            let shown = |text: &str| page.contains(text.split(['\'', '"', '/', '<', '&']).next().unwrap());
            let help = field.help(&reading());
            assert!(!help.is_empty() && shown(&help) && shown(field.label), "{help}");
        }
        assert!(page.contains("How many seconds before its row a voltage acts"));
        assert!(!page.contains("{{") && !page.contains("{%"));
    }

    #[test]
    fn a_field_says_what_it_was_told_and_shows_it_again() {
        for (name, text) in [
            ("gear_ratio", "50"),
            ("encoder_shaft", "output"),
            ("counts_per_rev", "1320"),
            ("metres_per_rev", "0.008"),
            ("rate", "100"),
            ("supply_volts", "11.1"),
            ("voltage_lead", "0.008"),
            ("hold", "first"),
            ("hold", "zero"),
            ("servo_gain", "2.5"),
            ("servo_damping", "0"),
            ("only", "id:3"),
            ("format", "bam-json"),
            ("resistance_ohm", "2.2"),
            ("inductance_h", "0.0005"),
        ] {
            let mut options = ReadOptions::default();
            field(name).say(&mut options, &format!(" {text} ")).unwrap();
            assert_ne!(options, ReadOptions::default(), "{name}");
            assert_eq!(field(name).said(&options).as_deref(), Some(text), "{name}");
            if name != "only" {
                field(name).say(&mut options, "").unwrap();
                assert_eq!(options, ReadOptions::default(), "{name}");
            }
        }
        assert!(FIELDS.iter().all(|field| field.said(&ReadOptions::default()).is_none()));
    }

    #[test]
    fn what_cannot_stand_in_a_field_is_refused_with_its_label_and_what_can() {
        for (name, text, said) in [
            ("voltage_lead", "-0.008", "\"Voltage acts before its row by (s)\" is \"-0.008\""),
            ("voltage_lead", "0", "give a positive number, or leave it empty"),
            ("voltage_lead", "8 ms", "\"8 ms\""),
            ("supply_volts", "inf", "\"Supply (V), for a duty\" is \"inf\""),
            ("servo_damping", "-1", "give a number of 0 or more"),
            ("hold", "second", "take zero or first, or leave it empty"),
            ("encoder_shaft", "wheel", "\"Encoder sits on\" is \"wheel\""),
            ("format", "xml", "take wpilib-sysid or bam-json"),
            ("only", "id", "such as id:3"),
            ("only", "id:3,voltage=u", "\"Only the rows of\""),
        ] {
            let mut options = ReadOptions::default();
            let refused = field(name).say(&mut options, text).unwrap_err().to_string();
            assert!(refused.contains(said), "{name}: {refused}");
            assert_eq!(options, ReadOptions::default(), "{name}");
        }
    }
}
