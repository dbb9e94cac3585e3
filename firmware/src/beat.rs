//! How often the sampling timer interrupts, which is at least every millisecond.
//!
//! The interrupt renews the dead man's handle of the board, so a program that hangs is noticed as soon at 100 samples a second
//! as at 2000. Where samples are further apart than a millisecond, only every nth interrupt is a sampling instant.

/// The longest time between two interrupts, us.
const LONGEST_US: u32 = 1000;
/// The bridge is off so long after an interrupt that should have come and did not, us.
pub const GRACE_US: u32 = 500;

/// Interrupts per sampling period of `period_us`, and the time between them, us.
///
/// ```
/// use motorlens_firmware::beat::split;
/// assert_eq!(split(500), (1, 500));
/// assert_eq!(split(1000), (1, 1000));
/// assert_eq!(split(1250), (2, 625));
/// assert_eq!(split(10_000), (10, 1000));
/// ```
pub fn split(period_us: u32) -> (u32, u32) {
    let fits = |beats: &u32| period_us.is_multiple_of(*beats) && period_us / beats <= LONGEST_US;
    let beats = (1..=period_us.max(1)).find(fits).unwrap_or(1);
    (beats, period_us / beats)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rate_of_the_link_has_an_interrupt_at_least_every_millisecond() {
        for rate in (100..=2000).filter(|rate| 1_000_000_u32.is_multiple_of(*rate)) {
            let (beats, apart) = split(1_000_000 / rate);
            assert_eq!(beats * apart * rate, 1_000_000);
            assert!((500..=LONGEST_US).contains(&apart), "{rate} Hz: {apart} us");
        }
    }
}
