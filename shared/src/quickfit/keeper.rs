//! Keeps what the quick fit needs while a run goes on.

use super::Kept;
use crate::linear::{Hold, Kind, Prepare};
use crate::link::{Sample, Scaling};
use heapless::Vec;

/// The most samples kept.
pub const KEPT: usize = 2000;

/// Turns the log's samples into kept ones: one of every few, with the mean of the voltages up to the next.
///
/// Takes the samples in order. A missed sample or a full store ends the keeping, so what is kept is gapless.
#[derive(Debug, Clone)]
pub struct Keeper {
    samples: Vec<Kept, KEPT>,
    prepare: Prepare,
    scaling: Scaling,
    every: u16,
    taken: u16,
    volts: f32,
    count: i32,
    ended: bool,
}

impl Keeper {
    /// An empty store; `every` is 1 or more.
    pub const fn new(scaling: Scaling, every: u16) -> Self {
        let prepare = Prepare::new(every as f64 / scaling.rate_hz as f64, Hold::Zero, Kind::Angle);
        Self { samples: Vec::new(), prepare, scaling, every, taken: 0, volts: 0.0, count: 0, ended: false }
    }

    /// Empties the store, in place, for another run.
    pub fn restart(&mut self, scaling: Scaling, every: u16) {
        self.samples.clear();
        self.prepare = Prepare::new(f64::from(every) / f64::from(scaling.rate_hz), Hold::Zero, Kind::Angle);
        (self.scaling, self.every) = (scaling, every);
        (self.taken, self.volts, self.ended) = (0, 0.0, false);
    }

    /// Takes the run's next sample.
    pub fn push(&mut self, sample: &Sample) {
        self.ended |= sample.missed() || self.samples.is_full();
        if self.ended {
            return;
        }
        if self.taken == 0 {
            self.count = sample.count;
        }
        self.volts += self.scaling.volts(sample);
        self.taken += 1;
        if self.taken == self.every {
            let mean = f64::from(self.volts / f32::from(self.every));
            let kept = self.prepare.push_as(mean, f64::from(self.count));
            self.ended |= self.samples.push(kept).is_err();
            (self.taken, self.volts) = (0, 0.0);
        }
    }

    /// Ends the keeping: samples are missing from here on.
    pub fn end(&mut self) {
        self.ended = true;
    }

    /// What is kept.
    pub fn samples(&self) -> &[Kept] {
        &self.samples
    }

    /// Time between kept samples, s.
    pub fn step_s(&self) -> f32 {
        f32::from(self.every) / f32::from(self.scaling.rate_hz)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(duty: i16, count: i32) -> Sample {
        Sample { duty, count, supply_mv: 10_000, current_ma: 0, late_us: 0 }
    }

    #[test]
    fn voltages_are_averaged_and_counts_are_those_of_the_first() {
        let mut keeper = Keeper::new(Scaling { pwm_top: 1000, rate_hz: 1000 }, 2);
        for (duty, count) in [(100, 7), (300, 8), (-500, 9), (-500, 11), (0, 12)] {
            keeper.push(&sample(duty, count));
        }
        assert_eq!(keeper.samples(), [[2.0, 0.0, 0.0], [-5.0, 0.004, 2.0]]);
    }

    #[test]
    fn nothing_is_kept_beyond_a_missed_sample_or_a_full_store() {
        let mut keeper = Keeper::new(Scaling { pwm_top: 1000, rate_hz: 1000 }, 1);
        keeper.push(&sample(1, 1));
        keeper.push(&Sample::MISSED);
        keeper.push(&sample(1, 2));
        assert_eq!(keeper.samples().len(), 1);
        keeper.restart(Scaling { pwm_top: 1000, rate_hz: 1000 }, 1);
        for count in 0..3000 {
            keeper.push(&sample(1, count));
        }
        assert_eq!(keeper.samples().len(), KEPT);
    }
}
