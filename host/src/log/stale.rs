//! A voltage that is logged less often than it changes: held in the file, and not by the drive.

use super::Record;
use super::hold::hold;
use super::motion::different;
use super::ripple::answer;
use super::stops::hard_stop;
use super::suspicion::Odd;
use super::timing::median_interval;
use super::weak::Weak;

/// A voltage is updated regularly where this share of its changes come one interval apart, of at least so many samples.
const REGULAR: f64 = 0.8;
const FEWEST_ROWS: usize = 3;
const FEWEST_CHANGES: usize = 25;
/// Steps of a programme have few levels; a sampled course has as many as it has samples, or nearly.
const LEVELS: f64 = 0.5;
/// What the smooth course must leave of what the staircase leaves.
const BETTER: f64 = 0.7;
/// An angle shows less than this share of the answer to each step where the drive does not hold the voltage, and so little scatter of
/// it that it would show all of it.
const NO_ANSWER: f64 = 0.35;
const TOLD: f64 = 0.45;

/// The voltage stands still between updates, and the motor answers to a smoother one.
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
    if hold < FEWEST_ROWS || (regular as f64) < REGULAR * rows.len() as f64 {
        return None;
    }
    let stale = unanswered(record, &changes, hold).unwrap_or_else(|| is_smoother(record, &changes));
    // A shaft that meets a stop answers to that, and not to its voltage.
    (stale && hard_stop(record).is_none()).then(|| {
        let ms = 1e3 * hold as f64 * median_interval(&record.time_s);
        (
            "stale_voltage",
            "voltage_v",
            format!(
                "a new voltage comes only every {ms:.0} ms ({hold} samples) and stands still in between, while the motor answers to one \
                 that goes on changing"
            ),
            "log the voltage at the rate of the motion; until then every time constant and delay found is that of the log".into(),
        )
    })
}

/// Whether the angle shows no answer to the steps; none where it does not tell.
fn unanswered(record: &Record, changes: &[usize], rows: usize) -> Option<bool> {
    let angle = record.angle_rad.as_ref()?;
    let interval = median_interval(&record.time_s);
    // An angle that is held as well has steps of its own.
    if hold(&record.time_s, angle).is_some_and(|held| held.time_s > 0.5 * rows as f64 * interval) {
        return None;
    }
    let motor = Weak::new(record)?.regress(0.0, |v| v).filter(|motor| motor.gain > 0.0)?;
    let answer = answer(angle, &record.voltage_v, changes, rows, interval, motor)?;
    (answer.deviation < TOLD).then_some(answer.share < NO_ANSWER)
}

/// Whether the motion is far better explained by a voltage of many levels that runs straight from one to the next.
fn is_smoother(record: &Record, changes: &[usize]) -> bool {
    let volts = &record.voltage_v;
    let levels = different(changes.iter().map(|k| volts[*k]));
    if (levels.len() as f64) < LEVELS * changes.len() as f64 {
        return false;
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
    left(&smooth).zip(left(record)).is_some_and(|(smooth, steps)| smooth < BETTER * steps)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::log::motion::speed;

    /// A motor with friction and an encoder of 1320 counts under sines, and the voltage as it was logged: updated every `hold` samples
    /// of 5 ms; the drive follows it where `steps`, `late` samples later.
    fn logged(sines: &[(f64, f64)], hold: usize, steps: bool, late: usize) -> Record {
        slowly(sines, hold, steps, late, 0.06, 3000)
    }

    /// The same of a motor with this time constant, s, for so many samples.
    fn slowly(sines: &[(f64, f64)], hold: usize, steps: bool, late: usize, tau_s: f64, count: u32) -> Record {
        let time: Vec<f64> = (0..count).map(|k| f64::from(k) * 0.005).collect();
        let wanted: Vec<f64> =
            time.iter().map(|t| sines.iter().map(|(size, rate)| size * (rate * t).sin()).sum()).collect();
        let held: Vec<f64> = (0..wanted.len()).map(|k| wanted[k - k % hold]).collect();
        let applied = if steps { &held } else { &wanted };
        let count = std::f64::consts::TAU / 1320.0;
        let (mut w, mut x) = (0.0_f64, 0.0_f64);
        let mut angle = Vec::new();
        for k in 0..applied.len() {
            angle.push((x / count).floor() * count);
            let v = applied[k.saturating_sub(late)];
            for _ in 0..5 {
                let drive = if w == 0.0 { v - v.clamp(-0.5, 0.5) } else { v - 0.5 * w.signum() };
                let next = w + 0.001 / tau_s * (2.0 * drive - w);
                w = if w * next < 0.0 { 0.0 } else { next };
                x += 0.001 * w;
            }
        }
        Record { time_s: time, voltage_v: held, angle_rad: Some(angle), ..Record::default() }
    }

    const SINES: [&[(f64, f64)]; 3] = [&[(6.0, 3.0), (2.0, 7.1)], &[(6.0, TAU / 2.0)], &[(6.0, 9.0)]];

    #[test]
    fn a_voltage_filled_forward_is_told_and_one_that_the_drive_holds_is_not() {
        for sines in SINES {
            for (hold, told) in [(20, "every 100 ms (20 samples)"), (10, "every 50 ms (10 samples)")] {
                let found = stale_voltage(&logged(sines, hold, false, 0));
                let (name, _, why, _) = found.unwrap_or_else(|| panic!("{sines:?}, {hold}"));
                assert!(name == "stale_voltage" && why.contains(told), "{why}");
                assert_eq!(stale_voltage(&logged(sines, hold, true, 0)), None, "{sines:?}, {hold}");
                assert_eq!(stale_voltage(&logged(sines, hold, true, 4)), None, "{sines:?}, {hold}, late");
            }
            assert_eq!(stale_voltage(&logged(sines, 1, true, 0)), None);
        }
    }

    /// Each update turns a slow shaft by a small part of a count: only a long log tells, and a short one says nothing of either.
    #[test]
    fn a_slow_motor_tells_a_stale_voltage_in_a_long_log() {
        let name =
            |steps, count| stale_voltage(&slowly(SINES[0], 10, steps, 0, 0.3, count)).map(|(name, ..)| name);
        assert_eq!(name(false, 36_000), Some("stale_voltage"));
        assert_eq!(name(true, 36_000), None);
        assert_eq!(name(true, 3000), None);
    }

    #[test]
    fn a_speed_that_answers_to_a_smoother_voltage_tells_it_too() {
        let mut record = logged(SINES[0], 20, false, 0);
        record.speed_rad_s = Some(speed(&record));
        record.angle_rad = None;
        assert!(stale_voltage(&record).is_some());
        let mut record = logged(SINES[0], 20, true, 0);
        record.speed_rad_s = Some(speed(&record));
        record.angle_rad = None;
        assert_eq!(stale_voltage(&record), None);
    }
}
