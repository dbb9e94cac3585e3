//! Waiting for the motor to stand still, before a run.

/// A run begins when the motor has stood still for so long, us. The encoder's count goes on from run to run, so that what depends on the
/// shaft's position is the same in all of them.
const STANDING_US: u32 = 100_000;
/// It does not begin where the shaft still turns after so long, us: a bridge that is not off would drive it from a speed that no log knows.
const PATIENCE_US: u32 = 6_000_000;
/// Counts within which it stands.
const STANDING_COUNTS: u32 = 2;

/// How the wait stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shaft {
    /// It has not stood for long enough yet.
    Awaited,
    /// It stands still.
    Still,
    /// It turns and turns.
    Turning,
}

/// Waiting for the motor to stand still.
#[derive(Debug, Clone, Copy)]
pub struct Wait {
    began_us: u32,
    count: i32,
    since_us: u32,
}

impl Wait {
    /// Begins to wait.
    pub fn new(now: u32, count: i32) -> Self {
        Self { began_us: now, count, since_us: now }
    }

    /// What the count says now.
    pub fn look(&mut self, now: u32, count: i32) -> Shaft {
        if count.abs_diff(self.count) > STANDING_COUNTS {
            (self.count, self.since_us) = (count, now);
        }
        if now.wrapping_sub(self.since_us) >= STANDING_US {
            Shaft::Still
        } else if now.wrapping_sub(self.began_us) >= PATIENCE_US {
            Shaft::Turning
        } else {
            Shaft::Awaited
        }
    }
}
