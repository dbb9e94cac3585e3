//! Driver, motor, encoder and analogue inputs at the chip's pins.

use motorlens_shared::link::DriveMode;
use motorlens_virtual_motor::{Bridge, VirtualMotor};
use rigless::device::{DeviceContext, Level, RegisterFile};
use rigless::soc::st::tim::{Channel, Tim};
use rigless::soc::stm32f427::generated::tim1::Register;
use rigless::soc::stm32f427::peripherals::adc::Channel as AdcChannel;
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::soc::stm32f427::peripherals::tim::General;
use rigless::time::VirtualNanos;

use crate::machine::Machine;

/// GPIOB among the ports, TIM3 among the general timers.
const PORT_B: usize = 1;
const TIMER_3: usize = 1;
/// Pins of port B.
const FORWARD: u8 = 0;
const BACKWARD: u8 = 1;
const ENABLE: u8 = 10;
const EMERGENCY: u8 = 12;
/// Inputs of the converter.
const CURRENT_INPUT: u8 = 1;
const SUPPLY_INPUT: u8 = 4;
/// One period of the PWM, s.
const PWM_PERIOD_S: f64 = 50e-6;

/// The motor with its driver, and what can be done to it.
#[derive(Debug)]
pub struct Plant {
    /// The motor.
    pub motor: VirtualMotor,
    /// The kind of driver that is wired up; the firmware is told the same.
    pub driver: DriveMode,
    /// The encoder's disc is held: no edge comes, whatever the motor does.
    pub jammed: bool,
    /// Current that a short adds to what the amplifier sees, A.
    pub short_a: f64,
    /// Whether the emergency contact is open.
    pub emergency: bool,
    /// The counter at each sampling instant since the start.
    pub sampled: Vec<i64>,
    now: VirtualNanos,
    duty: f64,
    sign: f64,
    enabled: bool,
    first_driven: Option<usize>,
    period_began: VirtualNanos,
    phase: u8,
    edges: i64,
}

impl Plant {
    /// A motor at rest at a driver that is off.
    pub fn new(motor: VirtualMotor, driver: DriveMode) -> Self {
        Plant {
            motor,
            driver,
            jammed: false,
            short_a: 0.0,
            emergency: false,
            sampled: Vec::new(),
            now: VirtualNanos(0),
            duty: 0.0,
            sign: 0.0,
            enabled: false,
            first_driven: None,
            period_began: VirtualNanos(0),
            phase: 0,
            edges: 0,
        }
    }

    /// Whether the driver's enable is high.
    pub fn driven(&self) -> bool {
        self.enabled
    }

    /// The PWM's high share at the driver.
    pub fn duty(&self) -> f64 {
        self.duty
    }

    /// Edges that the encoder has given so far.
    pub fn edges(&self) -> i64 {
        self.edges
    }

    /// The counter at the first `samples` sampling instants at which the driver was on or just being switched on: what
    /// the log of the first run must hold.
    pub fn run_counts(&self, samples: usize) -> Vec<i64> {
        let first = self.first_driven.unwrap_or_default();
        self.sampled.iter().skip(first).take(samples).copied().collect()
    }

    /// Lets the motor run up to `at` under the bridge as it was, and gives the encoder's edges to the chip.
    pub fn advance(&mut self, at: VirtualNanos, machine: &mut Machine) {
        while self.now.0 < at.0 {
            let (bridge, until) = self.bridge(at);
            self.motor.advance((until.0 - self.now.0) as f64 * 1e-9, bridge);
            self.now = until;
        }
        if self.jammed {
            return;
        }
        let target = self.motor.counts();
        while self.edges != target {
            let step = if target > self.edges { 1 } else { 3 };
            let next = (self.phase + step) & 3;
            let lines = |phase: u8| (phase == 1 || phase == 2, phase >= 2);
            let (old, new) = (lines(self.phase), lines(next));
            let (channel, level) = if old.0 != new.0 { (1, new.0) } else { (2, new.1) };
            let level = if level { Level::High } else { Level::Low };
            let input =
                |timer: &mut Tim<General>, registers: &mut RegisterFile, context: &mut DeviceContext<'_>| {
                    timer.drive_input(Channel::new(channel).expect("1 or 2"), level, registers, context);
                };
            machine.mcu.drive_timer(at, TIMER_3, input);
            self.phase = next;
            self.edges += if step == 1 { 1 } else { -1 };
        }
    }

    /// What the bridge does now, and until when at most, `end` at the latest.
    fn bridge(&self, end: VirtualNanos) -> (Bridge, VirtualNanos) {
        if !self.enabled {
            return (Bridge::Floating, end);
        }
        let nominal = self.motor.motor().nominal_v;
        match self.driver {
            DriveMode::SignMagnitudeBrake => (Bridge::Volts(self.sign * self.duty * nominal), end),
            DriveMode::LockedAntiPhase => (Bridge::Volts((2.0 * self.duty - 1.0) * nominal), end),
            DriveMode::SignMagnitudeCoast => {
                // The off part matters: go from switch to switch.
                let period = (PWM_PERIOD_S * 1e9) as u64;
                let on = (self.duty * PWM_PERIOD_S * 1e9).round() as u64;
                let since = (self.now.0 - self.period_began.0) % period;
                let (bridge, rest) = if since < on {
                    (Bridge::Volts(self.sign * nominal), on - since)
                } else {
                    (Bridge::Floating, period - since)
                };
                (bridge, VirtualNanos(end.0.min(self.now.0 + rest)))
            }
        }
    }

    /// Looks at the driver's inputs after the program may have changed them.
    pub fn look(&mut self, machine: &mut Machine) {
        let (port, registers) = machine.mcu.port(PORT_B);
        let high = |pin: u8| port.level(Pin::new(pin).expect("a port has 16"), registers) == Level::High;
        (self.enabled, self.sign) = (high(ENABLE), f64::from(high(FORWARD)) - f64::from(high(BACKWARD)));
        if self.enabled && self.first_driven.is_none() {
            self.first_driven = Some(self.sampled.len() - 1);
        }
        let (_, registers) = machine.mcu.advanced_timer(0);
        let top = registers.get(Register::Arr) as f64 + 1.0;
        self.duty = registers.get(Register::Ccr1) as f64 / top;
    }

    /// A new period of the PWM has begun.
    pub fn begin_period(&mut self, at: VirtualNanos) {
        self.period_began = at;
    }

    /// A sampling instant: the converter's inputs follow the motor, and the counter is remembered.
    pub fn sample(&mut self, machine: &mut Machine) {
        self.sampled.push(self.edges);
        let (converter, _) = machine.mcu.converter(0);
        let volts = self.motor.supply_v() / 11.0;
        let current = 1.65 + 0.165 * (self.motor.current_a() + self.short_a);
        for (input, volts) in [(SUPPLY_INPUT, volts), (CURRENT_INPUT, current)] {
            let millivolts = (volts * 1000.0).round().clamp(0.0, 3300.0) as u32;
            converter.set_input(AdcChannel::new(input).expect("the converter has it"), millivolts);
        }
    }

    /// Puts the emergency contact to the pin.
    pub fn wire_emergency(&self, at: VirtualNanos, machine: &mut Machine) {
        let level = (!self.emergency).then_some(Level::Low);
        machine.mcu.drive_port(at, PORT_B, |port, registers, context| {
            port.drive(Pin::new(EMERGENCY).expect("a port has 16"), level, registers, context);
        });
    }
}
