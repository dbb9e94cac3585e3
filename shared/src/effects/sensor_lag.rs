//! A filtered or stale reading.

use super::spec::{EXPLICIT, Port, Scale, Spec, shown, strength, Search};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::State;

pub(super) const SPEC: Spec = Spec {
    name: "sensor_lag",
    port: Port::Sensor,
    title: "the reading is filtered or stale (low-pass, averaging, slow bus)",
    equation: "time d(reading)/dt = x - reading; or, with hold, reading = x(k hold) for hold seconds",
    source: "first-order filter; zero-order hold",
    signature: "the reading trails in proportion to speed; jumps of speed are rounded",
    parameters: &[
        strength("time", "s", "time constant of the filter", Scale::Millisecond, [0.0, 5.0, 200.0]),
        shown("hold", "s", "how long a reading is held; 0: it is filtered", Scale::Millisecond, [0.0, 5.0, 500.0]),
    ],
    // How long a reading is held shows in the data.
    probes: &[&[1.5, 0.0], &[5.0, 0.0], &[15.0, 0.0], &[50.0, 0.0]],
    search: Search::Hold("hold"),
    laws: EXPLICIT,
    remembers: true,
    periodic: false,
    by_duty: false,
    contains: &[],
};

/// First-order filter or hold; memory holds how far the reading trails, and how old a held one is.
#[derive(Debug, Clone, Copy)]
pub struct SensorLag<S> {
    time: S,
    keep: S,
    ramp: S,
    step: S,
    hold: S,
    /// What whole holds leave of a step.
    rest: S,
    /// The reading is updated within a step where its age exceeds the hold by more than this.
    updated_above: S,
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
        let ramp = time * (S::one() - keep) / h;
        let hold = parameters[1];
        Self {
            time,
            keep,
            ramp,
            step: h,
            hold,
            rest: h.map_with(hold, |step, hold| {
                // Holds that divide the step leave nothing, whatever the last digit.
                let whole = if hold > 0.0 { libm::floor(step / hold + 1e-9) } else { 0.0 };
                if step > hold { (step - whole * hold).max(0.0) } else { step }
            }),
            // Of several updates in a step the last counts, and there is one in every step.
            updated_above: S::pick_gt(h, hold, -hold, S::zero()),
            on_motor: setting.encoder_on_motor,
        }
    }
}

impl<S: Scalar> Effect<S> for SensorLag<S> {
    #[inline(always)]
    fn begin(&self, state: &State<S>, memory: &mut Memory<S>) {
        let speed = if self.on_motor { state.speed } else { state.load_speed };
        memory.store = speed * S::pick_gt(self.hold, S::zero(), memory.age, self.time);
    }
    #[inline(always)]
    fn settle(&self, now: &Now<S>, after: &State<S>, memory: &mut Memory<S>) {
        let moved = if self.on_motor {
            after.angle - now.state.angle
        } else {
            after.load_angle - now.state.load_angle
        };
        let zero = S::zero();
        let filtered = self.keep.mul_add(memory.store, self.ramp * moved);
        // A new reading within the step is as old as what is left of it.
        let older = memory.age + self.rest;
        let over = older - self.hold;
        memory.age = S::pick_gt(zero, over, older, over);
        let trail = moved * memory.age / self.step;
        let held = S::pick_gt(self.updated_above, over, memory.store + moved, trail);
        memory.store = S::pick_gt(self.hold, zero, held, filtered);
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
        let (angles, motion) = run(Kind::SensorLag, &[0.02, 0.0], &[6.0; 2000]);
        close(motion.state.angle - angles[1999], 0.02 * motion.state.speed, 1e-9);
    }

    #[test]
    fn a_record_that_begins_in_motion_begins_with_the_trail() {
        use crate::simulator::Simulator;
        use crate::step::State;
        let speed = BASE.gain * 6.0;
        for (parameters, age, trail) in [([0.02, 0.0], 0.0, 0.02), ([0.0, 0.03], 0.012, 0.012)] {
            let simulator = Simulator::new(&BASE, [(Kind::SensorLag, &parameters[..])], &RIG);
            let mut motion = simulator.start_aged(State::moving(6.0 - BASE.back_emf() * speed, speed, 0.5), age);
            close(simulator.read(&motion), 0.5 - trail * speed, 1e-9);
            simulator.advance(&mut motion, &[6.0, 6.0], 1);
            let moved = if age > 0.0 { 0.0 } else { speed * RIG.step_s };
            close(simulator.read(&motion), 0.5 - trail * speed + moved, 1e-6);
        }
    }

    #[test]
    fn a_held_reading_is_updated_at_multiples_of_its_time_many_or_few_to_a_step() {
        let truth = run(Kind::SensorLag, &[0.0, 0.0], &[6.0; 2000]).0;
        for hold in [12.4, 2.708_3, 1.371_7, 0.831_9, 0.371_7, 0.131_37] {
            let held = run(Kind::SensorLag, &[0.0, 1e-3 * hold], &[6.0; 2000]).0;
            for (k, reading) in held.iter().enumerate().skip(20) {
                // Between two steps the shaft moves evenly enough.
                let updated = libm::floor((k + 1) as f64 / hold + 1e-9) * hold - 1.0;
                let (before, part) = (updated as usize, updated.fract());
                close(*reading, truth[before] + part * (truth[before + 1] - truth[before]), 2e-5);
            }
        }
    }

    #[test]
    fn a_hold_that_divides_the_step_is_updated_at_its_end() {
        let truth = run(Kind::SensorLag, &[0.0, 0.0], &[6.0; 200]).0;
        for hold in [5e-4, 2e-4, 1e-4, 1e-3 / 3.0] {
            assert_eq!(run(Kind::SensorLag, &[0.0, hold], &[6.0; 200]).0, truth);
        }
    }
}
