//! Records that begin in motion, under a model: how fast, and what that leaves to the model.

use super::candidate::Candidate;
use super::evidence::Evidence;
use crate::fit::search::Problem;
use crate::fit::start::Start;

impl Evidence {
    fn problems(&mut self) -> impl Iterator<Item = &mut Problem> {
        [&mut self.whole, &mut self.train, &mut self.unseen].into_iter().chain(&mut self.kept_out)
    }

    /// Fits the first speeds of the records that begin in motion anew under `model`, then the model, until that gains no
    /// more.
    pub fn settle_starts(&mut self, model: Candidate) -> Candidate {
        const ROUNDS: usize = 4;
        const GAIN: f64 = 0.02;
        const NEAR: f64 = 0.5;
        let mut model = model;
        for _ in 0..ROUNDS {
            // A start that is wrong shows in the error itself.
            let (values, near, before) = (model.values(), model.excess() < NEAR, model.merit());
            let kept: Vec<Vec<Start>> = self.problems().map(|problem| problem.starts()).collect();
            let mut moving = false;
            for problem in self.problems() {
                let slow = near && problem.find_slow_starts(&values);
                if slow || problem.grids.iter().any(|grid| !grid.rests()) {
                    problem.refine_starts(&values, near);
                    moving = true;
                }
            }
            if !moving {
                break;
            }
            let settled = self.fit(&values, 6);
            if settled.merit() > before {
                self.problems().zip(kept).for_each(|(problem, starts)| problem.set_starts(&starts));
                break;
            }
            model = settled;
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
        let slow = trial.problems().map(|problem| problem.find_slow_starts(&values));
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
    use motorlens_shared::effects::Kind;
    use motorlens_virtual_motor::Kind as Hidden;

    /// At 7 of 192 rad/s: under 10 V the first milliseconds look as they do from rest.
    #[test]
    fn a_motor_that_turns_slowly_when_its_records_begin_is_a_plain_motor() {
        let case = Case::new(32_100_123, &[], Conditions { disturbed: 0.5, spoilt: 0.15 });
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        assert!(base.explains(), "{:?}", base.records);
        assert!(evidence.train.grids.iter().all(|grid| !grid.rests()));
    }

    /// Of 10 V from the start on, which drive it further.
    #[test]
    fn a_motor_that_turns_the_way_it_is_driven_begins_in_motion_all_the_same() {
        let hidden = [Hidden::QuadraticDrag, Hidden::Eccentricity];
        let case = Case::new(35_200_007, &hidden, Conditions { disturbed: 0.25, spoilt: 0.15 });
        let (evidence, _) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        assert!(evidence.train.grids.iter().all(|grid| !grid.rests()));
    }

    /// A filter's reading is behind a shaft that turns when the record begins: the shaft is put before it, and a speed that would
    /// make up for that is not.
    #[test]
    fn under_a_late_reading_new_starts_are_better_or_the_old_ones_stay() {
        let hidden = [Hidden::Compliance, Hidden::SensorLag];
        let case = Case::new(35_200_038, &hidden, Conditions { disturbed: 0.25, spoilt: 0.15 });
        let (mut evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let late = evidence.fit(&base.values().with(Kind::SensorLag, vec![0.006, 0.0]), 12);
        let before = late.merit();
        let settled = evidence.settle_starts(late);
        assert!(settled.merit() < before - 0.02, "{before} -> {}", settled.merit());
        assert!(settled.unseen.position < 1.35, "{:?}", settled.unseen);
    }
}
