//! A counter that misses edges at speed.

use super::spec::{EXPLICIT, Port, Scale, Spec, shape, strength, Search};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::State;

pub(super) const SPEC: Spec = Spec {
    name: "lost_counts",
    port: Port::Sensor,
    title: "the counter misses edges above a speed",
    equation: "reading = x - integral of share w where |w| > threshold",
    source: "polled quadrature decoding, slow opto-couplers",
    signature: "angle falls behind at high speed only, and never comes back; slow motion fits",
    parameters: &[
        strength("share", "1", "share of counts lost", Scale::One, [0.0, 0.01, 0.6]),
        shape("threshold", "rad/s", "speed above which they are lost", Scale::Speed, [0.03, 0.35, 1.2]),
    ],
    probes: &[
        &[0.004, 0.2], &[0.004, 0.35], &[0.004, 0.6], &[0.03, 0.2], &[0.03, 0.35], &[0.03, 0.6],
        &[0.2, 0.35], &[0.2, 0.6],
    ],
    search: Search::Probes,
    laws: EXPLICIT,
    remembers: true,
    periodic: false,
    by_duty: false,
    contains: &[],
};

/// Loss of a share above a speed; memory holds the angle lost.
#[derive(Debug, Clone, Copy)]
pub struct LostCounts<S> {
    share: S,
    threshold: S,
    per_width: S,
}

impl<S: Scalar> LostCounts<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        // A little width keeps the error's slope against the threshold finite for the fit.
        let width = setting.reference_speed * S::lit(0.02);
        Self { share: parameters[0], threshold: parameters[1], per_width: S::one() / width }
    }
}

impl<S: Scalar> Effect<S> for LostCounts<S> {
    #[inline(always)]
    fn settle(&self, now: &Now<S>, after: &State<S>, memory: &mut Memory<S>) {
        let above = (after.load_speed.abs() - self.threshold) * self.per_width + S::lit(0.5);
        let active = above.clamp(S::zero(), S::one());
        memory.store += self.share * active * (after.load_angle - now.state.load_angle);
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
    fn loses_the_stated_share_above_the_threshold_and_nothing_below() {
        let (fast, motion) = run(Kind::LostCounts, &[0.1, 1.0], &[10.0; 3000]);
        let lost = motion.state.angle - fast[2999];
        close(lost, 0.1 * motion.state.angle, 0.1 * 0.01);
        let (slow, motion) = run(Kind::LostCounts, &[0.1, 1.0], &[1.0; 3000]);
        close(slow[2999], motion.state.angle, 1e-12);
    }
}
