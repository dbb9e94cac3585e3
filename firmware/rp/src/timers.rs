//! The clock and the sampling timer: both are the chip's microsecond timer.

use core::sync::atomic::{AtomicU32, Ordering};

use motorlens_firmware::hardware::Pace;

use crate::chip::{self, Clock, ClockRegisters};
use crate::pwm;

/// The sampling period, us, and the next instant.
static PERIOD_US: AtomicU32 = AtomicU32::new(1000);
static NEXT_US: AtomicU32 = AtomicU32::new(0);
/// An alarm that is set so little ahead could be in the past before it is set, us.
const AHEAD_US: u32 = 5;

/// The first alarm calls the control; the low word of the counter (it wraps after 71 minutes) is the clock.
pub struct Timers {
    clock: Clock,
}

impl Timers {
    /// Takes the timer.
    pub fn new(clock: Clock) -> Self {
        // SAFETY: lets the first alarm interrupt; nothing else uses the timer's registers.
        unsafe { (*ClockRegisters::ptr()).inte().write(|w| w.alarm_0().set_bit()) };
        Timers { clock }
    }
}

impl Pace for Timers {
    fn now_us(&mut self) -> u32 {
        self.clock.get_counter_low()
    }

    fn cycles(&mut self) -> u32 {
        chip::cycles()
    }

    fn set_rate(&mut self, rate_hz: u16) {
        // Rates are checked before they come here: 100 to 2000 Hz, a whole number of microseconds each.
        let period = 1_000_000 / u32::from(rate_hz);
        pwm::fit_to_rate(rate_hz.into());
        critical_section::with(|_| {
            PERIOD_US.store(period, Ordering::Relaxed);
            arm(self.now_us().wrapping_add(period));
        });
    }
}

/// Lets the alarm ask for the next interrupt, a period after the last: no error adds up.
pub fn acknowledge_sampling() {
    // SAFETY: clears the flag that caused the interrupt, and reads the clock.
    let now = unsafe {
        (*ClockRegisters::ptr()).intr().write(|w| w.alarm_0().clear_bit_by_one());
        (*ClockRegisters::ptr()).timerawl().read().bits()
    };
    let period = PERIOD_US.load(Ordering::Relaxed);
    let mut next = NEXT_US.load(Ordering::Relaxed).wrapping_add(period);
    // After a hold-up the instants that went by are left out; the control marks them in the log.
    while (next.wrapping_sub(now) as i32) < AHEAD_US as i32 {
        next = next.wrapping_add(period);
    }
    arm(next);
}

fn arm(next: u32) {
    NEXT_US.store(next, Ordering::Relaxed);
    // SAFETY: the first alarm is this module's alone.
    unsafe { (*ClockRegisters::ptr()).alarm0().write(|w| w.bits(next)) };
}
