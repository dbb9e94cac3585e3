//! A table of steady states: a speed for each level of the drive, row by row, and no log of a motion.

use super::motion::correlation;
use super::units::Quantity;

/// A table of steady states has so many rows at most; a log that begins so has more.
const MOST_STATES: usize = 200;
/// Share of its rows in which the drive is another than in the row before.
const STEPS: f64 = 0.9;
/// What moves goes with what drives it by at least this correlation.
const GOES_AT_ONCE: f64 = 0.9;

/// Whether in rows without a clock the drive is another in each and the speed goes with it. What is not driven and stands tells neither.
pub(super) fn are_steady_states(drive: &[f64], speed: &[f64]) -> bool {
    let pairs = drive.iter().zip(speed).filter(|(drive, speed)| **drive != 0.0 || **speed != 0.0);
    let (drive, speed): (Vec<f64>, Vec<f64>) = pairs.unzip();
    let steps = drive.windows(2).filter(|pair| pair[0] != pair[1]).count();
    (2..=MOST_STATES).contains(&drive.len())
        && steps as f64 > STEPS * (drive.len() - 1) as f64
        && correlation(&drive, &speed).abs() > GOES_AT_ONCE
}

/// What is said of them where they are read as rows of a rate all the same; `values` are the columns of the table.
pub(super) fn said_beside_rate(values: &[(Quantity, Vec<f64>)]) -> Option<(String, &'static str)> {
    let of = |wanted: &[Quantity]| values.iter().find(|(quantity, _)| wanted.contains(quantity));
    let (_, drive) = of(&[Quantity::Voltage, Quantity::Duty])?;
    let (_, speed) = of(&[Quantity::Speed])?;
    are_steady_states(drive, speed).then(|| {
        (
            "steady_states: the drive is another in every row and the speed goes with it: where each row is the speed that a level settled at, \
             no --rate makes a log of them, and the time constant found is none"
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
        assert!(said_beside_rate(&table).unwrap().0.starts_with("steady_states: "));
        assert_eq!(said_beside_rate(&table[..1]), None);
    }
}
