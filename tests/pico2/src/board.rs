//! The board: the chip, wired to a driver, a motor and its encoder, with a host at its USB line.

use std::str::FromStr;

use motorlens_virtual_motor::{Bridge, Motor, VirtualMotor};

use crate::chip::{CIRCLE, Chip, UNDEFINED};
use crate::host::Host;

/// So often the motor is advanced and a packet goes each way, s.
pub const STEP_S: f64 = 50e-6;
/// The motor is driven for so long before a fault comes, s, and where there is one, so long a host says nothing.
const BEFORE_S: f64 = 0.3;
const SILENT_S: f64 = 1.0;
/// Counts that the shaft is turned by hand, after each start, before anything is driven: the emulator's counter does not go below 0
/// (`jmp x--` leaves an X of 0 as it is; RP2350 data sheet 11.4.2: it is one less in any case). And after how long, s.
const AHEAD: i64 = 20_000;
const READY_S: f64 = 0.002;
/// TIMER0's alarms: a 1 takes one back.
const ARMED: u32 = 0x400b_0020;
/// What the converter's inputs have of supply and current: a divider, and an amplifier, V/A, around half of its own supply, V. And what the
/// pulses of the bridge leave of themselves on the supply, V.
const DIVIDER: f64 = 11.0;
const AMPLIFIER: f64 = 0.165;
const MIDDLE_V: f64 = 1.65;
const RIPPLE_V: f64 = 0.6;
/// So much a supply is pumped up, V, so much more current flows, A, and so long a crystal is still that comes back, s.
const PUMPED_V: f64 = 7.0;
const SHORT_A: f64 = 14.0;
const STILL_S: f64 = 0.1;

/// The driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Driver {
    /// PWM, two directions and an enable; it brakes in the off part.
    Brake,
    /// Two inputs and no enable.
    InIn,
}

impl FromStr for Driver {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "brake" => Ok(Self::Brake),
            "in-in" => Ok(Self::InIn),
            _ => Err(format!("no driver is named {name}")),
        }
    }
}

/// What is done to it while its motor is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Nothing.
    None,
    /// The emergency contact opens.
    Emergency,
    /// It opens for one step.
    Bounce,
    /// The core is at an instruction without a meaning.
    Core,
    /// The program runs in a circle with its interrupts off.
    Hang,
    /// Its main loop does, with interrupts on.
    Circle,
    /// The control, to which the variable at this address points, looks borrowed, over which the program panics.
    Panic(u32),
    /// The sampling timer's alarm is lost.
    Dead,
    /// Nothing of the host arrives for a second.
    Silent,
    /// The supply is pumped up by a motor that brakes.
    Pumped,
    /// More current flows.
    Short,
    /// The crystal stops.
    Crystal,
    /// It does, and swings again.
    CrystalBack,
}

impl FromStr for Fault {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Ok(match name {
            "none" => Self::None,
            "emergency" => Self::Emergency,
            "bounce" => Self::Bounce,
            "fault" => Self::Core,
            "hang" => Self::Hang,
            "circle" => Self::Circle,
            "dead" => Self::Dead,
            "silent" => Self::Silent,
            "pumped" => Self::Pumped,
            "short" => Self::Short,
            "crystal" => Self::Crystal,
            "crystal-back" => Self::CrystalBack,
            _ => {
                let control = name.strip_prefix("panic:").and_then(|address| address.parse().ok());
                control.map(Self::Panic).ok_or_else(|| format!("no fault is named {name}"))?
            }
        })
    }
}

/// Everything at one end of the USB line.
pub struct Board {
    /// The chip.
    pub chip: Chip,
    /// The host's controller.
    pub host: Host,
    motor: VirtualMotor,
    driver: Driver,
    fault: Fault,
    /// Beyond the motor's own.
    pumped_v: f64,
    short_a: f64,
    /// Counts that are shown beyond the motor's own, since which start.
    ahead: i64,
    starts: u32,
    shown: i64,
    driven_s: f64,
    since_s: Option<f64>,
    off_s: Option<f64>,
}

impl Board {
    /// A board with the image of the UF2 file.
    pub fn new(uf2: &[u8], driver: Driver, fault: Fault) -> Self {
        let mut board = Self {
            chip: Chip::new(uf2),
            host: Host::default(),
            motor: VirtualMotor::new(&Motor::small(), &[], 1),
            driver,
            fault,
            pumped_v: 0.0,
            short_a: 0.0,
            ahead: 0,
            starts: 0,
            shown: 0,
            driven_s: 0.0,
            since_s: None,
            off_s: None,
        };
        board.begin();
        board
    }

