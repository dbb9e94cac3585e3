//! A filtered or stale reading.

use super::spec::{EXPLICIT, Port, Scale, Spec, strength};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::State;

pub(super) const SPEC: Spec = Spec {
    name: "sensor_lag",
    port: Port::Sensor,
    title: "the reading is filtered or stale (low-pass, averaging, slow bus)",
    equation: "time d(reading)/dt = x - reading",
    source: "first-order filter; the mean age of stale samples acts alike",
    signature: "the reading trails in proportion to speed; jumps of speed are rounded",
    parameters: &[strength("time", "s", "time constant of the filter", Scale::Millisecond, [0.0, 5.0, 200.0])],
    probes: &[&[1.5], &[5.0], &[15.0], &[50.0]],
    laws: EXPLICIT,
    remembers: true,
    contains: &[],
};

/// First-order filter; memory holds how far the reading trails.
#[derive(Debug, Clone, Copy)]
pub struct SensorLag<S> {
    keep: S,
    ramp: S,
    on_motor: bool,
}

impl<S: Scalar> SensorLag<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        // First order over a step h: the trail decays by e^{-h/T} and a steady speed trails by T w. The Pade
        // quotient of e^{-z} at z = h/T is positive for every T, also for T = 0.
        let (time, h) = (parameters[0], setting.step);
        let num = S::lit(12.0) * time * time - S::lit(6.0) * time * h + h * h;
        let den = S::lit(12.0) * time * time + S::lit(6.0) * time * h + h * h;
        let keep = num / den;
        let keep = S::pick_gt(h, S::lit(4.0) * time, S::zero(), keep);
        Self { keep, ramp: time * (S::one() - keep) / h, on_motor: setting.encoder_on_motor }
    }
}

impl<S: Scalar> Effect<S> for SensorLag<S> {
    #[inline(always)]
    fn settle(&self, now: &Now<S>, after: &State<S>, memory: &mut Memory<S>) {
        let moved = if self.on_motor {
            after.angle - now.state.angle
        } else {
            after.load_angle - now.state.load_angle
        };
        memory.store = self.keep.mul_add(memory.store, self.ramp * moved);
    }
    #[inline(always)]
    fn read(&self, _state: &State<S>, memory: &Memory<S>, reading: &mut S) {
        *reading -= memory.store;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};

    #[test]
    fn steady_speed_trails_by_time_times_speed() {
        let (angles, motion) = run(Kind::SensorLag, &[0.02], &[6.0; 2000]);
        close(motion.state.angle - angles[1999], 0.02 * motion.state.speed, 1e-9);
    }
}
