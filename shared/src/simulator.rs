//! The motor with its effects, run over a grid of held voltages.

use crate::base::{Base, Coefficients};
use crate::effects::together::{Effects, Several};
use crate::effects::{Kind, Memory, Now, Rig, Setting, Spec};
use crate::scalar::Scalar;
use crate::step::{Drive, State, step};
use heapless::Vec;

pub use crate::effects::together::MAX_EFFECTS;
/// Most parameters that one effect has.
pub const MAX_PARAMETERS: usize = 5;

/// An effect with its parameters in the order of its row.
pub type Chosen<'a, S> = (Kind, &'a [S]);

/// At most [`MAX_EFFECTS`] effects, in the order of the registry: the order in which they act.
#[must_use]
pub fn in_order<'a, S: Scalar>(
    effects: impl IntoIterator<Item = Chosen<'a, S>>,
) -> Vec<Chosen<'a, S>, MAX_EFFECTS> {
    // A seventh effect has no place: callers are held to MAX_EFFECTS by the model file.
    let mut chosen: Vec<_, MAX_EFFECTS> = effects.into_iter().take(MAX_EFFECTS).collect();
    chosen.sort_unstable_by_key(|(kind, _)| *kind);
    chosen
}

/// The base model made ready for a set of effects: all that costs time before a run.
#[derive(Debug, Clone)]
pub struct Prepared<S> {
    coefficients: Coefficients<S>,
    /// What the effects see of motor and rig.
    pub setting: Setting<S>,
    part: S,
    load_per_torque: S,
}

impl<S: Scalar> Prepared<S> {
    /// Discretises `base` on `rig`; the first transmission among `effects` splits it in two masses.
    #[inline(always)]
    #[must_use]
    pub fn new(base: &Base<S>, effects: &[Chosen<S>], rig: &Rig) -> Self {
        let transmission = effects.iter().find(|(kind, _)| kind.is_transmission());
        let of = |place: fn(&Spec) -> Option<usize>| {
            transmission.and_then(|(kind, p)| Some(p[place(kind.spec())?]))
        };
        let share = of(Spec::load_share);
        let rotor = share
            .map_or(*base, |share| base.without_load(share, of(Spec::load_damping).unwrap_or(S::zero())));
        let parts = transmission.map_or(1, |(kind, _)| kind.spec().laws.parts);
        let setting = Setting::new(base, rig, parts);
        let part = S::lit(rig.step_s / parts as f64);
        let load_per_torque = part * setting.acceleration / share.unwrap_or(S::one());
        Self { coefficients: Coefficients::discretised(&rotor, part), setting, part, load_per_torque }
    }
}

/// Base model and effects with their parameters fixed: everything that does not change while it runs.
#[derive(Debug, Clone)]
pub struct Simulator<S, E = Several<S>> {
    prepared: Prepared<S>,
    effects: E,
}

/// What changes while a [`Simulator`] runs.
#[derive(Debug, Clone, Copy)]
pub struct Motion<S> {
    /// Current, speed and angle.
    pub state: State<S>,
    /// What each effect remembers, in the order of the registry.
    pub memories: [Memory<S>; MAX_EFFECTS],
}

impl<S: Scalar> Simulator<S> {
    /// Prepares `base` with `effects` (kind and parameters in the registry's order) on `rig`.
    ///
    /// At most [`MAX_EFFECTS`] are used, and the first transmission among them.
    pub fn new<'a>(base: &Base<S>, effects: impl IntoIterator<Item = Chosen<'a, S>>, rig: &Rig) -> Self {
        let effects = in_order(effects);
        let prepared = Prepared::new(base, &effects, rig);
        let effects = Several::new(&effects, &prepared.setting);
        Self::with(prepared, effects)
    }
}

impl<S: Scalar, E: Effects<S>> Simulator<S, E> {
    /// The same from parts; `effects` must be those that `prepared` was made for.
    #[inline(always)]
    pub fn with(prepared: Prepared<S>, effects: E) -> Self {
        Self { prepared, effects }
    }

    /// Starts from `state`, in which the motor has been for long.
    #[inline(always)]
    pub fn start(&self, state: State<S>) -> Motion<S> {
        self.start_aged(state, S::zero())
    }

