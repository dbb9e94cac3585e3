//! A position that does not come to rest: its limit cycle, from a simulation of the loop with all effects.
//!
//! A loop that is stable by its margins may go to and fro for ever where the motor answers near rest otherwise than farther away: between
//! gears with a gap the encoder on the load sees nothing of the rotor. How wide and how fast depends on the voltage limit, counts, friction
//! and loads together, so it is simulated. Source: Nordin, Gutman, Controlling mechanical systems with backlash, Automatica 38, 2002.

use serde::Serialize;

use super::step::Step;
use super::trial::Course;

/// By its encoder's counts alone a loop moves by less than so many of them.
const COUNTS: f64 = 2.0;
/// What swings on is as wide as it was a quarter of the run before, but for this share.
const DYING: f64 = 0.2;
/// So many periods make a cycle.
const PERIODS: usize = 3;
/// A period begins where the position has come from below this share of the width about the middle to above it.
const SURE: f64 = 0.25;

/// How a position goes to and fro though a constant one is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LimitCycle {
    /// Half of the way from one end to the other, rad.
    pub amplitude_rad: f64,
    /// Periods in a second, Hz; their mean where they differ.
    pub frequency_hz: f64,
}

impl LimitCycle {
    /// That of a position which should be `course`'s last wanted one since long; none where it comes to rest, or moves by a count of
    /// `count_rad` or two.
    pub(super) fn of(course: &Course, count_rad: f64) -> Option<Self> {
        let end = course.reached.len();
        let [half, last] = [end / 2, end * 3 / 4];
        let [[low, high], before] = [last..end, half..last].map(|part| ends(&course.reached[part]));
        let width = high - low;
        if width <= COUNTS * count_rad || width < (1.0 - DYING) * (before[1] - before[0]) {
            return None;
        }
        let (middle, sure) = (0.5 * (low + high), SURE * width);
        let mut was_below = false;
        let mut begun = Vec::new();
        for (time_s, place) in course.time_s.iter().zip(&course.reached).skip(last) {
            if *place < middle - sure {
                was_below = true;
            } else if was_below && *place > middle + sure {
                was_below = false;
                begun.push(*time_s);
            }
        }
        let periods = begun.len().saturating_sub(1);
        let seconds = begun.last()? - begun.first()?;
        (periods >= PERIODS)
            .then(|| Self { amplitude_rad: 0.5 * width, frequency_hz: periods as f64 / seconds })
    }
}

/// The lowest and the highest of them.
fn ends(places: &[f64]) -> [f64; 2] {
    places.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)])
}

/// What to do about the first of them.
pub(super) fn advice(steps: &[Step]) -> Option<String> {
    let (step, cycle) = steps.iter().find_map(|step| Some((step, step.limit_cycle?)))?;
    Some(format!(
        "The position does not come to rest ({}): it keeps moving by \u{b1}{:.2e} rad at {:.1} Hz. A larger phase margin makes the loop \
         slower and may stop it.",
        step.compensation, cycle.amplitude_rad, cycle.frequency_hz
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 8 s of what `place` is at a time, once in 5 ms.
    fn course(place: impl Fn(f64) -> f64) -> Course {
        let time_s: Vec<f64> = (1..=1600).map(|k| f64::from(k) * 5e-3).collect();
        let reached: Vec<f64> = time_s.iter().map(|time_s| place(*time_s)).collect();
        Course { wanted: vec![1.0; reached.len()], time_s, reached }
    }

    fn swing(time_s: f64) -> f64 {
        (std::f64::consts::TAU * 6.0 * time_s).sin()
    }

    #[test]
    fn a_position_that_swings_on_has_its_amplitude_and_frequency() {
        let found =
            LimitCycle::of(&course(|t| 1.0 + 0.02 * swing(t) + 0.002 * swing(9.0 * t)), 1e-3).unwrap();
        assert!((found.amplitude_rad - 0.02).abs() < 2.5e-3, "{found:?}");
        assert!((found.frequency_hz - 6.0).abs() < 0.1, "{found:?}");
    }

    #[test]
    fn what_dies_away_drifts_or_is_no_more_than_counts_is_no_limit_cycle() {
        let dies = course(|t| 1.0 + 0.5 * swing(t) * (-0.3 * t).exp());
        let drifts = course(|t| 0.01 * t);
        let counts = course(|t| 1.0 + 0.9e-3 * swing(t));
        for rests in [dies, drifts, counts, course(|_| 1.0), Course::default()] {
            assert_eq!(LimitCycle::of(&rests, 1e-3), None);
        }
    }
}
