//! Log samples as they travel: raw numbers of the board, and what turns them into SI units.

use heapless::Vec;
use serde::{Deserialize, Serialize};

/// The most samples in one [`LogBlock`]. Small, because on a line that damages one byte in a hundred the chance of a
/// frame to arrive falls with its length.
pub const LOG_SAMPLES: usize = 8;

/// One sampling instant, and the interval from there to the next: the count is the instant's, duty, supply and current are the
/// interval's, which holds a whole number of PWM periods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sample {
    /// Applied duty in PWM ticks, sign included; [`Scaling::pwm_top`] is full voltage.
    pub duty: i16,
    /// Encoder counts since the board started: what depends on the shaft's position is the same in every run.
    pub count: i32,
    /// Mean supply of the interval, mV: measured where a divider is wired, stated otherwise.
    pub supply_mv: u16,
    /// Mean current of the motor in the interval, mA; 0 where it is not measured.
    pub current_ma: i16,
    /// How much later than its nominal instant the sample was taken, us.
    pub late_us: i16,
}

impl Sample {
    /// Stands in the log where the board had no time to take a sample.
    pub const MISSED: Sample = Sample { duty: 0, count: 0, supply_mv: 0, current_ma: 0, late_us: i16::MIN };

    /// Whether this only marks the place of a sample that was not taken.
    pub const fn missed(&self) -> bool {
        self.late_us == i16::MIN
    }
}

/// Consecutive samples of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LogBlock {
    /// The run's number, as it was given with the start.
    pub run: u32,
    /// Number of the first sample, from 0 at the run's start.
    pub first: u32,
    /// The samples.
    pub samples: Vec<Sample, LOG_SAMPLES>,
}

/// What a board's raw numbers mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Scaling {
    /// PWM ticks of full voltage.
    pub pwm_top: u16,
    /// Samples a second, Hz.
    pub rate_hz: u16,
}

impl Scaling {
    /// The mean voltage at the driver's output in the sample's interval, V: duty times supply.
    ///
    /// One multiplication and one division in `f32`, the same bits on every machine.
    pub fn volts(&self, sample: &Sample) -> f32 {
        f32::from(sample.duty) * (f32::from(sample.supply_mv) * 1e-3) / f32::from(self.pwm_top)
    }

    /// The instant of sample number `index`, s from the run's start.
    pub fn seconds(&self, index: u32, sample: &Sample) -> f64 {
        f64::from(index) / f64::from(self.rate_hz) + f64::from(sample.late_us) * 1e-6
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_voltage_is_duty_times_supply_and_the_time_counts_the_delay() {
        let scaling = Scaling { pwm_top: 4200, rate_hz: 1000 };
        let sample = Sample { duty: -2100, count: 5, supply_mv: 12_000, current_ma: 0, late_us: 4 };
        assert!((scaling.volts(&sample) + 6.0).abs() < 1e-6);
        assert!((scaling.seconds(1500, &sample) - 1.500_004).abs() < 1e-12);
        assert!(!sample.missed() && Sample::MISSED.missed());
    }
}
