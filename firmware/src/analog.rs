//! What a converter's raw numbers mean, and when to convert so that their mean is the mean of whole PWM periods.

use core::sync::atomic::{AtomicU32, Ordering};

use motorlens_shared::link::Setup;

/// Full scale of a converter of 12 bits, counts.
pub const FULL: u32 = 4095;

/// What is wired to a board's converter, as the setup says.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Wiring {
    /// [`Setup::divider`]: hundredths, 0 for none.
    pub divider: u16,
    /// [`Setup::amplifier`]: tenths of mV/A, 0 for none.
    pub amplifier: u16,
}

impl From<&Setup> for Wiring {
    fn from(setup: &Setup) -> Self {
        Self { divider: setup.divider, amplifier: setup.amplifier }
    }
}

/// So many readings of 12 bits make a sum of 16, so that supply and current are added in one.
const TOGETHER: usize = 16;

/// Readings that make a mean for a bound: some PWM periods. An interrupt that was held up has the next one close behind it, and what was
/// converted between the two would be pulses of the bridge.
const FEWEST: u32 = 50;

/// Means over an interval.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Means {
    /// The supply, mV, where a divider is wired; 0 where a sample's interval had no reading.
    pub supply_mv: Option<u16>,
    /// The motor's current, mA, where an amplifier is wired; the largest where a sample's interval had no reading.
    pub current_ma: Option<i16>,
}

/// Readings added up since [`Sums::take`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sums {
    supply: u32,
    current: u32,
    count: u32,
    /// The converter's own supply as it was last known, mV.
    full_mv: u32,
}

impl Default for Sums {
    fn default() -> Self {
        Self::new()
    }
}

impl Sums {
    /// Nothing added.
    pub const fn new() -> Self {
        Self { supply: 0, current: 0, count: 0, full_mv: CALIBRATED_MV }
    }

    /// Adds the sums of `count` readings of each input, counts. A million of them fit.
    pub fn add(&mut self, supply: u32, current: u32, count: u32) {
        self.supply = self.supply.wrapping_add(supply);
        self.current = self.current.wrapping_add(current);
        self.count = self.count.wrapping_add(count);
    }

    /// Adds what a converter that goes round its inputs by itself has left in a ring, a round to a word with the supply in its lower half:
    /// the rounds from `from` to before `to`.
    pub fn follow(&mut self, ring: &[AtomicU32], from: usize, to: usize) {
        if to < from {
            self.add_rounds(ring.get(from..).unwrap_or_default());
            self.add_rounds(ring.get(..to).unwrap_or_default());
        } else {
            self.add_rounds(ring.get(from..to).unwrap_or_default());
        }
    }

    fn add_rounds(&mut self, rounds: &[AtomicU32]) {
        for words in rounds.chunks(TOGETHER) {
            let both = words.iter().map(|word| word.load(Ordering::Relaxed)).fold(0, u32::wrapping_add);
            self.add(both & 0xffff, both >> 16, words.len() as u32);
        }
    }

    /// The means of what was added after `before`, where that is enough for them: for bounds, to a hundredth, in few steps of 32 bits.
    pub fn since(&self, before: &Self, wiring: Wiring) -> Means {
        let count = self.count.wrapping_sub(before.count);
        if count < FEWEST {
            return Means::default();
        }
        // Sixteenths of a count, of some hundred readings at most.
        let mean = |sum: u32| 16 * sum / count.max(1);
        let supply_mv = (wiring.divider > 0).then(|| {
            let pin_mv = mean(self.supply.wrapping_sub(before.supply)) * self.full_mv / (16 * FULL);
            (pin_mv * u32::from(wiring.divider) / 100).min(u16::MAX.into()) as u16
        });
        let current_ma = (wiring.amplifier > 0).then(|| {
            // Half a count for what the converter cuts off, and the amplifier rests in the middle.
            let above = mean(self.current.wrapping_sub(before.current)) as i32 + 8 - 8 * FULL as i32;
            let pin = above * self.full_mv as i32 / FULL as i32; // sixteenths of mV
            let milliamperes = pin * 625 / i32::from(wiring.amplifier.max(1)); // by tenths of mV/A
            milliamperes.clamp(i16::MIN.into(), i16::MAX.into()) as i16
        });
        Means { supply_mv, current_ma }
    }

