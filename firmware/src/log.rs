//! The log ring, from which the host is served, again where a frame was lost.

use motorlens_shared::link::{LOG_SAMPLES, LogBlock, Sample, Scaling};

/// Samples held: a second at 1 kHz.
pub const LOG_LENGTH: usize = 1024;

/// Marks a log that was begun by this program; "mlog".
const MAGIC: u32 = 0x6d6c_6f67;

/// The last samples of a run, by number.
///
/// Integers only, so that any bytes are a valid value: the log may lie in memory that is not cleared at the start, and be
/// found again after a watchdog reset ([`Log::recover`]).
#[derive(Debug)]
#[repr(C)]
pub struct Log {
    magic: u32,
    run: u32,
    next: u32,
    missed: u32,
    running: u32,
    pwm_top: u16,
    rate_hz: u16,
    samples: [Sample; LOG_LENGTH],
}

impl Default for Log {
    fn default() -> Self {
        Self::new()
    }
}

impl Log {
    /// An empty log.
    pub const fn new() -> Self {
        Self {
            magic: MAGIC,
            run: 0,
            next: 0,
            missed: 0,
            running: 0,
            pwm_top: 1,
            rate_hz: 1,
            samples: [Sample::MISSED; LOG_LENGTH],
        }
    }

    /// Makes the best of whatever the memory held at the start. After a watchdog reset a log of this program is kept;
    /// otherwise it is emptied. True when its run was cut short, be it several resets ago: a supply that sinks may stay low.
    pub fn recover(&mut self, after_watchdog: bool) -> bool {
        let kept = after_watchdog
            && self.magic == MAGIC
            && self.running <= 1
            && self.rate_hz > 0
            && self.pwm_top > 0;
        if !kept {
            // In place: the log is too large for the stack.
            (self.magic, self.run, self.next, self.missed, self.running) = (MAGIC, 0, 0, 0, 0);
            (self.pwm_top, self.rate_hz) = (1, 1);
        }
        self.running == 1
    }

    /// Empties it for a run.
    pub fn begin(&mut self, run: u32, scaling: Scaling) {
        (self.run, self.next, self.missed, self.running) = (run, 0, 0, 1);
        (self.pwm_top, self.rate_hz) = (scaling.pwm_top, scaling.rate_hz);
    }

    /// The run is over.
    pub fn end(&mut self) {
        self.running = 0;
    }

    /// Appends a sample, over the oldest when full.
    pub fn push(&mut self, sample: Sample) {
        self.missed += u32::from(sample.missed());
        self.samples[self.next as usize % LOG_LENGTH] = sample;
        self.next += 1;
    }

    /// The run's number.
    pub fn run(&self) -> u32 {
        self.run
    }

    /// Number of the next sample.
    pub fn next(&self) -> u32 {
        self.next
    }

    /// Number of the oldest sample held.
    pub fn oldest(&self) -> u32 {
        self.next.saturating_sub(LOG_LENGTH as u32)
    }

    /// Samples that there was no time to take.
    pub fn missed(&self) -> u32 {
        self.missed
    }

    /// What the raw numbers mean.
    pub fn scaling(&self) -> Scaling {
        Scaling { pwm_top: self.pwm_top, rate_hz: self.rate_hz }
    }

    /// Sample number `index`; `None` when it is not held.
    pub fn get(&self, index: u32) -> Option<Sample> {
        (self.oldest()..self.next).contains(&index).then(|| self.held(index))
    }

    /// Up to `most` samples from `first` on; `None` when the first is not held.
    pub fn block(&self, first: u32, most: u32) -> Option<LogBlock> {
        self.get(first)?;
        let last = self.next.min(first.saturating_add(most)).min(first.saturating_add(LOG_SAMPLES as u32));
        // Plain copies: the sampling interrupt is held off meanwhile.
        Some(LogBlock { run: self.run, first, samples: (first..last).map(|k| self.held(k)).collect() })
    }

    /// Sample number `index`, which is held.
    fn held(&self, index: u32) -> Sample {
        self.samples[index as usize % LOG_LENGTH]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(count: i32) -> Sample {
        Sample { duty: 0, count, supply_mv: 0, current_ma: 0, late_us: 0 }
    }

    fn filled(samples: i32) -> Log {
        let mut log = Log::new();
        log.begin(7, Scaling { pwm_top: 4200, rate_hz: 1000 });
        (0..samples).for_each(|count| log.push(sample(count)));
        log
    }

    #[test]
    fn only_the_last_samples_are_held_and_found_by_number() {
        let log = filled(3000);
        assert_eq!((log.oldest(), log.next()), (3000 - LOG_LENGTH as u32, 3000));
        assert_eq!(log.get(2999), Some(sample(2999)));
        assert_eq!((log.get(3000), log.get(log.oldest() - 1)), (None, None));
        let block = log.block(2996, 100).unwrap();
        assert_eq!((block.first, block.samples.len(), block.samples[3]), (2996, 4, sample(2999)));
        assert_eq!(log.block(log.oldest(), 3).unwrap().samples.len(), 3);
        assert_eq!(log.block(5, 3), None);
    }

    #[test]
    fn a_log_survives_the_watchdog_and_nothing_else() {
        let mut log = filled(30);
        assert!(log.recover(true));
        assert_eq!((log.run(), log.next(), log.get(29)), (7, 30, Some(sample(29))));
        assert!(log.recover(true), "another reset before anybody has asked");
        assert!(!log.recover(false));
        assert_eq!(log.next(), 0);
        log.magic = 0;
        log.next = 5000;
        assert!(!log.recover(true));
        assert_eq!(log.next(), 0);
    }
}
