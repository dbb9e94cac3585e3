//! The driver: what it makes of the chip's pins, and what the motor gets of it.

use motorlens_shared::link::DriveMode;
use motorlens_virtual_motor::Bridge;
use rigless::device::{Level, RegisterFile};
use rigless::soc::st::tim::Channel;
use rigless::soc::stm32f427::generated::gpioa::Register as PortRegister;
use rigless::soc::stm32f427::generated::tim1::Register;
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::time::VirtualNanos;

use super::{PORT_B, Plant};
use crate::encoder::Mistake;
use crate::machine::Machine;

/// GPIOA among the ports.
const PORT_A: usize = 0;
/// The outputs of an advanced timer are enabled.
const MOE: u64 = 1 << 15;
/// The PWM at port A, and the second one.
const PWM: u8 = 8;
const SECOND_PWM: u8 = 9;
/// Pins of port B.
const FORWARD: u8 = 0;
const BACKWARD: u8 = 1;
const ENABLE: u8 = 15;
/// One period of the PWM, s.
const PWM_PERIOD_S: f64 = 50e-6;

/// Whether a port's pin is given to a peripheral.
fn alternate(registers: &RegisterFile, pin: u8) -> bool {
    registers.get(PortRegister::Moder) >> (2 * pin) & 3 == 2
}

/// Whether a pin that is no peripheral's is high: the program drives it so, or pulls it up. Where nothing does, the driver's own pull-down
/// holds it low.
fn stands_high(registers: &RegisterFile, pin: u8) -> bool {
    match registers.get(PortRegister::Moder) >> (2 * pin) & 3 {
        0 => registers.get(PortRegister::Pupdr) >> (2 * pin) & 3 == 1,
        1 => registers.get(PortRegister::Odr) >> pin & 1 == 1,
        _ => false,
    }
}

impl Plant {
    /// What the bridge does now, and until when at most, `end` at the latest.
    pub(super) fn bridge(&self, end: VirtualNanos) -> (Bridge, VirtualNanos) {
        if !self.enabled || self.mistake == Some(Mistake::DeadDriver) {
            return (Bridge::Floating, end);
        }
        let nominal = self.motor.motor().nominal_v;
        match self.driver {
            DriveMode::SignMagnitudeBrake => (Bridge::Volts(self.sign * self.duty * nominal), end),
            DriveMode::LockedAntiPhase => (Bridge::Volts((2.0 * self.duty - 1.0) * nominal), end),
            DriveMode::InInBrake => (Bridge::Volts((self.duty - self.second) * nominal), end),
            DriveMode::SignMagnitudeCoast | DriveMode::InInCoast => {
                let (sign, duty) = match self.driver {
                    DriveMode::InInCoast => ((self.duty - self.second).signum(), self.duty.max(self.second)),
                    _ => (self.sign, self.duty),
                };
                // The off part matters: go from switch to switch.
                let period = (PWM_PERIOD_S * 1e9) as u64;
                let on = (duty * PWM_PERIOD_S * 1e9).round() as u64;
                let since = (self.now.0 - self.period_began.0) % period;
                let (bridge, rest) = if since < on {
                    (Bridge::Volts(sign * nominal), on - since)
                } else {
                    (Bridge::Floating, period - since)
                };
                (bridge, VirtualNanos(end.0.min(self.now.0 + rest)))
            }
        }
    }

    /// Looks at the driver's inputs after the program or the chip may have changed them. Whether the timer has taken its compare
    /// registers over, as it does where a period begins (RM0090 17.3.9), is said by `renewed`; until then the pin has the old duty.
    pub fn look(&mut self, machine: &mut Machine, renewed: bool) {
        let (port, registers) = machine.mcu.port(PORT_B);
        let high = |pin: u8| port.level(Pin::new(pin).expect("a port has 16"), registers) == Level::High;
        let forward = high(FORWARD) && self.mistake != Some(Mistake::NoForward);
        self.sign = f64::from(forward) - f64::from(high(BACKWARD));
        let enable = (high(ENABLE), alternate(registers, ENABLE));
        let (_, registers) = machine.mcu.port(PORT_A);
        let pulsed = [PWM, SECOND_PWM].map(|pin| alternate(registers, pin));
        let held = [stands_high(registers, PWM), stands_high(registers, SECOND_PWM)];
        // A pin that is the timer's follows the timer's output, which is there while the timer is clocked.
        let (timer, registers) = machine.mcu.advanced_timer(0);
        let third = Channel::new(3).expect("the timer has four");
        self.enabled = match enable {
            (_, true) => timer.complementary_output(third, registers) == Some(Level::High),
            (high, false) => high,
        };
        if self.enabled && self.first_driven.is_none() {
            self.first_driven = Some(self.sampled.len() - 1);
        }
        let top = registers.get(Register::Arr) as f64 + 1.0;
        self.ticks = top;
        let on = registers.get(Register::Bdtr) & MOE != 0;
        self.pulses = on && pulsed.contains(&true) || held.contains(&true);
        self.by_timer = enable.1 || pulsed.contains(&true);
        if !(on && pulsed[0]) {
            (self.duty, self.second) = (f64::from(held[0]), f64::from(held[1]));
        } else if renewed {
            let share = |compare| registers.get(compare) as f64 / top;
            (self.duty, self.second) = (share(Register::Ccr1), share(Register::Ccr2));
        }
    }
}
