//! Records that begin in motion, under a model: how fast, and what that leaves to the model.

use super::evidence::Evidence;
use crate::fit::search::Problem;
use crate::fit::start::Start;
use crate::select::criterion::WORTH;
use crate::select::fitted::Fitted;

/// Rounds of fitting starts and model in turn.
const ROUNDS: usize = 4;
/// Multiples of the noise below which a model is near enough for first angles to be fitted too.
const NEAR: f64 = 1.5;

impl Evidence {
    fn problems(&mut self) -> impl Iterator<Item = &mut Problem> {
        std::iter::once(&mut self.whole).chain(&mut self.kept_out)
    }

    /// Fits the first speeds of the records that begin in motion anew under `model`, then the model, until that gains no
    /// more. Where the model is near, records that seem to begin at rest are looked at again: a slow motion hides within the first counts.
    /// Under a model that lacks something it would be made up.
    pub fn settle_starts(&mut self, model: Fitted) -> Fitted {
        let mut model = model;
        for _ in 0..ROUNDS {
            // A start that is wrong shows in the error itself.
            let values = model.values();
            let near = self.left_over(&model) < NEAR;
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
            self.lay_out_again();
            let settled = Fitted::of(self, &values, 1, 6);
            let gain = settled.gain_over(&model).total;
            if gain < 0.0 {
                self.problems().zip(kept).for_each(|(problem, starts)| problem.set_starts(&starts));
                self.lay_out_again();
                break;
            }
            model = settled;
            if gain < WORTH {
                break;
            }
        }
        model
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::discover::prepare;
    use crate::exam::case::{Case, Conditions};
    use motorlens_shared::effects::Kind;
    use motorlens_virtual_motor::Kind as Hidden;

    /// At 7 of 192 rad/s: under 10 V the first milliseconds look as they do from rest.
    #[test]
    fn a_motor_that_turns_slowly_when_its_records_begin_is_a_plain_motor() {
        let case = Case::new(32_100_123, &[], Conditions { disturbed: 0.5, spoilt: 0.15 });
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        assert!(evidence.left_over(&base) < 1.25, "{}", evidence.left_over(&base));
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
        let late = Fitted::of(&evidence, &base.values().with(Kind::SensorLag, vec![0.006, 0.0]), 2, 12);
        let before = late.score();
        let settled = evidence.settle_starts(late);
        assert!(settled.score() > before + WORTH, "{before} -> {}", settled.score());
    }
}
