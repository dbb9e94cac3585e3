//! Sends the log: new samples in order, and again what the host asks for.

use super::{with, working};
use crate::Shared;
use crate::control::Control;
use crate::hardware::Hardware;
use crate::outbox::Outbox;
use heapless::Deque;
use motorlens_shared::link::{FromBoard, LOG_SAMPLES, RunState};
use motorlens_shared::quickfit::Keeper;

/// Requests for samples that may wait.
const REQUESTS: usize = 8;
/// Samples in a block sent again: shorter than a new one, because the line is likely bad.
const AGAIN_SAMPLES: u32 = 4;

/// Samples asked for again.
#[derive(Debug, Clone, Copy)]
struct Again {
    id: u16,
    first: u32,
    last: u32,
}

/// What has been sent and kept, and what is asked for.
#[derive(Debug)]
pub struct Stream {
    run: u32,
    sent: u32,
    kept: u32,
    again: Deque<Again, REQUESTS>,
    turn: bool,
}

impl Stream {
    pub const fn new() -> Self {
        Self { run: 0, sent: 0, kept: 0, again: Deque::new(), turn: false }
    }

    /// Begins with the first sample of a run.
    pub fn begin(&mut self, run: u32) {
        (self.run, self.sent, self.kept) = (run, 0, 0);
        self.again.clear();
    }

    /// Takes a request for `count` samples from `first` on; false when too many wait already.
    pub fn ask(&mut self, id: u16, first: u32, count: u16) -> bool {
        let last = first.saturating_add(count.min(256).into());
        self.again.push_back(Again { id, first, last }).is_ok()
    }

    /// Hands new samples to the keeper.
    pub fn keep<H: Hardware>(&mut self, keeper: &mut Keeper, control: &Shared<H>) {
        while let Some(block) = with(control, |control| {
            let log = control.log();
            if self.kept < log.oldest() {
                keeper.end();
                self.kept = log.next();
            }
            log.block(self.kept, u32::MAX)
        }) {
            block.samples.iter().for_each(|sample| keeper.push(sample));
            self.kept += block.samples.len() as u32;
            with(control, Control::worked);
        }
    }

    /// Puts a block into the outbox, by turns of what is asked for and what is new.
    pub fn send<H: Hardware>(&mut self, outbox: &mut Outbox, control: &Shared<H>) {
        if outbox.has_room() {
            self.turn = !self.turn;
            let _ = (self.turn && self.send_again(outbox, control))
                || self.send_new(outbox, control)
                || self.send_again(outbox, control);
        }
    }

    fn send_new<H: Hardware>(&mut self, outbox: &mut Outbox, control: &Shared<H>) -> bool {
        let block = with(control, |control| {
            let log = control.log();
            // What is overwritten can only be missed; the host finds the gap by the numbers.
            self.sent = self.sent.max(log.oldest());
            // Whole blocks while it runs, the rest at its end.
            let running = control.status().state == RunState::Running;
            let waiting = log.next().saturating_sub(self.sent);
            let ready = waiting >= LOG_SAMPLES as u32 || (!running && waiting > 0);
            (ready && log.run() == self.run).then(|| log.block(self.sent, u32::MAX)).flatten()
        });
        let Some(block) = block else { return false };
        self.sent += block.samples.len() as u32;
        outbox.post(0, FromBoard::Log(block), &mut working(control))
    }

    fn send_again<H: Hardware>(&mut self, outbox: &mut Outbox, control: &Shared<H>) -> bool {
        let Some(again) = self.again.front_mut() else { return false };
        let id = again.id;
        let most = (again.last - again.first).min(AGAIN_SAMPLES);
        let message = match with(control, |control| control.log().block(again.first, most)) {
            Some(block) => {
                again.first += block.samples.len() as u32;
                FromBoard::Log(block)
            }
            None => {
                // Skip what is gone, say so, and go on with what is held.
                let held = with(control, |control| (control.log().oldest(), control.log().next()));
                let from = again.first;
                let gone = if from < held.0 { held.0.min(again.last) } else { again.last };
                again.first = gone;
                FromBoard::NotHeld { first: from, count: gone - from }
            }
        };
        if again.first >= again.last {
            self.again.pop_front();
        }
        outbox.post(id, message, &mut working(control))
    }
}