    /// The means, and begins anew. The converter's own supply is `full_mv`.
    pub fn take(&mut self, wiring: Wiring, full_mv: u32) -> Means {
        let Self { supply, current, count, .. } = *self;
        // A converter that does not answer is a supply that ends the run, and a current that does.
        let stopped = count == 0;
        let count = count.max(1);
        *self = Self { full_mv, ..Self::new() };
        let full_mv = u64::from(full_mv);
        // Microvolts at the pin, half a count for what the converter cuts off.
        let pin_uv = |sum: u32| {
            (u64::from(2 * sum + count) * full_mv * 1000 / u64::from(2 * count).max(1)) as i64
                / i64::from(FULL)
        };
        let supply_mv = (wiring.divider > 0).then(|| {
            let supply_uv = pin_uv(supply) * i64::from(wiring.divider) / 100;
            if stopped { 0 } else { ((supply_uv + 500) / 1000).clamp(0, u16::MAX.into()) as u16 }
        });
        let current_ma = (wiring.amplifier > 0).then(|| {
            let above_uv = pin_uv(current) - full_mv as i64 * 500;
            let milliamperes = above_uv * 10 / i64::from(wiring.amplifier.max(1)); // uV by tenths of mV/A are tenths of mA
            if stopped { i16::MAX } else { milliamperes.clamp(i16::MIN.into(), i16::MAX.into()) as i16 }
        });
        Means { supply_mv, current_ma }
    }
}

/// The supply of an STM32F4's converter at which the maker has measured the internal reference, mV (RM0090 13.10 and the chips' data
/// sheets, "internal reference voltage calibration values"), and also what is taken where no such value is found.
pub const CALIBRATED_MV: u32 = 3300;
/// Between these a calibration value is one: the reference is 1.18 to 1.24 V of 3.3 V.
const CALIBRATION: core::ops::RangeInclusive<u16> = 1400..=1600;
/// The converter's supply must be one that the chip runs at, mV.
const POSSIBLE_MV: core::ops::RangeInclusive<u64> = 2400..=3600;

/// The converter's full scale, mV: its own supply, which the internal reference tells. `calibration` is what the maker has measured of
/// it, counts; `count` readings of it make `sum`.
pub fn full_scale_mv(calibration: u16, sum: u32, count: u32) -> u32 {
    if !CALIBRATION.contains(&calibration) || sum == 0 {
        return CALIBRATED_MV;
    }
    // Half a count for what the converter cuts off, as in the readings that this scales.
    let twice = u64::from(2 * sum + count);
    let full_mv = u64::from(2 * CALIBRATED_MV * u32::from(calibration)) * u64::from(count) / twice.max(1);
    if POSSIBLE_MV.contains(&full_mv) { full_mv as u32 } else { CALIBRATED_MV }
}

/// Parts of a PWM period in which conversions are counted.
const PARTS: u32 = 32;
const PART_BITS: u32 = 32 - PARTS.trailing_zeros();

/// How unevenly conversions `apart` ticks apart fall on a PWM period of `period` ticks within `interval` ticks: 0 where every part of
/// the period gets the same number of them, `2^16 * (parts - 1)` where one gets all.
fn unevenness(apart: u32, period: u32, interval: u32) -> u32 {
    let mut parts = [0_u32; PARTS as usize];
    let count = (interval / apart.max(1)).max(1);
    // The phase as a share of 2^32, which wraps as the period does.
    let step = ((u64::from(apart) << 32) / u64::from(period.max(1))) as u32;
    let mut phase = 0_u32;
    for _ in 0..count {
        if let Some(part) = parts.get_mut((phase >> PART_BITS) as usize) {
            *part += 1;
        }
        phase = phase.wrapping_add(step);
    }
    let squares: u64 = parts.iter().map(|part| u64::from(*part) * u64::from(*part)).sum();
    let even = u64::from(count) * u64::from(count);
    ((u64::from(PARTS) * squares).saturating_sub(even) * 65_536 / even.max(1)) as u32
}

