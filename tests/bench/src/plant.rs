//! Driver, motor, encoder and analogue inputs at the chip's pins.

use std::collections::BTreeMap;

use motorlens_firmware::beat::split;
use motorlens_shared::link::DriveMode;
use motorlens_virtual_motor::{Bridge, VirtualMotor};
use rigless::device::{Level, RegisterFile};
use rigless::soc::st::tim::{BreakInput, BreakSource, Channel};
use rigless::soc::stm32f427::generated::gpioa::Register as PortRegister;
use rigless::soc::stm32f427::generated::tim1::Register;
use rigless::soc::stm32f427::peripherals::adc::Channel as AdcChannel;
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::time::VirtualNanos;

use crate::encoder::{Encoder, Mistake};
use crate::machine::{CORE_HZ, Machine};

/// GPIOA and GPIOB among the ports.
const PORT_A: usize = 0;
const PORT_B: usize = 1;
/// The outputs of an advanced timer are enabled.
const MOE: u64 = 1 << 15;
/// The PWM at port A, and the second one.
const PWM: u8 = 8;
const SECOND_PWM: u8 = 9;
/// Pins of port B.
const FORWARD: u8 = 0;
const BACKWARD: u8 = 1;
const ENABLE: u8 = 15;
const EMERGENCY: u8 = 12;
/// Inputs of the converter.
const CURRENT_INPUT: u8 = 1;
const SUPPLY_INPUT: u8 = 4;
/// What the supply's input reads where nothing is wired to it, V.
const FLOATING_V: f64 = 0.2;
/// A tick of the PWM's clock, ns.
const NS_PER_TICK: f64 = 1e9 / CORE_HZ as f64;
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

/// What the converter's inputs were shown after a sampling interrupt: sums over looks.
#[derive(Debug, Clone, Copy, Default)]
struct Sensed {
    supply_v: f64,
    current_a: f64,
    looks: f64,
}

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
    /// What a braking motor has pumped into a supply that cannot sink it, V above its own voltage.
    pub pumped_v: f64,
    /// Ripple of the supply in step with the PWM's pulses, V: so much lower while the pin is high than while it is low, its mean zero.
    pub ripple_v: f64,
    /// The same of what the current amplifier sees, A.
    pub ripple_a: f64,
    /// A slow swing of the supply, V, of ten periods a second.
    pub swing_v: f64,
    /// What is wired wrongly.
    pub mistake: Option<Mistake>,
    /// Whether the emergency contact is open.
    pub emergency: bool,
    /// The counter at each sampling instant since the start.
    pub sampled: Vec<i64>,
    now: VirtualNanos,
    duty: f64,
    second: f64,
    sign: f64,
    enabled: bool,
    pulses: bool,
    by_timer: bool,
    first_driven: Option<usize>,
    period_began: VirtualNanos,
    period_interrupt: usize,
    ticks: f64,
    shares: BTreeMap<usize, f64>,
    sensed: BTreeMap<usize, Sensed>,
    encoder: Encoder,
    beats: usize,
}

impl Plant {
    /// A motor at rest at a driver that is off.
    pub fn new(motor: VirtualMotor, driver: DriveMode) -> Self {
        Plant {
            motor,
            driver,
            jammed: false,
            short_a: 0.0,
            pumped_v: 0.0,
            ripple_v: 0.0,
            ripple_a: 0.0,
            swing_v: 0.0,
            mistake: None,
            emergency: false,
            sampled: Vec::new(),
            now: VirtualNanos(0),
            duty: 0.0,
            second: 0.0,
            sign: 0.0,
            enabled: false,
            pulses: false,
            by_timer: false,
            first_driven: None,
            period_began: VirtualNanos(0),
            period_interrupt: 0,
            ticks: 1.0,
            shares: BTreeMap::new(),
            sensed: BTreeMap::new(),
            encoder: Encoder::default(),
            beats: 1,
        }
    }

    /// The same, sampled so many times a second: where that is less than a thousand, the sampling timer interrupts between the
    /// sampling instants too.
    pub fn sampled_at(mut self, rate_hz: u16) -> Self {
        self.beats = split(1_000_000 / u32::from(rate_hz)).0 as usize;
        self
    }

    /// Whether the driver's enable is high.
    pub fn driven(&self) -> bool {
        self.enabled
    }

    /// Whether one of the PWMs' two pins may be high: it is the timer's and the timer's outputs are enabled, or the program holds it high
    /// itself. A driver with two inputs and no enable is off where neither is.
    pub fn pulses(&self) -> bool {
        self.pulses
    }

    /// Whether the timer has one of the pins of PWM and enable: what forces them low takes them from it, and what ends its outputs does not.
    pub fn by_timer(&self) -> bool {
        self.by_timer
    }

