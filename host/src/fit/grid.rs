//! A record laid on the time grid of the model.
//!
//! The model steps through cells of equal length, about a millisecond. A cell's voltage is the mean of the held
//! voltage over it, which keeps every volt-second whatever the time stamps do; samples fall between cells and are
//! interpolated there. So jitter and gaps cost nothing but this one pass.

use super::reading::{least_noise, reading_noise};
use super::voltages::mean_voltages;
use super::window::Since;
use crate::log::motion::mean;
use crate::log::{Record, timing};

/// What the record's main column is.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Angle of the output shaft, rad.
    Angle,
    /// Speed at the sampling instant, rad/s.
    Speed,
    /// Mean speed since the last sample, as counted from encoder edges, rad/s.
    MeanSpeed,
    /// Mean speed over the last so many seconds, rad/s.
    WindowSpeed(f64),
}

impl Quantity {
    /// The unit of everything that is compared.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Angle => "rad",
            Self::Speed | Self::MeanSpeed | Self::WindowSpeed(_) => "rad/s",
        }
    }

    /// In a sentence, after "each speed is"; none of an angle.
    pub fn speed_in_words(self) -> Option<String> {
        match self {
            Self::Angle => None,
            Self::Speed => Some("that of its time".into()),
            Self::MeanSpeed => Some("the mean since the reading before".into()),
            Self::WindowSpeed(length) => {
                Some(format!("the mean over the last {} ms", (1e4 * length).round() / 10.0))
            }
        }
    }
}

/// Where a sample lies: in cell `cell`, at `part` (0 ..= 1) of its length; `part` 1 is the cell's end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Cell number.
    pub cell: usize,
    /// Place within the cell.
    pub part: f64,
}

/// A record as the fit sees it.
#[derive(Debug, Clone)]
pub struct Grid {
    /// Name of the record.
    pub name: String,
    /// Length of a cell, s.
    pub step_s: f64,
    /// What a late voltage still brings at the start, then the mean voltage of every cell, V.
    pub(super) voltages: Vec<f64>,
    /// What was measured at the start and at the end of every cell, rad; empty where runs are free.
    pub(super) guide: Vec<f64>,
    /// Which of these are near a sample.
    pub(super) seen: Vec<bool>,
    /// Times of the samples kept, s.
    pub time_s: Vec<f64>,
    /// Their place on the grid; the first sample is the start itself (cell 0, part 0).
    pub places: Vec<Place>,
    /// What was measured there.
    pub measured: Vec<f64>,
    /// What that is.
    pub quantity: Quantity,
    /// Of mean speeds where each begins, a sample after the other.
    pub(super) since: Vec<Since>,
    /// Angle at the start, rad.
    pub start_angle: f64,
    /// Speed at the start, rad/s; of an angle's record, what [`super::start`] made of it.
    pub(super) start_speed: f64,
    /// How old the first reading is, s, where readings are held.
    pub(super) reading_age_s: f64,
    /// Smallest step of the measured column (0: none was found).
    pub quantum: f64,
    /// Standard deviation of one reading: the unit in which errors count.
    pub sigma: f64,
    /// Inverse noise of each time scale, finest first ([`super::scales`]); empty: that of one reading at all.
    pub scales: Vec<f64>,
    /// Inverse of the simulation error's root mean square; 0 where it is not known yet.
    pub even: f64,
    /// How far the mean of an angle's error may be off in it at no cost, rad ([`Self::offset`]); while effects are chosen, as far as it likes, since
    /// a disturbance moves it further than any effect.
    pub even_offset: f64,
    /// Median time between samples, s.
    pub interval_s: f64,
    /// The first samples only lead in: they are simulated but not judged.
    pub skip: usize,
}

