//! The encoder's counter, the clock and the sampling timer.

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

    fn set_rate(&mut self, rate_hz: u16) {
        // Rates are checked before they come here: 100 to 2000 Hz.
        let period = 1_000_000 / u32::from(rate_hz);
        self.sampling.start(period.micros()).expect("the sampling timer has 16 bits");
    }
}

/// Lets the sampling timer ask for the next interrupt.
pub fn acknowledge_sampling() {
    // SAFETY: clears the flag that caused the interrupt; the other bits are written as ones, which leaves them.
    unsafe { (*pac::TIM4::ptr()).sr().write(|w| w.bits(!1)) };
}
