//! An encoder disc that sits off centre.

use super::spec::{EXPLICIT, Port, Scale, Spec, strength};
use super::wave::Wave;
use super::{Effect, Memory, Setting};
use crate::scalar::Scalar;
use crate::step::State;

pub(super) const SPEC: Spec = Spec {
    name: "eccentricity",
    port: Port::Sensor,
    title: "the encoder disc sits off centre: reading error once per its revolution",
    equation: "reading = x + sine sin(a) + cosine (cos(a) - 1),  a: angle of the encoder's shaft",
    source: "eccentric scale error of rotary encoders",
    signature: "residual angle repeats with every revolution of the encoder's shaft, at any speed, without inertia",
    parameters: &[
        strength("sine", "rad", "reading error, sine part", Scale::Count, [-60.0, 1.5, 60.0]),
        strength("cosine", "rad", "reading error, cosine part", Scale::Count, [-60.0, 1.5, 60.0]),
    ],
    probes: &[
        &[1.0, 0.0], &[0.0, 1.0], &[-1.0, 0.0], &[0.0, -1.0],
        &[5.0, 0.0], &[0.0, 5.0], &[-5.0, 0.0], &[0.0, -5.0],
    ],
    laws: EXPLICIT,
    remembers: false,
    contains: &[],
};

/// Reading error in two components; zero at angle zero.
#[derive(Debug, Clone, Copy)]
pub struct Eccentricity<S> {
    error: Wave<S>,
    at_zero: S,
    turns: S,
    on_motor: bool,
}

impl<S: Scalar> Eccentricity<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        let on_motor = setting.encoder_on_motor;
        let turns = if on_motor { setting.motor_turns } else { setting.output_turns };
        Self { error: Wave::new(parameters[0], parameters[1]), at_zero: parameters[1], turns, on_motor }
    }
}

impl<S: Scalar> Effect<S> for Eccentricity<S> {
    #[inline(always)]
    fn read(&self, state: &State<S>, _memory: &Memory<S>, reading: &mut S) {
        let turn = (if self.on_motor { state.angle } else { state.load_angle }) * self.turns;
        *reading += self.error.at(turn) - self.at_zero;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};

    #[test]
    fn reading_differs_by_the_stated_sine_and_motion_does_not() {
        let (angles, motion) = run(Kind::Eccentricity, &[0.004, 0.0], &[3.0; 700]);
        let x = motion.state.angle;
        close(angles[699], x + 0.004 * libm::sin(x * RIG.gear_ratio), 1e-9);
    }
}
