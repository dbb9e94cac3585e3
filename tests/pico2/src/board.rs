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
    /// The sampling timer's alarm is lost.
    Dead,
    /// Nothing of the host arrives for a second.
    Silent,
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
            _ => return Err(format!("no fault is named {name}")),
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
    fault: Fault,
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
    pub fn new(uf2: &[u8], fault: Fault) -> Self {
        let mut board = Self {
            chip: Chip::new(uf2),
            host: Host::default(),
            motor: VirtualMotor::new(&Motor::small(), &[], 1),
            fault,
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

    /// What the driver makes of its pins, V: enabled by GP9, forward by GP8, backward by GP11, its mean by GP6; `None` where the motor is let go.
    pub fn volts(&mut self) -> Option<f64> {
        let [enable, forward, backward] = [9, 8, 11].map(|pin| self.chip.share(pin) > 0.5);
        let sign = if forward { 1.0 } else { -1.0 };
        let supply = self.motor.motor().nominal_v;
        (enable && forward != backward).then(|| sign * self.chip.share(6) * supply)
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
        }
        self.motor.advance(STEP_S, applied.map_or(Bridge::Floating, Bridge::Volts));
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

    fn injure(&mut self) {
        if self.since_s.is_some() || self.fault == Fault::None || self.driven_s < BEFORE_S {
            return;
        }
        let core = self.chip.core();
        // Not in a handler, nor within a critical section: a loop that circles there keeps what it borrowed from the interrupts, and an alarm that is
        // taken away is set again.
        let is_locked = core.regs.ipsr() != 0 || core.regs.primask != 0;
        if is_locked && matches!(self.fault, Fault::Circle | Fault::Dead) {
            return;
        }
        self.since_s = Some(0.0);
        match self.fault {
            Fault::None | Fault::Silent => {}
            Fault::Emergency | Fault::Bounce => self.chip.set_contact(true),
            Fault::Dead => self.chip.write(ARMED, 1),
            Fault::Core => self.chip.go_to(UNDEFINED),
            Fault::Circle => self.chip.go_to(CIRCLE),
            Fault::Hang => {
                self.chip.go_to(CIRCLE);
                self.chip.core().regs.primask = 1;
            }
        }
    }
}
