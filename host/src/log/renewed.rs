//! A voltage that is logged less often than it changes: held in the file, and not by the drive.

use super::Record;
use super::suspicion::Odd;
use super::timing::median_interval;
use super::weak::Weak;

/// A voltage is renewed regularly where this share of its changes come one interval apart, of at least so many samples.
const REGULAR: f64 = 0.8;
const FEWEST_ROWS: usize = 3;
const FEWEST_CHANGES: usize = 25;
/// Steps of a programme have few levels; a sampled course has as many as it has samples, or nearly.
const LEVELS: f64 = 0.5;
/// What the smooth course must leave of what the staircase leaves.
const BETTER: f64 = 0.7;

/// The voltage stands still between renewals, and the motor answers to a smoother one.
pub(super) fn stale_voltage(record: &Record) -> Option<Odd> {
    let volts = &record.voltage_v;
    let changes: Vec<usize> = (1..volts.len()).filter(|k| volts[*k] != volts[*k - 1]).collect();
    if changes.len() < FEWEST_CHANGES {
        return None;
    }
    let mut rows: Vec<usize> = changes.windows(2).map(|pair| pair[1] - pair[0]).collect();
    rows.sort_unstable();
    let hold = rows[rows.len() / 2];
    let regular = rows.iter().filter(|rows| (**rows).abs_diff(hold) <= hold / 10).count();
    let mut levels: Vec<f64> = changes.iter().map(|k| volts[*k]).collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    if hold < FEWEST_ROWS
        || (regular as f64) < REGULAR * rows.len() as f64
        || (levels.len() as f64) < LEVELS * changes.len() as f64
    {
        return None;
    }
    let mut smooth = record.clone();
    for pair in changes.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        for k in from..to {
            let part = (k - from) as f64 / (to - from) as f64;
            smooth.voltage_v[k] = volts[from] + part * (volts[to] - volts[from]);
        }
    }
    let left = |record: &Record| Some(Weak::new(record)?.regress(0.0, |v| v)?.left);
    (left(&smooth)? < BETTER * left(record)?).then(|| {
        let ms = 1e3 * hold as f64 * median_interval(&record.time_s);
        (
            "stale_voltage",
            "voltage_v",
            format!(
                "the voltage is renewed only every {ms:.0} ms ({hold} samples) and stands still in between, while the motor answers to one \
                 that goes on changing"
            ),
            "log the voltage at the rate of the motion; until then every time constant and delay found is that of the log".into(),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motor under a sine, and the voltage as it was logged: renewed every `hold` samples; the drive follows it where `steps`.
    fn logged(hold: usize, steps: bool) -> Record {
        let time: Vec<f64> = (0..2000).map(|k| f64::from(k) * 0.005).collect();
        let wanted: Vec<f64> = time.iter().map(|t| 6.0 * (3.0 * t).sin() + 2.0 * (7.1 * t).sin()).collect();
        let held: Vec<f64> = (0..wanted.len()).map(|k| wanted[k - k % hold]).collect();
        let applied = if steps { &held } else { &wanted };
        let (mut w, mut x) = (0.0, 0.0);
        let mut angle = Vec::new();
        for v in applied {
            angle.push(x);
            w += 0.08 * (2.0 * v - w);
            x += 0.005 * w;
        }
        Record { time_s: time, voltage_v: held, angle_rad: Some(angle), ..Record::default() }
    }

    #[test]
    fn a_voltage_filled_forward_is_told_and_one_that_the_drive_holds_is_not() {
        let (name, _, why, _) = stale_voltage(&logged(20, false)).unwrap();
        assert!(name == "stale_voltage" && why.contains("every 100 ms (20 samples)"), "{why}");
        assert_eq!(stale_voltage(&logged(20, true)), None);
        assert_eq!(stale_voltage(&logged(1, true)), None);
    }
}
