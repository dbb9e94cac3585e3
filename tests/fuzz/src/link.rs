//! What every input of the link's decoders, host's and board's, has to bear: it never ends them, what is read can be sent again, and
//! after one terminator the next message is heard.

use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{
    Cause, Decoder, FromBoard, LogBlock, MAX_ENCODED, MAX_FRAME, Packet, Reset, RunState, Sample, Setup,
    Status, ToBoard, decode, encode, encode_as,
};
use motorlens_shared::quickfit::Request;
use serde::de::DeserializeOwned;
use serde::ser::SerializeTuple;
use serde::{Serialize, Serializer};

/// Bytes as they stand: what a faulty end would frame rightly.
struct Raw<'a>(&'a [u8]);

impl Serialize for Raw<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut bytes = serializer.serialize_tuple(self.0.len())?;
        self.0.iter().try_for_each(|byte| bytes.serialize_element(byte))?;
        bytes.end()
    }
}

/// The first byte says who hears the rest, 0 the board and 1 the host, and what the rest is: 0 the line's own bytes, 2 a message in a plain
/// frame, 4 in a protected one.
pub fn hear(input: &[u8]) {
    let Some((way, content)) = input.split_first() else { return };
    let line = match way & 0b110 {
        0b010 => framed(content, false),
        0b100 => framed(content, true),
        _ => Some(content.to_vec()),
    };
    match line {
        Some(line) if way & 1 == 0 => heard(&line, ToBoard::Stop),
        Some(line) => heard(&line, FromBoard::Done),
        // Longer than a frame.
        None => {}
    }
}

fn framed(content: &[u8], protected: bool) -> Option<Vec<u8>> {
    let mut out = [0; MAX_FRAME];
    encode_as(&Raw(content), protected, &mut out, &mut || ()).ok().map(<[u8]>::to_vec)
}

fn heard<M: Serialize + DeserializeOwned>(line: &[u8], next: M) {
    let mut decoder = Decoder::new();
    for byte in line {
        if let Some(Ok(packet)) = decoder.push::<Packet<M>>(*byte) {
            sent_again(&packet);
        }
    }
    if let Some(Ok(packet)) = decoder.push::<Packet<M>>(0) {
        sent_again(&packet);
    }
    let mut out = [0; MAX_ENCODED];
    let frame = encode(&Packet { id: 1, message: next }, &mut out).expect("a short message fits");
    let read = frame.iter().find_map(|byte| decoder.push::<Packet<M>>(*byte));
    assert!(read.is_some_and(|packet| packet.is_ok()), "not in step after a terminator");
}

fn sent_again<M: Serialize + DeserializeOwned>(packet: &Packet<M>) {
    let mut out = [0; MAX_ENCODED];
    let sent = encode(packet, &mut out).expect("what was read can be sent").to_vec();
    let back = decode::<Packet<M>>(&sent[..sent.len() - 1]).expect("and read again");
    // By their bytes: a number that is none is not equal to itself.
    assert_eq!(encode(&back, &mut out).expect("and sent once more"), sent);
}

/// Messages in both directions, as the line has them, framed and to be framed.
pub fn seeds() -> Vec<Vec<u8>> {
    let shape = Shape::Multisine { amplitude_v: 9.0, low_hz: 0.2, high_hz: 8.0, tones: 8, seed: 2 };
    let programme = Programme::single("seed", shape, 1.0);
    let (name, segment) = (programme.name.clone(), programme.segments[0].clone());
    let sample = Sample { duty: -2100, count: -70_000, supply_mv: 12_000, current_ma: -900, late_us: -3 };
    let status = Status {
        state: RunState::Stopped(Cause::Turning),
        run: 9,
        oldest: 4000,
        next: 5024,
        missed: 0,
        kept: 1004,
        damaged: 12,
        reset: Reset::Watchdog,
        worst_cycles: 2900,
    };
    let to_board = [
        ToBoard::Hello { oldest: 1, newest: 5 },
        ToBoard::Configure(Setup::default()),
        ToBoard::SetSegment { index: 0, name: name.clone(), segment },
        ToBoard::ReadLog { first: 59_000, count: 64 },
        ToBoard::QuickFit(Request::default()),
    ];
    let from_board = [
        FromBoard::EffectName(name),
        FromBoard::Log(LogBlock {
            run: 9,
            first: 59_992,
            samples: [sample, Sample::MISSED].into_iter().collect(),
        }),
        FromBoard::Status(status),
        FromBoard::Fit(None),
    ];
    let mut seeds = Vec::new();
    to_board.into_iter().for_each(|message| seed(0, message, &mut seeds));
    from_board.into_iter().for_each(|message| seed(1, message, &mut seeds));
    seeds
}

fn seed<M: Serialize>(who: u8, message: M, seeds: &mut Vec<Vec<u8>>) {
    let packet = Packet { id: 77, message };
    let mut out = [0; MAX_FRAME];
    let plain = encode_as(&packet, false, &mut out, &mut || ()).expect("it fits").to_vec();
    let protected = encode_as(&packet, true, &mut out, &mut || ()).expect("it fits").to_vec();
    // Stuffing and sum taken off, the message alone.
    let mut message = plain.clone();
    let stuffed = message.len() - 1;
    let length = unstuffed(&mut message[..stuffed]) - 4;
    seeds.push([&[who], plain.as_slice()].concat());
    seeds.push([&[who], protected.as_slice()].concat());
    seeds.push([&[who | 0b010], &message[..length]].concat());
    seeds.push([&[who | 0b100], &message[..length]].concat());
}

/// Takes the byte stuffing (COBS) off in place, of a frame shorter than 254 bytes; the length that is left.
fn unstuffed(frame: &mut [u8]) -> usize {
    let mut next = usize::from(frame[0]);
    for at in 1..frame.len() {
        if at == next {
            next += usize::from(frame[at]);
            frame[at - 1] = 0;
        } else {
            frame[at - 1] = frame[at];
        }
    }
    frame.len() - 1
}
