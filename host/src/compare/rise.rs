//! Where a model is worse than the one before it.

use serde::Serialize;

use super::free_run::FreeRun;

/// Where the error rose most.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rise {
    /// The record.
    pub record: String,
    /// Middle of the half second in which its squared error rose most, s.
    pub at_s: f64,
    /// So many times its rms error before.
    pub times: f64,
}

impl Rise {
    /// Where, as it follows "the error rises".
    pub fn place(&self) -> String {
        format!(", most on {} around {:.1} s", self.record, self.at_s)
    }
}

/// Width of the windows that are compared, s.
const WINDOW_S: f64 = 0.5;

/// The record whose squared error rose most from the runs `before` to those `after`, and the time at which it did; none where the
/// pooled error did not rise.
pub fn worst_rise(before: &[FreeRun], after: &[FreeRun]) -> Option<Rise> {
    let rose = |a: &FreeRun, b: &FreeRun| squares(b).iter().sum::<f64>() - squares(a).iter().sum::<f64>();
    let pairs = || before.iter().zip(after).filter(|(a, b)| a.time_s.len() == b.time_s.len());
    if pairs().map(|(a, b)| rose(a, b)).sum::<f64>() <= 0.0 {
        return None;
    }
    let (a, b) = pairs().max_by(|x, y| rose(x.0, x.1).total_cmp(&rose(y.0, y.1)))?;
    let (old, new) = (squares(a), squares(b));
    let sum = |squares: &[f64]| squares.iter().sum::<f64>();
    Some(Rise {
        record: b.record.clone(),
        at_s: worst_time(&b.time_s, &old, &new)?,
        times: (sum(&new) / sum(&old).max(1e-300)).sqrt(),
    })
}

fn squares(run: &FreeRun) -> Vec<f64> {
    run.measured.iter().zip(&run.simulated).map(|(y, p)| (y - p) * (y - p)).collect()
}

/// Middle of the window in which `new` exceeds `old` most.
fn worst_time(time_s: &[f64], old: &[f64], new: &[f64]) -> Option<f64> {
    let begin = *time_s.first()?;
    let mut sums: Vec<f64> = Vec::new();
    for (k, t) in time_s.iter().enumerate() {
        let window = ((t - begin) / WINDOW_S) as usize;
        sums.resize(sums.len().max(window + 1), 0.0);
        sums[window] += new[k] - old[k];
    }
    let worst = (0..sums.len()).max_by(|a, b| sums[*a].total_cmp(&sums[*b]))?;
    Some(begin + (worst as f64 + 0.5) * WINDOW_S)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::grid::Quantity;

    fn run(record: &str, error: impl Fn(f64) -> f64) -> FreeRun {
        let time_s: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.01).collect();
        FreeRun {
            record: record.into(),
            measured: vec![0.0; 1000],
            simulated: time_s.iter().map(|t| error(*t)).collect(),
            voltage_v: vec![0.0; 1000],
            time_s,
            quantity: Quantity::Speed,
            first_speed_rad_s: 0.0,
        }
    }

    #[test]
    fn the_record_and_the_time_of_a_rise_are_named() {
        let before = [run("stairs", |_| 0.1), run("prbs", |_| 0.1)];
        let after =
            [run("stairs", |_| 0.05), run("prbs", |t| if (6.0..6.5).contains(&t) { 1.0 } else { 0.1 })];
        let rise = worst_rise(&before, &after).unwrap();
        assert_eq!((rise.record.as_str(), rise.at_s), ("prbs", 6.25));
        assert!(rise.times > 2.0);
    }

    #[test]
    fn a_fall_is_no_rise_even_where_one_record_rises() {
        let before = [run("stairs", |_| 1.0), run("prbs", |_| 0.1)];
        let after = [run("stairs", |_| 0.1), run("prbs", |_| 0.2)];
        assert_eq!(worst_rise(&before, &after), None);
    }
}
