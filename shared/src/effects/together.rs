//! Effects that work together in one model, known when the program is compiled or when it runs.
//!
//! A set that the compiler knows ([`With`] ... [`Nothing`]) leaves no choice to be made in a step and keeps a block of
//! lanes in registers; [`Several`] holds any set and chooses at every step.

use super::{Active, Effect, Kind, Memory, Named, Now, Port, Setting, Spec};
use crate::scalar::Scalar;
use crate::step::{Drive, Laws, State};
use heapless::Vec;

/// Most effects that one model may hold.
pub const MAX_EFFECTS: usize = 6;

/// A set of effects in the order of the registry. `memories` holds one for each of them, or more.
pub trait Effects<S: Scalar> {
    /// What of a step they need.
    fn laws(&self) -> Laws;
    /// One of them stands between rotor and load.
    fn two_masses(&self) -> bool;
    /// See [`Effect::drive`].
    fn drive(&self, now: &Now<S>, memories: &[Memory<S>], drive: &mut Drive<S>);
    /// See [`Effect::begin`].
    fn begin(&self, state: &State<S>, memories: &mut [Memory<S>]);
    /// See [`Effect::settle`].
    fn settle(&self, now: &Now<S>, after: &State<S>, memories: &mut [Memory<S>]);
    /// See [`Effect::couple`].
    fn couple(&self, part: S, state: &mut State<S>);
    /// See [`Effect::show`].
    fn show(&self, state: &mut State<S>);
    /// See [`Effect::read`].
    fn read(&self, state: &State<S>, memories: &[Memory<S>], reading: &mut S);
}

/// The plain motor.
#[derive(Debug, Clone, Copy)]
pub struct Nothing;

impl<S: Scalar> Effects<S> for Nothing {
    #[inline(always)]
    fn laws(&self) -> Laws {
        Laws::default()
    }
    #[inline(always)]
    fn two_masses(&self) -> bool {
        false
    }
    #[inline(always)]
    fn drive(&self, _now: &Now<S>, _memories: &[Memory<S>], _drive: &mut Drive<S>) {}
    #[inline(always)]
    fn begin(&self, _state: &State<S>, _memories: &mut [Memory<S>]) {}
    #[inline(always)]
    fn settle(&self, _now: &Now<S>, _after: &State<S>, _memories: &mut [Memory<S>]) {}
    #[inline(always)]
    fn couple(&self, _part: S, _state: &mut State<S>) {}
    #[inline(always)]
    fn show(&self, _state: &mut State<S>) {}
    #[inline(always)]
    fn read(&self, _state: &State<S>, _memories: &[Memory<S>], _reading: &mut S) {}
}

/// One effect before others, which follow it in the registry.
#[derive(Debug, Clone, Copy)]
pub struct With<A, R>(pub A, pub R);

impl<S: Scalar, A: Named<S>, R: Effects<S>> Effects<S> for With<A, R> {
    #[inline(always)]
    fn laws(&self) -> Laws {
        A::SPEC.laws.and(self.1.laws())
    }
    #[inline(always)]
    fn two_masses(&self) -> bool {
        A::SPEC.transmits() || self.1.two_masses()
    }
    #[inline(always)]
    fn drive(&self, now: &Now<S>, memories: &[Memory<S>], drive: &mut Drive<S>) {
        self.0.drive(now, &memories[0], drive);
        self.1.drive(now, &memories[1..], drive);
    }
    #[inline(always)]
    fn begin(&self, state: &State<S>, memories: &mut [Memory<S>]) {
        self.0.begin(state, &mut memories[0]);
        self.1.begin(state, &mut memories[1..]);
    }
    #[inline(always)]
    fn settle(&self, now: &Now<S>, after: &State<S>, memories: &mut [Memory<S>]) {
        self.0.settle(now, after, &mut memories[0]);
        let (mut seen, mut seen_after) = (*now, *after);
        self.0.show(&mut seen.state);
        self.0.show(&mut seen_after);
        self.1.settle(&seen, &seen_after, &mut memories[1..]);
    }
    #[inline(always)]
    fn couple(&self, part: S, state: &mut State<S>) {
        self.0.couple(part, state);
        self.1.couple(part, state);
    }
    #[inline(always)]
    fn show(&self, state: &mut State<S>) {
        self.0.show(state);
        self.1.show(state);
    }
    #[inline(always)]
    fn read(&self, state: &State<S>, memories: &[Memory<S>], reading: &mut S) {
        self.0.read(state, &memories[0], reading);
        self.1.read(state, &memories[1..], reading);
    }
}

