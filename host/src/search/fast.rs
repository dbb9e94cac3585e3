//! The fast search: least squares from a few starts, then the genetic algorithm's own objective by simplex.

use super::dispatch::{DOUBLES, Level};
use super::genetic::Start;
use super::projection::{Rates, least_squares};
use super::record::{LinearRecord, RecordError, Records};
use motorlens_shared::motor::{Combinations, PaperMotor};
use motorlens_shared::random::Stream;
use serde::Serialize;
use std::time::Instant;

/// What [`fast`] found.
#[derive(Debug, Clone, Serialize)]
pub struct FastResult {
    /// What the records determine.
    pub combinations: Combinations,
    /// One motor with these combinations, near the start's centre; `None` where no positive one is.
    pub motor: Option<PaperMotor>,
    /// Summed over the records, in double precision; rad s or rad.
    pub iae: f64,
    /// Candidates evaluated.
    pub evaluations: u64,
    /// Passes over the records; a pass evaluates up to four candidates side by side.
    pub passes: u64,
    /// The search alone.
    pub seconds: f64,
}

/// Starts that are enough to find the global least squares of a linear motor.
pub const STARTS: u32 = 3;

/// Minimises the IAE of the linear model on angle and speed records.
///
/// Variable projection runs from `starts` points drawn from `start` (its own stream for each of them); the
/// best goes on by simplex (Nelder and Mead, 1965) on the IAE.
///
/// # Errors
/// See [`RecordError`].
pub fn fast(
    records: &[LinearRecord],
    start: &Start,
    starts: u32,
    seed: u64,
) -> Result<FastResult, RecordError> {
    Ok(fast_on(&Records::new(records, Level::best())?, start, starts, seed))
}

/// [`fast`] on records that are already prepared.
#[must_use]
pub fn fast_on(records: &Records, start: &Start, starts: u32, seed: u64) -> FastResult {
    let began = Instant::now();
    let mut passes = 0;
    let mut best: Option<(Rates, f64)> = None;
    for k in 0..starts.max(1) {
        let first = start.motor(&start.admitted(&mut Stream::new(seed, 0, k)));
        let (rates, squared, used) = least_squares(records, Rates::of(&first.combinations()));
        passes += used;
        if best.is_none_or(|(_, least)| squared < least) {
            best = Some((rates, squared));
        }
    }
    let mut evaluations = passes * 3;
    let mut at = best.map_or(Rates::of(&start.centre().combinations()), |(rates, _)| rates);
    let mut iae = f64::INFINITY;
    // A simplex can collapse on a kink; a fresh one at the same place tells.
    for width in [1.0, 0.2, 0.04] {
        let polished = simplex(records, at, width);
        passes += polished.passes;
        evaluations += polished.passes * DOUBLES as u64;
        let fall = (iae - polished.iae) / polished.iae;
        (at, iae) = (polished.rates, polished.iae);
        if fall < 1e-4 {
            break;
        }
    }
    let combinations = at.combinations();
    FastResult {
        combinations,
        motor: combinations.realised_near(&start.centre()),
        iae: records.exact_iae(&combinations),
        evaluations,
        passes,
        seconds: began.elapsed().as_secs_f64(),
    }
}

struct Polished {
    rates: Rates,
    iae: f64,
    passes: u64,
}

/// Logarithmic gain, slow and fast rate, relative to the start.
type Point = [f64; 3];

/// First edges of the simplex: what 0.02 % of gain moves the angle as much as, roughly, the others do.
const EDGES: Point = [2e-4, 2e-3, 0.2];
/// Relative difference between the corners at which the simplex has arrived.
const CLOSE: f64 = 1e-5;
const MOST_PASSES: u64 = 150;

