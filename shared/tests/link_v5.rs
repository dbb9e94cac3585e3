//! The bytes of version 5: a shaft that still turns is why a run has not begun.

mod frames;

use frames::golden;
use motorlens_shared::link::{Cause, FromBoard, Reset, RunState, Status};

#[test]
fn the_cause_of_a_run_that_has_not_begun_keeps_its_bytes() {
    let status = Status {
        state: RunState::Stopped(Cause::Turning),
        run: 9,
        oldest: 0,
        next: 0,
        missed: 0,
        kept: 0,
        damaged: 0,
        reset: Reset::PowerOn,
        worst_cycles: 2900,
    };
    golden(FromBoard::Status(status), "07ac0207020909010101010107d416507bede800");
}