    /// The same with a reading that was taken `age` seconds before the start, where a sensor holds it.
    #[inline(always)]
    pub fn start_aged(&self, state: State<S>, age: S) -> Motion<S> {
        let mut memories = [Memory { age, ..Memory::empty(state.angle) }; MAX_EFFECTS];
        self.effects.begin(&state, &mut memories);
        Motion { state, memories }
    }

    /// Advances over cell `index` (from 1) of the grid, whose mean voltages are `voltages[1..]`; `voltages[0]` was
    /// held before the start.
    #[inline(always)]
    pub fn advance(&self, motion: &mut Motion<S>, voltages: &[S::Element], index: usize) {
        self.advance_seen::<false>(motion, voltages, index, S::zero());
    }

    /// [`Self::advance`] where the measured shaft is so far `ahead` of the model's, rad: equations that are tied to an angle (cogging torque, an
    /// unbalance, a spring, an eccentric encoder) act where it was seen. A simulation at the measured angle.
    #[inline(always)]
    pub fn advance_guided(&self, motion: &mut Motion<S>, voltages: &[S::Element], index: usize, ahead: S) {
        self.advance_seen::<true>(motion, voltages, index, ahead);
    }

    #[inline(always)]
    fn advance_seen<const GUIDED: bool>(
        &self,
        motion: &mut Motion<S>,
        voltages: &[S::Element],
        index: usize,
        ahead: S,
    ) {
        let command = S::splat(voltages[index]);
        if self.effects.two_masses() {
            for _ in 0..self.effects.laws().parts {
                let now = Now { command, state: motion.state, voltages, index };
                let drive = self.drive::<GUIDED>(&now, motion, ahead);
                self.advance_two_masses(&mut motion.state, &drive);
                let now = Now { command: drive.asked, ..now };
                self.effects.settle(&now, &motion.state, &mut motion.memories);
            }
        } else {
            let now = Now { command, state: motion.state, voltages, index };
            let mut drive = self.drive::<GUIDED>(&now, motion, ahead);
            drive.torque += drive.load_torque;
            let state = &mut motion.state;
            step(&self.prepared.coefficients, self.effects.laws(), state, &drive);
            state.load_speed = state.speed;
            state.load_angle = state.angle;
            let now = Now { command: drive.asked, ..now };
            self.effects.settle(&now, &motion.state, &mut motion.memories);
        }
    }

    #[inline(always)]
    fn drive<const GUIDED: bool>(&self, now: &Now<S>, motion: &Motion<S>, ahead: S) -> Drive<S> {
        let seen = if GUIDED { now.state.turned(ahead) } else { now.state };
        let mut drive = Drive::plain(now.command);
        self.effects.drive(&Now { state: seen, ..*now }, &motion.memories, &mut drive);
        drive
    }

    /// Rotor by the exact map, load by its own torque, then the transmission between them.
    #[inline(always)]
    fn advance_two_masses(&self, state: &mut State<S>, drive: &Drive<S>) {
        step(&self.prepared.coefficients, self.effects.laws(), state, drive);
        if self.effects.laws().torque {
            state.load_speed = self.prepared.load_per_torque.mul_add(drive.load_torque, state.load_speed);
        }
        self.effects.couple(self.prepared.part, state);
    }

    /// What the encoder shows, rad of the output shaft, without its quantisation.
    #[inline(always)]
    pub fn read(&self, motion: &Motion<S>) -> S {
        self.read_seen(motion, motion.state)
    }

    /// [`Self::read`] in a simulation at the measured angle, see [`Self::advance_guided`].
    #[inline(always)]
    pub fn read_guided(&self, motion: &Motion<S>, ahead: S) -> S {
        self.read_seen(motion, motion.state.turned(ahead))
    }

    #[inline(always)]
    fn read_seen(&self, motion: &Motion<S>, seen: State<S>) -> S {
        let s = &motion.state;
        let mut reading = if self.prepared.setting.encoder_on_motor { s.angle } else { s.load_angle };
        self.effects.read(&seen, &motion.memories, &mut reading);
        reading
    }

    /// Current as a voltage (R i), V.
    #[inline(always)]
    pub fn current(&self, motion: &Motion<S>) -> S {
        motion.state.current
    }
}
