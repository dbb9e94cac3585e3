//! Ends of different ages: a field that one of them has appended and the other does not know.
//!
//! The bytes are those of a version to come whose `Status` and `Setup` have two more fields. Today's end must read them as
//! its own message; that version must read today's bytes, with its own fields at zero.

use motorlens_shared::link::{
    Cause, Damage, FromBoard, MAX_ENCODED, Packet, Reset, RunState, Setup, Status, ToBoard, decode, encode,
};
use serde::{Deserialize, Serialize};

/// `Packet<ToBoard>` of the version to come, as far as `Configure`, its fourth variant.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Later {
    id: u16,
    variant: u8,
    setup: Setup,
    dither_hz: u32,
    quiet: bool,
}

fn bytes(frame: &str) -> Vec<u8> {
    (0..frame.len() / 2).map(|k| u8::from_str_radix(&frame[2 * k..2 * k + 2], 16).unwrap()).collect()
}

fn hex(frame: &[u8]) -> String {
    frame.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn a_field_that_a_newer_end_has_appended_is_skipped() {
    let later = Later { id: 300, variant: 3, setup: Setup::default(), dither_hz: 16_000, quiet: true };
    let mut out = [0; MAX_ENCODED];
    let mut frame = encode(&later, &mut out).unwrap().to_vec();
    frame.pop();
    let today = Packet { id: 300, message: ToBoard::Configure(Setup::default()) };
    assert_eq!(decode::<Packet<ToBoard>>(&frame), Ok(today));
}

#[test]
fn a_field_that_an_older_end_does_not_send_reads_as_zero() {
    // `Configure(Setup::default())` in the bytes of version 1, without its terminator.
    let mut out = [0; MAX_ENCODED];
    let today = Packet { id: 300, message: ToBoard::Configure(Setup::default()) };
    let mut frame = encode(&today, &mut out).unwrap().to_vec();
    frame.pop();
    let later = Later { id: 300, variant: 3, setup: Setup::default(), dither_hz: 0, quiet: false };
    assert_eq!(decode::<Later>(&frame), Ok(later));
}

#[test]
fn a_frame_cut_short_on_the_line_is_still_damage() {
    let mut out = [0; MAX_ENCODED];
    let frame = encode(&Packet { id: 300, message: ToBoard::Configure(Setup::default()) }, &mut out).unwrap();
    for length in 1..frame.len() - 1 {
        let read = decode::<Packet<ToBoard>>(&frame[..length]);
        assert!(matches!(read, Err(Damage::Checksum | Damage::Stuffing)), "{length} bytes: {read:?}");
    }
}

#[test]
fn the_cause_of_version_2_keeps_its_bytes() {
    let status = Status {
        state: RunState::Stopped(Cause::Supply),
        run: 9,
        oldest: 4000,
        next: 5024,
        missed: 0,
        kept: 1004,
        damaged: 12,
        reset: Reset::PowerOn,
        worst_cycles: 2900,
    };
    let packet = Packet { id: 300, message: FromBoard::Status(status) };
    let mut out = [0; MAX_ENCODED];
    let frame = encode(&packet, &mut out).unwrap();
    assert_eq!(&hex(frame)[..16], "0bac020702080 9a0".replace(' ', ""));
    let frame = bytes(&hex(&frame[..frame.len() - 1]));
    assert_eq!(decode::<Packet<FromBoard>>(&frame), Ok(packet));
}
