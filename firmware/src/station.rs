//! The main loop: answers the host, sends the log, keeps samples, fits.

mod answer;
mod stream;

use crate::Shared;
use crate::control::Control;
use crate::hardware::Hardware;
use crate::outbox::Outbox;
use embedded_io::{Read, ReadReady, Write, WriteReady};
use heapless::{String, Vec};
use motorlens_shared::excitation::{MAX_NAME, MAX_SEGMENTS, Segment};
use motorlens_shared::link::{Decoder, FromBoard, Packet, RunState, Scaling, Status, ToBoard};
use motorlens_shared::quickfit::{Arithmetic, Keeper, QuickFit, Request};
use stream::Stream;

/// How often the status is sent unasked, us.
const STATUS_US: u32 = 100_000;
/// Bytes that a turn of the main loop takes from the line at most: many times what the line brings in half a millisecond.
const BYTES_IN_A_TURN: usize = 256;

/// What the main loop needs of a board beside the control's hardware.
pub trait Platform {
    /// The core's clock, Hz.
    const CORE_HZ: u32;
    /// The numbers that the quick fit searches in: integers where the core has no floating-point unit.
    type Arithmetic: Arithmetic;
    /// The firmware's version.
    const VERSION: [u8; 3];
    /// The chip's own number.
    fn unique(&self) -> [u8; 12];
    /// Tells the watchdog that the main loop lives. Called often, also during a fit.
    fn alive(&mut self);
    /// Whether [`Self::enter_bootloader`] can do it.
    fn has_bootloader(&self) -> bool;
    /// Leaves for the boot loader. The bridge is off by then and the answer is sent.
    fn enter_bootloader(&mut self);
}

/// A serial line that never makes the caller wait.
pub trait Line: Read + ReadReady + Write + WriteReady {}
impl<L: Read + ReadReady + Write + WriteReady> Line for L {}

/// The state of the main loop. Large: it belongs in a static.
pub struct Station {
    decoder: Decoder,
    outbox: Outbox,
    stream: Stream,
    keeper: Keeper,
    segments: Vec<Segment, MAX_SEGMENTS>,
    name: String<MAX_NAME>,
    agreed: Option<u16>,
    damaged: u32,
    said: Option<(RunState, u32)>,
    fit: Option<QuickFit>,
    /// The request that `fit` answers: asked again, it is answered again and not carried out again.
    fitted: Option<(u16, Request)>,
    bootloader: bool,
}

impl Default for Station {
    fn default() -> Self {
        Self::new()
    }
}

impl Station {
    /// A station that has heard nothing.
    pub const fn new() -> Self {
        Self {
            decoder: Decoder::new(),
            outbox: Outbox::new(),
            stream: Stream::new(),
            keeper: Keeper::new(Scaling { pwm_top: 1, rate_hz: 1000 }, 1),
            segments: Vec::new(),
            name: String::new(),
            agreed: None,
            damaged: 0,
            said: None,
            fit: None,
            fitted: None,
            bootloader: false,
        }
    }

    /// One turn of the main loop; to be called at least every half a millisecond or so. It takes one message at most, and sends one block of
    /// the log at most, so that a turn has an end whatever comes.
    pub fn poll<H: Hardware>(
        &mut self,
        line: &mut impl Line,
        control: &Shared<H>,
        platform: &mut impl Platform,
    ) {
        platform.alive();
        with(control, Control::turned);
        self.listen(line, control, platform);
        self.stream.keep(&mut self.keeper, control);
        if self.agreed.is_some() {
            self.stream.send(&mut self.outbox, control);
            self.report(control);
        }
        self.outbox.pump(line);
        if self.bootloader {
            self.outbox.pump(line);
            // A line that fails cannot be told the answer; the boot loader was asked for all the same.
            let _ = line.flush();
            platform.enter_bootloader();
            self.bootloader = false;
        }
        with(control, Control::worked);
    }

    /// Takes what has come, up to the end of a frame.
    fn listen<H: Hardware>(
        &mut self,
        line: &mut impl Line,
        control: &Shared<H>,
        platform: &mut impl Platform,
    ) {
        for _ in 0..BYTES_IN_A_TURN {
            let mut byte = [0];
            if !line.read_ready().unwrap_or(false) || line.read(&mut byte).unwrap_or(0) == 0 {
                return;
            }
            match self.decoder.push_with_progress::<Packet<ToBoard>>(byte[0], &mut working(control)) {
                Some(Ok(packet)) => {
                    with(control, |control| control.heard());
                    self.outbox.protect(self.decoder.protected());
                    return self.answer(packet, line, control, platform);
                }
                Some(Err(_)) => return self.damaged = self.damaged.saturating_add(1),
                None => {}
            }
        }
    }

    /// Says how things stand, ten times a second and whenever the state changes.
    fn report<H: Hardware>(&mut self, control: &Shared<H>) {
        let (mut status, now) = with(control, |control| (control.status(), control.now_us()));
        let state = status.state;
        let due =
            self.said.is_none_or(|(state, at)| state != status.state || now.wrapping_sub(at) >= STATUS_US);
        if due && self.outbox.has_room() {
            self.complete(&mut status);
            self.outbox.post(0, FromBoard::Status(status), &mut working(control));
            self.said = Some((state, now));
        }
    }

    /// Adds what the main loop knows, in words that the host's version has.
    fn complete(&self, status: &mut Status) {
        (status.kept, status.damaged) = (self.keeper.samples().len() as u16, self.damaged);
        let version = self.agreed.unwrap_or(1);
        status.reset = status.reset.told_to(version);
        if let RunState::Stopped(cause) = status.state {
            status.state = RunState::Stopped(cause.told_to(version));
        }
    }
}

/// Borrows the control with the sampling interrupt held off. Keep it short.
fn with<H: Hardware, R>(control: &Shared<H>, act: impl FnOnce(&mut Control<H>) -> R) -> R {
    critical_section::with(|section| act(&mut control.borrow_ref_mut(section)))
}

/// Says again and again in a long piece of work that the main loop goes on.
fn working<H: Hardware>(control: &Shared<H>) -> impl FnMut() {
    move || with(control, Control::worked)
}
