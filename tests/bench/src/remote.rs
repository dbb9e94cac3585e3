//! Hosts that talk to the board in virtual time.

use std::time::Duration;

use motorlens::device::{Capture, Captured, Fault, Inquiry};
use motorlens_shared::link::FromBoard;

use crate::bench::{Remote, Scene};

/// A hand that does something to the scene as the run goes on.
pub type Hand = Box<dyn FnMut(Duration, &Capture, &mut Scene) + Send>;

/// Captures a run, then asks further things.
pub struct Session {
    capture: Capture,
    then: Option<Inquiry>,
    hand: Hand,
    patience: Duration,
    /// What came of the run.
    pub captured: Option<Result<Captured, Fault>>,
    /// What came of the questions.
    pub answers: Option<Result<Vec<FromBoard>, Fault>>,
    /// When the driver was switched off, after having been on.
    pub off_at: Option<Duration>,
    was_driven: bool,
    done_at: Option<Duration>,
}

/// A board that was asked to go elsewhere goes after its last answer, by a reset: so long at most.
const AWAY: Duration = Duration::from_millis(5);

impl Session {
    /// A capture, with a hand on the scene; it must end within `patience` of virtual time.
    pub fn new(capture: Capture, patience: Duration, hand: Hand) -> Self {
        Session {
            capture,
            then: None,
            hand,
            patience,
            captured: None,
            answers: None,
            off_at: None,
            was_driven: false,
            done_at: None,
        }
    }

    /// Asks this after the capture.
    pub fn then(mut self, inquiry: Inquiry) -> Self {
        self.then = Some(inquiry);
        self
    }

    /// The captured run.
    ///
    /// # Panics
    /// When there is none.
    pub fn run(&self) -> &Captured {
        self.captured.as_ref().expect("the capture ended").as_ref().expect("the capture succeeded")
    }
}

impl Remote for Session {
    fn turn(&mut self, now: Duration, received: &[u8], send: &mut Vec<u8>, scene: &mut Scene) -> bool {
        if self.was_driven && !scene.plant.driven() && self.off_at.is_none() {
            self.off_at = Some(now);
        }
        self.was_driven |= scene.plant.driven();
        (self.hand)(now, &self.capture, scene);
        if self.captured.is_none() {
            self.capture.receive(received, now);
            if std::mem::take(&mut scene.interrupt) {
                self.capture.stop(now);
            }
            self.capture.poll(now, send);
            self.captured = self.capture.take_outcome();
        } else if let Some(inquiry) = &mut self.then
            && self.answers.is_none()
        {
            inquiry.receive(received, now);
            inquiry.poll(now, send);
            self.answers = inquiry.take_outcome();
        }
        let done = self.captured.is_some() && (self.then.is_none() || self.answers.is_some());
        let on = if done { scene.led_astray && now < *self.done_at.get_or_insert(now) + AWAY } else { true };
        on && !scene.enough && now < self.patience
    }
}
