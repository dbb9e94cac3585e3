//! The host's side of USB: it finds the board on the bus, makes it a serial line and carries packets both ways (Universal Serial Bus
//! Specification 2.0, chapter 9; RP2350 data sheet 12.7.3, the memory of two ports).

use std::collections::VecDeque;

use crate::chip::Chip;

/// The memory, and in it the control of the buffers: four bytes each, of every endpoint its IN before its OUT.
const MEMORY: u32 = 0x5010_0000;
const BUFFERS: u32 = MEMORY + 0x80;
/// Endpoint 0's data.
const CONTROL_DATA: u32 = MEMORY + 0x100;
/// A buffer's control: how long it is, whose it is (the controller's), refused, its number modulo 2, whether something is in it.
const LENGTH: u32 = 0x3ff;
const AVAILABLE: u32 = 1 << 10;
const STALL: u32 = 1 << 11;
const PID: u32 = 1 << 13;
const FULL: u32 = 1 << 15;
/// Bytes of a packet at most.
const PACKET: usize = 64;
/// Buffers of endpoint 0.
const CONTROL_IN: u32 = 0;
const CONTROL_OUT: u32 = 1;

/// What a host asks of a serial device, in turn: what it is, that it take an address, what it has, that it be on, that a program is there.
const REQUESTS: [[u8; 8]; 5] = [
    [0x80, 6, 0, 1, 0, 0, 18, 0],
    [0x00, 5, 7, 0, 0, 0, 0, 0],
    [0x80, 6, 0, 2, 0, 0, 255, 0],
    [0x00, 9, 1, 0, 0, 0, 0, 0],
    [0x21, 0x22, 3, 0, 0, 0, 0, 0],
];
/// Of them the one whose answer holds the endpoints.
const CONFIGURATION: usize = 2;
/// In that answer: an endpoint's part, and one that carries bulk data.
const ENDPOINT: u8 = 5;
const BULK: u8 = 2;

/// How far it is.
#[derive(Clone, Copy)]
enum Stage {
    /// No device on the bus.
    Alone,
    /// About to ask, by [`REQUESTS`].
    Ask(usize),
    /// The answer's data come.
    Data(usize),
    /// The end of the request is confirmed.
    Confirm(usize),
    /// The line is open.
    Open,
}

/// A host with a program at its serial line.
pub struct Host {
    stage: Stage,
    answer: Vec<u8>,
    /// The line's endpoints, IN and OUT, and of which number modulo 2 their next packets are.
    line: [(u32, u32); 2],
    /// What the board has said.
    pub received: Vec<u8>,
    /// What it is to be told.
    pub sending: VecDeque<u8>,
}

impl Default for Host {
    fn default() -> Self {
        Self {
            stage: Stage::Alone,
            answer: Vec::new(),
            line: [(0, 0); 2],
            received: Vec::new(),
            sending: VecDeque::new(),
        }
    }
}

impl Host {
    /// A packet each way, where there is one and the board has room.
    pub fn turn(&mut self, chip: &mut Chip) {
        if !chip.beside.usb.present() {
            // Off the bus: what was under way is lost.
            self.sending.clear();
            self.stage = Stage::Alone;
            return;
        }
        if chip.beside.usb.unseen() {
            return;
        }
        match self.stage {
            Stage::Alone => {
                chip.beside.usb.reset_bus();
                self.stage = Stage::Ask(0);
            }
            Stage::Ask(number) => {
                for (at, word) in (MEMORY..).step_by(4).zip(REQUESTS[number].chunks_exact(4)) {
                    chip.write(at, u32::from_le_bytes(word.try_into().expect("four bytes")));
                }
                chip.beside.usb.set_up();
                self.answer.clear();
                self.stage = if REQUESTS[number][0] & 0x80 == 0 {
                    Stage::Confirm(number)
                } else {
                    Stage::Data(number)
                };
            }
            Stage::Data(number) => {
                let Some(packet) = take(chip, CONTROL_IN, CONTROL_DATA) else { return };
                self.answer.extend(&packet);
                let whole = self.answer.len() >= REQUESTS[number][6].into() || packet.len() < PACKET;
                if whole {
                    self.stage = Stage::Confirm(number);
                }
            }
            Stage::Confirm(number) => {
                // By an empty packet against the data's direction.
                let confirmed = if REQUESTS[number][0] & 0x80 == 0 {
                    take(chip, CONTROL_IN, CONTROL_DATA).map(|packet| assert!(packet.is_empty())).is_some()
                } else {
                    give(chip, CONTROL_OUT, CONTROL_DATA, &[])
                };
                if confirmed {
                    self.confirmed(number);
                }
            }
            Stage::Open => self.carry(chip),
        }
    }

