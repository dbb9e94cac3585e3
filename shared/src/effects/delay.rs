//! The voltage arrives late.

use super::spec::{EXPLICIT, Port, Scale, Spec, strength, Search};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "delay",
    port: Port::Voltage,
    title: "the voltage acts later than the log says (computing, radio, filters)",
    equation: "v(t) = v_log(t - time)",
    source: "transport delay",
    signature: "the response is the model's, shifted; residual peaks at every jump of the voltage",
    parameters: &[strength("time", "s", "dead time from voltage to torque", Scale::Millisecond, [0.0, 3.0, 300.0])],
    probes: &[&[1.0], &[3.0], &[8.0], &[20.0], &[45.0]],
    search: Search::Probes,
    laws: EXPLICIT,
    remembers: false,
    periodic: false,
    by_duty: false,
    contains: &[],
};

/// A delay of `steps` cells of the grid.
#[derive(Debug, Clone, Copy)]
pub struct Delay<S> {
    steps: S,
}

impl<S: Scalar> Delay<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        Self { steps: parameters[0] / setting.cell }
    }
}

impl<S: Scalar> Effect<S> for Delay<S> {
    /// The mean over a shifted cell is the weighted mean of the two cells it covers: exact for held voltages.
    #[inline(always)]
    fn drive(&self, now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        drive.voltage += S::look_back(now.voltages, now.index, self.steps) - now.command;
        drive.asked = drive.voltage;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};

    #[test]
    fn whole_steps_shift_the_answer_exactly() {
        let mut jump = [5.0; 600];
        jump[..100].fill(0.0);
        let late = run(Kind::Delay, &[0.040], &jump).0;
        let prompt = run(Kind::Delay, &[0.0], &jump).0;
        assert_eq!(prompt[300], late[340]);
        assert_eq!(late[139], 0.0);
    }
}
