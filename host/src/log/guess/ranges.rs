//! What the values of a column span, and what that tells by itself.

/// What the values of a column span.
pub(super) struct Range {
    pub low: f64,
    pub high: f64,
    pub whole: bool,
    /// It holds 100 itself, or nothing but tens: percent.
    pub has_round_tens: bool,
    first: f64,
}

/// What the pulses of a servo or an ESC span, us, with what some boards allow themselves; full duty back is 1000, none 1500 (of
/// a drive that turns one way only 1000) and full duty forth 2000.
const PULSES: (f64, f64) = (900.0, 2100.0);
/// A drive that begins below this stands still there.
const ONE_WAY: f64 = 1100.0;

impl Range {
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut range = Self {
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            whole: true,
            has_round_tens: true,
            first: f64::NAN,
        };
        for value in values {
            range.first = if range.first.is_nan() { value } else { range.first };
            range.low = range.low.min(value);
            range.high = range.high.max(value);
            range.whole &= value.fract() == 0.0;
            range.has_round_tens &= value % 10.0 == 0.0;
        }
        range.has_round_tens |= range.peak() == 100.0;
        if range.low > range.high {
            (range.low, range.high) = (0.0, 0.0);
        }
        range
    }

    /// The length of the pulse that is no duty, us, where the values are such pulses.
    pub fn pulse_of_no_duty(&self) -> Option<u32> {
        let are = self.low >= PULSES.0 && self.high <= PULSES.1 && self.high > self.low.max(ONE_WAY);
        are.then_some(if self.first < ONE_WAY { 1000 } else { 1500 })
    }

    /// Whether all of it is whole.
    pub fn is_whole(&self) -> bool {
        self.whole
    }

    pub fn peak(&self) -> f64 {
        self.low.abs().max(self.high.abs())
    }
}
