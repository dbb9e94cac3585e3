//! The fit on the emulated Cortex-M4F: in time, and bit for bit the host's.

use std::time::Duration;

use motorlens::device::{Capture, Inquiry};
use motorlens_bench::bench;
use motorlens_bench::cable::Cable;
use motorlens_bench::machine;
use motorlens_bench::plant::Plant;
use motorlens_bench::remote::Session;
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{FromBoard, Setup, ToBoard};
use motorlens_shared::quickfit::{Float, Keeper, QuickFit, Request, fit};
use motorlens_virtual_motor::{Effect, Motor, VirtualMotor};

/// Captures a multisine, fits on the board, fits the same log on the host.
fn both(effects: &[Effect], seconds: f32, keep_every: u16, request: Request) -> (QuickFit, QuickFit) {
    let setup = Setup { keep_every, ..Setup::default() };
    let shape = Shape::Multisine { amplitude_v: 9.0, low_hz: 0.2, high_hz: 8.0, tones: 8, seed: 2 };
    let capture = Capture::new(setup, &Programme::single("multisine", shape, seconds), 1);
    let session = Session::new(capture, Duration::from_secs(30), Box::new(|_, _, _| ()))
        .then(Inquiry::new([ToBoard::QuickFit(request)]));
    let plant = Plant::new(VirtualMotor::new(&Motor::paper(), effects, 3), setup.drive);
    let done = bench::run_at_full_rate(&machine::image(), plant, Cable::new(0.0, 1), session);
    machine::assert_clean(&done.session);
    let run = done.remote.run();
    let mut keeper = Keeper::new(run.scaling, keep_every);
    run.samples.iter().for_each(|(_, sample)| keeper.push(sample));
    let host =
        fit::<Float>(keeper.samples(), keeper.step_s(), &request, |_| (), || ()).expect("the host fits");
    let answers = done.remote.answers.expect("the board answers").expect("the board fits");
    let Some(FromBoard::Fit(Some(board))) = answers.last() else { panic!("no fit: {answers:?}") };
    (*board, host)
}

#[test]
fn board_and_host_fit_the_same_log_to_the_same_bits_within_three_tenths_of_a_second() {
    let request = Request { rad_per_count: 0.001, ..Request::default() };
    let (board, host) = both(&[], 5.0, 5, request);
    println!(
        "16 x 40 on {} samples: search {} us, with the polish {} us, {} simulations",
        board.samples, board.micros_search, board.micros, board.evaluations
    );
    assert_eq!(board.samples, 1000);
    assert_eq!(QuickFit { micros: 0, micros_search: 0, ..board }, host);
    // At 84 million instructions a second. The search takes the same for every record; how many simulations the polish adds depends on
    // the record: 40 of them make 0.05 s, and this one takes 80.
    assert!(board.micros_search > 0 && board.micros_search <= 170_000, "{} us", board.micros_search);
    assert!(board.micros <= 300_000, "{} us", board.micros);
}

#[test]
fn with_friction_and_a_full_store_they_agree_as_well() {
    let request = Request { coulomb: true, rad_per_count: 0.001, population: 24, generations: 10, seed: 9 };
    let (board, host) = both(&[Effect::parse("coulomb=0.6").unwrap()], 6.0, 3, request);
    println!("with friction on {} samples: {} us, {:?}", board.samples, board.micros, board.coulomb);
    assert_eq!((board.samples, QuickFit { micros: 0, micros_search: 0, ..board }), (2000, host));
    assert!(board.coulomb.is_some_and(|friction| friction.value > 0.1));
}
