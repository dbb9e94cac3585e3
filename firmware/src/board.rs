//! Hardware made of embedded-hal parts.

use crate::bridge::{Bridge, Pwms};
use crate::hardware::{Analog, Encoder, Hardware, Pace};
use embedded_hal::digital::{InputPin, OutputPin};
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
    fn set_rate(&mut self, rate_hz: u16, pwm_hz: u32) {
        self.pace.set_rate(rate_hz, pwm_hz);
    }
}

impl<P, F, B, N, E, A, S, T> Hardware for Parts<P, F, B, N, E, A, S, T>
where
    P: Pwms,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Control;
    use crate::hardware::NoAnalog;
    use crate::log::Log;
    use embedded_hal_mock::eh1::digital::{
        Mock as Pin, State, State::High, State::Low, Transaction as PinStep,
    };
    use embedded_hal_mock::eh1::pwm::{Mock as Pwm, Transaction as PwmStep};
    use motorlens_shared::excitation::{Player, Programme, Shape};
    use motorlens_shared::link::{Cause, Reset, RunState};
    use std::boxed::Box;
    use std::vec::Vec;

    /// A counter that goes on by itself.
    struct Turning(u16);

    impl Encoder for Turning {
        fn count(&mut self) -> u16 {
            self.0 += 1;
            self.0
        }
    }

    /// A clock that a test sets.
    struct Clock(u32);

    impl Pace for Clock {
        fn now_us(&mut self) -> u32 {
            self.0
        }
        fn cycles(&mut self) -> u32 {
            0
        }
        fn set_rate(&mut self, _: u16, _: u32) {}
    }

    #[test]
    fn the_emergency_contact_takes_every_pin_of_the_bridge_down() {
        let set = |states: &[State]| Pin::new(&states.iter().map(|at| PinStep::set(*at)).collect::<Vec<_>>());
        // The bridge is released when it is made, when the control takes it, and when the contact opens.
        let mut enable = set(&[Low, Low, High, Low]);
        let mut forward = set(&[Low, Low, High, Low]);
        let mut backward = set(&[Low, Low, Low, Low]);
        let mut emergency = Pin::new(&[PinStep::get(Low), PinStep::get(High)]);
        // Half of 12 V stated.
        let (top, off) = (PwmStep::max_duty_cycle(1000), PwmStep::set_duty_cycle(0));
        let mut pwm = Pwm::new(&[
            off.clone(),
            off.clone(),
            top.clone(), // for what the log's numbers mean
            top.clone(), // the first sample: the voltage so far, the first duty, its bounds, the second duty
            top.clone(),
            top.clone(),
            PwmStep::set_duty_cycle(500),
            top,
            off, // the contact, before anything else
        ]);
        let parts = Parts {
            bridge: Bridge::new(pwm.clone(), forward.clone(), backward.clone(), enable.clone()),
            encoder: Turning(0),
            analog: NoAnalog,
            emergency: emergency.clone(),
            pace: Clock(0),
        };
        let mut control = Control::new(parts, Box::leak(Box::new(Log::new())), Reset::PowerOn);
        let step = Programme::single("step", Shape::Step { level_v: 6.0 }, 1.0);
        control.start(1, Player::new(&step, 1000).unwrap());
        // Long enough to see that the motor stands.
        control.hardware_mut().pace.0 = 200_000;
        control.tick();
        assert_eq!(control.status().state, RunState::Running);
        control.hardware_mut().pace.0 += 1000;
        control.tick();
        assert_eq!(control.status().state, RunState::Stopped(Cause::Emergency));
        assert_eq!(control.status().next, 1, "the log so far is kept");
        pwm.done();
        for pin in [&mut enable, &mut forward, &mut backward, &mut emergency] {
            pin.done();
        }
    }
}
