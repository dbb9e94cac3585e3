//! What is wired to a board's converter, as its setup says it, and which limits can be seen through it.

use motorlens_shared::link::{SUPPLY_SHARES, Setup};

use crate::error::{Error, Result};

/// A converter's full scale, mV.
const FULL_MV: u32 = 3300;
/// The most that a board can be told of a supply, V.
const MOST_V: f32 = 65.535;
/// The most that a board can say of a current, mA.
const MOST_MA: f32 = 32_767.0;

/// What a setup says of a supply of `supply_v`, of a `divider` by what it divides and an `amplifier` by its mV per ampere where they are wired,
/// and of a limit of `current_limit_a`, 0 for none; all else as by default.
///
/// # Errors
/// What cannot be wired, or told, or a limit that could not be seen.
pub fn setup(
    supply_v: f32,
    divider: Option<f32>,
    amplifier: Option<f32>,
    current_limit_a: f32,
) -> Result<Setup> {
    let (divider, amplifier) = (self::divider(divider)?, self::amplifier(amplifier)?);
    Ok(Setup {
        supply_mv: supply(supply_v, divider)?,
        current_limit_ma: current_limit(current_limit_a, amplifier)?,
        divider,
        amplifier,
        ..Setup::default()
    })
}

/// [`Setup::divider`] of a divider that divides the supply by `ratio`, 1 to 655; 0 where none is wired.
///
/// # Errors
/// Another ratio.
fn divider(ratio: Option<f32>) -> Result<u16> {
    raw(ratio, 100.0, 1.0, 655.0, "a divider divides by 1 to 655")
}

/// [`Setup::amplifier`] of a current amplifier of so many mV per ampere, 0.1 to 6553; 0 where none is wired.
///
/// # Errors
/// Another slope.
fn amplifier(mv_per_a: Option<f32>) -> Result<u16> {
    raw(mv_per_a, 10.0, 0.1, 6553.0, "a current amplifier has 0.1 to 6553 mV per ampere")
}

/// [`Setup::supply_mv`] of a supply of so many volts, behind a divider as [`divider`] gives it.
///
/// # Errors
/// More than a board can be told, or a divider behind which it could not see that the supply is pumped up: full scale is no more than
/// what ends a run.
fn supply(volts: f32, divider: u16) -> Result<u16> {
    if volts > MOST_V {
        return Err(Error::usage(
            format!("a supply of {volts} V is more than a board can be told, {MOST_V} V"),
            "state the supply in volts (--supply 12)",
        ));
    }
    let supply_mv = (volts * 1000.0).round() as u16;
    let bound_mv = u32::from(supply_mv) * SUPPLY_SHARES.end() / 100;
    let seen_mv = FULL_MV * u32::from(divider) / 100;
    if divider > 0 && seen_mv <= bound_mv {
        let enough = bound_mv / FULL_MV + 1;
        return Err(Error::usage(
            format!(
                "behind this divider the board sees {:.1} V at most, so it would not see that a supply of {volts} V is pumped up to {:.1} V",
                f64::from(seen_mv) * 1e-3,
                f64::from(bound_mv) * 1e-3
            ),
            format!("wire a divider by {enough} or more, and say so (--divider {enough})"),
        ));
    }
    Ok(supply_mv)
}

/// [`Setup::current_limit_ma`] of a limit of so many amperes, behind an amplifier as [`amplifier`] gives it; 0 is none.
///
/// # Errors
/// A limit that no reading can be above, or that is none.
fn current_limit(amperes: f32, amplifier: u16) -> Result<u16> {
    if amperes == 0.0 {
        return Ok(0);
    }
    // Half of full scale to each side of the rest.
    let seen_ma = if amplifier == 0 { MOST_MA } else { (16_500_000.0 / f32::from(amplifier)).min(MOST_MA) };
    let limit_ma = (amperes * 1000.0).round();
    if limit_ma >= seen_ma {
        let seen_a = seen_ma / 1000.0;
        return Err(Error::usage(
            format!(
                "a current limit of {amperes} A would never end a run: the board reads up to {seen_a:.3} A"
            ),
            format!(
                "limit the current below {seen_a:.3} A (--current-limit), or wire an amplifier of fewer mV per ampere"
            ),
        ));
    }
    if limit_ma.is_nan() || limit_ma < 1.0 {
        return Err(Error::usage(
            "a current limit is 0.001 A or more",
            "leave it away, or at 0, where there is to be none",
        ));
    }
    Ok(limit_ma as u16)
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

    #[test]
    fn a_divider_behind_which_a_pumped_up_supply_is_not_seen_is_refused_with_one_that_would_do() {
        assert_eq!((supply(24.0, 1100).unwrap(), supply(12.0, 600).unwrap()), (24_000, 12_000));
        assert_eq!((supply(48.0, 0).unwrap(), supply(65.535, 0).unwrap()), (48_000, 65_535));
        for (volts, divider, enough) in
            [(24.2, 1100, "--divider 12"), (12.0, 500, "--divider 6"), (4.4, 200, "--divider 3")]
        {
            let told = supply(volts, divider).unwrap_err().to_string();
            assert!(told.contains(enough), "{told}");
        }
        for volts in [65.6, 12_000.0, f32::INFINITY] {
            assert!(supply(volts, 0).is_err(), "{volts}");
        }
    }

    #[test]
    fn a_current_limit_that_no_reading_can_be_above_is_refused_with_what_the_board_reads() {
        assert_eq!((current_limit(9.9, 1650).unwrap(), current_limit(0.0, 1650).unwrap()), (9_900, 0));
        assert_eq!((current_limit(16.0, 1000).unwrap(), current_limit(32.0, 10).unwrap()), (16_000, 32_000));
        for (amperes, amplifier, reads) in [
            (10.0, 1650, "10.000 A"),
            (16.5, 1000, "16.500 A"),
            (32.767, 10, "32.767 A"),
            (70.0, 0, "32.767 A"),
        ] {
            let told = current_limit(amperes, amplifier).unwrap_err().to_string();
            assert!(told.contains(reads), "{told}");
        }
        for amperes in [f32::NAN, -1.0, 0.0001] {
            assert!(current_limit(amperes, 1650).is_err(), "{amperes}");
        }
    }
}
