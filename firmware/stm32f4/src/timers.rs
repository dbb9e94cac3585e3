//! The encoder's counter, the clock and the sampling timer.

use core::sync::atomic::{AtomicU32, Ordering};

use motorlens_firmware::beat;
use motorlens_firmware::hardware::{Encoder, Pace};
use stm32f4xx_hal::hal_02::Qei as _;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::qei::Qei;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::timer::{CounterUs, Event};

/// TIM3 in encoder mode: 16 bits, every edge counted.
pub struct Counter(Qei<pac::TIM3>);

impl Counter {
    /// Takes the timer, which counts already.
    pub fn new(encoder: Qei<pac::TIM3>) -> Self {
        // SAFETY: TIM3 and the two pins are the encoder's alone; nothing else changes these fields.
        unsafe {
            // A level counts after 8 looks at 10.5 MHz, 0.76 us (RM0090 18.4.7, ICxF = 1001): shorter is what the bridge
            // induces beside the encoder's wires. A million counts a second have 2 us between a channel's edges.
            (*pac::TIM3::ptr()).ccmr1_input().modify(|_, w| w.ic1f().bits(0b1001).ic2f().bits(0b1001));
            // An encoder with open collectors pulls down only.
            let pulls = (*pac::GPIOA::ptr()).pupdr();
            pulls.modify(|_, w| w.pupdr6().pull_up().pupdr7().pull_up());
        }
        Counter(encoder)
    }
}

impl Encoder for Counter {
    fn count(&mut self) -> u16 {
        self.0.count()
    }
}

/// TIM4 calls the control, TIM5 counts microseconds (32 bits: it wraps after 71 minutes).
pub struct Timers {
    sampling: CounterUs<pac::TIM4>,
    clock: CounterUs<pac::TIM5>,
}

impl Timers {
    /// Starts the clock.
    pub fn new(sampling: pac::TIM4, clock: pac::TIM5, rcc: &mut Rcc) -> Self {
        let mut clock = clock.counter_us(rcc);
        clock.start(u32::MAX.micros()).expect("the clock's timer has 32 bits");
        // The HAL takes one off, and the clock would be a microsecond fast after each wrap (RM0090 18.4.12).
        // SAFETY: TIM5 is the clock's alone; no value of the reload is unsound.
        unsafe { (*pac::TIM5::ptr()).arr().write(|w| w.bits(u32::MAX)) };
        let mut sampling = sampling.counter_us(rcc);
        sampling.listen(Event::Update);
        Timers { sampling, clock }
    }
}

impl Pace for Timers {
    fn now_us(&mut self) -> u32 {
        self.clock.now().ticks()
    }

    fn cycles(&mut self) -> u32 {
        cortex_m::peripheral::DWT::cycle_count()
    }

    fn set_rate(&mut self, rate_hz: u16, pwm_hz: u32) {
        // Rates are checked before they come here: 100 to 2000 Hz, and 5 to 50 kHz.
        let (beats, apart) = beat::split(1_000_000 / u32::from(rate_hz));
        let ticks = apart * (crate::CORE_HZ / 1_000_000);
        let period = crate::pwm::fit_period(ticks, crate::CORE_HZ / pwm_hz.max(1));
        crate::adc::fit_round(period, beats * ticks);
        BEATS.store(beats, Ordering::Relaxed);
        LEFT.store(0, Ordering::Relaxed);
        // A millisecond at most: 16 bits hold it.
        let _ = self.sampling.start(apart.micros());
    }
}

/// Interrupts per sampling period, and how many are left until the next sampling instant.
static BEATS: AtomicU32 = AtomicU32::new(1);
static LEFT: AtomicU32 = AtomicU32::new(0);

/// Lets the sampling timer ask for the next interrupt; whether this one is a sampling instant.
pub fn acknowledge_sampling() -> bool {
    // SAFETY: clears the flag that caused the interrupt; the other bits are written as ones, which leaves them.
    unsafe { (*pac::TIM4::ptr()).sr().write(|w| w.bits(!1)) };
    let left = LEFT.load(Ordering::Relaxed);
    LEFT.store(if left == 0 { BEATS.load(Ordering::Relaxed) - 1 } else { left - 1 }, Ordering::Relaxed);
    left == 0
}
