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
    /// The numbers under which the fit's progress and result come.
    fit_requests: Vec<u16>,
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
            fit_requests: Vec::new(),
            failed: None,
        }
    }

    /// How far a fit is.
    pub fn progress(&self) -> Option<Progress> {
        self.progress
    }

    /// Takes bytes from the board.
    pub fn receive(&mut self, bytes: &[u8], now: Duration) {
        for packet in self.exchange.receive(bytes) {
            // Another request's fit, answered late, is not this one's.
            let asked_for = self.fit_requests.contains(&packet.id);
            match packet.message {
                FromBoard::Progress(progress) if asked_for => {
                    self.progress = Some(progress);
                    self.fitting = self.fitting.map(|(_, asked)| (now, asked));
                }
                FromBoard::Fit(fit) if asked_for => self.fit = Some(fit),
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
                let fit = matches!(message, ToBoard::QuickFit(_));
                let id = self.exchange.ask(message, now);
                if fit {
                    self.fitting = Some((now, now));
                    self.fit_requests.push(id);
                }
            } else if let (Some((since, asked)), None) = (self.fitting, self.fit) {
                if now.saturating_sub(since) > FIT_PATIENCE {
                    self.failed = Some(Fault::Silent);
                } else if now.saturating_sub(asked) > FIT_ASK {
                    // The result comes unasked, unless its frame was lost.
                    self.fitting = Some((since, now));
                    self.fit_requests.push(self.exchange.tell(ToBoard::ReadResult));
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

#[cfg(test)]
mod tests {
    use super::*;
    use motorlens_shared::link::{Decoder, Hello, MAX_ENCODED, Packet, encode};
    use motorlens_shared::quickfit::Request;

    #[test]
    fn a_fit_that_answers_another_request_is_not_taken_for_this_one() {
        let mut inquiry = Inquiry::new([ToBoard::QuickFit(Request::default())]);
        let mut decoder = Decoder::new();
        let mut now = Duration::ZERO;
        // What the host asks next.
        let mut asked = |inquiry: &mut Inquiry| {
            let mut out = Vec::new();
            now += Duration::from_millis(10);
            inquiry.poll(now, &mut out);
            out.iter()
                .find_map(|byte| decoder.push::<Packet<ToBoard>>(*byte))
                .expect("a request")
                .expect("whole")
        };
        let say = |inquiry: &mut Inquiry, id: u16, message: FromBoard| {
            let mut frame = [0; MAX_ENCODED];
            inquiry.receive(encode(&Packet { id, message }, &mut frame).expect("fits"), Duration::ZERO);
        };
        let hello = Hello { oldest: OLDEST, newest: NEWEST, firmware: [0, 1, 0], unique: [0; 12] };
        let id = asked(&mut inquiry).id;
        say(&mut inquiry, id, FromBoard::Hello(hello));
        let request = asked(&mut inquiry);
        assert!(matches!(request.message, ToBoard::QuickFit(_)));
        say(&mut inquiry, request.id.wrapping_sub(9), FromBoard::Fit(None));
        say(&mut inquiry, request.id, FromBoard::Done);
        inquiry.poll(Duration::from_millis(50), &mut Vec::new());
        assert!(inquiry.take_outcome().is_none(), "the other request's fit");
        say(&mut inquiry, request.id, FromBoard::Fit(None));
        let answers = inquiry.take_outcome().expect("all is there").expect("no fault");
        assert_eq!(answers.last(), Some(&FromBoard::Fit(None)));
    }
}
