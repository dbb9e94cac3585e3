//! What is wired to a board's converter, as its setup says it.

use crate::error::{Error, Result};

/// [`Setup::divider`] of a divider that divides the supply by `ratio`, 1 to 655; 0 where none is wired.
///
/// # Errors
/// Another ratio.
///
/// [`Setup::divider`]: motorlens_shared::link::Setup::divider
pub fn divider(ratio: Option<f32>) -> Result<u16> {
    raw(ratio, 100.0, 1.0, 655.0, "a divider divides by 1 to 655")
}

/// [`Setup::amplifier`] of a current amplifier of so many mV per ampere, 0.1 to 6553; 0 where none is wired.
///
/// # Errors
/// Another slope.
///
/// [`Setup::amplifier`]: motorlens_shared::link::Setup::amplifier
pub fn amplifier(mv_per_a: Option<f32>) -> Result<u16> {
    raw(mv_per_a, 10.0, 0.1, 6553.0, "a current amplifier has 0.1 to 6553 mV per ampere")
}

fn raw(value: Option<f32>, units: f32, least: f32, most: f32, rule: &str) -> Result<u16> {
    match value {
        None => Ok(0),
        Some(value) if (least..=most).contains(&value) => Ok((value * units).round() as u16),
        Some(_) => Err(Error::usage(rule, "see motorlens capture --help")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wired_is_told_in_hundredths_and_tenths_and_nothing_as_zero() {
        assert_eq!((divider(Some(11.0)).unwrap(), divider(None).unwrap()), (1100, 0));
        assert_eq!((amplifier(Some(165.0)).unwrap(), amplifier(None).unwrap()), (1650, 0));
        assert_eq!((divider(Some(655.0)).unwrap(), amplifier(Some(6553.0)).unwrap()), (65_500, 65_530));
        for ratio in [f32::NAN, -11.0, 0.0, 0.99, 656.0] {
            assert!(divider(Some(ratio)).is_err(), "{ratio}");
        }
        for slope in [f32::NAN, -165.0, 0.0, 0.01, 6554.0] {
            assert!(amplifier(Some(slope)).is_err(), "{slope}");
        }
    }
}
