//! The model's own step as a program.

use motorlens_shared::effects::Kind;

use super::expression::{Printer, Syntax, Text, reach};
use super::record::{Input, Recorded};
use super::step::{Changing, Step, trace};
use super::{Exported, Options, effects};
use crate::model_file::Model;

/// A language: its file with places to fill, and how statements stand in it.
pub(super) struct Language {
    template: &'static str,
    pub(super) syntax: Syntax,
    /// Before a statement of a function, and of the loop within.
    indents: [&'static str; 2],
    end: &'static str,
    /// Before a name that is defined for good, and before one that changes.
    define: [&'static str; 2],
    /// Before the state's own variables.
    own: &'static str,
    /// Declares such a variable, where the language asks for it.
    field: Option<fn(&str, &str) -> String>,
    /// Past voltages that reach back so many steps, with the voltage that holds a speed, V s/rad: their declaration, what they are at the
    /// start, how they move on.
    pub(super) past: fn(usize, f64) -> [String; 3],
}

pub(super) const C: Language = Language {
    template: include_str!("motor.c.in"),
    syntax: Syntax {
        least: |a, b| format!("least({a}, {b})"),
        most: |a, b| format!("most({a}, {b})"),
        pick: |[a, b, x, y]| format!("({a} > {b} ? {x} : {y})"),
        divide: |_, _| None,
        round: |x| format!("rint({x})"),
        absolute: |x| format!("fabs({x})"),
        past: |steps| format!("s->past[{steps}]"),
        call: |name, arguments| format!("{name}({})", arguments.join(", ")),
        not_finite: |x| match x {
            x if x.is_nan() => "NAN",
            x if x > 0.0 => "INFINITY",
            _ => "-INFINITY",
        },
    },
    indents: ["    ", "        "],
    end: ";",
    define: ["const double ", "double "],
    own: "s->",
    field: Some(|name, meaning| format!("    double {name}; /* {meaning} */\n")),
    past: |steps, holding| {
        [
            format!("    double past[{}]; /* V, the latest first */\n", steps + 1),
            format!(
                "    /* At rest there was no voltage before; in motion, the one that holds the speed. */\n    \
                 for (k = 0; k < {}; k++)\n        s->past[k] = {holding:?} * speed;\n",
                steps + 1
            ),
            format!(
                "    for (k = {steps}; k > 0; k--)\n        s->past[k] = s->past[k - 1];\n    s->past[0] = volts;\n"
            ),
        ]
    },
};

/// What Python lacks of a floating-point unit.
pub(super) const NUMBERS: &str = include_str!("numbers.py.in");

pub(super) const PYTHON: Language = Language {
    template: include_str!("motor.py.in"),
    syntax: Syntax {
        least: |a, b| format!("least({a}, {b})"),
        most: |a, b| format!("most({a}, {b})"),
        pick: |[a, b, x, y]| format!("({x} if {a} > {b} else {y})"),
        divide: |a, b| Some(format!("divide({a}, {b})")),
        round: |x| format!("nearest({x})"),
        absolute: |x| format!("fabs({x})"),
        past: |steps| format!("past[{steps}]"),
        call: |name, arguments| format!("{name}({})", arguments.join(", ")),
        not_finite: |x| match x {
            x if x.is_nan() => "nan",
            x if x > 0.0 => "inf",
            _ => "-inf",
        },
    },
    indents: ["        ", "            "],
    end: "",
    define: ["", ""],
    own: "self.",
    field: None,
    past: |steps, holding| {
        [
            String::new(),
            format!(
                "        # At rest there was no voltage before; in motion, the one that holds the speed.\n        \
                 self.past = [{holding:?} * speed] * {}\n",
                steps + 1
            ),
            "        past = self.past = [volts, *self.past[:-1]]\n".into(),
        ]
    },
};

/// What an input is called, in every language.
pub(super) fn name(effects: &[(Kind, Vec<f64>)], input: Input) -> String {
    match input {
        Input::Command => "volts".into(),
        Input::Step => "steps".into(),
        Input::Current => "current".into(),
        Input::Speed => "speed".into(),
        Input::Angle => "angle".into(),
        Input::LoadSpeed => "load_speed".into(),
        Input::LoadAngle => "load_angle".into(),
        Input::Origin => "start".into(),
        Input::WasCurrent => "was_current".into(),
        Input::WasSpeed => "was_speed".into(),
        Input::WasAngle => "was_angle".into(),
        Input::WasLoadSpeed => "was_load_speed".into(),
        Input::WasLoadAngle => "was_load_angle".into(),
        Input::Asked => "asked".into(),
        Input::Store(k) => format!("{}_memory", effects[k].0.name()),
        Input::Age(k) => format!("{}_age", effects[k].0.name()),
    }
}

/// What it is, for whoever reads the program.
pub(super) fn meaning(effects: &[(Kind, Vec<f64>)], input: Input) -> String {
    match input {
        Input::Command => "V, at the driver's output".into(),
        Input::Step => "taken, this one included".into(),
        Input::Current => "V: current times winding resistance".into(),
        Input::Speed => "rad/s, of the rotor, seen through the gear".into(),
        Input::Angle => "rad, of the rotor, seen through the gear".into(),
        Input::LoadSpeed => "rad/s, of the output shaft".into(),
        Input::LoadAngle => "rad, of the output shaft".into(),
        Input::Origin => "rad: the first angle".into(),
        Input::WasCurrent => "V: current at the beginning of the step".into(),
        Input::WasSpeed | Input::WasLoadSpeed => "rad/s, at the beginning of the step".into(),
        Input::WasAngle | Input::WasLoadAngle => "rad, at the beginning of the step".into(),
        Input::Asked => "V, that the bridge was told in the step".into(),
        Input::Store(k) => format!("what {} remembers", effects[k].0.name()),
        Input::Age(k) => format!("s: age of what {} holds", effects[k].0.name()),
    }
}

/// The lines that head a program: the base model's parameters, then each effect, its equation and its parameters.
pub(super) fn heading(model: &Model) -> String {
    let effects = model.effects.iter().map(|e| {
        let spec = e.effect.spec();
        let numbers: Vec<String> =
            e.parameters.iter().map(|p| format!("{} = {} {}", p.name, p.value, p.unit)).collect();
        format!("{}: {} ({}).", spec.name, spec.equation, numbers.join(", "))
    });
    let b = &model.base;
    let base = format!(
        "gain = {} rad/(s V), tau_m = {} s, tau_e = {} s, viscous_share = {}.",
        b.gain, b.tau_m, b.tau_e, b.viscous_share
    );
    // What ends a comment of C would end this one.
    std::iter::once(base).chain(effects).collect::<Vec<_>>().join("\n   ").replace("*/", "* /")
}

/// Fills the template of `language`.
pub(super) fn export(model: &Model, options: &Options, language: &Language) -> Exported {
    let effects = effects(model);
    let step = trace(&model.base.base(), &effects, &model.rig(options.step_s()));
    let names = |input: Input| name(&effects, input);
    let printer = Printer::new(&step.tape, &language.syntax, &effects, &names);
    let next: Vec<Recorded> = step.changing.iter().map(|c| c.next).chain([step.reading]).collect();
    let first: Vec<Recorded> = step.changing.iter().map(|c| c.first).chain([step.first_reading]).collect();
    let [outside, inside] = language.indents;
    let [past_field, past_begin, past_move] =
        reach(&step.tape, &next).map_or_else(Default::default, |steps| (language.past)(steps, step.holding));
    let counter = if past_move.is_empty() { "" } else { "    int k;\n" };

    let fields: String = step
        .changing
        .iter()
        .filter_map(|c| Some(language.field?(&names(c.input), &meaning(&effects, c.input))))
        .collect();
    let blocks = [
        ("NUMBERS", NUMBERS.to_owned()),
        ("FIELDS", fields + &past_field),
        ("COUNTER", if language.field.is_some() { counter.to_owned() } else { String::new() }),
        ("BEGIN", language.begin(&step, &names, &printer.text(&first)) + &past_begin),
        ("MOVE", past_move),
        (
            "LOAD",
            each(&step, |c| {
                format!(
                    "{outside}{1}{0} = {2}{0}{3}\n",
                    names(c.input),
                    language.define[1],
                    language.own,
                    language.end
                )
            }),
        ),
        ("ADVANCE", language.advance(inside, &step, &names, &printer.text(&next))),
        (
            "STORE",
            each(&step, |c| {
                format!("{outside}{1}{0} = {0}{2}\n", names(c.input), language.own, language.end)
            }),
        ),
    ];
    let mut text = language.template.to_owned();
    for (place, block) in blocks {
        text = text.replace(&format!("@{place}@\n"), &block);
    }
    let words = [
        ("HEADING", heading(model)),
        ("STEP", format!("{:?}", options.step_s())),
        ("PARTS", step.parts.to_string()),
    ];
    for (place, word) in words {
        text = text.replace(&format!("@{place}@"), &word);
    }
    Exported::whole(text, model, options.step_s())
}

impl Language {
    pub(super) fn definitions(&self, text: &Text) -> Vec<String> {
        text.defined
            .iter()
            .map(|(name, value)| format!("{}{name} = {value}{}", self.define[0], self.end))
            .collect()
    }

    /// The state at the start.
    fn begin(&self, step: &Step, names: &dyn Fn(Input) -> String, text: &Text) -> String {
        let mut lines = self.definitions(text);
        lines.extend(
            targets(step, names)
                .iter()
                .zip(&text.outputs)
                .map(|(target, value)| format!("{}{target} = {value}{}", self.own, self.end)),
        );
        lines.iter().map(|line| format!("{}{line}\n", self.indents[0])).collect()
    }

    /// A part of a step: all is computed before anything changes.
    fn advance(&self, indent: &str, step: &Step, names: &dyn Fn(Input) -> String, text: &Text) -> String {
        let mut lines = self.definitions(text);
        let targets = targets(step, names);
        let changed: Vec<(&String, &String)> =
            targets.iter().zip(&text.outputs).filter(|(target, value)| target != value).collect();
        let (define, end) = (self.define[0], self.end);
        lines.extend(changed.iter().map(|(target, value)| format!("{define}next_{target} = {value}{end}")));
        lines.extend(changed.iter().map(|(target, _)| format!("{target} = next_{target}{end}")));
        lines.iter().map(|line| format!("{indent}{line}\n")).collect()
    }
}

/// The names of what a step changes.
fn targets(step: &Step, names: &dyn Fn(Input) -> String) -> Vec<String> {
    step.changing.iter().map(|c| names(c.input)).chain(["reading".into()]).collect()
}

fn each(step: &Step, line: impl Fn(&Changing) -> String) -> String {
    step.changing.iter().map(line).collect()
}
