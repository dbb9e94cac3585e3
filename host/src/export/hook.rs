//! Effects that a simulator of bodies lacks, as a Python program around its step: their own drive, memory and reading.
//!
//! The simulator integrates winding, rotor and load; before a step the effects say what voltage, torques and friction act in it,
//! and after it what they remember and what the sensor shows. All of it is written down by the effects themselves, see
//! [`super::record`]: the gear contact of `backlash` too, which is met on the model's own time grid ([`contact_grid`]). A stiff contact that
//! is met at other times is another contact: on a finer grid the error of a motor with a gap is another by 3 %.

use motorlens_shared::base::Base;
use motorlens_shared::effects::together::{Effects, MAX_EFFECTS, Several};
use motorlens_shared::effects::{Active, Effect, Kind, Memory, Now, Rig, Setting};
use motorlens_shared::simulator::in_order;
use motorlens_shared::step::{Drive, State};

use super::expression::{Printer, Text, reach};
use super::program::{NUMBERS, PYTHON, name};
use super::record::{Input, Recorded, Tape, record};
use super::step::{constants, input, lit, memory};
use super::transmission;
use crate::model_file::Model;

/// What the program applies: parts of a [`Drive`] by its names there, and the torque that the gear contact passes to the load.
const APPLIED: [&str; 13] = [
    "asked",
    "voltage",
    "torque",
    "load_torque",
    "contact",
    "forward",
    "backward",
    "meshing",
    "meshing_knee",
    "drop",
    "brush",
    "brush_knee",
    "series",
];

/// A memory that changes: at the start, and after a step.
struct Remembered {
    input: Input,
    first: Recorded,
    next: Recorded,
}

struct Traced {
    tape: Tape,
    drive: [Recorded; APPLIED.len()],
    remembered: Vec<Remembered>,
    reading: Recorded,
}

fn trace(base: &Base<f64>, effects: &[(Kind, Vec<f64>)], rig: &Rig, grid_s: f64) -> Traced {
    let (traced, tape) = record(|| {
        let (base, numbers) = constants(base, effects);
        let effects = in_order(numbers.iter().map(|(kind, p)| (*kind, p.as_slice())));
        let setting = Setting::new(&base, rig, 1);
        let several = Several::new(&effects, &setting);
        let now_at = |state, command| Now { command, state, voltages: &[], index: 1 };

        let seen = State {
            load_speed: input(Input::LoadSpeed),
            load_angle: input(Input::LoadAngle),
            ..State::moving(input(Input::Current), input(Input::Speed), input(Input::Angle))
        };
        let mut first = [Memory::empty(input(Input::Angle)); MAX_EFFECTS];
        several.begin(&State { current: lit(0.0), ..seen }, &mut first);

        let before: [Memory<Recorded>; MAX_EFFECTS] = std::array::from_fn(memory);
        let command = input(Input::Command);
        let voltages = [lit(0.0), command];
        let mut d = Drive::plain(command);
        several.drive(&Now { voltages: &voltages, ..now_at(seen, command) }, &before, &mut d);

        let was = State {
            load_speed: input(Input::WasLoadSpeed),
            load_angle: input(Input::WasLoadAngle),
            ..State::moving(input(Input::WasCurrent), input(Input::WasSpeed), input(Input::WasAngle))
        };
        let asked = input(Input::Asked);
        let mut after = before;
        several.settle(&Now { voltages: &voltages, ..now_at(was, asked) }, &seen, &mut after);
        let mut reading = if rig.encoder_on_motor { seen.angle } else { seen.load_angle };
        several.read(&seen, &after, &mut reading);

        let remembered = (0..effects.len()).flat_map(|k| {
            [
                (Input::Store(k), first[k].store, before[k].store, after[k].store),
                (Input::Age(k), first[k].age, before[k].age, after[k].age),
            ]
        });
        Traced {
            tape: Tape::default(),
            drive: [
                d.asked,
                d.voltage,
                d.torque,
                d.load_torque,
                contact(&numbers, &Setting::new(&base, &Rig { step_s: grid_s, ..*rig }, 1), seen),
                d.friction_forward,
                d.friction_backward,
                d.meshing,
                d.meshing_knee,
                d.drop,
                d.brush,
                d.brush_knee,
                d.series,
            ],
            remembered: remembered
                .filter(|(.., old, new)| old != new)
                .map(|(input, first, _, next)| Remembered { input, first, next })
                .collect(),
            reading,
        }
    });
    Traced { tape, ..traced }
}

/// Time between two looks of the model at its gear contact where it is simulated in steps of a millisecond, s; none without a transmission.
pub(super) fn contact_grid(effects: &[(Kind, Vec<f64>)]) -> Option<f64> {
    let (kind, _) = transmission(effects)?;
    Some(1e-3 / kind.spec().laws.parts as f64)
}

