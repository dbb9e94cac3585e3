//! The PWM that takes a new duty at once.

use core::convert::Infallible;

use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use motorlens_firmware::bridge::Pwms;
use motorlens_shared::link::PWM_HZ;

use crate::chip::CORE_HZ;
use crate::hal::gpio::bank0::{Gpio6, Gpio7};
use crate::hal::gpio::{FunctionPwm, Pin, PullNone};
use crate::hal::pac;
use crate::hal::pwm::{FreeRunning, Pwm3, Slice};

/// GP6 is channel A of this slice, GP7 channel B.
const SLICE: usize = 3;

/// The slice's first channel, and for drivers with two inputs its second.
///
/// The slice takes a duty over at the end of its period, the direction pins change at once. So that the two agree and
/// the voltage changes at the sampling instant, each new duty begins a new period. So that the restart cuts no period
/// short, which would raise the mean, a whole number of periods makes a sample ([`fit_to_rate`]).
pub struct Pwm {
    _slice: Slice<Pwm3, FreeRunning>,
}

impl Pwm {
    /// Takes the pins and starts the slice at duty 0.
    pub fn new(
        mut slice: Slice<Pwm3, FreeRunning>,
        first: Pin<Gpio6, FunctionPwm, PullNone>,
        second: Pin<Gpio7, FunctionPwm, PullNone>,
    ) -> Self {
        slice.default_config();
        slice.set_top((CORE_HZ / PWM_HZ - 1) as u16);
        let _ = slice.channel_a.set_duty_cycle(0);
        let _ = slice.channel_b.set_duty_cycle(0);
        slice.channel_a.output_to(first);
        slice.channel_b.output_to(second);
        slice.enable();
        Pwm { _slice: slice }
    }
}

/// Makes the PWM's period a whole part of the sampling period, and returns its ticks; the nearest to `wanted_hz`, of at least 5 kHz, at
/// `rate_hz`, of at most 2.
pub fn fit_to_rate(rate_hz: u32, wanted_hz: u32) -> u32 {
    let periods = (wanted_hz + rate_hz / 2) / rate_hz;
    let ticks = CORE_HZ / (rate_hz * periods);
    // SAFETY: one register of the slice that belongs to `Pwm`; whatever it holds is a period.
    unsafe { (*pac::PWM::ptr()).ch(SLICE).top().write(|w| w.top().bits((ticks - 1) as u16)) };
    ticks
}

impl ErrorType for Pwm {
    type Error = Infallible;
}

impl SetDutyCycle for Pwm {
    fn max_duty_cycle(&self) -> u16 {
        // SAFETY: a read of this slice's register.
        unsafe { (*pac::PWM::ptr()).ch(SLICE).top().read().top().bits() + 1 }
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        // SAFETY: this slice's registers. The compare value is taken over where the counter wraps, so it is put there.
        unsafe {
            let slice = (*pac::PWM::ptr()).ch(SLICE);
            slice.cc().modify(|_, w| w.a().bits(duty));
            slice.ctr().write(|w| w.ctr().bits(slice.top().read().top().bits()));
        }
        Ok(())
    }
}

impl Pwms for Pwm {
    fn set_second(&mut self, duty: u16) {
        // SAFETY: this slice's register.
        unsafe { (*pac::PWM::ptr()).ch(SLICE).cc().modify(|_, w| w.b().bits(duty)) };
    }
}
