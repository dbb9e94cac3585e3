//! A table of steady states: a speed for each level of the drive, row by row, and no log of a motion.

use super::motion::{correlation, different};
use super::timing::median_interval;
use super::units::Quantity;

/// A table of steady states has so many levels at most, each once in every sweep; a log of a changing drive has more.
const MOST_LEVELS: usize = 200;
/// Fewer rows than this are in an order by chance.
const FEWEST_ROWS: usize = 5;
/// Share of its rows in which the drive is another than in the row before.
const STEPS: f64 = 0.9;
/// The speeds come in the order of the drive by at least this rank correlation; levels that move nothing are ties and lower it.
const IN_ORDER: f64 = 0.9;
/// A motor follows its drive late: the drive of some rows before leaves less than this share of what is missing of an order, ...
const LATE: f64 = 0.5;
/// ... where more than this is missing, which is not rounding.
const MISSING: f64 = 1e-3;
/// Rows that are this far apart, s, may each be a steady state whatever clock they have: at two readings a second and fewer a motor shows no
/// motion.
pub(super) const FAR_APART_S: f64 = 0.4;
/// The lag is sought in the first rows, so many at most: they go through all levels several times, and the time that it takes grows with the
/// square of their number.
const SEARCHED: usize = 5 * MOST_LEVELS;

/// Whether the drive is another in each row and the speed comes in its order, whatever the curve: that of a pulse-width
/// drive saturates. What is not driven and stands tells neither. A ramp that never turns keeps the order too, however late
/// the motor follows it.
pub(super) fn are_steady_states(drive: &[f64], speed: &[f64]) -> bool {
    let pairs = drive.iter().zip(speed).filter(|(drive, speed)| **drive != 0.0 || **speed != 0.0);
    let (drive, speed): (Vec<f64>, Vec<f64>) = pairs.unzip();
    let steps = drive.windows(2).filter(|pair| pair[0] != pair[1]).count();
    drive.len() >= FEWEST_ROWS
        && steps as f64 > STEPS * (drive.len() - 1) as f64
        && different(drive.iter().copied()).len() <= MOST_LEVELS
        && out_of_order(&ranks(&drive), &ranks(&speed)) < 1.0 - IN_ORDER
        && !follows_late(&drive, &speed)
}

/// Whether the speed goes with the drive of rows before better than with that of its own row: the lag of a motion.
fn follows_late(drive: &[f64], speed: &[f64]) -> bool {
    let rows = drive.len().min(SEARCHED);
    (1..=rows / 4).any(|late| {
        let moved = ranks(&speed[late..rows]);
        let missing = |drive: &[f64]| out_of_order(&ranks(drive), &moved);
        let beside_own = missing(&drive[late..rows]);
        beside_own > MISSING && missing(&drive[..rows - late]) < LATE * beside_own
    })
}

/// What two columns of ranks miss of the one order, or of the opposite one: 1 less the magnitude of the rank correlation (Spearman).
fn out_of_order(a: &[f64], b: &[f64]) -> f64 {
    1.0 - correlation(a, b).abs()
}

/// The place of each value among all, from 0; of equal ones the mean of their places.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|one, other| values[*one].total_cmp(&values[*other]));
    let mut ranks = vec![0.0; values.len()];
    let mut before = 0;
    for equal in order.chunk_by(|one, other| values[*one] == values[*other]) {
        let mean = before as f64 + 0.5 * (equal.len() - 1) as f64;
        equal.iter().for_each(|place| ranks[*place] = mean);
        before += equal.len();
    }
    ranks
}