    fn confirmed(&mut self, number: usize) {
        if number == CONFIGURATION {
            self.line = endpoints(&self.answer).map(|endpoint| (endpoint, 0));
        }
        self.stage = if number + 1 < REQUESTS.len() { Stage::Ask(number + 1) } else { Stage::Open };
    }

    fn carry(&mut self, chip: &mut Chip) {
        let [(from, number), (to, next)] = &mut self.line;
        let buffer = 2 * *from;
        let shown = chip.read(BUFFERS + 4 * buffer) & PID;
        let at = data(chip, buffer);
        if let Some(packet) = take(chip, buffer, at) {
            assert_eq!(shown, *number, "a packet twice, or one lost");
            *number ^= PID;
            self.received.extend(packet);
        }
        let buffer = 2 * *to + 1;
        let packet: Vec<u8> = self.sending.iter().take(PACKET).copied().collect();
        let wanted = chip.read(BUFFERS + 4 * buffer) & PID;
        let at = data(chip, buffer);
        if !packet.is_empty() && give(chip, buffer, at, &packet) {
            assert_eq!(wanted, *next, "the board waits for another packet");
            *next ^= PID;
            self.sending.drain(..packet.len());
        }
    }
}

/// Where an endpoint's data are: its control stands before the buffers', of endpoint 1 first.
fn data(chip: &mut Chip, buffer: u32) -> u32 {
    MEMORY + (chip.read(MEMORY + 4 * buffer) & 0xffc0)
}

/// Takes what the device has put into a buffer at `data`; nothing where it has not.
fn take(chip: &mut Chip, buffer: u32, data: u32) -> Option<Vec<u8>> {
    let at = BUFFERS + 4 * buffer;
    let control = chip.read(at);
    assert_eq!(control & STALL, 0, "the device refuses");
    if control & AVAILABLE == 0 {
        return None;
    }
    let length = (control & LENGTH) as usize;
    let words = (data..).step_by(4).take(length.div_ceil(4));
    let mut packet: Vec<u8> = words.flat_map(|at| chip.read(at).to_le_bytes()).collect();
    packet.truncate(length);
    chip.write(at, control & !(AVAILABLE | FULL));
    chip.beside.usb.done(buffer);
    Some(packet)
}

/// Puts a packet into a buffer at `data`, where the device waits for one.
fn give(chip: &mut Chip, buffer: u32, data: u32, packet: &[u8]) -> bool {
    let at = BUFFERS + 4 * buffer;
    let control = chip.read(at);
    if control & AVAILABLE == 0 {
        return false;
    }
    for (at, bytes) in (data..).step_by(4).zip(packet.chunks(4)) {
        let mut word = [0; 4];
        word[..bytes.len()].copy_from_slice(bytes);
        chip.write(at, u32::from_le_bytes(word));
    }
    chip.write(at, control & !(AVAILABLE | LENGTH) | FULL | packet.len() as u32);
    chip.beside.usb.done(buffer);
    true
}

/// The endpoints that carry bulk data, IN and OUT, of a device's description of itself.
fn endpoints(description: &[u8]) -> [u32; 2] {
    let mut found = [0; 2];
    let mut rest = description;
    while let [length, kind, ..] = *rest {
        if kind == ENDPOINT && rest[3] & 3 == BULK {
            found[usize::from(rest[2] & 0x80 == 0)] = u32::from(rest[2] & 0xf);
        }
        rest = rest.get(usize::from(length).max(1)..).unwrap_or_default();
    }
    assert!(!found.contains(&0), "no serial line: {description:02x?}");
    found
}
