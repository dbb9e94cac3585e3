//! The motor with its effects, run over a grid of held voltages.

use crate::base::{Base, Coefficients};
use crate::effects::{Active, Effect, Kind, Memory, Now, Rig, Setting};
use crate::scalar::Scalar;
use crate::step::{Drive, State, step};
use heapless::Vec;

/// Most effects that one model may hold.
pub const MAX_EFFECTS: usize = 6;
/// Most parameters that one effect has.
pub const MAX_PARAMETERS: usize = 4;

/// A gap or a spring in the transmission is integrated in this many parts of a step.
const TRANSMISSION_PARTS: usize = 4;

/// Base model and effects with their parameters fixed: everything that does not change while it runs.
#[derive(Debug, Clone)]
pub struct Simulator<S> {
    coefficients: Coefficients<S>,
    setting: Setting<S>,
    active: Vec<Active<S>, MAX_EFFECTS>,
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
        let mut active = Vec::new();
        let mut load_share = S::zero();
        let mut two_masses = false;
        let setting = Setting::new(base, rig);
        for (kind, parameters) in effects {
            if let (Some(index), false) = (kind.spec().load_share(), two_masses) {
                two_masses = true;
                load_share = parameters[index];
            }
            // A seventh effect has no place: callers are held to MAX_EFFECTS by the model file.
            let _ = active.push(Active::new(kind, parameters, &setting));
        }
        let parts = if two_masses { TRANSMISSION_PARTS } else { 1 };
        let rotor = if two_masses { base.without_load(load_share) } else { *base };
        let coefficients = Coefficients::new(&rotor, S::lit(rig.step_s / parts as f64));
        Self { coefficients, setting, active, parts, load_share }
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
        for _ in 0..self.parts {
            let now = self.now(&motion.state, voltages, index);
            let mut drive = Drive::plain(now.command);
            for (effect, memory) in self.active.iter().zip(&motion.memory) {
                effect.drive(&now, memory, &mut drive);
            }
            if self.parts == 1 {
                drive.torque += drive.load_torque;
                step(&self.coefficients, &mut motion.state, &drive);
                motion.state.load_speed = motion.state.speed;
                motion.state.load_angle = motion.state.angle;
            } else {
                self.advance_two_masses(&mut motion.state, &drive);
            }
            for (effect, memory) in self.active.iter().zip(&mut motion.memory) {
                effect.settle(&now, &motion.state, memory);
            }
        }
    }

    /// Rotor by the exact map, load by its own torque, then the transmission between them.
    #[inline(always)]
    fn advance_two_masses(&self, state: &mut State<S>, drive: &Drive<S>) {
        let part = self.coefficients.half_step + self.coefficients.half_step;
        step(&self.coefficients, state, drive);
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
