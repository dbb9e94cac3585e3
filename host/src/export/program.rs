//! The exact step of the model as a program.

use motorlens_shared::base::Coefficients;

use super::{Exported, Options, effects, laws, not_expressed};
use crate::model_file::Model;

/// A language: its name, its file with places to fill, and how a statement ends.
pub(super) struct Language {
    name: &'static str,
    template: &'static str,
    indent: &'static str,
    end: &'static str,
}

pub(super) const C: Language =
    Language { name: "the C program", template: include_str!("motor.c.in"), indent: "    ", end: ";" };
pub(super) const PYTHON: Language = Language {
    name: "the Python module",
    template: include_str!("motor.py.in"),
    indent: "        ",
    end: "",
};

/// Fills the template of `language`.
pub(super) fn export(model: &Model, options: &Options, language: &Language) -> Exported {
    let rig = model.rig(options.step_s);
    let (mut statements, mut left_out, mut names) = (String::new(), Vec::new(), Vec::new());
    for (kind, parameters) in effects(model) {
        match laws::statements(kind, &parameters, &rig) {
            Some(lines) => {
                names.push(kind.name());
                for line in lines {
                    statements += &format!("{}{line}{}\n", language.indent, language.end);
                }
            }
            None => left_out.push(not_expressed(kind, language.name)),
        }
    }
    let c = Coefficients::new(&model.base.base(), options.step_s);
    let mut text = language.template.replace("@EFFECTS@\n", &statements);
    let numbers = [
        ("UU", c.uu),
        ("UW", c.uw),
        ("UV", c.uv),
        ("UF", c.uf),
        ("WU", c.wu),
        ("WW", c.ww),
        ("WV", c.wv),
        ("WF", c.wf),
        ("XU", c.xu),
        ("XW", c.xw),
        ("XV", c.xv),
        ("XF", c.xf),
        ("HALF_STEP", c.half_step),
        ("STEP", options.step_s),
    ];
    for (name, value) in numbers {
        text = text.replace(&format!("@{name}@"), &format!("{value:e}"));
    }
    let said = if left_out.is_empty() { "nothing".to_owned() } else { left_out.join(" ") };
    text = text.replace("@NAMES@", &if names.is_empty() { "none".to_owned() } else { names.join(", ") });
    Exported { text: text.replace("@LEFT_OUT@", &said), left_out }
}