    /// The PWM's high share at the driver.
    pub fn duty(&self) -> f64 {
        self.duty
    }

    /// Edges that the encoder has given so far.
    pub fn edges(&self) -> i64 {
        self.encoder.edges()
    }

    /// The counter at the first `samples` sampling instants at which the driver was on or just being switched on: what
    /// the log of the first run must hold.
    pub fn run_counts(&self, samples: usize) -> Vec<i64> {
        let first = self.first_driven.unwrap_or_default();
        self.sampled.iter().skip(first).step_by(self.beats).take(samples).copied().collect()
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
        self.encoder.follow(self.motor.counts(), self.mistake, at, machine);
    }

    /// What the bridge does now, and until when at most, `end` at the latest.
    fn bridge(&self, end: VirtualNanos) -> (Bridge, VirtualNanos) {
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

    /// The PWM begins a new period, and with it maybe another duty: [`Self::look`] has not seen it yet. What the pin was high since the
    /// last time is kept for the sampling interrupt after which that was.
    pub fn begin_period(&mut self, at: VirtualNanos) {
        let length = (at.0 - self.period_began.0) as f64;
        let period = self.ticks * NS_PER_TICK;
        let on = self.duty * period;
        let whole = (length / period).floor();
        let high = whole * on + (length - whole * period).min(on);
        self.shares.insert(self.period_interrupt, high / length);
        (self.period_began, self.period_interrupt) = (at, self.sampled.len());
    }

    /// The share of the time that the PWM's pin was high in the interval after sample number `index` of the first run.
    pub fn high_share(&self, index: usize) -> Option<f64> {
        let first = self.first_driven? + 1 + index * self.beats;
        let parts: Option<Vec<f64>> =
            (first..first + self.beats).map(|at| self.shares.get(&at).copied()).collect();
        Some(parts?.iter().sum::<f64>() / self.beats as f64)
    }

    /// The means of supply, V, and current, A, that the converter's inputs were shown in the interval after sample number `index` of the
    /// first run.
    pub fn sensed(&self, index: usize) -> Option<(f64, f64)> {
        let first = self.first_driven? + 1 + index * self.beats;
        let mut all = Sensed::default();
        for at in first..first + self.beats {
            let part = self.sensed.get(&at)?;
            all.supply_v += part.supply_v;
            all.current_a += part.current_a;
            all.looks += part.looks;
        }
        Some((all.supply_v / all.looks, all.current_a / all.looks))
    }

    /// A sampling instant: the counter is remembered.
    pub fn sample(&mut self, at: VirtualNanos, machine: &mut Machine) {
        self.sampled.push(self.edges());
        self.sense(at, machine);
    }

    /// The converter's inputs follow supply and current.
    pub fn sense(&mut self, at: VirtualNanos, machine: &mut Machine) {
        let period = self.ticks * NS_PER_TICK;
        let since = at.0.saturating_sub(self.period_began.0) as f64 % period;
        // High or low, its mean over the period is zero.
        let high = self.enabled && since < self.duty * period;
        let pulse = if high { self.duty - 1.0 } else { self.duty };
        let swing = (std::f64::consts::TAU * 10.0 * at.0 as f64 * 1e-9).sin();
        let rippled = if self.enabled { pulse } else { 0.0 };
        let supply_v = self.motor.supply_v() + self.pumped_v + self.swing_v * swing + self.ripple_v * rippled;
        let current_a = self.motor.current_a() + self.short_a - self.ripple_a * rippled;
        let sensed = self.sensed.entry(self.sampled.len()).or_default();
        sensed.supply_v += supply_v;
        sensed.current_a += current_a;
        sensed.looks += 1.0;
        let (converter, _) = machine.mcu.converter(0);
        let current = 1.65 + 0.165 * current_a;
        let supply = if self.mistake == Some(Mistake::NoDivider) { FLOATING_V } else { supply_v / 11.0 };
        for (input, volts) in [(SUPPLY_INPUT, supply), (CURRENT_INPUT, current)] {
            let millivolts = (volts * 1000.0).round().clamp(0.0, 3300.0) as u32;
            converter.set_input(AdcChannel::new(input).expect("the converter has it"), millivolts);
        }
    }

    /// Puts the emergency contact to the pin, which is the timer's break input too.
    pub fn wire_emergency(&self, at: VirtualNanos, machine: &mut Machine) {
        let level = (!self.emergency).then_some(Level::Low);
        machine.mcu.drive_port(at, PORT_B, |port, registers, context| {
            port.drive(Pin::new(EMERGENCY).expect("a port has 16"), level, registers, context);
        });
        let level = if self.emergency { Level::High } else { Level::Low };
        machine.mcu.drive_advanced_timer(at, 0, |timer, registers, context| {
            timer.drive_break_source(BreakInput::First, BreakSource::Pin, level, registers, context);
        });
    }
}
