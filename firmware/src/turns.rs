//! Whether the main loop still turns while the motor is driven.
//!
//! It hears the host and sends the log, and a run that nobody can stop is none. The sampling interrupt, which comes at least every
//! millisecond ([`crate::beat`]), sees how long ago the loop has done a piece of work: begun a turn, worked through a symbol of a protected
//! frame, kept a block of the log.
//!
//! A loop that does one piece again and again would look like one that works. So a turn as a whole, which takes one message and sends one
//! block at most, has its time too. One whose turns go on and which hears nothing is ended as any silence of the host is
//! ([`crate::supervisor`]): a frame that is damaged says nothing.

/// The main loop hangs when its last piece of work is so long ago, us. With the interrupts at most a millisecond apart the bridge is off
/// within 2 ms of it, the interrupt's own time included.
const LONGEST_PIECE_US: u32 = 800;
/// It hangs too when a turn takes so long, us.
const LONGEST_TURN_US: u32 = 50_000;

/// When the main loop last did a piece of work, and how long it took at most.
#[derive(Debug, Clone, Copy, Default)]
pub struct Turns {
    turned_us: u32,
    worked_us: u32,
    longest_piece_us: u32,
    longest_turn_us: u32,
}

impl Turns {
    /// Begins to watch, in the middle of a turn.
    pub fn new(now_us: u32) -> Self {
        Self { turned_us: now_us, worked_us: now_us, ..Self::default() }
    }

    /// A turn begins.
    pub fn turned(&mut self, now_us: u32) {
        self.worked(now_us);
        self.longest_turn_us = self.longest_turn_us.max(now_us.wrapping_sub(self.turned_us));
        self.turned_us = now_us;
    }

    /// The main loop has done a piece of its turn's work.
    pub fn worked(&mut self, now_us: u32) {
        self.longest_piece_us = self.longest_piece_us.max(now_us.wrapping_sub(self.worked_us));
        self.worked_us = now_us;
    }

    /// Whether the main loop hangs.
    pub fn hang(&self, now_us: u32) -> bool {
        now_us.wrapping_sub(self.worked_us) >= LONGEST_PIECE_US
            || now_us.wrapping_sub(self.turned_us) >= LONGEST_TURN_US
    }

    /// The longest time from one piece of work to the next, and of a turn, since the watch began, sleep included, us.
    pub fn longest_us(&self) -> (u32, u32) {
        (self.longest_piece_us, self.longest_turn_us)
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
                turns.turned(begin + worked);
                let found = (1..9).map(|k| k * apart).find(|after| turns.hang(begin.wrapping_add(*after)));
                assert!(found.is_some_and(|found| found - worked < 1850), "{rate} Hz: {found:?} us");
            }
            for now in (0..100_000).step_by(apart as usize) {
                // A loop that sleeps is woken twice in a millisecond, and something may hold it up.
                turns.turned(now / 500 * 500);
                assert!(!turns.hang(now + 250), "{rate} Hz");
            }
        }
    }

    #[test]
    fn a_loop_that_does_the_same_piece_of_a_turn_for_ever_is_found_too_and_long_turns_of_many_pieces_are_not()
    {
        let mut turns = Turns::new(7);
        for turn in 0..10 {
            let begin = turn * (LONGEST_TURN_US - 1) + 7;
            turns.turned(begin);
            for now in (begin..).step_by(300).take_while(|now| now - begin < LONGEST_TURN_US) {
                turns.worked(now);
                assert!(!turns.hang(now));
            }
        }
        assert_eq!(turns.longest_us(), (300, LONGEST_TURN_US - 1));
        let hung = (0..).map(|k| 9 * (LONGEST_TURN_US - 1) + 7 + 100 * k).find(|now| {
            turns.worked(*now);
            turns.hang(*now)
        });
        assert!(hung.is_some());
    }
}
