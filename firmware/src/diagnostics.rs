//! What the board says over RTT to whoever has a debugger on it: why it started, each run's begin, end and timing, and what goes
//! wrong on the line. `cargo run --release` in a board's directory shows it.
//!
//! Everything is said from the main loop: an interrupt, or a program that is at fault, touches no logger.

use crate::Shared;
use crate::hardware::Hardware;
use motorlens_shared::link::{Cause, Reset, RunState, Status};

/// What was said last.
#[derive(Debug)]
pub struct Diagnostics {
    state: RunState,
    missed: u32,
    worst_cycles: u32,
    cycles_in_us: u32,
}

impl Diagnostics {
    /// Says who starts, and why; where a panic was the reason and its place is known, file and line, also that.
    pub fn begin(reset: Reset, panic: Option<(&[u8], u32)>, core_hz: u32) -> Self {
        defmt::info!("motorlens {=str}: started, reason: {=str}", env!("CARGO_PKG_VERSION"), reason(reset));
        if let (Reset::Panic, Some((file, line))) = (reset, panic) {
            defmt::error!("the panic's place: {=[u8]:a} line {=u32}", file, line);
        }
        Diagnostics {
            state: RunState::Idle,
            missed: 0,
            worst_cycles: 0,
            cycles_in_us: (core_hz / 1_000_000).max(1),
        }
    }

    /// Says what has changed.
    pub fn look<H: Hardware>(&mut self, control: &Shared<H>) {
        let (status, turns) = critical_section::with(|section| {
            let control = control.borrow_ref(section);
            (control.status(), control.turns())
        });
        if status.state == RunState::Running && status.missed > self.missed {
            defmt::warn!("run {=u32}: {=u32} samples missed so far", status.run, status.missed);
        }
        self.missed = status.missed;
        if self.state != status.state {
            self.changed(&status);
            if self.state == RunState::Running {
                let (piece, turn) = turns.longest_us();
                defmt::info!(
                    "main loop: {=u32} us without a piece of work, {=u32} us a turn at most",
                    piece,
                    turn
                );
            }
            self.state = status.state;
        }
    }

    fn changed(&mut self, status: &Status) {
        match status.state {
            RunState::Idle => defmt::info!("idle"),
            RunState::Running => defmt::info!("run {=u32}: begun", status.run),
            RunState::Stopped(cause) => {
                let (run, samples) = (status.run, status.next);
                if matches!(cause, Cause::Finished | Cause::Asked) {
                    defmt::info!("run {=u32}: {=str} after {=u32} samples", run, ended(cause), samples);
                } else {
                    defmt::error!("run {=u32}: {=str} after {=u32} samples", run, ended(cause), samples);
                }
                if status.worst_cycles > self.worst_cycles {
                    self.worst_cycles = status.worst_cycles;
                    let microseconds = status.worst_cycles / self.cycles_in_us;
                    defmt::info!("longest sampling interrupt so far: {=u32} us", microseconds);
                }
            }
        }
    }
}

/// As [`Reset`] is displayed, without the formatting of strings that would bring.
fn reason(reset: Reset) -> &'static str {
    match reset {
        Reset::PowerOn => "power or the reset pin",
        Reset::Watchdog => "the program hung",
        Reset::Software => "on request",
        Reset::Panic => "a panic",
        Reset::CoreFault => "a fault of the core",
        Reset::Clock => "the crystal stopped",
        Reset::Supply => "the chip's supply sank",
    }
}

fn ended(cause: Cause) -> &'static str {
    match cause {
        Cause::Finished => "finished",
        Cause::Asked => "stopped on request",
        Cause::RunLimit => "run-time limit",
        Cause::Stall => "stall",
        Cause::OverCurrent => "over-current",
        Cause::LinkLoss => "link lost",
        Cause::Emergency => "emergency input open",
        Cause::Watchdog => "control lost, restarted",
        Cause::Supply => "supply out of bounds",
        Cause::Turning => "shaft still turned, not begun",
    }
}
