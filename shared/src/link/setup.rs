//! How a run is set up.

use core::fmt;
use core::ops::RangeInclusive;
use serde::{Deserialize, Serialize};

/// How the bridge is driven. The log says which, because the motor sees another voltage in the off part of the PWM.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DriveMode {
    /// Direction pins and PWM; the motor is shorted in the off part (TB6612, drivers with PWM and DIR or with PH and EN).
    SignMagnitudeBrake,
    /// Direction pins and PWM; the motor floats in the off part (L298 with PWM on its enable input).
    SignMagnitudeCoast,
    /// The PWM reverses the bridge; half duty is no voltage.
    LockedAntiPhase,
    /// Two PWM inputs, both high in the off part: the motor is shorted (DRV8833, DRV8871, BTS7960). Since version 2.
    InInBrake,
    /// Two PWM inputs, both low in the off part: the motor floats (DRV8833, DRV8871). Since version 2.
    InInCoast,
}

impl DriveMode {
    /// The name in logs and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::SignMagnitudeBrake => "sign_magnitude_brake",
            Self::SignMagnitudeCoast => "sign_magnitude_coast",
            Self::LockedAntiPhase => "locked_anti_phase",
            Self::InInBrake => "in_in_brake",
            Self::InInCoast => "in_in_coast",
        }
    }

    /// The version of the link that brought it: an older board does not know it.
    pub const fn since(self) -> u16 {
        match self {
            Self::InInBrake | Self::InInCoast => 2,
            _ => 1,
        }
    }
}

/// Everything about a run but its programme. A limit of 0 is off where it says so.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Setup {
    /// Samples a second, Hz: 100 to 2000, a whole number of microseconds apart.
    pub rate_hz: u16,
    /// How the bridge is driven.
    pub drive: DriveMode,
    /// Supply voltage where the board does not measure it, mV.
    pub supply_mv: u16,
    /// The largest duty, thousandths of full voltage: 1 to 1000. The commands are clipped there.
    pub duty_limit: u16,
    /// The longest run, ms; more than 0.
    pub run_limit_ms: u32,
    /// Voltage from which standing still is a stall, mV.
    pub stall_mv: u16,
    /// How long the motor may stand still under it, ms; 0 is off.
    pub stall_ms: u16,
    /// The largest current, mA; 0 is off, and so it must be where no current is measured.
    pub current_limit_ma: u16,
    /// How long the host may stay silent, ms; more than 0, and no longer than half the board's log lasts.
    pub link_timeout_ms: u16,
    /// The quick fit keeps one sample of so many: 1 or more; voltages between are averaged.
    pub keep_every: u16,
    /// The PWM's frequency, Hz, within [`PWM_LIMITS_HZ`]; 0 is [`PWM_HZ`]. The board takes the nearest that a sampling period holds whole
    /// periods of, and tells it in its capabilities. Since version 3; an older board stays at its own.
    pub pwm_hz: u32,
    /// The divider before the supply's input, hundredths: 1100 divides by 11. 0 says that none is wired: the input floats and is not
    /// read, and the supply is as stated. Since version 4, as the next.
    pub divider: u16,
    /// The slope of the bidirectional amplifier before the current's input, tenths of mV/A: 1650 is 165 mV/A. Its output without
    /// current is half of the converter's supply. 0 says that none is wired.
    pub amplifier: u16,
}

/// The PWM's frequency where none is asked for, Hz: above what is heard, and what every usual driver can switch.
pub const PWM_HZ: u32 = 20_000;
/// The frequencies that can be asked for, Hz. Below, the boards' 16-bit timers at their clocks have no more ticks for full voltage than
/// fit in a sample; above, dead times and switching of usual drivers take a part of the voltage that the log does not know.
pub const PWM_LIMITS_HZ: RangeInclusive<u32> = 5_000..=50_000;

impl Default for Setup {
    fn default() -> Self {
        Self {
            rate_hz: 1000,
            drive: DriveMode::SignMagnitudeBrake,
            supply_mv: 12_000,
            duty_limit: 1000,
            run_limit_ms: 120_000,
            stall_mv: 4000,
            stall_ms: 500,
            current_limit_ma: 0,
            link_timeout_ms: 500,
            keep_every: 5,
            pwm_hz: 0,
            divider: 0,
            amplifier: 0,
        }
    }
}

/// The supply as it is measured must lie within these shares of the stated one, per cent. An input without its divider
/// floats, and a duty worked out from what it reads could be full where 1 V is asked for.
pub const SUPPLY_SHARES: RangeInclusive<u32> = 50..=150;

/// Why a setup is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum SetupFault {
    /// The rate is outside 100 to 2000 Hz or does not divide a million.
    Rate,
    /// The stated supply is zero.
    Supply,
    /// The duty limit is outside 1 to 1000.
    DutyLimit,
    /// The run limit is zero or more than an hour.
    RunLimit,
    /// The link timeout is zero, or longer than half of what the board's log holds at this rate.
    LinkTimeout,
    /// A current limit where no current is measured.
    NoCurrentSense,
    /// `keep_every` is zero.
    KeepEvery,
    /// The PWM's frequency is outside [`PWM_LIMITS_HZ`]. Since version 3.
    Pwm,
    /// A divider that divides by less than one. Since version 4.
    Divider,
    /// A divider or an amplifier at a board without a converter. Since version 4.
    NoConverter,
}

