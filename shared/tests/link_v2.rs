//! Ends of different ages: a field that one of them has appended and the other does not know. And the bytes of version 2.
//!
//! A version to come has two more fields in `Setup` and in `Status`. Today's end must read its bytes as its own messages; that
//! version must read today's bytes, with its own fields at zero. So have versions 1 and 4 between them, which are both out.

mod frames;

use frames::{golden, sent, unended};
use motorlens_shared::link::{
    Cause, Damage, DriveMode, FromBoard, Packet, Reset, RunState, Setup, Status, ToBoard, decode,
};
use serde::{Deserialize, Serialize};

/// A packet of the version to come, as far as this variant.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Later<M> {
    id: u16,
    variant: u8,
    message: M,
    number: u32,
    flag: bool,
}

const CONFIGURE: &str = "06ac0203e8070ce05de807c0a907a01ff40304f4030501010538da768b00";
const LATER_CONFIGURE: &str = "06ac0203e8070ce05de807c0a907a01ff40304f40305010108807d01b18c831900";
const STATUS: &str = "0bac0207020309a01fa0270bec070c01d41688180db500";
const LATER_STATUS: &str = "0bac0207020309a01fa0270dec070c01d4160701782e378500";

fn status(cause: Cause, reset: Reset) -> Status {
    Status {
        state: RunState::Stopped(cause),
        run: 9,
        oldest: 4000,
        next: 5024,
        missed: 0,
        kept: 1004,
        damaged: 12,
        reset,
        worst_cycles: 2900,
    }
}

/// `Configure` and `Status` of the version to come.
fn later(number: [u32; 2], flag: bool) -> (Later<Setup>, Later<Status>) {
    let [of_setup, of_status] = number;
    (
        Later { id: 300, variant: 3, message: Setup::default(), number: of_setup, flag },
        Later {
            id: 300,
            variant: 7,
            message: status(Cause::Stall, Reset::Watchdog),
            number: of_status,
            flag,
        },
    )
}

/// The same of today, which have their recorded bytes.
fn today() -> (ToBoard, FromBoard) {
    let messages =
        (ToBoard::Configure(Setup::default()), FromBoard::Status(status(Cause::Stall, Reset::Watchdog)));
    golden(messages.0.clone(), CONFIGURE);
    golden(messages.1.clone(), STATUS);
    messages
}

#[test]
fn a_field_that_a_newer_end_has_appended_is_skipped() {
    let (configure, status) = later([16_000, 7], true);
    assert_eq!((sent(&configure).as_str(), sent(&status).as_str()), (LATER_CONFIGURE, LATER_STATUS));
    let (configure, status) = today();
    assert_eq!(decode(&unended(LATER_CONFIGURE)), Ok(Packet { id: 300, message: configure }));
    assert_eq!(decode(&unended(LATER_STATUS)), Ok(Packet { id: 300, message: status }));
}

#[test]
fn a_field_that_an_older_end_does_not_send_reads_as_zero() {
    today();
    let (configure, status) = later([0, 0], false);
    assert_eq!(decode(&unended(CONFIGURE)), Ok(configure));
    assert_eq!(decode(&unended(STATUS)), Ok(status));
}

/// `Configure` as a board of version 1 reads it.
#[derive(Debug, PartialEq, Deserialize)]
struct Version1 {
    id: u16,
    variant: u8,
    rate_hz: u16,
    drive: DriveMode,
    supply_mv: u16,
    duty_limit: u16,
    run_limit_ms: u32,
    stall_mv: u16,
    stall_ms: u16,
    current_limit_ma: u16,
    link_timeout_ms: u16,
    keep_every: u16,
}

#[test]
fn a_board_of_version_1_reads_the_setup_of_version_4_and_skips_what_has_been_appended_since() {
    // The PWM's frequency of version 3, divider and amplifier of version 4; the other way stands in `link_v1.rs`.
    let wired = "06ac0203e8070ce05de807c0a907a01ff4030ef40305807dcc08f20c5c6ee7df00";
    let Setup { rate_hz, drive, supply_mv, duty_limit, run_limit_ms, .. } = Setup::default();
    let Setup { stall_mv, stall_ms, current_limit_ma, link_timeout_ms, keep_every, .. } = Setup::default();
    let read = Version1 {
        id: 300,
        variant: 3,
        rate_hz,
        drive,
        supply_mv,
        duty_limit,
        run_limit_ms,
        stall_mv,
        stall_ms,
        current_limit_ma,
        link_timeout_ms,
        keep_every,
    };
    assert_eq!(decode(&unended(wired)), Ok(read));
}

#[test]
fn a_frame_cut_short_on_the_line_is_still_damage() {
    let frame = unended(CONFIGURE);
    for length in 1..frame.len() {
        let read = decode::<Packet<ToBoard>>(&frame[..length]);
        assert!(matches!(read, Err(Damage::Checksum | Damage::Stuffing)), "{length} bytes: {read:?}");
    }
}

#[test]
fn the_cause_of_version_2_keeps_its_bytes() {
    let stopped = FromBoard::Status(status(Cause::Supply, Reset::PowerOn));
    golden(stopped, "0bac0207020809a01fa02704ec070c07d416807747c200");
}
