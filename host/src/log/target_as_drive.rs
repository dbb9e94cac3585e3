//! Where a position servo was told to go, read as what drives a motor: the shaft comes to rest at another angle for each level.
//!
//! A level that drives a motor turns it on and on. A shaft that rests at every level, at an angle that goes with it there and back, was sent to
//! angles, as a hobby servo is by its pulses; or a spring or a weight holds against the motor.

use std::ops::Range;

use super::Record;
use super::motion::{correlation, different, runs, span};
use super::suspicion::Odd;

/// A level is held for so many samples at least, and so many levels are held.
const HELD: usize = 5;
const FEWEST: usize = 6;
/// The shaft rests where it goes less than this share of its whole way in the last quarter of a level, which has two samples at least; at this
/// share of the levels it does.
const RESTS: f64 = 0.02;
const QUARTER: usize = 4;
const MOST: f64 = 0.8;
/// It rests in so many places, which are this share of its way apart: between two stops there are two.
const PLACES: usize = 4;
const APART: f64 = 0.04;
/// The rests go with the levels by this correlation, either way, and the levels turn back so many times: a drift goes with a staircase too.
const GOES_WITH: f64 = 0.95;
const TURNS: usize = 2;

/// The shaft rests at another angle for each level of the drive.
pub(super) fn target_as_drive(record: &Record) -> Option<Odd> {
    let angle = record.angle_rad.as_ref().filter(|_| !record.is_of_position_loop())?;
    let volts = &record.voltage_v;
    let way = span(angle);
    let mut held = runs(volts);
    held.retain(|run| run.len() >= HELD);
    let rests = |run: &&Range<usize>| {
        let last = (run.len() / QUARTER).max(2);
        span(&angle[run.end - last..run.end]) <= RESTS * way
    };
    let resting = held.iter().filter(rests).count();
    let levels: Vec<f64> = held.iter().map(|run| volts[run.start]).collect();
    let places: Vec<f64> = held.iter().map(|run| angle[run.end - 1]).collect();
    let sorted = different(places.iter().copied());
    let apart = 1 + sorted.windows(2).filter(|pair| pair[1] - pair[0] > APART * way).count();
    let turns = levels.windows(3).filter(|of| (of[1] - of[0]) * (of[2] - of[1]) < 0.0).count();
    let is_sent = way > 0.0
        && held.len() >= FEWEST
        && resting as f64 >= MOST * held.len() as f64
        && apart >= PLACES
        && turns >= TURNS
        && correlation(&levels, &places).abs() > GOES_WITH;
    is_sent.then(|| {
        (
            "target_as_drive",
            "voltage_v",
            format!(
                "the shaft comes to rest at another angle for each level of the drive, {:.3} .. {:.3} rad in {} levels: so answers a position servo \
                 to where it is told to go, or a motor against a spring or a weight",
                sorted[0],
                sorted[sorted.len() - 1],
                held.len()
            ),
            "if this is where a servo was told to go, write it in the unit of the angle, from the same zero and with the same sign, and map that \
             column as target=COLUMN:deg in the place of the drive; the voltage is the servo's own"
                .into(),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEVELS: [f64; 8] = [0.0, 3.0, -3.0, 1.5, 6.0, -6.0, -1.5, 4.0];

    /// A shaft under levels of 0.6 s, whose angle is moved on in each row of 20 ms by `step` of the volts and where it is.
    fn moved(step: impl Fn(f64, f64) -> f64) -> Record {
        let time_s: Vec<f64> = (0..480).map(|k| 0.02 * f64::from(k)).collect();
        let voltage_v: Vec<f64> = (0..480).map(|k| LEVELS[k / 30 % 8]).collect();
        let mut x = 0.0;
        let angles = voltage_v.iter().map(|volts| {
            x += step(*volts, x);
            x
        });
        let angle_rad = Some(angles.collect());
        Record { time_s, voltage_v, angle_rad, ..Record::default() }
    }

    /// A hobby servo's pulses were a duty: a spring and lost counts "explained" it.
    #[test]
    fn a_shaft_that_rests_where_its_level_sends_it_is_told_as_a_servo_whichever_way_it_turns() {
        for sign in [1.0, -1.0] {
            let sent = moved(|volts, x| (0.3 * (sign * 0.13 * volts - x)).clamp(-0.06, 0.06));
            let (name, _, why, fix) = target_as_drive(&sent).unwrap();
            assert!(name == "target_as_drive" && why.contains("-0.7"), "{why}");
            assert!(fix.contains("target=COLUMN"), "{fix}");
        }
    }

    #[test]
    fn a_motor_that_turns_on_and_one_between_stops_are_none() {
        assert_eq!(target_as_drive(&moved(|volts, _| 0.04 * volts)), None);
        let between_stops = |volts: f64, x: f64| (x + 0.2 * volts).clamp(-1.0, 1.0) - x;
        assert_eq!(target_as_drive(&moved(between_stops)), None);
    }
}
