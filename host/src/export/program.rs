//! The exact step of the model as a program.

use motorlens_shared::base::Coefficients;
use motorlens_shared::effects::Kind;
use motorlens_shared::simulator::MAX_EFFECTS;

use super::laws::{Place, Statements, number, statements};
use super::{Exported, Options, effects};
use crate::model_file::Model;

/// A language: its file with places to fill, and how a statement stands in it.
pub(super) struct Language {
    template: &'static str,
    indent: &'static str,
    end: &'static str,
}

pub(super) const C: Language =
    Language { template: include_str!("motor.c.in"), indent: "        ", end: ";" };
pub(super) const PYTHON: Language =
    Language { template: include_str!("motor.py.in"), indent: "            ", end: "" };

/// Fills the template of `language`.
pub(super) fn export(model: &Model, options: &Options, language: &Language) -> Exported {
    let rig = model.rig(options.step_s);
    let base = model.base.base();
    let effects = effects(model);
    let load_share = effects.iter().find_map(|(kind, p)| Some(p[kind.spec().load_share()?]));
    let parts = effects.iter().map(|(kind, _)| kind.spec().laws.parts).max().unwrap_or(1);
    let part_s = options.step_s / parts as f64;
    let load_damping =
        effects.iter().find_map(|(kind, p)| Some(p[kind.spec().load_damping()?])).unwrap_or(0.0);
    let rotor = load_share.map_or(base, |share| base.without_load(share, load_damping));
    let all: Vec<Statements> = effects
        .iter()
        .enumerate()
        .map(|(memory, (kind, p))| statements(*kind, p, &Place { rig: &rig, base: &base, part_s, memory }))
        .collect();
    let lines = |of: fn(&Statements) -> &Vec<String>, before: &[String], indent: &str| -> String {
        let own = all.iter().flat_map(of);
        before.iter().chain(own).map(|line| format!("{indent}{line}{}\n", language.end)).collect()
    };
    let load = match load_share {
        Some(share) => vec![
            format!("load_speed2 = load_speed + {:e} * load_torque", part_s * base.acceleration() / share),
            "load_angle2 = load_angle".into(),
        ],
        None => vec!["load_speed2 = speed2".into(), "load_angle2 = angle2".into()],
    };
    let rigid = if load_share.is_some() { vec![] } else { vec!["torque += load_torque".to_owned()] };
    let outside = &language.indent[4..];
    let mut drive = lines(|s| &s.drive, &[], language.indent);
    drive +=
        &rigid.iter().map(|line| format!("{}{line}{}\n", language.indent, language.end)).collect::<String>();
    let blocks = [
        ("BEGIN", lines(|s| &s.begin, &[], outside)),
        ("DRIVE", drive),
        ("COUPLE", lines(|s| &s.couple, &load, language.indent)),
        ("SETTLE", lines(|s| &s.settle, &[], language.indent)),
        ("READ", lines(|s| &s.read, &[], outside)),
    ];
    let mut text = language.template.to_owned();
    for (name, block) in blocks {
        text = text.replace(&format!("@{name}@\n"), &block);
    }
    let c = Coefficients::new(&rotor, part_s);
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
        ("PER_IMPULSE", c.per_impulse),
        ("ELECTRIC_IMPULSE", c.electric_impulse),
        ("VISCOUS", c.viscous),
        ("BACK_EMF", c.back_emf),
        ("CONSTANTS", c.shares.constants),
        ("KEPT", c.shares.kept),
        ("HALF_KEPT", c.shares.half_kept),
        ("RAMP", c.shares.ramp),
        ("HALF_STEP", c.half_step),
        ("STEP", options.step_s),
    ];
    for (name, value) in numbers {
        text = text.replace(&format!("@{name}@"), &number(value));
    }
    let names: Vec<&str> = effects.iter().map(|(kind, _)| kind.name()).collect();
    let words = [
        ("NAMES", if names.is_empty() { "none".to_owned() } else { names.join(", ") }),
        ("PARTS", parts.to_string()),
        ("PAST", past(&effects, options.step_s).to_string()),
        ("MEMORIES", MAX_EFFECTS.to_string()),
        ("SHAFT", if rig.encoder_on_motor { "angle2" } else { "load_angle2" }.to_owned()),
        ("SHAFT_BEFORE", if rig.encoder_on_motor { "angle" } else { "load_angle" }.to_owned()),
    ];
    for (name, word) in words {
        text = text.replace(&format!("@{name}@"), &word);
    }
    Exported { text, left_out: Vec::new() }
}

/// Commands that a program keeps: as many as its delay looks back, and the present one.
fn past(effects: &[(Kind, Vec<f64>)], step_s: f64) -> usize {
    let delay = effects.iter().find(|(kind, _)| *kind == Kind::Delay).map_or(0.0, |(_, p)| p[0]);
    (delay / step_s) as usize + 2
}