/// What the transmission among `effects` does to the load where it is `seen` on the grid, as a torque over one of its times, in V; the
/// load's own friction is the simulator's.
fn contact(
    effects: &[(Kind, Vec<Recorded>)],
    setting: &Setting<Recorded>,
    seen: State<Recorded>,
) -> Recorded {
    let Some((kind, p)) = transmission(effects) else { return lit(0.0) };
    let spec = kind.spec();
    let (Some(share), mut p) = (spec.load_share(), p.clone()) else { return lit(0.0) };
    if let Some(place) = spec.load_damping() {
        p[place] = lit(0.0);
    }
    // The simulator has moved the load on already.
    let before = State { load_angle: seen.load_angle - setting.step * seen.load_speed, ..seen };
    let mut after = before;
    Active::new(*kind, &p, setting).couple(setting.step, &mut after);
    (after.load_speed - before.load_speed) * (p[share] / (setting.acceleration * setting.step))
}

/// What stands in the MJCF beside which the program runs.
pub(super) struct Beside<'a> {
    /// N m/V.
    pub torque_per_volt: f64,
    /// Ohm.
    pub resistance: f64,
    /// Dry friction of the joint, N m.
    pub friction: f64,
    /// s.
    pub step_s: f64,
    /// Voltage that holds a speed, V s/rad, and the current with which it does, as a voltage.
    pub holding: f64,
    pub current_per_speed: f64,
    /// Steps from one look at the gear contact to the next.
    pub contact_steps: u32,
    /// The joint of the output shaft, and the one that the motor turns.
    pub names: [&'a str; 2],
}

/// The program for `effects`.
pub(super) fn program(model: &Model, effects: &[(Kind, Vec<f64>)], beside: &Beside) -> String {
    let grid_s = f64::from(beside.contact_steps) * beside.step_s;
    let traced = trace(&model.base.base(), effects, &model.rig(beside.step_s), grid_s);
    let names = |input: Input| name(effects, input);
    let printer = Printer::new(&traced.tape, &PYTHON.syntax, effects, &names);
    let kept: Vec<String> = traced.remembered.iter().map(|m| names(m.input)).collect();
    let first: Vec<Recorded> = traced.remembered.iter().map(|m| m.first).collect();
    let next: Vec<Recorded> = traced.remembered.iter().map(|m| m.next).chain([traced.reading]).collect();
    let [_, past_begin, past_move] = reach(&traced.tape, &traced.drive)
        .map_or_else(Default::default, |steps| (PYTHON.past)(steps, beside.holding));

    let lines = |text: &Text, targets: &[String]| -> String {
        let mut lines = PYTHON.definitions(text);
        // Together: one may stand in another's expression.
        if !targets.is_empty() {
            lines.push(format!("{} = {}", targets.join(", "), text.outputs.join(", ")));
        }
        lines.iter().map(|line| format!("        {line}\n")).collect()
    };
    let own: Vec<String> = kept.iter().map(|name| format!("self.{name}")).collect();
    let applied: Vec<String> = APPLIED.iter().map(|name| (*name).to_owned()).collect();
    let shown: Vec<String> = kept.iter().cloned().chain(["reading".into()]).collect();
    let each = |line: &dyn Fn(&String) -> String| -> String {
        kept.iter().map(|name| format!("        {}\n", line(name))).collect()
    };
    let blocks = [
        ("NUMBERS", NUMBERS.to_owned()),
        ("BEGIN", lines(&printer.text(&first), &own) + &past_begin),
        ("LOAD", each(&|name| format!("{name} = self.{name}"))),
        ("MOVE", past_move),
        ("DRIVE", lines(&printer.text(&traced.drive), &applied)),
        ("SETTLE", lines(&printer.text(&next), &shown)),
        ("STORE", each(&|name| format!("self.{name} = {name}"))),
    ];
    let mut text = include_str!("hook.py.in").to_owned();
    for (place, block) in blocks {
        text = text.replace(&format!("@{place}@\n"), &block);
    }
    let heading: Vec<String> = effects
        .iter()
        .map(|(kind, p)| {
            let spec = kind.spec();
            let numbers: Vec<String> =
                spec.parameters.iter().zip(p).map(|(q, x)| format!("{} = {x} {}", q.name, q.unit)).collect();
            format!("{}: {} ({}).", spec.name, spec.equation, numbers.join(", "))
        })
        .collect();
    let words = [
        ("HEADING", heading.join("\n   ")),
        ("SCALE", format!("{:?}", beside.torque_per_volt)),
        ("RESISTANCE", format!("{:?}", beside.resistance)),
        ("FRICTION", format!("{:?}", beside.friction)),
        ("STEP", format!("{:?}", beside.step_s)),
        ("HOLDING", format!("{:?}", beside.holding)),
        ("CURRENT", format!("{:?}", beside.current_per_speed)),
        ("CONTACT_STEPS", beside.contact_steps.to_string()),
        ("OUTPUT", format!("{:?}", beside.names[0])),
        ("ROTOR", format!("{:?}", beside.names[1])),
    ];
    for (place, word) in words {
        text = text.replace(&format!("@{place}@"), &word);
    }
    text
}
