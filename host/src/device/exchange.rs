//! Requests and answers over a line that may lose or damage any of them.

use super::Fault;
use motorlens_shared::link::{
    Decoder, FromBoard, MAX_FRAME, NEWEST, OLDEST, Packet, Refusal, ToBoard, agree, encode_as,
};
use std::time::Duration;

/// An unanswered request is sent again after this time.
const AGAIN: Duration = Duration::from_millis(250);
/// The board is taken for dead after this time without an answer.
const PATIENCE: Duration = Duration::from_secs(10);
/// So many bytes are kept of a board that speaks otherwise, and after this time they are enough to know that it does.
const HEARD: usize = 240;
const ENOUGH: Duration = Duration::from_secs(3);
/// The first version whose boards read protected frames.
const PROTECTS: u16 = 3;
/// A damaged frame makes up for so many whole ones; where the sum exceeds the limit the line is bad, and frames are protected from
/// then on: where one in nine is damaged, or a few come together.
const DAMAGE: u32 = 8;
const BAD_LINE: u32 = 40;
/// The board stops the motor when it hears nothing for its link timeout; this is how often it hears something.
const KEEP_ALIVE: Duration = Duration::from_millis(50);

struct Pending {
    id: u16,
    message: ToBoard,
    since: Duration,
    sent: Option<Duration>,
}

/// One end of the link: one request at a time, sent until it is answered.
#[derive(Default)]
pub struct Exchange {
    decoder: Decoder,
    id: u16,
    pending: Option<Pending>,
    answer: Option<Result<FromBoard, Fault>>,
    spoke: Duration,
    out: Vec<u8>,
    damaged: u64,
    /// How bad the line has been lately, and whether frames are protected for it.
    trouble: u32,
    protects: bool,
    /// The newest version that the board speaks, once it has told.
    newest: Option<u16>,
    /// The first bytes heard, as long as none of them made a message.
    heard: Vec<u8>,
    understood: bool,
}

impl Exchange {
    /// Asks; the answer comes from [`Self::take_answer`]. One request at a time. Returns the request's number, under which
    /// the board says whatever belongs to it.
    pub fn ask(&mut self, message: ToBoard, now: Duration) -> u16 {
        // 0 is what the board says unasked.
        self.id = self.id.wrapping_add(1).max(1);
        self.answer = None;
        self.pending = Some(Pending { id: self.id, message, since: now, sent: None });
        self.id
    }

    /// Whether a request waits for its answer.
    pub fn busy(&self) -> bool {
        self.pending.is_some()
    }

    /// The answer to the last request, once.
    pub fn take_answer(&mut self) -> Option<Result<FromBoard, Fault>> {
        self.answer.take()
    }

    /// Says something that needs no answer, or whose answer is found otherwise.
    /// Returns its number.
    pub fn tell(&mut self, message: ToBoard) -> u16 {
        self.id = self.id.wrapping_add(1).max(1);
        self.post(self.id, message, self.protects);
        self.id
    }

    /// Frames that arrived damaged.
    pub fn damaged(&self) -> u64 {
        self.damaged
    }

    /// Takes bytes from the board and returns the messages that they complete, answers included, each with the number of the
    /// request that it belongs to (0 is what the board says unasked).
    pub fn receive(&mut self, bytes: &[u8]) -> Vec<Packet<FromBoard>> {
        let mut messages = Vec::new();
        if !self.understood {
            self.heard.extend(bytes.iter().take(HEARD - self.heard.len().min(HEARD)));
        }
        for byte in bytes {
            match self.decoder.push::<Packet<FromBoard>>(*byte) {
                Some(Ok(packet)) => {
                    self.trouble = self.trouble.saturating_sub(1);
                    self.arrived(packet, &mut messages);
                }
                Some(Err(_)) => {
                    self.damaged += 1;
                    self.trouble = self.trouble.saturating_add(DAMAGE);
                }
                None => {}
            }
        }
        self.protects |= self.trouble >= BAD_LINE && self.newest.is_some_and(|newest| newest >= PROTECTS);
        messages
    }

    fn arrived(&mut self, packet: Packet<FromBoard>, messages: &mut Vec<Packet<FromBoard>>) {
        self.understood = true;
        if let FromBoard::Hello(hello) = &packet.message {
            self.newest = Some(hello.newest);
        }
        if packet.message == FromBoard::Refused(Refusal::Version) {
            // The board has started anew since the hello; greet it again and let the request be repeated.
            self.tell(ToBoard::Hello { oldest: OLDEST, newest: NEWEST });
            return;
        }
        if self.pending.as_ref().is_some_and(|pending| pending.id == packet.id) {
            self.pending = None;
            self.answer = Some(match &packet.message {
                FromBoard::Refused(refusal) => Err(Fault::Refused(*refusal)),
                FromBoard::Hello(hello)
                    if agree((OLDEST, NEWEST), (hello.oldest, hello.newest)).is_none() =>
                {
                    Err(Fault::Version(hello.oldest, hello.newest))
                }
                message => Ok(message.clone()),
            });
        }
        messages.push(packet);
    }

    /// Lets time pass, and hands over what is to be sent.
    pub fn poll(&mut self, now: Duration, out: &mut Vec<u8>) {
        if let Some(pending) = &mut self.pending {
            let waited = now.saturating_sub(pending.since);
            let foreign = !self.understood && !self.heard.is_empty();
            if foreign && (waited > PATIENCE || waited > ENOUGH && self.heard.len() >= HEARD) {
                self.pending = None;
                self.answer = Some(Err(Fault::Foreign(std::mem::take(&mut self.heard))));
            } else if waited > PATIENCE {
                self.pending = None;
                self.answer = Some(Err(Fault::Silent));
            } else if pending.sent.is_none_or(|sent| now.saturating_sub(sent) >= AGAIN) {
                let again = pending.sent.replace(now).is_some();
                let (id, message) = (pending.id, pending.message.clone());
                self.post(id, message.clone(), self.protects);
                // Asked in vain: a bad line, perhaps. A board of an older version takes this for one damaged frame more.
                if again && !self.protects && self.newest.is_none_or(|newest| newest >= PROTECTS) {
                    self.post(id, message, true);
                }
            }
        }
        if now.saturating_sub(self.spoke) >= KEEP_ALIVE {
            self.tell(ToBoard::KeepAlive);
        }
        if !self.out.is_empty() {
            self.spoke = now;
            out.append(&mut self.out);
        }
    }

    fn post(&mut self, id: u16, message: ToBoard, protected: bool) {
        // Every message that this program makes fits in a frame: their sizes are bounded by their types.
        if let Ok(frame) = encode_as(&Packet { id, message }, protected, &mut [0; MAX_FRAME], &mut || ()) {
            self.out.extend_from_slice(frame);
        }
    }
}
