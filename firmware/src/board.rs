//! Hardware made of embedded-hal parts.

use crate::bridge::Bridge;
use crate::hardware::{Analog, Encoder, Hardware, Pace};
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::pwm::SetDutyCycle;
use motorlens_shared::link::DriveMode;

/// The parts of a board: a bridge, an encoder, analogue inputs, the emergency input, clock and sampling timer.
#[derive(Debug)]
pub struct Parts<P, F, B, N, E, A, S, T> {
    /// The driver's inputs.
    pub bridge: Bridge<P, F, B, N>,
    /// The position counter.
    pub encoder: E,
    /// Supply and current, where fitted.
    pub analog: A,
    /// A contact to ground that opens in an emergency, with a pull-up: a broken wire stops the motor too.
    pub emergency: S,
    /// Clock and sampling timer.
    pub pace: T,
}

impl<P, F, B, N, E, A, S, T: Pace> Pace for Parts<P, F, B, N, E, A, S, T> {
    fn now_us(&mut self) -> u32 {
        self.pace.now_us()
    }
    fn cycles(&mut self) -> u32 {
        self.pace.cycles()
    }
    fn set_rate(&mut self, rate_hz: u16) {
        self.pace.set_rate(rate_hz);
    }
}

impl<P, F, B, N, E, A, S, T> Hardware for Parts<P, F, B, N, E, A, S, T>
where
    P: SetDutyCycle,
    F: OutputPin,
    B: OutputPin,
    N: OutputPin,
    E: Encoder,
    A: Analog,
    S: InputPin,
    T: Pace,
{
    type Analog = A;

    fn count(&mut self) -> u16 {
        self.encoder.count()
    }
    fn apply(&mut self, mode: DriveMode, duty: i16) -> i16 {
        self.bridge.apply(mode, duty)
    }
    fn release(&mut self) {
        self.bridge.release();
    }
    fn pwm_top(&self) -> u16 {
        self.bridge.top()
    }
    fn analog(&mut self) -> &mut A {
        &mut self.analog
    }
    fn emergency(&mut self) -> bool {
        // An input that cannot be read is as good as open.
        self.emergency.is_high().unwrap_or(true)
    }
}
