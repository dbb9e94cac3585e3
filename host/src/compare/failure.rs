//! Where a model fails: its error sorted by what the motor was doing.
//!
//! The error of an open-loop simulation of the angle carries all that happened before. So every bin has two shares: of the
//! squared error itself, and of its *growth* over 50 ms, which tells where the error is made.

use motorlens_shared::effects::Rig;
use serde::Serialize;

use super::course::{Moment, moments};
use super::free_run::FreeRun;
use super::slices::{self, Sorting};

/// The error sorted in every way that these records allow.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FailureMap {
    /// Unit of the errors.
    pub unit: &'static str,
    /// One a sorting.
    pub slices: Vec<Slice>,
}

/// The error sorted in one way. Its bins hold every sample exactly once.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Slice {
    /// `speed`, `since_reversal`, `standstill`, `voltage`, `time`, `output_angle`, `motor_angle`.
    pub by: &'static str,
    /// The same for people.
    pub title: &'static str,
    /// What it shows, in one line.
    pub reading: String,
    /// Unit of the limits.
    pub unit: &'static str,
    /// The bins that hold samples, in order.
    pub bins: Vec<Bin>,
}

/// Samples of one kind.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bin {
    /// For people.
    pub label: String,
    /// Lower limit, where there is one.
    pub low: Option<f64>,
    /// Upper limit, where there is one.
    pub high: Option<f64>,
    /// How many.
    pub samples: usize,
    /// Their share of all samples.
    pub share_of_samples: f64,
    /// Their share of the squared error.
    pub share_of_error: f64,
    /// Their share of the squared growth of the error.
    pub share_of_growth: f64,
    /// Root of the mean square error among them.
    pub rmse: f64,
    /// Mean of the signed error (measured minus simulated).
    pub mean_error: f64,
    /// Mean of the signed growth.
    pub mean_growth: f64,
}

/// Above this ratio of error to samples a bin is named.
const CONSPICUOUS: f64 = 1.5;
/// A bin that holds less than this share of the growth explains nothing.
const NOTEWORTHY: f64 = 0.05;

/// Sorts the errors of `runs`, made on `rig`.
pub fn failure_map(runs: &[FreeRun], rig: &Rig) -> FailureMap {
    let all: Vec<Moment> = runs.iter().flat_map(|run| moments(run, rig)).collect();
    let unit = runs.first().map_or("", |run| run.quantity.unit());
    FailureMap { unit, slices: slices::all(&all, rig).into_iter().map(|s| slice(s, &all)).collect() }
}

#[derive(Clone, Copy, Default)]
struct Sums {
    samples: usize,
    error: f64,
    squared: f64,
    growth: f64,
    growth_squared: f64,
}

fn slice(sorting: Sorting, all: &[Moment]) -> Slice {
    let mut sums = vec![Sums::default(); sorting.bins.len()];
    for m in all {
        let Some(bin) = (sorting.place)(m) else { continue };
        let s = &mut sums[bin];
        s.samples += 1;
        s.error += m.error;
        s.squared += m.error * m.error;
        s.growth += m.growth;
        s.growth_squared += m.growth * m.growth;
    }
    let total = |f: fn(&Sums) -> f64| sums.iter().map(f).sum::<f64>().max(f64::MIN_POSITIVE);
    let (samples, squared, grown) =
        (total(|s| s.samples as f64), total(|s| s.squared), total(|s| s.growth_squared));
    let bins: Vec<Bin> = sorting
        .bins
        .into_iter()
        .zip(&sums)
        .filter(|(_, s)| s.samples > 0)
        .map(|(edge, s)| {
            let n = s.samples as f64;
            Bin {
                label: edge.label,
                low: edge.low,
                high: edge.high,
                samples: s.samples,
                share_of_samples: n / samples,
                share_of_error: s.squared / squared,
                share_of_growth: s.growth_squared / grown,
                rmse: (s.squared / n).sqrt(),
                mean_error: s.error / n,
                mean_growth: s.growth / n,
            }
        })
        .collect();
    Slice { by: sorting.name, title: sorting.title, reading: reading(&bins), unit: sorting.unit, bins }
}

impl Slice {
    /// How unlike the time the error is spread over the bins, 0 ..= 1: the total variation distance of their shares.
    pub fn concentration(&self) -> f64 {
        0.5 * self.bins.iter().map(|b| (b.share_of_growth - b.share_of_samples).abs()).sum::<f64>()
    }
}

impl FailureMap {
    /// The sortings, the one in which the error is most concentrated first.
    pub fn by_concentration(&self) -> Vec<&Slice> {
        let mut all: Vec<&Slice> = self.slices.iter().collect();
        all.sort_by(|a, b| b.concentration().total_cmp(&a.concentration()));
        all
    }
}

