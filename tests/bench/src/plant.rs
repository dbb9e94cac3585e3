//! Driver, motor, encoder and analogue inputs at the chip's pins.

mod analog;
mod driver;

use std::collections::BTreeMap;

use analog::Sensed;
use motorlens_firmware::beat::split;
use motorlens_shared::link::DriveMode;
use motorlens_virtual_motor::VirtualMotor;
use rigless::device::Level;
use rigless::soc::st::tim::{BreakInput, BreakSource};
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::time::VirtualNanos;

use crate::encoder::{Encoder, Mistake};
use crate::machine::{CORE_HZ, Machine};

/// GPIOB among the ports.
const PORT_B: usize = 1;
const EMERGENCY: u8 = 12;
/// A tick of the PWM's clock, ns.
const NS_PER_TICK: f64 = 1e9 / CORE_HZ as f64;

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

    /// A sampling instant: the counter is remembered.
    pub fn sample(&mut self, at: VirtualNanos, machine: &mut Machine) {
        self.sampled.push(self.edges());
        self.sense(at, machine);
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