    /// Lets the image start and turns the shaft ahead, faster than it turns later.
    fn begin(&mut self) {
        self.chip.run(READY_S, |_| ());
        for _ in 0..AHEAD {
            self.shown += 1;
            self.chip.show_count(self.shown);
            self.chip.turn();
        }
        self.ahead = self.shown - self.motor.counts();
        self.starts = self.chip.restarts();
    }

    /// What the driver makes of its pins, V: enabled by GP9, forward by GP8, backward by GP11, its mean by GP6, or by GP6 and GP7 alone; `None`
    /// where the motor is let go.
    pub fn volts(&mut self) -> Option<f64> {
        let supply = self.motor.motor().nominal_v;
        let [first, second] = [6, 7].map(|pin| self.chip.share(pin));
        if self.driver == Driver::InIn {
            return (first > 0.0 || second > 0.0).then_some((first - second) * supply);
        }
        let [enable, forward, backward] = [9, 8, 11].map(|pin| self.chip.share(pin) > 0.5);
        let sign = if forward { 1.0 } else { -1.0 };
        (enable && forward != backward).then_some(sign * first * supply)
    }

    /// When the pins were off for good after the fault, ms after it.
    pub fn off_ms(&self) -> Option<f64> {
        self.off_s.map(|seconds| seconds * 1e3)
    }

    /// One step of the motor, with the encoder's edges in it spread over it.
    pub fn step(&mut self) {
        if self.chip.restarts() != self.starts {
            self.begin();
        }
        let applied = self.volts();
        if applied.is_some_and(|volts| volts != 0.0) {
            self.driven_s += STEP_S;
        }
        self.injure();
        if let Some(since) = &mut self.since_s {
            *since += STEP_S;
            self.off_s = if applied.is_some() { None } else { self.off_s.or(Some(*since)) };
            if self.fault == Fault::Bounce && *since > 1.5 * STEP_S {
                self.chip.set_contact(false);
            }
            if self.fault == Fault::Silent && *since < SILENT_S {
                self.host.sending.clear();
            }
            if self.fault == Fault::CrystalBack && (*since - STILL_S).abs() < STEP_S / 2.0 {
                self.chip.set_crystal(true);
            }
        }
        self.motor.advance(STEP_S, applied.map_or(Bridge::Floating, Bridge::Volts));
        self.show_supply_and_current();
        let edges = self.motor.counts() + self.ahead - self.shown;
        for _ in 0..edges.abs() {
            self.shown += edges.signum();
            self.chip.show_count(self.shown);
            self.chip.run(STEP_S / edges.abs() as f64, |_| ());
        }
        if edges == 0 {
            self.chip.run(STEP_S, |_| ());
        }
        self.host.turn(&mut self.chip);
    }

    fn show_supply_and_current(&mut self) {
        let supply = self.motor.motor().nominal_v + self.pumped_v;
        let current = self.motor.current_a() + self.short_a;
        let converter = &mut self.chip.beside.converter;
        converter.pins = [supply / DIVIDER, MIDDLE_V + AMPLIFIER * current];
        converter.ripple_v = RIPPLE_V / DIVIDER;
    }

    fn injure(&mut self) {
        if self.since_s.is_some() || self.fault == Fault::None || self.driven_s < BEFORE_S {
            return;
        }
        let core = self.chip.core();
        // Not in a handler, nor within a critical section: a loop that circles there keeps what it borrowed from the interrupts, an alarm that is
        // taken away is set again, and a borrow that is made up is written over where one ends.
        let is_locked = core.regs.ipsr() != 0 || core.regs.primask != 0;
        if is_locked && matches!(self.fault, Fault::Circle | Fault::Dead | Fault::Panic(_)) {
            return;
        }
        self.since_s = Some(0.0);
        match self.fault {
            Fault::None | Fault::Silent => {}
            Fault::Emergency | Fault::Bounce => self.chip.set_contact(true),
            Fault::Dead => self.chip.write(ARMED, 1),
            Fault::Panic(control) => {
                // A `RefCell` begins with its flag.
                let flag = self.chip.read(control);
                self.chip.write(flag, 1);
            }
            Fault::Pumped => self.pumped_v = PUMPED_V,
            Fault::Short => self.short_a = SHORT_A,
            Fault::Crystal | Fault::CrystalBack => self.chip.set_crystal(false),
            Fault::Core => self.chip.go_to(UNDEFINED),
            Fault::Circle => self.chip.go_to(CIRCLE),
            Fault::Hang => {
                self.chip.go_to(CIRCLE);
                self.chip.core().regs.primask = 1;
            }
        }
    }
}
