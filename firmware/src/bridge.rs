//! The driver's inputs: a PWM, two direction pins, an enable; a second PWM for drivers with two inputs.

use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;
use motorlens_shared::link::DriveMode;

/// The two PWM outputs of one timer. Their duties change together.
pub trait Pwms: SetDutyCycle {
    /// Puts the second output to so many ticks, from the next [`SetDutyCycle::set_duty_cycle`] on at the latest.
    fn set_second(&mut self, duty: u16);
}

/// A bridge driver. Sign-magnitude drivers take PWM and both directions; a locked anti-phase driver takes the PWM as its
/// phase input and the enable; a driver with two inputs takes both PWMs. Pins that a driver has not are left open.
#[derive(Debug)]
pub struct Bridge<P, F, B, E> {
    pwm: P,
    forward: F,
    backward: B,
    enable: E,
    mode: Option<DriveMode>,
}

impl<P: Pwms, F: OutputPin, B: OutputPin, E: OutputPin> Bridge<P, F, B, E> {
    /// Takes the pins and turns the bridge off.
    pub fn new(pwm: P, forward: F, backward: B, enable: E) -> Self {
        let mut bridge = Self { pwm, forward, backward, enable, mode: None };
        bridge.release();
        bridge
    }

    /// PWM ticks of full voltage; a timer with more loses its last ones.
    pub fn top(&self) -> u16 {
        self.pwm.max_duty_cycle().min(i16::MAX as u16)
    }

    /// Applies `duty` ticks, clipped to the top, and returns what the driver can really do: locked anti-phase has half
    /// the resolution.
    pub fn apply(&mut self, mode: DriveMode, duty: i16) -> i16 {
        let top = self.top() as i16;
        let duty = duty.clamp(-top, top);
        // Pins of a chip cannot fail; a port expander's could, and then the driver is not to be trusted with a motor.
        self.mode = Some(mode);
        let done = match mode {
            DriveMode::SignMagnitudeBrake | DriveMode::SignMagnitudeCoast => {
                let (forward, backward) = (duty >= 0, duty < 0);
                self.forward.set_state(forward.into()).is_ok()
                    && self.backward.set_state(backward.into()).is_ok()
                    && self.pwm.set_duty_cycle(duty.unsigned_abs()).is_ok()
            }
            DriveMode::LockedAntiPhase => {
                let high = (i32::from(top) + i32::from(duty)) / 2;
                self.pwm.set_duty_cycle(high as u16).is_ok()
            }
            DriveMode::InInBrake | DriveMode::InInCoast => {
                // One input pulses, the other stands: high, where the off part is to be a brake.
                let (on, off) = match mode {
                    DriveMode::InInBrake => (self.top(), self.top() - duty.unsigned_abs()),
                    _ => (duty.unsigned_abs(), 0),
                };
                let (first, second) = if duty >= 0 { (on, off) } else { (off, on) };
                self.pwm.set_second(second);
                self.pwm.set_duty_cycle(first).is_ok()
            }
        };
        if !(done && self.enable.set_high().is_ok()) {
            self.release();
            return 0;
        }
        match mode {
            DriveMode::LockedAntiPhase => {
                (2 * ((i32::from(top) + i32::from(duty)) / 2) - i32::from(top)) as i16
            }
            _ => duty,
        }
    }

