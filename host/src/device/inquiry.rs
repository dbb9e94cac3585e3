//! Requests one after the other, and what comes of a fit.

use super::{Exchange, Fault};
use motorlens_shared::link::{FromBoard, NEWEST, OLDEST, ToBoard};
use motorlens_shared::quickfit::{Progress, QuickFit};
use std::collections::VecDeque;
use std::time::Duration;

/// The longest that a fit may keep silent, and how often its result is asked for.
const FIT_PATIENCE: Duration = Duration::from_secs(60);
const FIT_ASK: Duration = Duration::from_secs(1);

/// A hello and further requests.
pub struct Inquiry {
    exchange: Exchange,
    script: VecDeque<ToBoard>,
    answers: Vec<FromBoard>,
    fitting: Option<(Duration, Duration)>,
    progress: Option<Progress>,
    fit: Option<Option<QuickFit>>,
    failed: Option<Fault>,
}

impl Inquiry {
    /// Greets the board, then asks these.
    pub fn new(requests: impl IntoIterator<Item = ToBoard>) -> Self {
        let mut script = VecDeque::from([ToBoard::Hello { oldest: OLDEST, newest: NEWEST }]);
        script.extend(requests);
        Self {
            exchange: Exchange::default(),
            script,
            answers: Vec::new(),
            fitting: None,
            progress: None,
            fit: None,
            failed: None,
        }
    }

    /// How far a fit is.
    pub fn progress(&self) -> Option<Progress> {
        self.progress
    }

    /// Takes bytes from the board.
    pub fn receive(&mut self, bytes: &[u8], now: Duration) {
        for message in self.exchange.receive(bytes) {
            match message {
                FromBoard::Progress(progress) => {
                    self.progress = Some(progress);
                    self.fitting = self.fitting.map(|(_, asked)| (now, asked));
                }
                FromBoard::Fit(fit) => self.fit = Some(fit),
                _ => {}
            }
        }
    }

    /// Lets time pass, and hands over what is to be sent.
    pub fn poll(&mut self, now: Duration, out: &mut Vec<u8>) {
        match self.exchange.take_answer() {
            Some(Err(fault)) => self.failed = Some(fault),
            Some(Ok(answer)) => self.answers.push(answer),
            None => {}
        }
        if self.failed.is_none() && !self.exchange.busy() {
            if let Some(message) = self.script.pop_front() {
                if matches!(message, ToBoard::QuickFit(_)) {
                    self.fitting = Some((now, now));
                }
                self.exchange.ask(message, now);
            } else if let (Some((since, asked)), None) = (self.fitting, self.fit) {
                if now.saturating_sub(since) > FIT_PATIENCE {
                    self.failed = Some(Fault::Silent);
                } else if now.saturating_sub(asked) > FIT_ASK {
                    // The result comes unasked, unless its frame was lost.
                    self.fitting = Some((since, now));
                    self.exchange.tell(ToBoard::ReadResult);
                }
            }
        }
        self.exchange.poll(now, out);
    }

    /// The answers, the hello's first, once all are there; with a fit, once its result is there too.
    pub fn take_outcome(&mut self) -> Option<Result<Vec<FromBoard>, Fault>> {
        if let Some(fault) = self.failed.take() {
            return Some(Err(fault));
        }
        let waiting = self.exchange.busy() || !self.script.is_empty() || self.answers.is_empty();
        if waiting || (self.fitting.is_some() && self.fit.is_none()) {
            return None;
        }
        let mut answers = std::mem::take(&mut self.answers);
        answers.extend(self.fit.take().map(FromBoard::Fit));
        Some(Ok(answers))
    }
}