/// Any effects, up to [`MAX_EFFECTS`].
#[derive(Debug, Clone)]
pub struct Several<S> {
    active: Vec<Active<S>, MAX_EFFECTS>,
    laws: Laws,
    two_masses: bool,
    /// Where those that drive, transmit, sense and remember stand: the registry's order is that of the ports.
    driving: Places,
    transmitting: Places,
    sensing: Places,
    remembering: Places,
    /// A sensor shows another one something else than the shaft.
    chained: bool,
}

/// The first of some places, and that behind the last.
#[derive(Debug, Clone, Copy)]
struct Places(usize, usize);

impl Places {
    /// From the first effect that `is` what is asked to the last; a user's formula may be anything.
    fn of(effects: &[(Kind, &[impl Scalar])], is: impl Fn(&Spec) -> bool) -> Self {
        let is_one = |(kind, _): &(Kind, _)| matches!(kind, Kind::Formula(_)) || is(kind.spec());
        let effects = &effects[..effects.len().min(MAX_EFFECTS)];
        let end = effects.iter().rposition(is_one).map_or(0, |last| last + 1);
        Self(effects.iter().position(is_one).unwrap_or(0), end)
    }

    #[inline(always)]
    fn among<T>(self, all: &[T]) -> &[T] {
        all.get(self.0..self.1).unwrap_or_default()
    }

    #[inline(always)]
    fn among_mut<T>(self, all: &mut [T]) -> &mut [T] {
        all.get_mut(self.0..self.1).unwrap_or_default()
    }
}

impl<S: Scalar> Several<S> {
    /// Fixes the parameters (in each row's order); of more than [`MAX_EFFECTS`], the last are left out.
    #[must_use]
    pub fn new(effects: &[(Kind, &[S])], setting: &Setting<S>) -> Self {
        let any = |of: fn(Kind) -> bool| effects.iter().any(|(kind, _)| of(*kind));
        let chained = any(|kind| kind == Kind::Eccentricity) && any(|kind| kind == Kind::SensorLag);
        Self {
            active: effects.iter().take(MAX_EFFECTS).map(|(k, p)| Active::new(*k, p, setting)).collect(),
            laws: effects.iter().fold(Laws::default(), |laws, (kind, _)| laws.and(kind.spec().laws)),
            two_masses: any(Kind::is_transmission),
            driving: Places::of(effects, |spec| matches!(spec.port, Port::Voltage | Port::Torque)),
            transmitting: Places::of(effects, Spec::transmits),
            sensing: Places::of(effects, |spec| spec.port == Port::Sensor),
            remembering: Places::of(effects, |spec| spec.remembers || chained && spec.port == Port::Sensor),
            chained,
        }
    }
}

impl<S: Scalar> Effects<S> for Several<S> {
    #[inline(always)]
    fn laws(&self) -> Laws {
        self.laws
    }
    #[inline(always)]
    fn two_masses(&self) -> bool {
        self.two_masses
    }
    #[inline(always)]
    fn drive(&self, now: &Now<S>, memories: &[Memory<S>], drive: &mut Drive<S>) {
        for (effect, memory) in self.driving.among(&self.active).iter().zip(self.driving.among(memories)) {
            effect.drive(now, memory, drive);
        }
    }
    #[inline(always)]
    fn begin(&self, state: &State<S>, memories: &mut [Memory<S>]) {
        for (effect, memory) in self.active.iter().zip(memories) {
            effect.begin(state, memory);
        }
    }
    #[inline(always)]
    fn settle(&self, now: &Now<S>, after: &State<S>, memories: &mut [Memory<S>]) {
        let Places(first, end) = self.remembering;
        if first == end {
            // What is remembered costs two copies of the motion.
            return;
        }
        let (mut seen, mut seen_after) = (*now, *after);
        for (effect, memory) in
            self.remembering.among(&self.active).iter().zip(self.remembering.among_mut(memories))
        {
            effect.settle(&seen, &seen_after, memory);
            if self.chained {
                effect.show(&mut seen.state);
                effect.show(&mut seen_after);
            }
        }
    }
    #[inline(always)]
    fn couple(&self, part: S, state: &mut State<S>) {
        for effect in self.transmitting.among(&self.active) {
            effect.couple(part, state);
        }
    }
    #[inline(always)]
    fn show(&self, state: &mut State<S>) {
        for effect in self.sensing.among(&self.active) {
            effect.show(state);
        }
    }
    #[inline(always)]
    fn read(&self, state: &State<S>, memories: &[Memory<S>], reading: &mut S) {
        for (effect, memory) in self.sensing.among(&self.active).iter().zip(self.sensing.among(memories)) {
            effect.read(state, memory, reading);
        }
    }
}
