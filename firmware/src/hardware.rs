//! What the control loop needs of a board.

use crate::analog::{Means, Wiring};
use motorlens_shared::link::DriveMode;

/// A position counter. embedded-hal has no trait for one.
pub trait Encoder {
    /// The counter as it stands, wrapping.
    fn count(&mut self) -> u16;
}

/// Analogue measurements, where a board has a converter.
pub trait Analog {
    /// Whether there is one.
    const CONVERTER: bool;
    /// Says what is wired to it; nothing is, until it is said.
    fn wire(&mut self, wiring: Wiring);
    /// Adds up what was converted since the last time, and returns the means of that alone, of what is wired, where enough was converted
    /// for one. Called at least every millisecond.
    fn gather(&mut self) -> Means;
    /// The means of what was gathered since the last time that they were asked for.
    fn means(&mut self) -> Means;
}

/// A board without a converter.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoAnalog;

impl Analog for NoAnalog {
    const CONVERTER: bool = false;
    fn wire(&mut self, _: Wiring) {}
    fn gather(&mut self) -> Means {
        Means::default()
    }
    fn means(&mut self) -> Means {
        Means::default()
    }
}

/// Time and pace: a microsecond clock that wraps, and the timer that calls the control.
pub trait Pace {
    /// Microseconds since the start, wrapping.
    fn now_us(&mut self) -> u32;
    /// The core's cycle counter, wrapping; 0 where there is none.
    fn cycles(&mut self) -> u32;
    /// Calls the control so many times a second from now on, and puts the PWM near `pwm_hz`: a sampling period holds a whole
    /// number of its periods. Both are checked before they come here.
    fn set_rate(&mut self, rate_hz: u16, pwm_hz: u32);
}

/// Everything the control loop touches.
pub trait Hardware: Pace {
    /// What is measured beside the position.
    type Analog: Analog;
    /// The encoder's counter, wrapping.
    fn count(&mut self) -> u16;
    /// Puts the bridge to `duty` (of [`Self::pwm_top`], sign included) and returns the duty that it really has.
    fn apply(&mut self, mode: DriveMode, duty: i16) -> i16;
    /// Takes the bridge off, whatever state it is in.
    fn release(&mut self);
    /// PWM ticks of full voltage, at most 32767.
    fn pwm_top(&self) -> u16;
    /// The analogue measurements.
    fn analog(&mut self) -> &mut Self::Analog;
    /// Whether the emergency input is open.
    fn emergency(&mut self) -> bool;
}
