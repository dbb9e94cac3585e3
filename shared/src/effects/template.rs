//! Template: a torque that grows with speed, beyond what the base model has. Copy this file, add its line to
//! the registry in `mod.rs`, and run `cargo test -p motorlens-shared`: the tests there hold for every row.
//!
//! Equation, source and signature stand in the row, because users read them too (`motorlens effects`).

use super::spec::{Port, Scale, Search, Spec, TORQUE, strength};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

/// The row: everything that help, bounds, legends and the board's capability message are made of.
pub(super) const SPEC: Spec = Spec {
    name: "template",
    port: Port::Torque,
    title: "a torque against the motion, proportional to speed",
    equation: "f = -drag w",
    source: "a worked example",
    signature: "residual torque on a straight line through zero when drawn over speed",
    parameters: &[strength("drag", "V s/rad", "torque per speed", Scale::One, [0.0, 0.01, 1.0])],
    probes: &[&[0.01], &[0.1]],
    search: Search::Probes,
    laws: TORQUE,
    remembers: false,
    periodic: false,
    by_duty: false,
    contains: &[],
};

/// Parameters, in the numbers that the step needs. Immutable: what changes while it runs is in [`Memory`].
#[derive(Debug, Clone, Copy)]
pub struct Template<S> {
    drag: S,
}

impl<S: Scalar> Template<S> {
    pub(super) fn new(parameters: &[S], _setting: &Setting<S>) -> Self {
        Self { drag: parameters[0] }
    }
}

impl<S: Scalar> Effect<S> for Template<S> {
    #[inline(always)]
    fn drive(&self, now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        // Branch-free, so that one source runs in vector lanes and in fixed point.
        drive.torque -= self.drag * now.state.speed;
    }
}

#[test]
fn the_template_slows_the_motor_as_its_equation_says() {
    use super::testing::{BASE, RIG, close};
    let setting = Setting::new(&BASE, &RIG, 1);
    let effect = Template::new(&[0.1], &setting);
    let state = crate::step::State::moving(0.0, 5.0, 0.0);
    let now = Now { command: 0.0, state, voltages: &[0.0], index: 0 };
    let mut drive = Drive::plain(0.0);
    effect.drive(&now, &Memory::empty(0.0), &mut drive);
    close(drive.torque, -0.5, 1e-12);
    assert_eq!(SPEC.parameters.len(), 1);
}
