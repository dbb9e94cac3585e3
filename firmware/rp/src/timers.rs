//! The clock and the sampling timer: both are the chip's microsecond timer.

use core::sync::atomic::{AtomicU32, Ordering};

use motorlens_firmware::beat;
use motorlens_firmware::hardware::Pace;

use crate::chip::{self, Clock, ClockRegisters};
use crate::{adc, guard, pwm};

/// The time between two interrupts, us, and the next one.
static APART_US: AtomicU32 = AtomicU32::new(1000);
static NEXT_US: AtomicU32 = AtomicU32::new(0);
/// Interrupts per sampling period, and how many are left until the next sampling instant.
static BEATS: AtomicU32 = AtomicU32::new(1);
static LEFT: AtomicU32 = AtomicU32::new(0);
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
        unsafe { (*ClockRegisters::ptr()).inte().modify(|_, w| w.alarm_0().set_bit()) };
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

    fn set_rate(&mut self, rate_hz: u16, pwm_hz: u32) {
        // Rates are checked before they come here: 100 to 2000 Hz, a whole number of microseconds each.
        let (beats, apart) = beat::split(1_000_000 / u32::from(rate_hz));
        let period = pwm::fit_to_rate(1_000_000 / apart.max(1), pwm_hz);
        adc::fit_round(period, beats * apart * (chip::CORE_HZ / 1_000_000));
        critical_section::with(|_| {
            BEATS.store(beats, Ordering::Relaxed);
            LEFT.store(0, Ordering::Relaxed);
            APART_US.store(apart, Ordering::Relaxed);
            arm(self.now_us().wrapping_add(apart));
        });
    }
}

/// Lets the alarm ask for the next interrupt, so long after the last that no error adds up; whether this one is a sampling
/// instant.
pub fn acknowledge_sampling() -> bool {
    // SAFETY: clears the flag that caused the interrupt, and reads the clock.
    let now = unsafe {
        (*ClockRegisters::ptr()).intr().write(|w| w.alarm_0().clear_bit_by_one());
        (*ClockRegisters::ptr()).timerawl().read().bits()
    };
    let apart = APART_US.load(Ordering::Relaxed);
    let (beats, mut left) = (BEATS.load(Ordering::Relaxed), LEFT.load(Ordering::Relaxed));
    let due = left == 0;
    let mut next = next_us();
    // After a hold-up the instants that went by are left out; the control marks them in the log.
    loop {
        left = if left == 0 { beats - 1 } else { left - 1 };
        next = next.wrapping_add(apart);
        if next.wrapping_sub(now) as i32 >= AHEAD_US as i32 {
            break;
        }
    }
    LEFT.store(left, Ordering::Relaxed);
    arm(next);
    due
}

/// When the sampling timer interrupts next.
pub fn next_us() -> u32 {
    NEXT_US.load(Ordering::Relaxed)
}

fn arm(next: u32) {
    NEXT_US.store(next, Ordering::Relaxed);
    guard::renew(next);
    // SAFETY: the first alarm is this module's alone.
    unsafe { (*ClockRegisters::ptr()).alarm0().write(|w| w.bits(next)) };
}