/// Longest cell, s, where readings are dense. The exact map allows more, but friction and effects are held over a cell.
const LONGEST_CELL: f64 = 1.001e-3;
/// Cells between two readings where these are slow, and the longest cell then, s: nothing faster is seen.
const BETWEEN_READINGS: f64 = 8.0;
const LONGEST_SLOW_CELL: f64 = 4e-3;
/// Cells that a record should not exceed, and the longest cell that this may lead to, s.
const MOST_CELLS: f64 = 120_000.0;
const LONGEST_SWEEP_CELL: f64 = 0.01;
/// Samples closer together than this are thinned: the motor does not move between them.
const SHORTEST_CELL: f64 = 0.45e-3;
/// Readings that stay at least: the first speed is the middle one of so many.
const FEWEST_READINGS: usize = 3;

impl Grid {
    /// Lays `record` on the grid; `quantum` is the smallest step of its main column.
    pub fn new(record: &Record, quantum: f64) -> Self {
        let interval = timing::median_interval(&record.time_s);
        let (quantity, column) = main_column(record, quantum, interval);
        let updated = updates(quantity, column);
        let at = |kept: &Vec<usize>| -> Vec<f64> { kept.iter().map(|k| record.time_s[*k]).collect() };
        let update_s = updated.as_ref().map(|kept| timing::median_interval(&at(kept)));
        let step = cell_length(interval, update_s.unwrap_or(interval), record.duration_s());
        let thin = ((step / interval).round() as usize).clamp(1, (record.len() / FEWEST_READINGS).max(1));
        let origin = record.time_s[0];
        let cells = (record.duration_s() / step).ceil() as usize + 1;
        let mut grid = Self {
            name: record.name.clone(),
            step_s: step,
            voltages: mean_voltages(record, step, cells),
            guide: Vec::new(),
            seen: Vec::new(),
            time_s: Vec::new(),
            places: Vec::new(),
            measured: Vec::new(),
            quantity,
            since: Vec::new(),
            start_angle: record.angle_rad.as_ref().map_or(0.0, |a| a[0]),
            start_speed: 0.0,
            reading_age_s: 0.0,
            quantum,
            sigma: reading_noise(quantity, column, quantum),
            scales: Vec::new(),
            even: 0.0,
            even_offset: f64::INFINITY,
            interval_s: update_s.unwrap_or(interval * thin as f64),
            skip: 0,
        };
        for k in updated.unwrap_or_else(|| (0..record.len()).step_by(thin).collect()) {
            let position = (record.time_s[k] - origin) / step;
            grid.places.push(place(position));
            grid.time_s.push(record.time_s[k]);
            grid.measured.push(column[k]);
        }
        if grid.quantity != Quantity::Angle {
            let speed = median3(grid.measured[0], grid.measured[1], grid.measured[2]);
            grid.begin_at(speed, grid.voltages[1]);
        }
        grid.read_as(quantity)
    }

    /// Mean voltage of every cell, V.
    pub fn cells(&self) -> &[f64] {
        &self.voltages[1..]
    }

    /// Mean voltage between each reading and the one before, V.
    pub fn sample_voltages(&self) -> Vec<f64> {
        let between = |from: usize, to: usize| {
            mean(&self.cells()[from.min(to)..=to.max(from).min(self.cells().len() - 1)])
        };
        let first = std::iter::once(0);
        let ends = self.places.iter().map(|place| place.cell);
        let begins = first.chain(ends.clone().map(|cell| cell + 1));
        begins.zip(ends).map(|(from, to)| between(from, to)).collect()
    }

    /// The least that a reading may scatter by: the counting where an encoder counts, and the digits that a number has.
    pub fn least_noise(&self) -> f64 {
        least_noise(&self.measured, self.quantum)
    }

    /// Whether the record begins at rest.
    pub fn rests(&self) -> bool {
        self.start_speed == 0.0
    }

    /// Speed at which the record begins, rad/s.
    pub fn first_speed_rad_s(&self) -> f64 {
        self.start_speed
    }

    /// Begins at `speed`, rad/s, under `voltage`, V, that a late bridge still brings; a motor at rest had none.
    pub(crate) fn begin_at(&mut self, speed: f64, voltage: f64) {
        self.start_speed = speed;
        self.voltages[0] = if speed == 0.0 { 0.0 } else { voltage };
    }

