//! A PWM as the winding sees it: what of its period is off, and how long a diode conducts there.

use super::decay::ln_one_and;
use super::{Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::State;

/// A PWM of one frequency on a supply, before a winding. The effects that are made of it remember what the last step added to the speed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pwm<S> {
    /// Voltage of the supply, V.
    pub supply: S,
    per_supply: S,
    back_emf: S,
    /// Its period over the electrical time constant, and the inverse.
    pub period: S,
    per_period: S,
}

impl<S: Scalar> Pwm<S> {
    /// Of `frequency`, Hz.
    pub fn new(frequency: S, setting: &Setting<S>) -> Self {
        let per_period = frequency * setting.tau_e;
        Self {
            supply: S::one() / setting.per_supply,
            per_supply: setting.per_supply,
            back_emf: setting.back_emf,
            period: S::one() / per_period,
            per_period,
        }
    }

    /// Share of the period in which it is off under a `command` of 0 or more, V.
    #[inline(always)]
    pub fn off(&self, command: S) -> S {
        S::one() - (command * self.per_supply).min(S::one())
    }

    /// Share of the period in which a diode conducts a current that has `begun`, V, `against` a voltage, were there time enough.
    #[inline(always)]
    pub fn conducting(&self, begun: S, against: S) -> S {
        self.per_period * ln_one_and(begun, against)
    }

    /// Back-EMF in the middle of the step, V: that at its beginning would leave an error of first order.
    #[inline(always)]
    pub fn emf(&self, now: &Now<S>, memory: &Memory<S>) -> S {
        self.back_emf * memory.store.mul_add(S::lit(0.5), now.state.speed)
    }
}

/// Remembers what the step from `now` to `after` added to the speed.
#[inline(always)]
pub(super) fn remember<S: Scalar>(now: &Now<S>, after: &State<S>, memory: &mut Memory<S>) {
    memory.store = after.speed - now.state.speed;
}