/// What is said of them where they are read as a log all the same: as rows of a rate, without `time_s`, or with a clock whose rows are far
/// apart. `values` are the columns of the table.
pub(super) fn said_beside_log(
    time_s: Option<&[f64]>,
    values: &[(Quantity, Vec<f64>)],
) -> Option<(String, &'static str)> {
    if time_s.is_some_and(|time_s| median_interval(time_s) < FAR_APART_S) {
        return None;
    }
    let of = |wanted: &[Quantity]| values.iter().find(|(quantity, _)| wanted.contains(quantity));
    let (_, drive) = of(&[Quantity::Voltage, Quantity::Duty])?;
    let (_, speed) = of(&[Quantity::Speed])?;
    are_steady_states(drive, speed).then(|| {
        (
            "steady_states: the drive is another in every row and the speed goes with it: where each row is the speed that a level settled at, \
             no clock and no --rate makes a log of them, and the time constant found is none"
                .to_owned(),
            "log time, drive and motion while it moves",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_speed_for_each_level_is_told_from_a_motion_and_levels_that_move_nothing_do_not_hide_it() {
        let levels: Vec<f64> = (0..40).map(|k| f64::from(20 - k).max(0.0) * 0.5).collect();
        let settled: Vec<f64> = levels.iter().map(|v| 30.0 * v).collect();
        assert!(are_steady_states(&levels, &settled));
        let step = vec![5.0; 40];
        let rises: Vec<f64> = (0..40).map(|k| 1.0 - (-0.1 * f64::from(k)).exp()).collect();
        assert!(!are_steady_states(&step, &rises) && !are_steady_states(&[0.0; 40], &[0.0; 40]));
        let table = [(Quantity::Duty, levels), (Quantity::Speed, settled)];
        assert!(said_beside_log(None, &table).unwrap().0.starts_with("steady_states: "));
        assert_eq!(said_beside_log(None, &table[..1]), None);
        let clock = |step: f64| (0..40).map(|k| step * f64::from(k)).collect::<Vec<f64>>();
        assert!(said_beside_log(Some(&clock(1.1)), &table).is_some());
        assert_eq!(said_beside_log(Some(&clock(0.01)), &table), None);
    }

    /// The speed, in whole rpm, that levels 0 to 254 of a slow pulse-width drive settle at: it saturates long before full duty.
    fn saturating(level: f64) -> f64 {
        (523.0 * (1.0 - (-(level - 17.0).max(0.0) / 20.0).exp())).round()
    }

    #[test]
    fn a_curve_that_saturates_is_a_table_in_one_sweep_and_in_several() {
        let sweep: Vec<f64> = (0..128).map(|k| f64::from(2 * k)).collect();
        let there_and_back: Vec<f64> = sweep.iter().chain(sweep.iter().rev().skip(1)).copied().collect();
        for levels in [sweep.clone(), sweep.repeat(4), there_and_back] {
            let settled: Vec<f64> = levels.iter().map(|level| saturating(*level)).collect();
            assert!(correlation(&levels, &settled) < 0.9);
            assert!(are_steady_states(&levels, &settled));
        }
    }

    /// What a motor with a lag of `tau` rows does under a drive.
    fn motion(drive: &[f64], tau: f64) -> Vec<f64> {
        let follows = |speed: &mut f64, volts: &f64| {
            let settled = 30.0 * (volts.abs() - 0.5).max(0.0).copysign(*volts);
            *speed += (settled - *speed) * (1.0 - (-1.0 / tau).exp());
            Some(*speed)
        };
        drive.iter().scan(0.0, follows).collect()
    }

    #[test]
    fn a_motor_that_follows_a_slow_ramp_or_sweep_late_is_no_table() {
        let ramp = |k: i32| 0.1 * f64::from(90 - (k - 90).abs());
        let sine = |k: i32| 6.0 * (0.05 * f64::from(k)).sin();
        for shape in [&ramp as &dyn Fn(i32) -> f64, &sine] {
            let drive: Vec<f64> = (0..180).map(shape).collect();
            for tau in [3.0, 5.0, 10.0] {
                assert!(!are_steady_states(&drive, &motion(&drive, tau)), "a lag of {tau} rows");
            }
        }
    }

    #[test]
    fn equal_values_share_their_mean_rank() {
        assert_eq!(ranks(&[3.0, 1.0, 3.0, -2.0]), [2.5, 1.0, 2.5, 0.0]);
        assert_eq!(ranks(&[]), [0.0; 0]);
    }
}