/// Nelder and Mead's simplex in which every turn evaluates all four candidate moves at once: on a vector unit
/// four cost as much as one.
fn simplex(records: &Records, from: Rates, width: f64) -> Polished {
    let rates =
        |x: &Point| Rates { gain: from.gain * x[0].exp(), slow: from.slow + x[1], fast: from.fast + x[2] };
    let iae = |points: [Point; DOUBLES]| {
        let motors = points.map(|x| rates(&x).combinations());
        records.exact_iae_of(&motors).map(|v| if v.is_nan() { f64::INFINITY } else { v })
    };
    let mut corners: [Point; 4] = [[0.0; 3]; 4];
    for k in 0..3 {
        corners[k + 1][k] = width * EDGES[k];
    }
    let mut values = iae(corners);
    let mut passes = 1;
    while passes < MOST_PASSES {
        let mut order = [0, 1, 2, 3];
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        (corners, values) = (order.map(|k| corners[k]), order.map(|k| values[k]));
        if values[3] - values[0] < CLOSE * values[0] {
            break;
        }
        let moved = |by: f64| -> Point {
            core::array::from_fn(|k| {
                let centre = (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0;
                centre + by * (corners[3][k] - centre)
            })
        };
        let points = [-1.0, -2.0, -0.5, 0.5].map(moved);
        let tried = iae(points);
        passes += 1;
        let [reflected, expanded, ..] = tried;
        let chosen = if reflected < values[0] {
            usize::from(expanded < reflected)
        } else if reflected < values[2] {
            0
        } else if reflected < values[3] {
            2
        } else {
            3
        };
        if tried[chosen] < values[3] {
            (corners[3], values[3]) = (points[chosen], tried[chosen]);
        } else {
            let best = corners[0];
            corners = corners.map(|c| core::array::from_fn(|k| 0.5 * (best[k] + c[k])));
            values = iae(corners);
            passes += 1;
        }
    }
    let best = (0..4).min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
    Polished { rates: rates(&corners[best]), iae: values[best], passes }
}

#[cfg(test)]
mod tests {
    use super::{STARTS, fast_on};
    use crate::search::dispatch::Level;
    use crate::search::genetic::{GaOptions, Start, genetic_on};
    use crate::search::record::Records;
    use crate::search::trial::{MOTOR, three_sines};
    use motorlens_shared::linear::Kind;

    const START: Start = Start::Logarithmic { centre: MOTOR, factor: 4.0 };

    #[test]
    fn reaches_the_objective_of_the_genetic_search_from_every_seed() {
        let records = Records::new(&three_sines(100, Kind::Angle), Level::best()).expect("good");
        let genetic = genetic_on(&records, &START, &GaOptions::default(), &mut |_, _| ());
        for seed in 0..60 {
            let fast = fast_on(&records, &START, STARTS, seed);
            assert!(fast.iae < genetic.iae * 1.001, "seed {seed}: {} {}", fast.iae, genetic.iae);
            assert!(fast.evaluations * 20 < genetic.evaluations, "{}", fast.evaluations);
        }
    }

    #[test]
    fn a_reversed_encoder_gives_a_negative_gain_and_no_motor() {
        let mut reversed = three_sines(100, Kind::Angle);
        for record in &mut reversed {
            record.measured.iter_mut().for_each(|y| *y = -*y);
        }
        let records = Records::new(&reversed, Level::best()).expect("good");
        let result = fast_on(&records, &START, STARTS, 1);
        let gain = result.combinations.gain() / MOTOR.combinations().gain();
        assert!((gain + 1.0).abs() < 0.01, "{gain}");
        assert!(result.motor.is_none());
    }

    #[test]
    fn speed_alone_determines_the_same_combinations() {
        let records = Records::new(&three_sines(1000, Kind::Speed), Level::best()).expect("good");
        let found = fast_on(&records, &START, STARTS, 1).combinations;
        let truth = MOTOR.combinations();
        assert!((found.gain() / truth.gain() - 1.0).abs() < 1e-5);
        let slow = |c: &motorlens_shared::motor::Combinations| c.time_constants().expect("real").0;
        assert!((slow(&found) / slow(&truth) - 1.0).abs() < 1e-4);
    }
}
