//! The PWM that takes a new duty at once, the driver's enable, and the hardware that takes both away.

use core::convert::Infallible;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use embedded_hal::digital::{ErrorType as PinErrorType, InputPin, OutputPin};
use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use motorlens_firmware::bridge::Pwms;
use stm32f4xx_hal::gpio::{Alternate, Input, PB12, PB15};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::timer::PwmChannel;

use crate::deadman;

/// The outputs were enabled by this program, and if they are not now, the hardware took them away.
static ARMED: AtomicBool = AtomicBool::new(false);

/// TIM1's first channel, and for drivers with two inputs its second.
///
/// The timer takes a duty over at the end of its period, the direction pins change at once. So that the two agree and
/// the voltage changes at the sampling instant, each new duty begins a new period; a sampling period holds a whole number
/// of them ([`fit_period`]), so that none is cut short by the next.
pub struct Pwm {
    first: PwmChannel<pac::TIM1, 0>,
    second: PwmChannel<pac::TIM1, 1>,
}

impl Pwm {
    /// Takes the channels and starts them at duty 0, with the emergency contact as the timer's break input.
    ///
    /// The HAL sets AOE, with which a break ends by itself at the next period: it is cleared, so that outputs that were
    /// taken away stay away (RM0090 17.4.18). A high level at the break input, which is an open contact, takes them away
    /// without any program; then they rest low (OSSI) as they do at duty 0 (OSSR).
    pub fn new(
        mut first: PwmChannel<pac::TIM1, 0>,
        mut second: PwmChannel<pac::TIM1, 1>,
        _: &Emergency,
    ) -> Self {
        first.set_duty(0);
        first.enable();
        second.set_duty(0);
        second.enable();
        let pwm = Pwm { first, second };
        // SAFETY: TIM1 is this program's alone, and nothing else writes its break register before the interrupts run.
        unsafe {
            (*pac::TIM1::ptr()).bdtr().modify(|_, w| {
                w.aoe().clear_bit().moe().clear_bit();
                w.ossi().set_bit().ossr().set_bit().bke().set_bit().bkp().set_bit()
            });
        }
        pwm
    }
}

impl ErrorType for Pwm {
    type Error = Infallible;
}

impl SetDutyCycle for Pwm {
    fn max_duty_cycle(&self) -> u16 {
        self.first.get_max_duty()
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.first.set_duty(duty);
        LATENESS.store(cycles().wrapping_sub(ENTRY.load(Ordering::Relaxed)).min(LATEST), Ordering::Relaxed);
        renew();
        Ok(())
    }
}

impl Pwms for Pwm {
    fn set_second(&mut self, duty: u16) {
        self.second.set_duty(duty);
    }
}

/// When the sampling timer's last interrupt began, and how much later the last new duty was there, cycles.
static ENTRY: AtomicU32 = AtomicU32::new(0);
static LATENESS: AtomicU32 = AtomicU32::new(0);
/// The sampling interrupt is not that long.
const LATEST: u32 = 50 * (crate::CORE_HZ / 1_000_000);

fn cycles() -> u32 {
    cortex_m::peripheral::DWT::cycle_count()
}

/// The sampling timer's interrupt begins.
pub fn interrupt_begins() {
    ENTRY.store(cycles(), Ordering::Relaxed);
}

/// [`renew`], in an interrupt between two sampling instants, so late in it as the new duty was in its own: then a whole number of
/// periods lies between, and none that is cut short raises the mean of the voltage.
pub fn renew_in_step() {
    let (entry, lateness) = (ENTRY.load(Ordering::Relaxed), LATENESS.load(Ordering::Relaxed));
    while cycles().wrapping_sub(entry) < lateness {}
    renew();
}

/// Begins a new period of the PWM, and with it the dead man's time anew.
fn renew() {
    // SAFETY: TIM1 is this program's alone; UG only begins a new period.
    unsafe { (*pac::TIM1::ptr()).egr().write(|w| w.ug().set_bit()) };
}

/// The driver's enable: TIM1's third channel, complementary output, held at a level by the timer (OC3M, RM0090 17.4.8).
/// What takes the timer's outputs away takes the enable with the PWM, and no program is needed for it: the emergency
/// contact, a crystal that stops (17.3.12), and a program that sets no new duty ([`deadman`]).
pub struct Enable {
    _pin: PB15<Alternate<1>>,
}

