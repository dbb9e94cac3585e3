//! A model's step as expressions, written down by the model itself.

use motorlens_shared::base::Base;
use motorlens_shared::effects::together::{Effects, MAX_EFFECTS, Several};
use motorlens_shared::effects::{Kind, Memory, Now, Rig};
use motorlens_shared::simulator::{Motion, Prepared, Simulator, in_order};
use motorlens_shared::step::{Drive, Laws, State};

use super::record::{Input, Recorded, Tape, record};
use crate::fit::start::held;

/// What changes from step to step, and how.
#[derive(Debug, Clone, Copy)]
pub(super) struct Changing {
    pub input: Input,
    /// Its value at the start.
    pub first: Recorded,
    /// Its value after a part of a step.
    pub next: Recorded,
}

/// A step of a model: the same part, `parts` times.
pub(super) struct Step {
    pub tape: Tape,
    /// Current, speeds and angles, and what the effects remember.
    pub changing: Vec<Changing>,
    /// What the sensor shows at the start, which [`Input::Speed`] and [`Input::Angle`] tell, and after a part.
    pub first_reading: Recorded,
    pub reading: Recorded,
    /// Parts of a step.
    pub parts: usize,
    /// Voltage that holds a speed, V s/rad: what a motor that begins in motion had before.
    pub holding: f64,
}

/// Effects of which a program runs one part of a step at a time.
struct InOnePart(Several<Recorded>);

impl Effects<Recorded> for InOnePart {
    fn laws(&self) -> Laws {
        Laws { parts: 1, ..self.0.laws() }
    }
    fn two_masses(&self) -> bool {
        self.0.two_masses()
    }
    fn drive(&self, now: &Now<Recorded>, memories: &[Memory<Recorded>], drive: &mut Drive<Recorded>) {
        self.0.drive(now, memories, drive);
    }
    fn begin(&self, state: &State<Recorded>, memories: &mut [Memory<Recorded>]) {
        self.0.begin(state, memories);
    }
    fn settle(&self, now: &Now<Recorded>, after: &State<Recorded>, memories: &mut [Memory<Recorded>]) {
        self.0.settle(now, after, memories);
    }
    fn couple(&self, part: Recorded, state: &mut State<Recorded>) {
        self.0.couple(part, state);
    }
    fn show(&self, state: &mut State<Recorded>) {
        self.0.show(state);
    }
    fn read(&self, state: &State<Recorded>, memories: &[Memory<Recorded>], reading: &mut Recorded) {
        self.0.read(state, memories, reading);
    }
}

/// Writes down a step of `base` with `effects` on `rig`.
pub(super) fn trace(base: &Base<f64>, effects: &[(Kind, Vec<f64>)], rig: &Rig) -> Step {
    let holding = holding(base, rig);
    let current_per_speed = holding - base.back_emf();
    let (step, tape) = record(|| {
        let (base, numbers) = constants(base, effects);
        let effects = in_order(numbers.iter().map(|(kind, p)| (*kind, p.as_slice())));
        let prepared = Prepared::new(&base, &effects, rig);
        let parts =
            effects.iter().find(|(kind, _)| kind.is_transmission()).map_or(1, |(k, _)| k.spec().laws.parts);
        let several = InOnePart(Several::new(&effects, &prepared.setting));
        let simulator = Simulator::with(prepared, several);

        let current = lit(current_per_speed) * input(Input::Speed);
        let start = simulator.start(State::moving(current, input(Input::Speed), input(Input::Angle)));
        let first_reading = simulator.read(&start);
        let before = Motion { state: state(), memories: std::array::from_fn(memory) };
        let mut after = before;
        // The voltages are one input, and so is their number.
        simulator.advance(&mut after, &[lit(0.0), input(Input::Command)], 1);
        let reading = simulator.read(&after);
        Step {
            tape: Tape::default(),
            changing: changing(&start, &before, &after, effects.len()),
            first_reading,
            reading,
            parts,
            holding,
        }
    });
    Step { tape, ..step }
}

/// Voltage that holds a speed on `rig`, V s/rad, as a run of the model in motion begins with it.
pub(super) fn holding(base: &Base<f64>, rig: &Rig) -> f64 {
    Some(held(rig, 1.0)).filter(|volts| volts.is_finite()).unwrap_or(1.0 / base.gain)
}

/// The parameters of a model, as constants of the tape.
pub(super) fn constants(
    base: &Base<f64>,
    effects: &[(Kind, Vec<f64>)],
) -> (Base<Recorded>, Vec<(Kind, Vec<Recorded>)>) {
    let base = Base {
        gain: lit(base.gain),
        tau_m: lit(base.tau_m),
        tau_e: lit(base.tau_e),
        viscous_share: lit(base.viscous_share),
    };
    (base, effects.iter().map(|(kind, p)| (*kind, p.iter().map(|x| lit(*x)).collect())).collect())
}

pub(super) fn lit(x: f64) -> Recorded {
    motorlens_shared::scalar::Scalar::lit(x)
}

pub(super) fn input(input: Input) -> Recorded {
    Recorded::input(input)
}

fn state() -> State<Recorded> {
    State {
        current: input(Input::Current),
        speed: input(Input::Speed),
        angle: input(Input::Angle),
        load_speed: input(Input::LoadSpeed),
        load_angle: input(Input::LoadAngle),
    }
}

pub(super) fn memory(effect: usize) -> Memory<Recorded> {
    Memory {
        store: input(Input::Store(effect)),
        age: input(Input::Age(effect)),
        origin: input(Input::Origin),
    }
}

/// The state, and of what `effects` effects remember that which ever changes.
fn changing(
    start: &Motion<Recorded>,
    before: &Motion<Recorded>,
    after: &Motion<Recorded>,
    effects: usize,
) -> Vec<Changing> {
    let of = |state: &State<Recorded>| {
        [state.current, state.speed, state.angle, state.load_speed, state.load_angle]
    };
    let inputs = [Input::Current, Input::Speed, Input::Angle, Input::LoadSpeed, Input::LoadAngle];
    let state = inputs.into_iter().zip(of(&start.state)).zip(of(&after.state));
    let remembered = (0..effects.min(MAX_EFFECTS)).flat_map(|k| {
        let [first, old, new] = [start, before, after].map(|motion| motion.memories[k]);
        [(Input::Store(k), first.store, old.store, new.store), (Input::Age(k), first.age, old.age, new.age)]
    });
    state
        .map(|((input, first), next)| Changing { input, first, next })
        .chain(remembered.filter(|(.., old, new)| old != new).map(|(input, first, _, next)| Changing {
            input,
            first,
            next,
        }))
        .chain([Changing { input: Input::Origin, first: input(Input::Angle), next: input(Input::Origin) }])
        .collect()
}
