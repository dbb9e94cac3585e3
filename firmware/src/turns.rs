//! Whether the main loop still turns while the motor is driven.
//!
//! It hears the host and sends the log, and a run that nobody can stop is none. The sampling interrupt, which comes at least every
//! millisecond ([`crate::beat`]), sees how long ago the loop has done a piece of work: a turn, a message, a block of the log.

/// The main loop hangs when its last piece of work is so long ago, us. With the interrupts at most a millisecond apart the bridge is off
/// within 2 ms of it, the interrupt's own time included.
const LONGEST_US: u32 = 800;

/// When the main loop last did a piece of work.
#[derive(Debug, Clone, Copy, Default)]
pub struct Turns {
    worked_us: u32,
}

impl Turns {
    /// The main loop has done a piece of work.
    pub fn worked(&mut self, now_us: u32) {
        self.worked_us = now_us;
    }

    /// Whether the main loop hangs.
    pub fn hang(&self, now_us: u32) -> bool {
        now_us.wrapping_sub(self.worked_us) >= LONGEST_US
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beat::split;

    #[test]
    fn a_loop_that_hangs_is_found_within_two_milliseconds_at_every_rate_and_one_that_works_is_not() {
        for rate in (100..=2000).filter(|rate| 1_000_000_u32.is_multiple_of(*rate)) {
            let (_, apart) = split(1_000_000 / rate);
            let mut turns = Turns::default();
            // Over the clock's wrap too.
            for worked in (0..apart).step_by(7) {
                let begin = u32::MAX - 3 * apart;
                turns.worked(begin + worked);
                let found = (1..9).map(|k| k * apart).find(|after| turns.hang(begin.wrapping_add(*after)));
                assert!(found.is_some_and(|found| found - worked < 1850), "{rate} Hz: {found:?} us");
            }
            for now in (0..100_000).step_by(apart as usize) {
                // A loop that sleeps is woken twice in a millisecond.
                turns.worked(now / 500 * 500);
                assert!(!turns.hang(now + 499), "{rate} Hz");
            }
        }
    }
}