impl Setup {
    /// The PWM's frequency that is asked for, Hz.
    pub fn pwm_hz(&self) -> u32 {
        if self.pwm_hz == 0 { PWM_HZ } else { self.pwm_hz }
    }

    /// The version of the link that brought the newest of what is asked for: an older board would not do it.
    pub const fn since(&self) -> u16 {
        if self.divider > 0 || self.amplifier > 0 { 4 } else { self.drive.since() }
    }

    /// Whether a supply measured as `supply_mv` fits the stated one.
    pub fn trusts(&self, supply_mv: u16) -> bool {
        let share = 100 * u32::from(supply_mv);
        let stated = u32::from(self.supply_mv);
        share >= SUPPLY_SHARES.start() * stated && share <= SUPPLY_SHARES.end() * stated
    }

    /// Checks the setup against a board whose log holds `log_samples` and that has a converter or not.
    ///
    /// # Errors
    /// The first field at fault.
    pub fn check(&self, log_samples: u32, converter: bool) -> Result<(), SetupFault> {
        let timeout_samples = u32::from(self.link_timeout_ms) * u32::from(self.rate_hz) / 1000;
        if !(100..=2000).contains(&self.rate_hz) || !1_000_000_u32.is_multiple_of(self.rate_hz.into()) {
            Err(SetupFault::Rate)
        } else if self.supply_mv == 0 {
            Err(SetupFault::Supply)
        } else if !(1..=1000).contains(&self.duty_limit) {
            Err(SetupFault::DutyLimit)
        } else if !(1..=3_600_000).contains(&self.run_limit_ms) {
            Err(SetupFault::RunLimit)
        } else if self.link_timeout_ms == 0 || timeout_samples > log_samples / 2 {
            Err(SetupFault::LinkTimeout)
        } else if (self.divider > 0 || self.amplifier > 0) && !converter {
            Err(SetupFault::NoConverter)
        } else if (1..100).contains(&self.divider) {
            Err(SetupFault::Divider)
        } else if self.current_limit_ma > 0 && self.amplifier == 0 {
            Err(SetupFault::NoCurrentSense)
        } else if self.keep_every == 0 {
            Err(SetupFault::KeepEvery)
        } else if !PWM_LIMITS_HZ.contains(&self.pwm_hz()) {
            Err(SetupFault::Pwm)
        } else {
            Ok(())
        }
    }
}

impl fmt::Display for SetupFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Rate => "the sampling rate must be 100 to 2000 Hz and divide a million (100, 200, 250, 400, 500, 800, 1000, 2000, ...)",
            Self::Supply => "state the supply voltage",
            Self::DutyLimit => "the duty limit must be 0.001 to 1",
            Self::RunLimit => "the run limit must be more than 0 and at most an hour",
            Self::LinkTimeout => {
                "the link timeout must be more than 0 and at most half of what the board's log holds"
            }
            Self::NoCurrentSense => "no current is measured, so it cannot be limited: state the amplifier that is wired",
            Self::KeepEvery => "the quick fit must keep one sample of 1 or more",
            Self::Pwm => "the PWM's frequency must be 5000 to 50,000 Hz",
            Self::Divider => "a divider divides by 1 or more",
            Self::NoConverter => "this board measures neither supply nor current",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_field_out_of_range_is_named() {
        let good = Setup::default();
        assert_eq!(good.check(1024, false), Ok(()));
        let bad = [
            (Setup { rate_hz: 99, ..good }, SetupFault::Rate),
            (Setup { rate_hz: 300, ..good }, SetupFault::Rate),
            (Setup { supply_mv: 0, ..good }, SetupFault::Supply),
            (Setup { duty_limit: 1001, ..good }, SetupFault::DutyLimit),
            (Setup { run_limit_ms: 0, ..good }, SetupFault::RunLimit),
            (Setup { rate_hz: 2000, ..good }, SetupFault::LinkTimeout),
            (Setup { current_limit_ma: 1, ..good }, SetupFault::NoCurrentSense),
            (Setup { keep_every: 0, ..good }, SetupFault::KeepEvery),
            (Setup { pwm_hz: 4_999, ..good }, SetupFault::Pwm),
            (Setup { pwm_hz: 50_001, ..good }, SetupFault::Pwm),
            (Setup { divider: 99, ..good }, SetupFault::Divider),
        ];
        for (setup, fault) in bad {
            assert_eq!(setup.check(1024, true), Err(fault));
        }
        let wired = Setup { divider: 1100, amplifier: 1650, current_limit_ma: 2000, ..good };
        assert_eq!(wired.check(1024, true), Ok(()));
        assert_eq!(wired.check(1024, false), Err(SetupFault::NoConverter));
    }
}