    /// The beginning of the record, for fitting: `share` of its samples.
    #[must_use]
    pub fn beginning(&self, share: f64) -> Self {
        self.first((self.len() as f64 * share) as usize)
    }

    /// The first `n` samples, all judged.
    #[must_use]
    pub fn first(&self, n: usize) -> Self {
        let mut part = self.clone();
        part.time_s.truncate(n);
        part.places.truncate(n);
        part.since.truncate(n);
        part.measured.truncate(n);
        part.skip = 0;
        part
    }

    /// The samples of `range` alone, all judged: the run still starts at the record's beginning.
    #[must_use]
    pub fn only(&self, range: std::ops::Range<usize>) -> Self {
        let places = self.places[range.clone()].to_vec();
        // Nothing behind the last sample is run.
        let ends = places.last().map_or(0, |place| place.cell + 2);
        let until = |all: &[f64]| all[..ends.min(all.len())].to_vec();
        Self {
            name: self.name.clone(),
            voltages: until(&self.voltages),
            guide: until(&self.guide),
            seen: self.seen[..ends.min(self.seen.len())].to_vec(),
            time_s: self.time_s[range.clone()].to_vec(),
            places,
            since: self.since.get(range.clone()).map(<[Since]>::to_vec).unwrap_or_default(),
            measured: self.measured[range].to_vec(),
            scales: self.scales.clone(),
            skip: 0,
            ..*self
        }
    }

    /// The rest of the record, for judging: the run still starts at its beginning.
    #[must_use]
    pub fn rest(&self, share: f64) -> Self {
        Self { skip: (self.len() as f64 * share) as usize, ..self.clone() }
    }

    /// Number of samples compared.
    pub fn len(&self) -> usize {
        self.measured.len()
    }

    /// Whether there is nothing to compare.
    pub fn is_empty(&self) -> bool {
        self.measured.is_empty()
    }
}

/// About a millisecond, dividing the sampling interval where that is longer; more for records of many minutes with
/// few samples, such as sweeps of steady speeds.
fn cell_length(interval: f64, update_s: f64, duration: f64) -> f64 {
    let slow = (1.001 * update_s / BETWEEN_READINGS).min(LONGEST_SLOW_CELL);
    let longest = LONGEST_CELL.max(slow).max((duration / MOST_CELLS).min(LONGEST_SWEEP_CELL));
    if interval >= SHORTEST_CELL {
        interval / (interval / longest).ceil()
    } else {
        interval * (SHORTEST_CELL / interval).ceil()
    }
}

/// Stamps within 2 % of a cell of its edge count as on the edge: that is writing precision, not jitter.
pub(super) fn place(position: f64) -> Place {
    let nearest = position.round();
    let position = if (position - nearest).abs() < 0.02 { nearest } else { position };
    let end = position.ceil().max(1.0);
    // Whole cells exactly: their readings need no interpolation.
    let part = position - (end - 1.0);
    Place { cell: end as usize - 1, part: if (part - 1.0).abs() < 1e-6 { 1.0 } else { part } }
}

/// Angle where there is one; else speed, as a mean since the last sample if it counts in whole encoder edges.
fn main_column(record: &Record, quantum: f64, interval: f64) -> (Quantity, &[f64]) {
    if let Some(angle) = &record.angle_rad {
        return (Quantity::Angle, angle);
    }
    let speed = record.speed_rad_s.as_deref().unwrap_or(&[]);
    let counts = std::f64::consts::TAU / (quantum * interval);
    // A speed that moves in steps of one count per interval was counted over that interval.
    let counted = quantum > 0.0 && counts > 8.0 && interval > 3e-3;
    (if counted { Quantity::MeanSpeed } else { Quantity::Speed }, speed)
}

