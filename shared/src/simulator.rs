//! The motor with its effects, run over a grid of held voltages.

use crate::base::{Base, Coefficients};
use crate::effects::{Active, Effect, Kind, Memory, Now, Rig, Setting};
use crate::scalar::Scalar;
use crate::step::{Drive, Laws, State, step};
use heapless::Vec;

/// Most effects that one model may hold.
pub const MAX_EFFECTS: usize = 6;
/// Most parameters that one effect has.
pub const MAX_PARAMETERS: usize = 4;

/// A gap or a spring in the transmission is integrated in this many parts of a step.
pub const TRANSMISSION_PARTS: usize = 4;

/// Base model and effects with their parameters fixed: everything that does not change while it runs.
#[derive(Debug, Clone)]
pub struct Simulator<S> {
    coefficients: Coefficients<S>,
    setting: Setting<S>,
    active: Vec<Active<S>, MAX_EFFECTS>,
    laws: Laws,
    remembers: bool,
    parts: usize,
    load_share: S,
}

/// What changes while a [`Simulator`] runs.
#[derive(Debug, Clone, Copy)]
pub struct Motion<S> {
    /// Current, speed and angle.
    pub state: State<S>,
    memory: [Memory<S>; MAX_EFFECTS],
}

impl<S: Scalar> Simulator<S> {
    /// Prepares `base` with `effects` (kind and parameters in the registry's order) on `rig`.
    ///
    /// At most [`MAX_EFFECTS`] are used, and the first transmission among them.
    pub fn new<'a>(base: &Base<S>, effects: impl IntoIterator<Item = (Kind, &'a [S])>, rig: &Rig) -> Self {
        let effects: Vec<(Kind, &[S]), MAX_EFFECTS> = effects.into_iter().take(MAX_EFFECTS).collect();
        let two_masses = effects.iter().any(|(kind, _)| kind.spec().load_share().is_some());
        let parts = if two_masses { TRANSMISSION_PARTS } else { 1 };
        let setting = Setting::new(base, rig, parts);
        let mut active = Vec::new();
        let mut laws = Laws::default();
        let mut remembers = false;
        let mut load_share = S::zero();
        let mut coupled = false;
        for (kind, parameters) in effects {
            if let (Some(index), false) = (kind.spec().load_share(), coupled) {
                coupled = true;
                load_share = parameters[index];
            }
            let needs = kind.spec().laws;
            laws.resistive |= needs.resistive;
            laws.dry |= needs.dry;
            laws.meshing |= needs.meshing;
            laws.gradual |= needs.gradual;
            remembers |= kind.spec().remembers;
            // There is room: no more than MAX_EFFECTS were taken.
            let _ = active.push(Active::new(kind, parameters, &setting));
        }
        let rotor = if two_masses { base.without_load(load_share) } else { *base };
        let coefficients = Coefficients::new(&rotor, S::lit(rig.step_s / parts as f64));
        Self { coefficients, setting, active, laws, remembers, parts, load_share }
    }

    /// Starts from `state`, with every effect's own memory empty.
    pub fn start(&self, state: State<S>) -> Motion<S> {
        Motion { state, memory: [Memory::empty(state.angle); MAX_EFFECTS] }
    }

    #[inline(always)]
    fn now<'a>(&self, s: &State<S>, voltages: &'a [S::Element], index: usize) -> Now<'a, S> {
        let command = S::splat(voltages[index]);
        Now { command, state: *s, voltages, index }
    }

    /// Advances over cell `index` of the grid, whose mean voltages are `voltages`.
    #[inline(always)]
    pub fn advance(&self, motion: &mut Motion<S>, voltages: &[S::Element], index: usize) {
        if self.parts == 1 {
            let now = self.now(&motion.state, voltages, index);
            let mut drive = self.drive(&now, motion);
            drive.torque += drive.load_torque;
            let mut state = now.state;
            step(&self.coefficients, self.laws, &mut state, &drive);
            state.load_speed = state.speed;
            state.load_angle = state.angle;
            self.settle(&now, state, motion);
        } else {
            for _ in 0..TRANSMISSION_PARTS {
                let now = self.now(&motion.state, voltages, index);
                let drive = self.drive(&now, motion);
                let mut state = now.state;
                self.advance_two_masses(&mut state, &drive);
                self.settle(&now, state, motion);
            }
        }
    }

    #[inline(always)]
    fn drive(&self, now: &Now<S>, motion: &Motion<S>) -> Drive<S> {
        let mut drive = Drive::plain(now.command);
        for (effect, memory) in self.active.iter().zip(&motion.memory) {
            effect.drive(now, memory, &mut drive);
        }
        drive
    }

    #[inline(always)]
    fn settle(&self, now: &Now<S>, state: State<S>, motion: &mut Motion<S>) {
        motion.state = state;
        if self.remembers {
            for (effect, memory) in self.active.iter().zip(&mut motion.memory) {
                effect.settle(now, &state, memory);
            }
        }
    }

    /// Rotor by the exact map, load by its own torque, then the transmission between them.
    #[inline(always)]
    fn advance_two_masses(&self, state: &mut State<S>, drive: &Drive<S>) {
        let part = self.coefficients.half_step + self.coefficients.half_step;
        step(&self.coefficients, self.laws, state, drive);
        state.load_speed += part * self.setting.acceleration * drive.load_torque / self.load_share;
        for effect in &self.active {
            effect.couple(part, state);
        }
    }

    /// What the encoder shows, rad of the output shaft, without its quantisation.
    #[inline(always)]
    pub fn read(&self, motion: &Motion<S>) -> S {
        let s = &motion.state;
        let mut reading = if self.setting.encoder_on_motor { s.angle } else { s.load_angle };
        for (effect, memory) in self.active.iter().zip(&motion.memory) {
            effect.read(s, memory, &mut reading);
        }
        reading
    }

    /// Current as a voltage (R i), V.
    #[inline(always)]
    pub fn current(&self, motion: &Motion<S>) -> S {
        motion.state.current
    }
}
