//! What the motor does while a run goes on: a row of bars each for speed and current, as wide as the terminal.
//!
//! The width is the whole run, so the rows fill as it goes on. Bars stand between the largest magnitude so far backward and the
//! same forward; half a bar is rest.

use std::time::Duration;

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use motorlens_shared::link::Sample;

use super::Console;
use crate::device::{Capture, Shaft};

/// Bars from the lowest to the highest.
const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
/// The rows are drawn anew after this time.
const REFRESH: Duration = Duration::from_millis(100);
/// Columns beside the bars: the row's name before, the latest value with its unit behind.
const BESIDE: usize = 9 + 18;

/// The progress of a run on the terminal.
pub struct Strip {
    samples: Vec<(u32, Sample)>,
    shaft: Option<Shaft>,
    total: u64,
    bar: ProgressBar,
    rows: [ProgressBar; 2],
    drawn: Option<Duration>,
}

impl Strip {
    /// A run of `total` samples; speed is told in counts where the shaft is not known.
    pub fn new(name: &str, total: u64, shaft: Option<&Shaft>, console: &Console) -> Self {
        let shown = console.shows_progress();
        let target = if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let all = MultiProgress::with_draw_target(target);
        let style = |template| ProgressStyle::with_template(template).expect("the template is sound");
        let bar = all.add(ProgressBar::new(total));
        bar.set_style(style("{msg:24} {wide_bar} {pos}/{len} samples"));
        bar.set_message(name.to_owned());
        let rows = [(); 2].map(|()| all.add(ProgressBar::no_length().with_style(style("{msg}"))));
        Self { samples: Vec::new(), shaft: shaft.copied(), total, bar, rows, drawn: None }
    }

    /// Shows how far the run is.
    pub fn show(&mut self, capture: &Capture, now: Duration) {
        if self.bar.is_hidden() || self.drawn.is_some_and(|drawn| now.saturating_sub(drawn) < REFRESH) {
            return;
        }
        self.drawn = Some(now);
        self.bar.set_position(capture.samples() as u64);
        self.samples.extend(capture.samples_from(self.samples.len()));
        let Some(scaling) = capture.scaling() else { return };
        let columns = usize::from(console::Term::stderr().size().1).saturating_sub(BESIDE).max(1);
        let (per_count, unit) =
            self.shaft.map_or((1.0, "counts/s"), |shaft| (shaft.rad_per_count(), "rad/s"));
        let speed = slopes(&self.samples, columns, self.total, f64::from(scaling.rate_hz) * per_count);
        self.rows[0].set_message(row("speed", &speed, unit));
        let second = if capture.measures_current() {
            let current = |sample: &Sample| f64::from(sample.current_ma) * 1e-3;
            row("current", &means(&self.samples, columns, self.total, current), "A")
        } else {
            let voltage = |sample: &Sample| f64::from(scaling.volts(sample));
            row("voltage", &means(&self.samples, columns, self.total, voltage), "V")
        };
        self.rows[1].set_message(second);
    }

    /// Takes it off the terminal while something else is said there.
    pub fn aside(&self, say: impl FnOnce()) {
        self.bar.suspend(say);
    }

    /// Takes it off the terminal.
    pub fn clear(&self) {
        self.rows.iter().chain([&self.bar]).for_each(ProgressBar::finish_and_clear);
    }
}

/// The column of sample number `index` of `total`.
fn column(index: u32, columns: usize, total: u64) -> usize {
    (u64::from(index) * columns as u64 / total.max(1)).min(columns as u64 - 1) as usize
}

/// The mean of a value in each column that has samples, in order.
fn means(samples: &[(u32, Sample)], columns: usize, total: u64, value: impl Fn(&Sample) -> f64) -> Vec<f64> {
    let mut sums = vec![(0.0, 0_u32); columns];
    for (index, sample) in samples.iter().filter(|(_, sample)| !sample.missed()) {
        let sum = &mut sums[column(*index, columns, total)];
        *sum = (sum.0 + value(sample), sum.1 + 1);
    }
    sums.iter().filter(|(_, count)| *count > 0).map(|(sum, count)| sum / f64::from(*count)).collect()
}

/// The count's mean slope over each column, times `scale`: from its first sample to the next column's first.
fn slopes(samples: &[(u32, Sample)], columns: usize, total: u64, scale: f64) -> Vec<f64> {
    let mut marks: Vec<(usize, u32, i32)> = Vec::new();
    let mut last = None;
    for (index, sample) in samples.iter().filter(|(_, sample)| !sample.missed()) {
        let at = column(*index, columns, total);
        if marks.last().is_none_or(|mark| mark.0 != at) {
            marks.push((at, *index, sample.count));
        }
        last = Some((at, *index, sample.count));
    }
    marks.extend(last);
    let pairs = marks.windows(2).filter(|pair| pair[1].1 > pair[0].1);
    pairs
        .map(|pair| f64::from(pair[1].2.wrapping_sub(pair[0].2)) / f64::from(pair[1].1 - pair[0].1) * scale)
        .collect()
}

/// A name, bars, and the latest value.
fn row(name: &str, values: &[f64], unit: &str) -> String {
    let most = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let bar = |value: &f64| {
        let share = if most > 0.0 { value / most } else { 0.0 };
        BARS[((share + 1.0) / 2.0 * (BARS.len() - 1) as f64).round() as usize]
    };
    let bars: String = values.iter().map(bar).collect();
    let latest = values.last().map_or(String::new(), |value| format!("{value:.2} {unit}"));
    format!("{name:<8} {bars} {latest}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(count: impl Fn(u32) -> i32) -> Vec<(u32, Sample)> {
        let sample = |index| Sample {
            duty: 100,
            count: count(index),
            supply_mv: 12_000,
            current_ma: if index < 50 { 500 } else { -1000 },
            late_us: 0,
        };
        (0..100).map(|index| (index, sample(index))).collect()
    }

    #[test]
    fn the_rows_are_as_wide_as_the_part_of_the_run_that_is_there() {
        let samples = run(|index| 2 * index as i32);
        for columns in [1, 7, 40] {
            let speed = slopes(&samples, columns, 200, 1000.0);
            assert_eq!(speed.len(), columns.div_ceil(2).max(1), "{columns}");
            assert!(speed.iter().all(|value| (value - 2000.0).abs() < 1e-9), "{speed:?}");
        }
    }

    #[test]
    fn bars_stand_about_the_middle_and_the_latest_value_behind_them() {
        let current = means(&run(|_| 0), 4, 100, |sample| f64::from(sample.current_ma) * 1e-3);
        assert_eq!(current, [0.5, 0.5, -1.0, -1.0]);
        assert_eq!(row("current", &current, "A"), "current  ▆▆▁▁ -1.00 A");
        assert_eq!(row("speed", &[0.0, 3.0], "rad/s"), "speed    ▅█ 3.00 rad/s");
        assert_eq!(row("speed", &[], "rad/s"), "speed     ");
    }

    #[test]
    fn samples_that_were_not_taken_and_a_run_longer_than_told_break_nothing() {
        let mut samples = run(|index| index as i32);
        samples[3].1 = Sample::MISSED;
        assert_eq!(slopes(&samples, 5, 20, 1.0).len(), 5);
        assert!(slopes(&samples[..1], 5, 20, 1.0).is_empty());
        // The first sample, and all that came after the last one that was told.
        assert_eq!(means(&samples, 5, 0, |_| 1.0), [1.0, 1.0]);
    }
}
