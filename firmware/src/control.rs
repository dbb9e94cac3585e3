//! The control of one motor: what begins, ends and sets up a run. The sampling interrupt's part is `instant`.

mod instant;

use crate::analog::Wiring;
use crate::beat::split;
use crate::encoder::Extended;
use crate::hardware::{Analog, Hardware};
use crate::log::Log;
use crate::standing::Wait;
use crate::supervisor::Supervisor;
use crate::turns::Turns;
use motorlens_shared::excitation::Player;
use motorlens_shared::link::{Cause, Reset, RunState, Sample, Scaling, Setup, Status};

/// What a sampling instant brings.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Next {
    /// The programme's voltage as a duty.
    Duty(i16),
    /// The programme is over.
    End,
}

/// A supervisor for a run with this setup.
fn supervisor(setup: &Setup) -> Supervisor {
    let (_, apart_us) = split(1_000_000 / u32::from(setup.rate_hz.max(1)));
    Supervisor::new(apart_us)
}

/// The control of one motor.
pub struct Control<H: 'static> {
    hardware: H,
    log: &'static mut Log,
    setup: Setup,
    state: RunState,
    reset: Reset,
    player: Option<Player>,
    encoder: Extended,
    supervisor: Supervisor,
    wait: Wait,
    turns: Turns,
    origin_us: Option<u32>,
    heard_us: u32,
    /// What is to be applied at the next instant.
    planned: Option<Next>,
    /// The sample whose interval goes on; supply and current are still missing.
    open: Option<Sample>,
    /// The last means of supply, mV, and current, mA.
    supply_mv: u16,
    current_ma: i16,
    ticks: u32,
    worst_cycles: u32,
}

impl<H: Hardware> Control<H> {
    /// Takes the hardware, with the bridge off, and what an earlier start may have left in the log.
    pub fn new(mut hardware: H, log: &'static mut Log, reset: Reset) -> Self {
        hardware.release();
        let setup = Setup::default();
        hardware.set_rate(setup.rate_hz, setup.pwm_hz());
        let cut_short = log.recover(reset.lost_control());
        let state = if cut_short { RunState::Stopped(Cause::Watchdog) } else { RunState::Idle };
        Self {
            hardware,
            log,
            setup,
            state,
            reset,
            player: None,
            encoder: Extended::default(),
            supervisor: supervisor(&setup),
            wait: Wait::new(0, 0),
            turns: Turns::default(),
            origin_us: None,
            heard_us: 0,
            planned: None,
            open: None,
            supply_mv: setup.supply_mv,
            current_ma: 0,
            ticks: 0,
            worst_cycles: 0,
        }
    }

    /// A turn of the main loop begins: to be called at least every half a millisecond or so, between long pieces of work.
    pub fn turned(&mut self) {
        self.turns.turned(self.hardware.now_us());
    }

    /// The main loop has done a piece of its turn's work: to be called as often.
    pub fn worked(&mut self) {
        self.turns.worked(self.hardware.now_us());
    }

    /// How long the main loop took in the last run.
    pub fn turns(&self) -> Turns {
        self.turns
    }

    /// Begins a run of `player` with the present setup, once the motor stands still; it waits with the bridge off, and ends the run where
    /// the shaft goes on turning.
    pub fn start(&mut self, run: u32, player: Player) {
        self.log.begin(run, self.scaling());
        self.player = Some(player);
        self.supervisor = supervisor(&self.setup);
        let now = self.hardware.now_us();
        let count = self.encoder.look(self.hardware.count());
        self.wait = Wait::new(now, count);
        self.heard_us = now;
        // What it took to prepare the programme is no hang of this run.
        self.turns = Turns::new(now);
        (self.origin_us, self.planned, self.open) = (None, None, None);
        self.state = RunState::Running;
    }

    /// Takes the bridge off. A run that is under way ends with this cause; the log stays.
    pub fn stop(&mut self, cause: Cause) {
        self.hardware.release();
        if self.state == RunState::Running {
            // Its interval is cut short: the means are those of the one before.
            self.push_open();
            self.state = RunState::Stopped(cause);
            self.player = None;
            self.log.end();
        }
    }

    /// Takes another setup. Only while nothing runs; the caller has checked it.
    pub fn configure(&mut self, setup: Setup) {
        self.setup = setup;
        self.hardware.set_rate(setup.rate_hz, setup.pwm_hz());
        self.hardware.analog().wire(Wiring::from(&setup));
    }

    /// The host was heard.
    pub fn heard(&mut self) {
        self.heard_us = self.hardware.now_us();
    }

    /// What the control is doing, and what the log holds.
    pub fn status(&self) -> Status {
        Status {
            state: self.state,
            run: self.log.run(),
            oldest: self.log.oldest(),
            next: self.log.next(),
            missed: self.log.missed(),
            kept: 0,
            damaged: 0,
            reset: self.reset,
            worst_cycles: self.worst_cycles,
        }
    }

    /// What the raw numbers of a run begun now would mean.
    pub fn scaling(&self) -> Scaling {
        Scaling { pwm_top: self.hardware.pwm_top(), rate_hz: self.setup.rate_hz }
    }

    /// The present setup.
    pub fn setup(&self) -> Setup {
        self.setup
    }

    /// The log.
    pub fn log(&self) -> &Log {
        self.log
    }

    /// Sampling instants since the start: when this stands still, the interrupt is dead.
    pub fn ticks(&self) -> u32 {
        self.ticks
    }

    /// Whether the emergency input is open.
    pub fn emergency(&mut self) -> bool {
        self.hardware.emergency()
    }

    /// Whether supply and current are measured.
    pub fn measures(&self) -> (bool, bool) {
        (self.setup.divider > 0, self.setup.amplifier > 0)
    }

    /// The hardware, for what only the board knows of it.
    pub fn hardware_mut(&mut self) -> &mut H {
        &mut self.hardware
    }

    /// The clock, us.
    pub fn now_us(&mut self) -> u32 {
        self.hardware.now_us()
    }
}