/// Of some times between conversions, ticks, the one at which they fall most evenly on the PWM's period within an interval that holds
/// a whole number of periods: then their mean is that of whole periods, whatever the ripple. 0 where there is nothing to choose from.
pub fn most_even(period: u32, interval: u32, apart: impl IntoIterator<Item = u32>) -> u32 {
    apart.into_iter().min_by_key(|apart| unevenness(*apart, period, interval)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIRED: Wiring = Wiring { divider: 1100, amplifier: 1650 };

    /// What a converter gives for so many volts of a full scale of `full_v`.
    fn counts(volts: f64, full_v: f64) -> u32 {
        (volts / full_v * f64::from(FULL)) as u32
    }

    #[test]
    fn means_are_in_mv_and_ma_of_what_is_wired() {
        let mut sums = Sums::new();
        for ripple in [-0.3, 0.1, 0.2] {
            let supply = counts((12.0 + ripple) / 11.0, 3.3);
            sums.add(supply, counts(1.65 - 0.165 * (2.0 + ripple), 3.3), 1);
        }
        let means = sums.take(WIRED, 3300);
        let (supply, current) = (means.supply_mv.unwrap(), means.current_ma.unwrap());
        assert!(supply.abs_diff(12_000) <= 12 && current.abs_diff(-2000) <= 6, "{means:?}");
        assert_eq!(sums, Sums::new());
        sums.add(2000, 2000, 1);
        assert_eq!(sums.take(Wiring::default(), 3300), Means::default());
    }

    #[test]
    fn the_means_of_the_last_readings_alone_are_there_before_the_interval_ends() {
        let mut sums = Sums::new();
        sums.add(40 * counts(12.0 / 11.0, 3.3), 40 * 2048, 40);
        let before = sums;
        assert_eq!(sums.since(&before, WIRED), Means::default());
        for amperes in [-6.0, -0.2, 0.0, 0.2, 6.0] {
            let before = sums;
            let current = counts(1.65 + 0.165 * amperes, 3.3);
            sums.add(49 * counts(19.0 / 11.0, 3.3), 49 * current, 49);
            assert_eq!(sums.since(&before, WIRED), Means::default(), "too few are pulses of the bridge");
            sums.add(counts(19.0 / 11.0, 3.3), current, 1);
            let Means { supply_mv: Some(supply), current_ma: Some(current) } = sums.since(&before, WIRED)
            else {
                panic!("both are wired");
            };
            assert!(supply.abs_diff(19_000) <= 40, "{supply}");
            assert!((f64::from(current) - 1000.0 * amperes).abs() <= 5.0, "{amperes} A: {current}");
            assert_eq!(sums.since(&before, Wiring::default()), Means::default());
        }
        // Both ends of the scale of every part do not overflow.
        for (reading, current_ma) in [(4095, i16::MAX), (0, i16::MIN)] {
            let before = sums;
            sums.add(800 * reading, 800 * reading, 800);
            let means = sums.since(&before, Wiring { divider: u16::MAX, amplifier: 1 });
            assert_eq!(
                (means.supply_mv.map(|mv| mv > 0), means.current_ma),
                (Some(reading > 0), Some(current_ma))
            );
        }
    }

    #[test]
    fn a_ring_is_added_up_from_where_it_was_left_over_its_end_too() {
        let ring: std::vec::Vec<AtomicU32> = (0..40).map(|k| AtomicU32::new(k | 4095 << 16)).collect();
        let mut sums = Sums::new();
        sums.follow(&ring, 3, 37);
        sums.follow(&ring, 37, 2);
        sums.follow(&ring, 2, 2);
        let of = |places: std::ops::Range<u32>| places.sum::<u32>();
        assert_eq!((sums.supply, sums.current, sums.count), (of(3..40) + of(0..2), 39 * 4095, 39));
    }

    #[test]
    fn a_converter_that_gives_nothing_is_a_supply_and_a_current_out_of_bounds() {
        let means = Sums::new().take(WIRED, 3300);
        assert_eq!(means, Means { supply_mv: Some(0), current_ma: Some(i16::MAX) });
    }

    #[test]
    fn the_reference_takes_the_converters_own_supply_out() {
        for full_v in [2.9, 3.3, 3.45] {
            let mut sums = Sums::new();
            sums.add(60 * counts(12.0 / 11.0, full_v), 60 * counts(full_v / 2.0, full_v), 60);
            let calibration = (1.21 / 3.3 * f64::from(FULL)).round() as u16;
            let means = sums.take(WIRED, full_scale_mv(calibration, 16 * counts(1.21, full_v), 16));
            let (supply, current) = (means.supply_mv.unwrap(), means.current_ma.unwrap());
            // A count of the reference is 0.07 %.
            assert!(supply.abs_diff(12_000) <= 16 && current.abs() <= 8, "{full_v} V: {means:?}");
        }
    }

    #[test]
    fn without_a_calibration_or_a_reading_that_could_be_true_the_converters_supply_is_taken_as_nominal() {
        for (calibration, reading) in [(0, 1501), (0xffff, 1501), (1501, 0), (1501, 900), (1501, 4095)] {
            assert_eq!(full_scale_mv(calibration, 60 * reading, 60), 3300, "{calibration}, {reading}");
        }
        assert!(full_scale_mv(1501, 60 * 1601, 60).abs_diff(3094) <= 2);
    }

    /// The largest error of the mean of a pulse of any width and phase, as a share of the pulse, and of a triangle as high.
    fn errors(apart: u32, period: u32, interval: u32) -> (f64, f64) {
        let count = interval / apart;
        let (mut pulse, mut triangle) = (0.0_f64, 0.0_f64);
        for step in 0..40 {
            let begin = f64::from(step) / 40.0;
            let phase = |k: u32| (f64::from(k) * f64::from(apart) / f64::from(period) + begin).fract();
            let mean =
                |f: &dyn Fn(f64) -> f64| (0..count).map(|k| f(phase(k))).sum::<f64>() / f64::from(count);
            for width in [0.1, 0.3, 0.5, 0.7, 0.9] {
                pulse = pulse.max((mean(&|at| f64::from(at < width)) - width).abs());
            }
            triangle = triangle.max((mean(&|at| 1.0 - (2.0 * at - 1.0).abs()) - 0.5).abs());
        }
        (pulse, triangle)
    }

    #[test]
    fn conversions_fall_evenly_on_the_period_at_every_rate_and_pwm_frequency() {
        // The STM32F4's rounds, a Pico's and a Pico 2's, ticks of the core's clock.
        let [pico, pico_2] = [125, 150].map(|mega_hz| {
            (97..=129).step_by(4).map(|apart| 2 * apart * mega_hz / 48).collect::<std::vec::Vec<u32>>()
        });
        let boards = [(84_000_000_u32, &[216, 268, 320][..]), (125_000_000, &pico), (150_000_000, &pico_2)];
        for (core, rounds) in boards {
            for interval_us in [500, 625, 800, 1000, 1600, 2000, 10_000] {
                let interval = interval_us * (core / 1_000_000);
                for pwm_hz in (5_000_u32..=50_000).step_by(1_000) {
                    // As many whole periods as make up an interval.
                    let periods = (u64::from(interval) * u64::from(pwm_hz) / u64::from(core)).max(1) as u32;
                    let period = interval / periods;
                    let chosen = most_even(period, interval, rounds.iter().copied());
                    let (pulse, triangle) = errors(chosen, period, interval);
                    let case = std::format!(
                        "{core} Hz, {interval_us} us, PWM {pwm_hz} Hz: {pulse:.4}, {triangle:.4}"
                    );
                    assert!(pulse < 0.04 && triangle < 0.01, "{case}");
                }
            }
        }
    }
}
