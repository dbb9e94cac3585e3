//! Records that begin in motion, under a model: how fast, and what that leaves to the model.

use super::candidate::Candidate;
use super::evidence::Evidence;

impl Evidence {
    /// Fits the first speeds of the records that begin in motion anew under `model`, then the model, until that gains no
    /// more.
    pub fn settle_starts(&mut self, model: Candidate) -> Candidate {
        const ROUNDS: usize = 4;
        const GAIN: f64 = 0.02;
        const NEAR: f64 = 0.3;
        let mut model = model;
        for _ in 0..ROUNDS {
            // A start that is wrong shows in the error itself.
            let (values, near, before) = (model.values(), model.excess() < NEAR, model.merit());
            let mut moving = false;
            let each = [&mut self.whole, &mut self.train, &mut self.unseen];
            for problem in each.into_iter().chain(&mut self.kept_out) {
                let slow = near && problem.find_slow_starts(&values);
                if slow || problem.grids.iter().any(|grid| !grid.rests()) {
                    problem.refine_starts(&values, near);
                    moving = true;
                }
            }
            if !moving {
                break;
            }
            model = self.fit(&values, 6);
            if model.merit() > before - GAIN {
                break;
            }
        }
        model
    }

    /// The same where `base` does not explain records that seem to begin at rest, and does once they begin in slow motion.
    pub fn settle_slow_starts(&mut self, base: Candidate) -> Candidate {
        if base.explains() {
            return base;
        }
        let (mut trial, values) = (self.clone(), base.values());
        let each = [&mut trial.whole, &mut trial.train, &mut trial.unseen];
        let slow =
            each.into_iter().chain(&mut trial.kept_out).map(|problem| problem.find_slow_starts(&values));
        if slow.filter(|slow| *slow).count() == 0 {
            return base;
        }
        let again = trial.fit(&values, 6);
        let settled = trial.settle_starts(again);
        if settled.explains() {
            *self = trial;
            return settled;
        }
        base
    }
}

#[cfg(test)]
mod tests {
    use crate::diagnose::discover::prepare;
    use crate::exam::case::{Case, Conditions};

    /// At 7 of 192 rad/s: under 10 V the first milliseconds look as they do from rest.
    #[test]
    fn a_motor_that_turns_slowly_when_its_records_begin_is_a_plain_motor() {
        let case = Case::new(32_100_123, &[], Conditions { disturbed: 0.5, spoilt: 0.15 });
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        assert!(base.explains(), "{:?}", base.records);
        assert!(evidence.train.grids.iter().all(|grid| !grid.rests()));
    }
}
