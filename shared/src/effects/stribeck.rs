//! Dry friction that falls as the lubricant begins to carry.

use super::spec::{DRY, Port, Scale, Spec, shape, strength, Search};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::{Drive, State};

pub(super) const SPEC: Spec = Spec {
    name: "stribeck",
    port: Port::Torque,
    title: "dry friction with a higher break-away level (Stribeck)",
    equation: "f = -(level + excess / (1 + s + s^2/2 + s^3/6)) sign(w),  s = tail x + (1 - tail) x^2,  x = |w| / speed",
    source: "Stribeck 1902; Tustin 1947 (x), Armstrong-Helouvry 1991 (x^2); the quotient follows exp(-s)",
    signature: "residual torque steps at zero speed and falls within a few per cent of the top speed; stick-slip at slow triangles",
    parameters: &[
        strength("level", "V", "friction at speed, as a voltage", Scale::Volt, [0.0, 0.2, 10.0]),
        strength("excess", "V", "break-away level above it", Scale::Volt, [0.0, 0.15, 5.0]),
        shape("speed", "rad/s", "where the excess has fallen to 38 %", Scale::Speed, [0.002, 0.02, 0.2]),
        shape("tail", "1", "shape of the excess: 0 falls like a bell, 1 like an exponential", Scale::One, [0.0, 0.4, 1.0]),
    ],
    probes: &[&[0.2, 0.14, 0.01, 0.4], &[0.2, 0.14, 0.035, 0.4], &[0.7, 0.5, 0.01, 0.4], &[0.7, 0.5, 0.035, 0.4]],
    search: Search::Probes,
    laws: DRY,
    remembers: true,
    periodic: false,
    by_duty: false,
    contains: &[("coulomb", "level")],
};

/// Dry friction `level + excess` at rest, `level` at speed; memory holds what the last step added to the speed.
#[derive(Debug, Clone, Copy)]
pub struct Stribeck<S> {
    level: S,
    excess: S,
    per_speed: S,
    tail: S,
    bell: S,
}

impl<S: Scalar> Stribeck<S> {
    pub(super) fn new(parameters: &[S], _setting: &Setting<S>) -> Self {
        let (level, excess, tail) = (parameters[0], parameters[1], parameters[3]);
        Self { level, excess, per_speed: S::one() / parameters[2], tail, bell: S::one() - tail }
    }
}

/// What is left of the excess: e^-s to the third power of s, above it by 3 % of the excess at most. Its longer tail shows a
/// search the way to a fall that is over within the first steps.
#[inline(always)]
fn fall<S: Scalar>(s: S) -> S {
    let inner = s.mul_add(S::lit(1.0 / 6.0), S::lit(0.5));
    S::one() / inner.mul_add(s, S::one()).mul_add(s, S::one())
}

impl<S: Scalar> Effect<S> for Stribeck<S> {
    #[inline(always)]
    fn drive(&self, now: &Now<S>, memory: &Memory<S>, drive: &mut Drive<S>) {
        // The speed in the middle of the step: at low gears a motor passes much of the fall within one. What stopped the
        // motor in the last step does not go on: at rest it is at rest.
        let speed = now.state.speed;
        let middle = (S::lit(0.5) * memory.store).mul_add(speed.sign(), speed.abs());
        let x = middle.max(S::zero()) * self.per_speed;
        let friction = self.excess.mul_add(fall(x * self.bell.mul_add(x, self.tail)), self.level);
        drive.friction_forward += friction;
        drive.friction_backward += friction;
    }
    #[inline(always)]
    fn settle(&self, now: &Now<S>, after: &State<S>, memory: &mut Memory<S>) {
        memory.store = after.speed - now.state.speed;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};
    use crate::step::State;

    #[test]
    fn breaks_away_above_level_plus_excess_only() {
        assert_eq!(steady_speed(Kind::Stribeck, &[0.3, 0.2, 0.1, 0.4], 0.49), 0.0);
        assert!(steady_speed(Kind::Stribeck, &[0.3, 0.2, 0.1, 0.4], 0.53) > 0.0);
    }

    #[test]
    fn the_fall_is_that_at_the_middle_of_the_step() {
        let gain = gain_of_half_steps(Kind::Stribeck, &[0.2, 0.4, 2.0, 0.4]);
        assert!(gain > 3.0, "half the step leaves 1/{gain:.1} of the error");
    }

    /// Just stopped, a motor has to break away at once.
    #[test]
    fn what_stopped_the_motor_does_not_go_on() {
        let start = State::moving(0.0, 0.01, 0.0);
        let shape = [0.3, 0.2, 0.001, 0.0];
        let (_, stopped) = run_from(start, Kind::Stribeck, &shape, &[-0.2, 0.49, 0.49, 0.49, 0.49, 0.49]);
        assert_eq!(stopped.state.speed, 0.0);
    }

    #[test]
    fn at_speed_only_the_level_is_left() {
        close(steady_speed(Kind::Stribeck, &[0.3, 0.2, 0.1, 0.4], 6.0), BASE.gain * 5.7, 1e-4);
    }
}
