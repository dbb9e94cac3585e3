//! A weak supply: its voltage falls as the motor draws from it.

use super::spec::{SERIES, Port, Scale, Spec, strength};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "supply_sag",
    port: Port::Voltage,
    title: "a weak supply: the voltage falls with the current drawn",
    equation: "v = v_log - resistance (v_log / supply)^2 u",
    source: "a bridge at duty d draws d i from a source of resistance R_s, and passes on d of what is left",
    signature: "too little torque at full duty and high current, none missing at low duty",
    parameters: &[strength("resistance", "1", "source resistance per winding resistance", Scale::One, [0.0, 0.2, 4.0])],
    probes: &[&[0.1], &[0.35], &[0.8]],
    laws: SERIES,
    remembers: false,
    contains: &[],
};

/// Source resistance as a share of the winding's.
#[derive(Debug, Clone, Copy)]
pub struct SupplySag<S> {
    resistance: S,
    per_supply: S,
}

impl<S: Scalar> SupplySag<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        Self { resistance: parameters[0], per_supply: setting.per_supply }
    }
}

impl<S: Scalar> Effect<S> for SupplySag<S> {
    #[inline(always)]
    fn drive(&self, now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        let duty = now.command * self.per_supply;
        drive.series += self.resistance * duty * duty;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};

    /// Steady: u = b w / c, so w (1 / gain + s b / c) = v with s the resistance at this duty.
    #[test]
    fn steady_speed_solves_the_balance() {
        let v = 6.0;
        let s = 0.8 * (v / RIG.supply_v) * (v / RIG.supply_v);
        let truth = v * BASE.gain / (1.0 + s * BASE.viscous_share);
        close(steady_speed(Kind::SupplySag, &[0.8], v), truth, 1e-9);
    }
}
