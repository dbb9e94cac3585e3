//! What the motor does while a run goes on: a row of bars each for speed and current or voltage, as wide as the terminal.
//!
//! The width is the whole run, so the rows fill as it goes on. Bars stand between the largest magnitude so far backward and the
//! same forward; half a bar is rest.

use std::time::Duration;

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use motorlens_shared::link::Sample;

use super::Console;
use crate::device::lines::Run;
use crate::device::{Capture, Shaft};

/// Bars from the lowest to the highest.
const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
/// The rows are drawn anew after this time.
const REFRESH: Duration = Duration::from_millis(100);
/// Columns beside the bars: the row's name before, the latest value with its unit behind.
const BESIDE: usize = 9 + 18;

/// What the second row shows: its name and its unit.
const CURRENT: [&str; 2] = ["current", "A"];
const VOLTAGE: [&str; 2] = ["voltage", "V"];

/// A sample as it is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    /// Its number in the run, which gives it its column.
    number: u32,
    /// When it was taken, s.
    time_s: f64,
    /// Encoder counts; may wrap.
    count: i32,
    /// What the second row shows.
    value: f64,
}

/// The progress of a run on the terminal.
pub struct Strip {
    points: Vec<Point>,
    /// Samples that were made into points, or left out because they were not taken.
    taken: usize,
    shaft: Option<Shaft>,
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
        Self { points: Vec::new(), taken: 0, shaft: shaft.copied(), bar, rows, drawn: None }
    }

    /// Shows how far a run of the firmware is.
    pub fn show(&mut self, capture: &Capture, now: Duration) {
        if !self.is_due(now) {
            return;
        }
        self.bar.set_position(capture.samples() as u64);
        let Some(scaling) = capture.scaling() else { return };
        let current = capture.measures_current();
        let samples = capture.samples_from(self.taken);
        self.taken += samples.len();
        let point = |(number, sample): &(u32, Sample)| Point {
            number: *number,
            time_s: f64::from(*number) / f64::from(scaling.rate_hz),
            count: sample.count,
            value: if current {
                f64::from(sample.current_ma) * 1e-3
            } else {
                f64::from(scaling.volts(sample))
            },
        };
        self.points.extend(samples.iter().filter(|(_, sample)| !sample.missed()).map(point));
        self.draw(if current { CURRENT } else { VOLTAGE });
    }

    /// Shows how far a run of the line protocol is, with a supply of `supply_v` where the board measures none.
    pub fn show_lines(&mut self, run: &Run, supply_v: f64, now: Duration) {
        if !self.is_due(now) {
            return;
        }
        self.bar.set_length(run.number("samples").map_or(run.len() as u64, |samples| samples as u64));
        self.bar.set_position(run.len() as u64);
        self.bar.set_message(run.pairs.get("programme").cloned().unwrap_or_default());
        // All of them: a board that was started anew in the run begins anew.
        self.points = of_lines(run, supply_v);
        self.draw(VOLTAGE);
    }

    /// Whether the rows are seen, and due to be drawn anew.
    fn is_due(&mut self, now: Duration) -> bool {
        let due =
            !self.bar.is_hidden() && self.drawn.is_none_or(|drawn| now.saturating_sub(drawn) >= REFRESH);
        if due {
            self.drawn = Some(now);
        }
        due
    }

    fn draw(&self, [name, unit]: [&str; 2]) {
        let columns = usize::from(console::Term::stderr().size().1).saturating_sub(BESIDE).max(1);
        let total = self.bar.length().unwrap_or(0);
        let (per_count, speed_unit) =
            self.shaft.map_or((1.0, "counts/s"), |shaft| (shaft.rad_per_count(), "rad/s"));
        let speed = slopes(&self.points, columns, total, per_count);
        self.rows[0].set_message(row("speed", &speed, speed_unit));
        self.rows[1].set_message(row(name, &means(&self.points, columns, total), unit));
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

/// What a board has printed of a run so far; the second row shows the voltage.
fn of_lines(run: &Run, supply_v: f64) -> Vec<Point> {
    let voltage = run.voltage_v(supply_v);
    let rows = run.time_us.iter().zip(&run.count).zip(voltage);
    let point = |(number, ((time_us, count), value)): (u32, ((&u64, &i64), f64))| Point {
        number,
        time_s: *time_us as f64 * 1e-6,
        // Differences are taken modulo 2^32.
        count: *count as i32,
        value,
    };
    (0..).zip(rows).map(point).collect()
}

/// The column of sample number `number` of `total`.
fn column(number: u32, columns: usize, total: u64) -> usize {
    (u64::from(number) * columns as u64 / total.max(1)).min(columns as u64 - 1) as usize
}

/// The mean value in each column that has samples, in order.
fn means(points: &[Point], columns: usize, total: u64) -> Vec<f64> {
    let mut sums = vec![(0.0, 0_u32); columns];
    for point in points {
        let sum = &mut sums[column(point.number, columns, total)];
        *sum = (sum.0 + point.value, sum.1 + 1);
    }
    sums.iter().filter(|(_, count)| *count > 0).map(|(sum, count)| sum / f64::from(*count)).collect()
}

/// The count's mean slope over each column, times `per_count`: from its first sample to the next column's first.
fn slopes(points: &[Point], columns: usize, total: u64, per_count: f64) -> Vec<f64> {
    let mut marks: Vec<(usize, &Point)> = Vec::new();
    for point in points {
        let at = column(point.number, columns, total);
        if marks.last().is_none_or(|mark| mark.0 != at) {
            marks.push((at, point));
        }
    }
    marks.extend(points.last().map(|last| (columns, last)));
    let slope = |(from, to): (&Point, &Point)| {
        f64::from(to.count.wrapping_sub(from.count)) / (to.time_s - from.time_s) * per_count
    };
    let pairs = marks.windows(2).map(|pair| (pair[0].1, pair[1].1));
    pairs.filter(|(from, to)| to.time_s > from.time_s).map(slope).collect()
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
    use crate::device::lines::Row;

    /// A hundred samples at 1000 a second.
    fn run(count: impl Fn(u32) -> i32) -> Vec<Point> {
        let point = |number| Point {
            number,
            time_s: f64::from(number) * 1e-3,
            count: count(number),
            value: if number < 50 { 0.5 } else { -1.0 },
        };
        (0..100).map(point).collect()
    }

    #[test]
    fn the_rows_are_as_wide_as_the_part_of_the_run_that_is_there() {
        let points = run(|number| 2 * number as i32);
        for columns in [1, 7, 40] {
            let speed = slopes(&points, columns, 200, 1.0);
            assert_eq!(speed.len(), columns.div_ceil(2).max(1), "{columns}");
            assert!(speed.iter().all(|value| (value - 2000.0).abs() < 1e-9), "{speed:?}");
        }
    }

    #[test]
    fn bars_stand_about_the_middle_and_the_latest_value_behind_them() {
        let current = means(&run(|_| 0), 4, 100);
        assert_eq!(current, [0.5, 0.5, -1.0, -1.0]);
        assert_eq!(row("current", &current, "A"), "current  ▆▆▁▁ -1.00 A");
        assert_eq!(row("speed", &[0.0, 3.0], "rad/s"), "speed    ▅█ 3.00 rad/s");
        assert_eq!(row("speed", &[], "rad/s"), "speed     ");
    }

    #[test]
    fn samples_that_were_not_taken_and_a_run_longer_than_told_break_nothing() {
        let mut points = run(|number| number as i32);
        points.remove(3);
        assert_eq!(slopes(&points, 5, 20, 1.0).len(), 5);
        assert!(slopes(&points[..1], 5, 20, 1.0).is_empty());
        // The first sample, and all that came after the last one that was told.
        points.iter_mut().for_each(|point| point.value = 1.0);
        assert_eq!(means(&points, 5, 0), [1.0, 1.0]);
    }

    #[test]
    fn what_a_board_prints_is_drawn_by_its_own_times_in_volts_and_across_a_counter_that_wraps() {
        let mut lines = Run::default();
        lines.pairs.insert("duty_full".into(), "200".into());
        // A line was lost after the third: the speed is the same all the same.
        for k in [0, 1, 2, 4, 5, 6, 7, 8] {
            let row =
                Row { t_us: 4000 * k, duty: 100, count: i32::MAX.wrapping_add(8 * k as i32), supply_mv: 0 };
            lines.push(row).unwrap();
        }
        let points = of_lines(&lines, 12.0);
        let (speed, voltage) = (slopes(&points, 4, 8, 0.5), means(&points, 4, 8));
        assert!(speed.len() == 4 && speed.iter().all(|value| (value - 1000.0).abs() < 1e-9), "{speed:?}");
        assert_eq!(voltage, [6.0; 4]);
        assert_eq!(row("voltage", &voltage, "V"), "voltage  ████ 6.00 V");
    }
}
