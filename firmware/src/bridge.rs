//! The driver's inputs: one PWM, two direction pins, an enable.

use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;
use motorlens_shared::link::DriveMode;

/// A bridge driver. Sign-magnitude drivers take PWM and both directions; a locked anti-phase driver takes the PWM as its
/// phase input and the enable. Pins that a driver has not are left open.
#[derive(Debug)]
pub struct Bridge<P, F, B, E> {
    pwm: P,
    forward: F,
    backward: B,
    enable: E,
}

impl<P: SetDutyCycle, F: OutputPin, B: OutputPin, E: OutputPin> Bridge<P, F, B, E> {
    /// Takes the pins and turns the bridge off.
    pub fn new(pwm: P, forward: F, backward: B, enable: E) -> Self {
        let mut bridge = Self { pwm, forward, backward, enable };
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

    /// Everything low. Each pin is tried whatever becomes of the others.
    pub fn release(&mut self) {
        let _ = self.enable.set_low();
        let _ = self.pwm.set_duty_cycle(0);
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
