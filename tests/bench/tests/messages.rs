//! What the board says to a debugger: why it started, its runs and their faults, and how long its interrupt takes.

use std::time::Duration;

use motorlens::device::Capture;
use motorlens_bench::bench::{self, Scene, Upset};
use motorlens_bench::cable::Cable;
use motorlens_bench::plant::Plant;
use motorlens_bench::remote::{Hand, Session};
use motorlens_bench::{machine, terminal};
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::Setup;
use motorlens_virtual_motor::{Motor, VirtualMotor};

/// The messages of a run of a second, with a hand on the scene.
fn messages(hand: Hand) -> Vec<String> {
    let setup = Setup::default();
    let triangle = Programme::single("triangle", Shape::Triangle { amplitude_v: 8.0, period_s: 1.0 }, 1.0);
    let plant = Plant::new(VirtualMotor::new(&Motor::paper(), &[], 3), setup.drive);
    let session = Session::new(Capture::new(setup, &triangle, 7), Duration::from_secs(8), hand);
    let done = bench::run_at_full_rate(&machine::image(), plant, Cable::new(0.0, 1), session);
    terminal::messages(&machine::image(), &done.scene.told)
}

fn position(messages: &[String], wanted: &str) -> usize {
    let found = messages.iter().position(|message| message.contains(wanted));
    found.unwrap_or_else(|| panic!("nobody says {wanted:?}: {messages:#?}"))
}

#[test]
fn a_run_is_told_from_the_start_to_the_longest_interrupt() {
    let told = messages(Box::new(|_, _, _| ()));
    let order = [
        "info: motorlens 0.1.0: started, reason: power or the reset pin",
        "info: run 7: begun",
        "info: run 7: finished after 1000 samples",
        "info: longest sampling interrupt so far: ",
    ];
    let places = order.map(|wanted| position(&told, wanted));
    assert!(places.is_sorted(), "{told:#?}");
    let microseconds = told[places[3]].trim_end_matches(" us").rsplit(' ').next().map(str::parse::<u32>);
    assert!(matches!(microseconds, Some(Ok(1..=100))), "{told:#?}");
}

#[test]
fn a_fault_is_an_error_with_its_cause() {
    let told = messages(Box::new(|_, capture: &Capture, scene: &mut Scene| {
        scene.plant.emergency = capture.samples() > 300;
    }));
    let fault = position(&told, "error: run 7: emergency input open after 3");
    assert!(fault > position(&told, "info: run 7: begun"), "{told:#?}");
}

/// The messages where this strikes in the run.
fn messages_after(upset: Upset) -> Vec<String> {
    let mut struck = false;
    messages(Box::new(move |_, capture: &Capture, scene: &mut Scene| {
        if capture.samples() > 300 && !std::mem::replace(&mut struck, true) {
            scene.upset = Some(upset);
        }
    }))
}

#[test]
fn a_restart_after_a_panic_says_so() {
    let told = messages_after(Upset::Panic);
    assert!(position(&told, "started, reason: a panic") > position(&told, "info: run 7: begun"), "{told:#?}");
}

#[test]
fn a_restart_after_a_panic_of_the_main_loop_says_its_place_too() {
    let told = messages_after(Upset::PanicOfMainLoop);
    let place = position(&told, "error: the panic's place: ");
    assert!(place > position(&told, "started, reason: a panic"), "{told:#?}");
    assert!(told[place].contains(".rs line "), "{told:#?}");
}
