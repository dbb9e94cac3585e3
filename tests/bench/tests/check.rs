//! `device check` on a board that is wired wrongly: each mistake is named, and nothing beside it.

use std::time::Duration;

use motorlens::device::Capture;
use motorlens::device::check::{Checked, check, programme, setup};
use motorlens_bench::bench;
use motorlens_bench::cable::Cable;
use motorlens_bench::encoder::Mistake;
use motorlens_bench::machine;
use motorlens_bench::plant::Plant;
use motorlens_bench::remote::Session;
use motorlens_shared::link::Setup;
use motorlens_virtual_motor::{Motor, VirtualMotor};

/// The check as `device check --divider 11` makes it, with what is done to the plant beforehand.
fn checked(wire: impl FnOnce(&mut Plant)) -> Checked {
    let setup = setup(Setup { divider: 1100, ..Setup::default() });
    let mut plant = Plant::new(VirtualMotor::new(&Motor::paper(), &[], 3), setup.drive);
    wire(&mut plant);
    let capture = Capture::new(setup, &programme(6.0), 1);
    let session = Session::new(capture, Duration::from_secs(20), Box::new(|_, _, _| ()));
    let done = bench::run_at_full_rate(&machine::image(), plant, Cable::new(0.0, 1), session);
    machine::assert_clean(&done.session);
    check(done.remote.run())
}

/// What is wrong after this mistake.
fn wrong(mistake: Mistake) -> Vec<&'static str> {
    named(&checked(|plant| plant.mistake = Some(mistake)))
}

fn named(checked: &Checked) -> Vec<&'static str> {
    let wrong = checked.findings.iter().filter(|finding| !finding.ok);
    let named: Vec<_> = wrong.map(|finding| finding.check).collect();
    assert_eq!(checked.ok, named.is_empty(), "{checked:?}");
    named
}

#[test]
fn a_board_that_is_wired_right_has_nothing_wrong() {
    let checked = checked(|_| ());
    assert_eq!(named(&checked), [""; 0], "{checked:?}");
    assert!(checked.breakaway_v.iter().all(Option::is_some), "{checked:?}");
}

#[test]
fn swapped_lines_of_the_encoder_count_against_the_voltage() {
    assert_eq!(wrong(Mistake::SwappedLines), ["encoder_sign"]);
}

#[test]
fn a_line_of_the_encoder_that_does_not_arrive_leaves_a_count_that_flickers() {
    assert_eq!(wrong(Mistake::MissingLine), ["encoder_lines"]);
}

#[test]
fn an_encoder_without_its_supply_and_a_driver_without_it_leave_the_count_frozen() {
    assert_eq!(named(&checked(|plant| plant.jammed = true)), ["motion"]);
    assert_eq!(wrong(Mistake::DeadDriver), ["motion"]);
}

#[test]
fn a_wire_of_a_direction_that_does_not_arrive_leaves_half_of_the_bridge() {
    assert_eq!(wrong(Mistake::NoForward), ["direction"]);
}

#[test]
fn a_divider_that_is_not_there_ends_the_run_before_the_motor_is_driven() {
    let checked = checked(|plant| plant.mistake = Some(Mistake::NoDivider));
    assert_eq!(named(&checked), ["run", "supply"]);
}