impl Enable {
    /// Takes the pin, low.
    pub fn new(pin: PB15<Input>) -> Self {
        level(false);
        // SAFETY: as above; the channel's output alone, active high.
        unsafe { (*pac::TIM1::ptr()).ccer().modify(|_, w| w.cc3ne().set_bit().cc3np().clear_bit()) };
        Enable { _pin: pin.into_alternate() }
    }
}

/// Holds the third channel's output high or low, as far as the outputs are enabled.
fn level(high: bool) {
    let force = if high { 0b101 } else { 0b100 };
    // SAFETY: as above; the third channel is the enable's alone.
    unsafe { (*pac::TIM1::ptr()).ccmr2_output().modify(|_, w| w.oc3m().bits(force)) };
}

impl PinErrorType for Enable {
    type Error = Infallible;
}

impl OutputPin for Enable {
    fn set_high(&mut self) -> Result<(), Infallible> {
        if !ARMED.swap(true, Ordering::Relaxed) {
            level(true);
            deadman::arm();
            // SAFETY: TIM1 is this program's alone, and enabling the outputs has no effect while the break input is active.
            // Flags are cleared by writing 0, the others are left by writing 1.
            unsafe {
                let timer = &*pac::TIM1::ptr();
                timer.sr().write(|w| w.bits(!(1 << 7)));
                timer.bdtr().modify(|_, w| w.moe().set_bit());
            }
        }
        Ok(())
    }

    fn set_low(&mut self) -> Result<(), Infallible> {
        ARMED.store(false, Ordering::Relaxed);
        // SAFETY: TIM1 is this program's alone.
        unsafe { (*pac::TIM1::ptr()).bdtr().modify(|_, w| w.moe().clear_bit()) };
        level(false);
        deadman::disarm();
        Ok(())
    }
}

/// The emergency contact: a level that the program reads, and at the same pin the PWM timer's break input, which needs no
/// program. A contact that opened and closed between two looks is seen by what it did to the timer.
pub struct Emergency {
    _pin: PB12<Alternate<1>>,
}

impl Emergency {
    /// Takes the pin, as TIM1_BKIN with a pull-up: a broken wire is an open contact.
    pub fn new(pin: PB12<Input>) -> Self {
        Emergency { _pin: pin.into_alternate().internal_pull_up(true) }
    }
}

impl PinErrorType for Emergency {
    type Error = Infallible;
}

impl InputPin for Emergency {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        // SAFETY: reads of two registers; the input's level can be read in every mode of the pin.
        unsafe {
            let open = (*pac::GPIOB::ptr()).idr().read().bits() & (1 << 12) != 0;
            let taken =
                ARMED.load(Ordering::Relaxed) && (*pac::TIM1::ptr()).bdtr().read().moe().bit_is_clear();
            Ok(open || taken)
        }
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}

/// Sets TIM1 so that the `ticks` of the core's clock between two interrupts of the sampling timer are a whole number of PWM periods, of about
/// `wanted` ticks each: then the mean of the voltage over them is the duty, whatever the rate. Returns the ticks of a period.
pub fn fit_period(ticks: u32, wanted: u32) -> u32 {
    let period = whole_share(ticks, wanted);
    // SAFETY: TIM1 is this program's alone, and nothing runs while the rate is changed.
    unsafe {
        let timer = &*pac::TIM1::ptr();
        timer.arr().write(|w| w.bits(period - 1));
        timer.rcr().write(|w| w.bits(deadman::repetitions(ticks, period)));
        timer.egr().write(|w| w.ug().set_bit());
    }
    period
}

/// The divisor of `ticks` that lies nearest to `wanted`. The search is short: a sampling period has many divisors.
fn whole_share(ticks: u32, wanted: u32) -> u32 {
    let divides = |share: &u32| *share > 0 && *share <= u16::MAX.into() && ticks.is_multiple_of(*share);
    (0..wanted).flat_map(|apart| [wanted - apart, wanted + apart]).find(divides).unwrap_or(wanted)
}
