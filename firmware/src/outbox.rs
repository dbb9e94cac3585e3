//! Frames on their way out.

use embedded_io::{Write, WriteReady};
use heapless::Deque;
use motorlens_shared::link::{FromBoard, MAX_FRAME, Packet, encode_as};

/// Bytes that may wait for the line.
const LENGTH: usize = 1024;

/// Encoded frames, waiting for the line to take them.
#[derive(Debug, Default)]
pub struct Outbox {
    bytes: Deque<u8, LENGTH>,
    protected: bool,
}

impl Outbox {
    /// An empty box.
    pub const fn new() -> Self {
        Self { bytes: Deque::new(), protected: false }
    }

    /// Frames are protected from now on, or not: as the host's are, which knows whether the line is bad.
    pub fn protect(&mut self, protected: bool) {
        self.protected = protected;
    }

    /// Whether any frame fits.
    pub fn has_room(&self) -> bool {
        LENGTH - self.bytes.len() >= MAX_FRAME
    }

    /// Queues a message; false when it does not fit, and then none of it is queued. A protected one takes long: `progress` is called
    /// meanwhile.
    pub fn post(&mut self, id: u16, message: FromBoard, progress: &mut dyn FnMut()) -> bool {
        let mut out = [0; MAX_FRAME];
        let Ok(frame) = encode_as(&Packet { id, message }, self.protected, &mut out, progress) else {
            return false;
        };
        LENGTH - self.bytes.len() >= frame.len()
            && frame.iter().all(|byte| self.bytes.push_back(*byte).is_ok())
    }

    /// Gives the line what it takes without waiting.
    pub fn pump<L: Write + WriteReady>(&mut self, line: &mut L) {
        while !self.bytes.is_empty() && line.write_ready().unwrap_or(false) {
            let taken = line.write(self.bytes.as_slices().0).unwrap_or(0);
            if taken == 0 {
                return;
            }
            for _ in 0..taken {
                self.bytes.pop_front();
            }
        }
    }
}
