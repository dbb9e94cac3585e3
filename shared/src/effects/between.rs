//! What nearly every log has, around the effects that differ from motor to motor.
//!
//! A loop compiled for a set of effects is 3 to 4 times faster than one that asks each for its kind, and there are too many sets of three.
//! But most have a friction, and many a delay or a filter: whether these are there is known when the program runs, and holds for all of a
//! run. So a set has to be compiled with those only that are left.

use super::together::{Effects, MAX_EFFECTS};
use super::{Coulomb, CoulombAsymmetric, Delay, Effect, Kind, Memory, Named, Now, SensorLag, Setting};
use crate::scalar::Scalar;
use crate::step::{Drive, Laws, State};

/// The common effects, each with the field of [`Between`] that holds it: what a set is taken apart by and what is put in agree.
macro_rules! common {
    ($($kind:ident $field:ident),+ $(,)?) => {
        /// Whether [`Between`] holds such an effect itself: its set need not be compiled.
        #[must_use]
        pub const fn is_common(kind: Kind) -> bool {
            matches!(kind, $(Kind::$kind)|+)
        }

        impl<S: Scalar, E> Between<S, E> {
            /// Puts an effect in its field, where it is common.
            #[inline(always)]
            fn put(&mut self, kind: Kind, parameters: &[S], setting: &Setting<S>) {
                match kind {
                    $(Kind::$kind => self.$field = Some(<$kind<S> as Named<S>>::named(parameters, setting).into()),)+
                    _ => {}
                }
            }
        }
    };
}

common! {
    Delay delay,
    Coulomb friction,
    CoulombAsymmetric friction,
    SensorLag lag,
}

/// Effects behind a delay and dry friction, and before a filter, each of which may be absent.
#[derive(Debug, Clone, Copy)]
pub struct Between<S, E> {
    delay: Option<Delay<S>>,
    friction: Option<CoulombAsymmetric<S>>,
    effects: E,
    lag: Option<SensorLag<S>>,
}

/// The memory of what is late, behind those of the effects between.
const LATE: usize = MAX_EFFECTS - 1;

impl<S: Scalar, E: Effects<S>> Between<S, E> {
    /// The `effects`, fewer than [`MAX_EFFECTS`] and in the registry's order, with those of `common` (kind and parameters) that are common
    /// ([`is_common`]); of two frictions the last.
    #[inline(always)]
    pub fn new(common: &[(Kind, &[S])], effects: E, setting: &Setting<S>) -> Self {
        let mut all = Self { delay: None, friction: None, effects, lag: None };
        for (kind, parameters) in common {
            all.put(*kind, parameters, setting);
        }
        all
    }
}

impl<S: Scalar, E: Effects<S>> Effects<S> for Between<S, E> {
    #[inline(always)]
    fn laws(&self) -> Laws {
        let late = <Delay<S> as Named<S>>::SPEC.laws.and(<SensorLag<S> as Named<S>>::SPEC.laws);
        let laws = late.and(self.effects.laws());
        let dry = <CoulombAsymmetric<S> as Named<S>>::SPEC.laws;
        if self.friction.is_some() { laws.and(dry) } else { laws }
    }
    #[inline(always)]
    fn two_masses(&self) -> bool {
        self.effects.two_masses()
    }
    #[inline(always)]
    fn drive(&self, now: &Now<S>, memories: &[Memory<S>], drive: &mut Drive<S>) {
        if let Some(delay) = &self.delay {
            delay.drive(now, &memories[LATE], drive);
        }
        // It reads nothing of what other effects drive, and saturation reads what it drives.
        if let Some(friction) = &self.friction {
            friction.drive(now, &memories[LATE], drive);
        }
        self.effects.drive(now, memories, drive);
    }
    #[inline(always)]
    fn begin(&self, state: &State<S>, memories: &mut [Memory<S>]) {
        self.effects.begin(state, memories);
        if let Some(lag) = &self.lag {
            lag.begin(state, &mut memories[LATE]);
        }
    }
    #[inline(always)]
    fn settle(&self, now: &Now<S>, after: &State<S>, memories: &mut [Memory<S>]) {
        self.effects.settle(now, after, memories);
        if let Some(lag) = &self.lag {
            let (mut seen, mut seen_after) = (*now, *after);
            self.effects.show(&mut seen.state);
            self.effects.show(&mut seen_after);
            lag.settle(&seen, &seen_after, &mut memories[LATE]);
        }
    }
    #[inline(always)]
    fn couple(&self, part: S, state: &mut State<S>) {
        self.effects.couple(part, state);
    }
    #[inline(always)]
    fn show(&self, state: &mut State<S>) {
        self.effects.show(state);
    }
    #[inline(always)]
    fn read(&self, state: &State<S>, memories: &[Memory<S>], reading: &mut S) {
        self.effects.read(state, memories, reading);
        if let Some(lag) = &self.lag {
            lag.read(state, &memories[LATE], reading);
        }
    }
}
