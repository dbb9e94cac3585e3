//! The motorlens firmware for STM32F4 boards.
#![no_std]
#![no_main]

mod panic;

use cortex_m_rt::{entry, exception};
use defmt_rtt as _;
use stm32f4xx_hal::{pac, prelude::*, rcc::Config, watchdog::IndependentWatchdog};

#[entry]
fn main() -> ! {
    let device = pac::Peripherals::take().expect("taken once");
    let _rcc = device.RCC.freeze(Config::hse(8.MHz()).sysclk(84.MHz()));
    let mut watchdog = IndependentWatchdog::new(device.IWDG);
    watchdog.start(100.millis());
    let mut core = cortex_m::Peripherals::take().expect("taken once");
    core.SYST.set_reload(84_000 - 1);
    core.SYST.clear_current();
    core.SYST.enable_counter();
    core.SYST.enable_interrupt();
    loop {
        watchdog.feed();
        cortex_m::asm::wfi();
    }
}

/// Wakes the main loop every millisecond.
#[exception]
fn SysTick() {}
