//! Records that begin in motion, under a model: how fast, and what that leaves to the model.

use super::evidence::Evidence;
use crate::select::fitted::{Fitted, SETTLED};

/// Rounds of looking for slow starts.
const ROUNDS: usize = 3;
/// Multiples of the noise below which a model is near enough to tell slow starts from rest.
const NEAR: f64 = 1.5;

impl Evidence {
    /// Lets the records begin as `model` has them. Those that no fit sees begin as they must under whichever model is run over them
    /// ([`crate::compare::free_run::free_runs`]).
    pub fn begin_as(&mut self, model: &Fitted) {
        self.whole.begin_with(&model.speeds);
        if model.speeds != self.train.first_speeds() {
            self.lay_out_again();
        }
    }

    /// The same, and where the model is near, records that seem to begin at rest are looked at again: a slow motion hides within the first
    /// counts. Under a model that lacks something it would be made up. The model fitted to the records that begin so.
    pub fn settle_starts(&mut self, model: Fitted) -> Fitted {
        let mut model = model;
        for _ in 0..ROUNDS {
            self.begin_as(&model);
            let values = model.values();
            if self.left_over(&model) >= NEAR || !self.whole.find_slow_starts(&values) {
                break;
            }
            self.lay_out_again();
            model = Fitted::of(self, &values, SETTLED.0, SETTLED.1);
        }
        model
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::discover::prepare;
    use crate::exam::case::{Case, Conditions};
    use crate::log::Record;
    use crate::motor_file::MotorFile;
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

    /// Of speeds a third off, under a filter's late readings.
    #[test]
    fn a_fit_ends_at_the_same_first_speeds_wherever_they_begin() {
        let hidden = [Hidden::Compliance, Hidden::SensorLag];
        let case = Case::new(35_200_038, &hidden, Conditions { disturbed: 0.25, spoilt: 0.15 });
        let (mut evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let late = base.values().with(Kind::SensorLag, vec![0.005, 0.0]);
        let fitted = Fitted::of(&evidence, &late, 4, 12);
        let off: Vec<f64> = fitted.speeds.iter().map(|speed| 1.33 * speed).collect();
        evidence.train.begin_with(&off);
        let again = Fitted::of(&evidence, &late, 4, 12);
        assert!((again.score() - fitted.score()).abs() < 1.0, "{} {}", again.score(), fitted.score());
        for (one, other) in again.speeds.iter().zip(&fitted.speeds) {
            assert!((one / other - 1.0).abs() < 0.01, "{one} {other}");
        }
    }

    /// Cut out of a longer one: of a first speed that is wrong most is made up for by the time constant, and neither alone leads back.
    #[test]
    fn a_record_of_a_plain_motor_that_is_cut_out_of_a_longer_one_has_its_own_speed_and_time_constant() {
        let voltage = |t: f64| {
            6.0 + 3.0 * (5.0 * t).sin() + if ((t / 0.4) as usize).is_multiple_of(2) { 2.0 } else { -2.0 }
        };
        let (mut speed, mut angle, mut record) = (0.0, 0.0, Record::default());
        let mut measured = Vec::new();
        for k in 0..15_000_u32 {
            let t = f64::from(k) * 1e-4;
            if t >= 1.0 && k.is_multiple_of(50) {
                record.time_s.push(t);
                record.voltage_v.push(voltage(t));
                measured.push((angle / 0.01_f64).round() * 0.01);
            }
            speed += 1e-4 * (50.0 * voltage(t - t % 5e-3) - speed) / 0.25;
            angle += 1e-4 * speed;
        }
        record.angle_rad = Some(measured);
        let (evidence, base) = prepare(&[record], &[], &MotorFile::default()).unwrap();
        let found = base.values().base;
        assert!(
            (found.tau_m / 0.25 - 1.0).abs() < 0.04 && (found.gain / 50.0 - 1.0).abs() < 0.02,
            "{found:?}"
        );
        assert!(evidence.left_over(&base) < 1.5, "{}", evidence.left_over(&base));
    }
}