/// Share of the error for its share of the time.
fn density(bin: &Bin) -> f64 {
    bin.share_of_growth / bin.share_of_samples.max(1e-12)
}

/// Of the bins that explain something, the one in which most of the error is made for its time, if it stands out.
fn fullest(bins: &[Bin]) -> Option<&Bin> {
    let noteworthy = bins.iter().filter(|b| b.share_of_growth >= NOTEWORTHY);
    noteworthy.max_by(|a, b| density(a).total_cmp(&density(b))).filter(|b| density(b) >= CONSPICUOUS)
}

/// The bin in which the error is made, or that there is none.
fn reading(bins: &[Bin]) -> String {
    match fullest(bins) {
        Some(b) => format!(
            "{}: {:.0} % of the error is made here, in {:.0} % of the time",
            b.label,
            100.0 * b.share_of_growth,
            100.0 * b.share_of_samples
        ),
        None => "evenly spread".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::grid::Quantity;

    fn rig() -> Rig {
        Rig {
            step_s: 1e-3,
            gear_ratio: 10.0,
            encoder_on_motor: true,
            nominal_v: 12.0,
            supply_v: 12.0,
            reference_speed: 10.0,
            count_rad: 1e-4,
        }
    }

    /// 20 s of a triangle of 8 rad/s; the model loses `lost` rad at every reversal.
    fn run(lost: f64) -> FreeRun {
        let time_s: Vec<f64> = (0..20_000).map(|k| f64::from(k) * 1e-3).collect();
        let forward = |t: f64| (t / 2.0) as i64 % 2 == 0;
        let mut angle = 0.0;
        let (mut measured, mut simulated, mut voltage_v, mut error) = (vec![], vec![], vec![], 0.0);
        for t in &time_s {
            let speed = if forward(*t) { 8.0 } else { -8.0 };
            angle += speed * 1e-3;
            let wanted = if forward(*t) { 0.0 } else { lost };
            error += (wanted - error) * 0.2;
            measured.push(angle);
            simulated.push(angle - error);
            voltage_v.push(speed);
        }
        FreeRun {
            record: "r".into(),
            time_s,
            measured,
            simulated,
            voltage_v,
            quantity: Quantity::Angle,
            first_speed_rad_s: 0.0,
        }
    }

    fn by<'a>(map: &'a FailureMap, name: &str) -> &'a Slice {
        map.slices.iter().find(|s| s.by == name).expect("this slice exists")
    }

    #[test]
    fn shares_sum_to_one_and_every_sample_is_in_one_bin() {
        let map = failure_map(&[run(0.05)], &rig());
        assert_eq!(map.slices.len(), 7);
        for slice in &map.slices {
            let sum = |f: fn(&Bin) -> f64| slice.bins.iter().map(f).sum::<f64>();
            assert_eq!(slice.bins.iter().map(|b| b.samples).sum::<usize>(), 20_000, "{}", slice.by);
            for share in [sum(|b| b.share_of_error), sum(|b| b.share_of_growth), sum(|b| b.share_of_samples)]
            {
                assert!((share - 1.0).abs() < 1e-9, "{}", slice.by);
            }
        }
    }

    #[test]
    fn play_in_the_gear_shows_after_reversals() {
        let map = failure_map(&[run(0.05)], &rig());
        let slice = by(&map, "since_reversal");
        assert!(slice.reading.contains(" ms") && slice.reading.contains("is made here"), "{}", slice.reading);
        let soon: f64 =
            slice.bins.iter().filter(|b| b.high.is_some_and(|h| h <= 0.05)).map(|b| b.share_of_growth).sum();
        assert!(soon > 0.5, "{soon}");
        let order: Vec<f64> = map.by_concentration().iter().map(|slice| slice.concentration()).collect();
        assert!(order.is_sorted_by(|a, b| a >= b) && slice.concentration() > 0.3, "{order:?}");
    }

    #[test]
    fn an_error_that_the_motor_does_not_cause_is_evenly_spread() {
        let mut even = run(0.0);
        for (k, p) in even.simulated.iter_mut().enumerate() {
            // The phase grows with the square: no stride of samples beats with it.
            *p += 1e-3 * ((k * k) as f64 * 0.37).sin();
        }
        let map = failure_map(&[even], &rig());
        for name in ["since_reversal", "voltage", "time", "motor_angle"] {
            assert_eq!(by(&map, name).reading, "evenly spread", "{name}");
        }
    }

    #[test]
    fn records_of_speed_have_no_angle() {
        let mut speeds = run(0.0);
        speeds.quantity = Quantity::Speed;
        speeds.measured.clone_from(&speeds.voltage_v);
        let map = failure_map(&[speeds], &rig());
        assert!(map.slices.iter().all(|s| !s.by.contains("angle")));
        assert_eq!(map.unit, "rad/s");
    }
}
