//! A Modelica block: the model's own step as a function, called at its sampling instants.
//!
//! The voltage of a step is its mean, as in a fit, so the block may be driven by any signal. Friction holds exactly and
//! turns exactly where the model's does; a continuous equation would have to be smoothed about zero speed, and creep.

use super::expression::{Printer, Syntax, reach};
use super::program::{heading, meaning, name};
use super::record::{Input, Recorded};
use super::step::trace;
use super::{Exported, Options, effects};
use crate::model_file::Model;

const SYNTAX: Syntax = Syntax {
    least: |a, b| format!("min({a}, {b})"),
    most: |a, b| format!("max({a}, {b})"),
    pick: |[a, b, x, y]| format!("(if {a} > {b} then {x} else {y})"),
    divide: |_, _| None,
    round: |x| format!("floor({x} + 0.5)"),
    absolute: |x| format!("abs({x})"),
    past: |steps| format!("past[{}]", steps + 1),
    call: |name, arguments| match name {
        "pow" => format!("(({})^({}))", arguments[0], arguments[1]),
        other => format!("{other}({})", arguments.join(", ")),
    },
    not_finite: |x| if x > 0.0 { "1.0e300*1.0e300" } else { "-1.0e300*1.0e300" },
};

/// One model, no libraries.
pub(super) fn export(model: &Model, options: &Options) -> Exported {
    let effects = effects(model);
    let step = trace(&model.base.base(), &effects, &model.rig(options.step_s()));
    let names = |input: Input| name(&effects, input);
    let printer = Printer::new(&step.tape, &SYNTAX, &effects, &names);
    let next: Vec<Recorded> = step.changing.iter().map(|c| c.next).chain([step.reading]).collect();
    let text = printer.text(&next);
    let kept: Vec<String> = step.changing.iter().map(|c| names(c.input)).chain(["reading".into()]).collect();
    let first: Vec<Recorded> = step.changing.iter().map(|c| c.first).chain([step.first_reading]).collect();
    let begun = printer.text(&first);
    // The number of steps, then what is behind, stand after what changes.
    let past = reach(&step.tape, &next).map_or(0, |steps| steps + 1);
    let size = kept.len() + 1 + past;
    let steps = kept.len() + 1;

    let lines = |lines: Vec<String>, indent: &str| -> String {
        lines.iter().map(|line| format!("{indent}{line};\n")).collect()
    };
    let declared = lines(
        kept.iter()
            .zip(step.changing.iter().map(|c| meaning(&effects, c.input)).chain(["rad".into()]))
            .map(|(name, meaning)| format!("Real {name} \"{meaning}\""))
            .chain(kept.iter().map(|name| format!("Real next_{name}")))
            .chain(text.defined.iter().map(|(name, _)| format!("Real {name}")))
            .chain((past > 0).then(|| format!("Real past[{past}] \"V, the latest first\"")))
            .collect(),
        "    ",
    );
    let loaded = lines(
        kept.iter()
            .enumerate()
            .map(|(k, name)| format!("{name} := state[{}]", k + 1))
            .chain([format!("steps := state[{steps}] + 1")])
            .chain((past > 0).then(|| "past[1] := volts".to_owned()))
            .chain((1..past).map(|k| format!("past[{}] := state[{}]", k + 1, steps + k)))
            .collect(),
        "    ",
    );
    let advanced = lines(
        text.defined
            .iter()
            .map(|(name, value)| format!("{name} := {value}"))
            .chain(kept.iter().zip(&text.outputs).map(|(name, value)| format!("next_{name} := {value}")))
            .chain(kept.iter().map(|name| format!("{name} := next_{name}")))
            .collect(),
        "      ",
    );
    let stored = lines(
        kept.iter()
            .enumerate()
            .map(|(k, name)| format!("next[{}] := {name}", k + 1))
            .chain([format!("next[{steps}] := steps")])
            .chain((0..past).map(|k| format!("next[{}] := past[{}]", steps + 1 + k, k + 1)))
            .collect(),
        "    ",
    );
    let begin_declared = if begun.defined.is_empty() {
        String::new()
    } else {
        let names = begun.defined.iter().map(|(name, _)| format!("Real {name}")).collect();
        format!("  protected\n{}", lines(names, "    "))
    };
    let holding = step.holding;
    let begin = lines(
        begun
            .defined
            .iter()
            .map(|(name, value)| format!("{name} := {value}"))
            .chain(begun.outputs.iter().enumerate().map(|(k, value)| format!("first[{}] := {value}", k + 1)))
            .chain([format!("first[{steps}] := 0")])
            // At rest there was no voltage before; in motion, the one that holds the speed.
            .chain((0..past).map(|k| format!("first[{}] := {holding:?}*speed", steps + 1 + k)))
            .collect(),
        "    ",
    );
    let of = |name: &str| kept.iter().position(|kept| kept == name).unwrap_or(0) + 1;
    let (current, speed, angle) = (of("current"), of("load_speed"), of("load_angle"));
    let mut text = include_str!("Motor.mo.in").to_owned();
    let places = [
        ("@BEGIN_DECLARED@\n", begin_declared),
        ("@BEGIN@\n", begin),
        ("@DECLARED@\n", declared),
        ("@LOADED@\n", loaded),
        ("@ADVANCED@\n", advanced),
        ("@STORED@\n", stored),
        ("@HEADING@", heading(model)),
        ("@STEP@", format!("{:?}", options.step_s())),
        ("@PARTS@", step.parts.to_string()),
        ("@SIZE@", size.to_string()),
        ("@READING@", kept.len().to_string()),
        ("@CURRENT@", current.to_string()),
        ("@SPEED@", speed.to_string()),
        ("@ANGLE@", angle.to_string()),
    ];
    for (place, block) in places {
        text = text.replace(place, &block);
    }
    Exported::whole(text, model, options.step_s())
}
