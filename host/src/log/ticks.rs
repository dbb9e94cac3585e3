//! Clocks of few bits, whose count begins anew at their width: a `uint16_t` of milliseconds after a minute, `micros()` after 71 minutes.
//!
//! That is told from a clock that was reset by the interval: with the width added the row comes when the next one was due.

/// The counts at which clocks of 16 and of 32 bits begin anew.
const WIDTHS: [f64; 2] = [65_536.0, 4_294_967_296.0];
/// The numbers at which those of rows do.
const WIDTHS_OF_ROWS: [f64; 3] = [256.0, 65_536.0, 4_294_967_296.0];
/// The interval across the end of the count is that of the rows before within this factor.
const ALIKE: f64 = 2.0;

/// A clock's count, row by row.
#[derive(Debug, Clone, Default)]
pub(super) struct Ticks {
    last: Option<f64>,
    interval: Option<f64>,
    width: Option<f64>,
    added: f64,
    /// The counts are numbers of rows, some of which may be missing.
    of_rows: bool,
    /// How often the count began anew.
    pub times: usize,
}

impl Ticks {
    /// The numbers of rows.
    pub fn of_rows() -> Self {
        Ticks { of_rows: true, ..Ticks::default() }
    }

    /// The count that a clock of many bits would have.
    pub fn read(&mut self, count: f64) -> f64 {
        if let Some(last) = self.last
            && count < last
            && let Some(width) = self.width_of(last, count)
        {
            self.width = Some(width);
            self.added += width;
            self.times += 1;
        } else if let Some(last) = self.last.filter(|last| count > *last) {
            self.interval = Some(count - last);
        }
        self.last = Some(count);
        count + self.added
    }

    /// The width of the clock, if it is that which makes it fall from `last` to `count`.
    fn width_of(&self, last: f64, count: f64) -> Option<f64> {
        let interval = self.interval?;
        let is = |width: &f64| {
            let step = count + width - last;
            let is_whole = last.fract() == 0.0 && count.fract() == 0.0;
            let is_within = count >= 0.0 && last < *width && last > 0.5 * width;
            let is_due = step <= ALIKE * interval && interval <= ALIKE * step;
            // Of a width that is known rows may be missing there.
            is_whole && is_within && (is_due || self.of_rows && self.width.is_some() && step < 0.5 * width)
        };
        let widths: &[f64] = if self.of_rows { &WIDTHS_OF_ROWS } else { &WIDTHS };
        widths.iter().copied().filter(|width| self.width.is_none_or(|known| known == *width)).find(is)
    }

    /// All of `counts` as [`Ticks::read`] has them.
    pub fn all(counts: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut ticks = Ticks::default();
        counts.map(|count| ticks.read(count)).collect()
    }

    /// The width of the clock and how often it was reached; none where it never was.
    pub fn wrapped(&self) -> Option<(f64, usize)> {
        self.width.map(|width| (width, self.times))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_goes_on_where_its_clock_begins_anew_and_a_reset_is_none() {
        for (width, from, step) in
            [(65_536.0, 62_000.0, 10.0), (65_536.0, 0.0, 10_000.0), (WIDTHS[1], 4.29e9, 1e4)]
        {
            let count = |k: u32| from + step * f64::from(k);
            let read = Ticks::all((0..900).map(|k| count(k) % width));
            assert!((0..900).all(|k| read[k as usize] == count(k)), "{width} {from}");
        }
        let reset = [64_000.0, 64_010.0, 64_020.0, 0.0, 10.0];
        assert_eq!(Ticks::all(reset.into_iter()), reset);
        let repeated = [65_520.0, 65_530.0, 65_530.0, 4.0, 14.0];
        assert_eq!(Ticks::all(repeated.into_iter())[3..], [65_540.0, 65_550.0]);
    }
}