/// Readings of a speed are held where the column changes only every so many rows: at least so many ...
const HELD_ROWS: usize = 3;
/// ... in this share of its changes, give or take a row.
const HELD_SHARE: f64 = 0.6;

/// The rows at which a held reading is updated; none where readings are not held. A slow update between them (a radio, a slow bus)
/// repeats what was read before, which is no further measurement. A column that stands still is taken to be updated as often.
fn updates(quantity: Quantity, column: &[f64]) -> Option<Vec<usize>> {
    if quantity == Quantity::Angle {
        return None;
    }
    let changes: Vec<usize> = (1..column.len()).filter(|k| column[*k] != column[*k - 1]).collect();
    let mut runs: Vec<usize> = changes.windows(2).map(|w| w[1] - w[0]).collect();
    if runs.len() < 8 {
        return None;
    }
    runs.sort_unstable();
    let hold = runs[runs.len() / 2];
    let regular = runs.iter().filter(|run| run.abs_diff(hold) <= 1 + hold / 10).count();
    if hold < HELD_ROWS || (regular as f64) < HELD_SHARE * runs.len() as f64 {
        return None;
    }
    let mut kept = vec![0];
    for change in changes.into_iter().chain([column.len()]) {
        while kept.last().is_some_and(|last| last + 2 * hold <= change) {
            kept.push(kept[kept.len() - 1] + hold);
        }
        if change < column.len() && change > kept[kept.len() - 1] {
            kept.push(change);
        }
    }
    Some(kept)
}

fn median3(a: f64, b: f64, c: f64) -> f64 {
    a.max(b).min(a.min(b).max(c))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A shaft that turns evenly, counted, at `times` under `volts`.
    pub fn record(times: Vec<f64>, volts: Vec<f64>) -> Record {
        let angle = times.iter().map(|t| 0.01 * (t * 300.0).floor()).collect();
        Record { time_s: times, voltage_v: volts, angle_rad: Some(angle), ..Record::default() }
    }

    /// Every tenth row is a reading, as over a radio; a slow speed of few levels changes as it likes.
    #[test]
    fn a_held_speed_counts_once_an_update() {
        let held: Vec<f64> = (0..600).map(|k| f64::from(k / 10) * 0.1).collect();
        let kept = updates(Quantity::Speed, &held).unwrap();
        assert!(kept.len() == 60 && kept[7] == 70, "{kept:?}");
        let levels: Vec<f64> = (0..600).map(|k| (f64::from(k) * 0.02).sin() * 3.0).map(f64::round).collect();
        assert_eq!(updates(Quantity::Speed, &levels), None);
        assert_eq!(updates(Quantity::Angle, &held), None);
    }

    #[test]
    fn even_samples_fall_on_cell_ends() {
        let times: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.005).collect();
        let grid = Grid::new(&record(times, vec![1.0; 100]), 0.01);
        assert!((grid.step_s - 0.001).abs() < 1e-12);
        assert_eq!(grid.places[0], Place { cell: 0, part: 0.0 });
        assert_eq!(grid.places[3].cell, 14);
        assert!((grid.places[3].part - 1.0).abs() < 1e-9);
    }

    #[test]
    fn fast_logs_are_thinned_to_the_grid() {
        let times: Vec<f64> = (0..10_000).map(|k| f64::from(k) * 1e-4).collect();
        let grid = Grid::new(&record(times, vec![1.0; 10_000]), 0.01);
        assert!(grid.len() <= 2001 && grid.step_s > 4e-4);
    }

    #[test]
    fn a_short_record_of_a_fast_log_keeps_the_readings_that_tell_its_first_speed() {
        let time_s: Vec<f64> = (0..30).map(|k| f64::from(k) * 1e-6).collect();
        let speed_rad_s = Some(time_s.iter().map(|t| 1e4 * t).collect());
        let record = Record { time_s, voltage_v: vec![1.0; 30], speed_rad_s, ..Record::default() };
        assert!(Grid::new(&record, 0.0).len() >= FEWEST_READINGS);
    }
}
