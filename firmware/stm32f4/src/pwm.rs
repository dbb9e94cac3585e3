//! The PWM that takes a new duty at once.

use core::convert::Infallible;

use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::timer::PwmChannel;

/// TIM1's first channel.
///
/// The timer takes a duty over at the end of its period, the direction pins change at once. So that the two agree and
/// the voltage changes at the sampling instant, each new duty begins a new period.
pub struct Pwm(PwmChannel<pac::TIM1, 0>);

impl Pwm {
    /// Takes the channel and starts it at duty 0.
    pub fn new(mut channel: PwmChannel<pac::TIM1, 0>) -> Self {
        channel.set_duty(0);
        channel.enable();
        Pwm(channel)
    }
}

impl ErrorType for Pwm {
    type Error = Infallible;
}

impl SetDutyCycle for Pwm {
    fn max_duty_cycle(&self) -> u16 {
        self.0.get_max_duty()
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.0.set_duty(duty);
        // SAFETY: a write of one bit that only begins a new period; TIM1 is this program's alone.
        unsafe { (*pac::TIM1::ptr()).egr().write(|w| w.ug().set_bit()) };
        Ok(())
    }
}
