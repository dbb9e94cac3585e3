//! What takes the bridge off where the crystal stops.
//!
//! Sampling timer, second alarm and watchdog count ticks of clk_ref, which is the crystal (RP2040 data sheet 4.7.2, RP2350 8.5): without it
//! none of them goes off. Core and PWM hang on the PLL, which has lost its reference then. As long as its oscillator swings by itself they run
//! on, at a frequency that nobody states, and the PWM holds its last duty. So the core's own timer, SysTick, looks whether the microseconds
//! still go on.
//!
//! What has happened can be told only where the crystal swings again. Without it the board comes back by its power or by its RUN pin alone, and
//! both clear the watchdog's scratch registers (RP2040 data sheet 4.7.4), as a power cycle clears the memory: a start by power is all it knows.
//!
//! Where the core stands too, nothing does. The chip's resuscitation (CLK_SYS_RESUS, RP2040 data sheet 2.15.5) would give the core
//! clk_ref, which is what has stopped: from the ring oscillator no microsecond could be made that is fit to sample by.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::exception;
use motorlens_shared::link::Reset;

use crate::chip::{CORE_HZ, ClockRegisters};
use crate::panic::stop_for_good;

/// Looks in a second.
const LOOKS_HZ: u32 = 2000;
/// So many looks in a row that see the same microsecond: one alone may come right after one that was held up.
const STANDS: u32 = 2;

static SEEN_US: AtomicU32 = AtomicU32::new(0);
static STOOD: AtomicU32 = AtomicU32::new(0);

/// Begins to look, with the timer running.
pub fn watch(timer: &mut SYST) {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(CORE_HZ / LOOKS_HZ - 1);
    timer.clear_current();
    timer.enable_counter();
    timer.enable_interrupt();
}

#[exception]
fn SysTick() {
    // SAFETY: a read of the clock.
    let now = unsafe { (*ClockRegisters::ptr()).timerawl().read().bits() };
    let stood = if SEEN_US.load(Ordering::Relaxed) == now { STOOD.load(Ordering::Relaxed) + 1 } else { 0 };
    SEEN_US.store(now, Ordering::Relaxed);
    STOOD.store(stood, Ordering::Relaxed);
    if stood >= STANDS {
        // The watchdog stands as well: the pins are held low until the crystal swings again, when it goes on counting and restarts the
        // board, which tells what is noted here, or until the board gets its power anew.
        stop_for_good(Reset::Clock);
    }
}