    /// The enable low first, then everything else at rest. Each pin is tried whatever becomes of the others.
    ///
    /// To a locked anti-phase driver a low PWM is full voltage backward. Its enable holds it off, but where that wire is
    /// missing or broken, half duty is no voltage: that is where its PWM rests.
    pub fn release(&mut self) {
        let _ = self.enable.set_low();
        let rest = if self.mode == Some(DriveMode::LockedAntiPhase) { self.top() / 2 } else { 0 };
        if matches!(self.mode, Some(DriveMode::InInBrake | DriveMode::InInCoast)) {
            self.pwm.set_second(0);
        }
        let _ = self.pwm.set_duty_cycle(rest);
        let _ = self.forward.set_low();
        let _ = self.backward.set_low();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal_mock::eh1::digital::{Mock as Pin, State, Transaction as PinStep};
    use embedded_hal_mock::eh1::pwm::{Mock as Pwm, Transaction as PwmStep};
    use std::vec::Vec;

    /// The second output's duty comes before the first's, in the same list of steps.
    impl Pwms for Pwm {
        fn set_second(&mut self, duty: u16) {
            let _ = self.set_duty_cycle(duty);
        }
    }

    /// Runs `act` on a bridge whose pins expect exactly these states after the release that begins every bridge.
    fn expect(
        pwm: &[PwmStep],
        forward: &[State],
        backward: &[State],
        enable: &[State],
        act: impl FnOnce(&mut Bridge<Pwm, Pin, Pin, Pin>),
    ) {
        let pin = |steps: &[State]| {
            let all: Vec<_> = [State::Low].iter().chain(steps).map(|state| PinStep::set(*state)).collect();
            Pin::new(&all)
        };
        let pwm: Vec<_> = [PwmStep::set_duty_cycle(0)].iter().chain(pwm).cloned().collect();
        let mut bridge = Bridge::new(Pwm::new(&pwm), pin(forward), pin(backward), pin(enable));
        act(&mut bridge);
        bridge.pwm.done();
        bridge.forward.done();
        bridge.backward.done();
        bridge.enable.done();
    }

    #[test]
    fn sign_magnitude_sets_direction_and_duty() {
        let pwm = [
            PwmStep::max_duty_cycle(1000),
            PwmStep::set_duty_cycle(250),
            PwmStep::max_duty_cycle(1000),
            PwmStep::set_duty_cycle(1000),
        ];
        use State::{High, Low};
        expect(&pwm, &[High, Low], &[Low, High], &[High, High], |bridge| {
            assert_eq!(bridge.apply(DriveMode::SignMagnitudeBrake, 250), 250);
            assert_eq!(bridge.apply(DriveMode::SignMagnitudeCoast, -4000), -1000);
        });
    }

    #[test]
    fn locked_anti_phase_rests_at_half_and_reports_the_duty_it_has() {
        let pwm = [
            PwmStep::max_duty_cycle(1000),
            PwmStep::set_duty_cycle(500),
            PwmStep::max_duty_cycle(1000),
            PwmStep::set_duty_cycle(624),
        ];
        expect(&pwm, &[], &[], &[State::High, State::High], |bridge| {
            assert_eq!(bridge.apply(DriveMode::LockedAntiPhase, 0), 0);
            assert_eq!(bridge.apply(DriveMode::LockedAntiPhase, 249), 248);
        });
    }

    #[test]
    fn a_locked_anti_phase_driver_is_released_to_no_voltage_even_without_its_enable() {
        let pwm = [
            PwmStep::max_duty_cycle(1000),
            PwmStep::set_duty_cycle(750),
            PwmStep::max_duty_cycle(1000),
            PwmStep::set_duty_cycle(500),
        ];
        use State::{High, Low};
        expect(&pwm, &[Low], &[Low], &[High, Low], |bridge| {
            assert_eq!(bridge.apply(DriveMode::LockedAntiPhase, 500), 500);
            bridge.release();
        });
    }

    #[test]
    fn a_driver_with_two_inputs_pulses_one_and_holds_the_other() {
        let (top, set) = (PwmStep::max_duty_cycle(1000), PwmStep::set_duty_cycle);
        // Second, first: brake forward, brake at rest, coast backward, released.
        let mut pwm = std::vec![top.clone(), top.clone(), top.clone(), set(750), set(1000)];
        pwm.extend([top.clone(), top.clone(), top.clone(), set(1000), set(1000)]);
        pwm.extend([top, set(250), set(0)]);
        pwm.extend([set(0), set(0)]);
        use State::{High, Low};
        expect(&pwm, &[Low], &[Low], &[High, High, High, Low], |bridge| {
            assert_eq!(bridge.apply(DriveMode::InInBrake, 250), 250);
            assert_eq!(bridge.apply(DriveMode::InInBrake, 0), 0);
            assert_eq!(bridge.apply(DriveMode::InInCoast, -250), -250);
            bridge.release();
        });
    }

    #[test]
    fn a_pin_that_fails_takes_the_bridge_off() {
        use std::io::ErrorKind;
        let failing =
            PinStep::set(State::High).with_error(embedded_hal_mock::eh1::MockError::Io(ErrorKind::Other));
        let pin = |steps: &[PinStep]| Pin::new(steps);
        let low = PinStep::set(State::Low);
        let pwm = [PwmStep::set_duty_cycle(0), PwmStep::max_duty_cycle(1000), PwmStep::set_duty_cycle(0)];
        let mut bridge = Bridge::new(
            Pwm::new(&pwm),
            pin(&[low.clone(), failing, low.clone()]),
            pin(&[low.clone(), low.clone()]),
            pin(&[low.clone(), low]),
        );
        assert_eq!(bridge.apply(DriveMode::SignMagnitudeBrake, 100), 0);
        bridge.pwm.done();
        bridge.forward.done();
        bridge.backward.done();
        bridge.enable.done();
    }
}
