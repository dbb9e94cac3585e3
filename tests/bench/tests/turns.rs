//! How long the main loop takes: it says often enough that it works, whatever the line brings and however slow the core is.

use std::time::Duration;

use motorlens::device::{Capture, Captured};
use motorlens_bench::bench::{self, Remote, Scene};
use motorlens_bench::cable::Cable;
use motorlens_bench::machine::{self, CORE_HZ};
use motorlens_bench::plant::Plant;
use motorlens_bench::remote::Session;
use motorlens_bench::terminal;
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{Cause, MAX_PROTECTED, Setup, encode_protected};
use motorlens_virtual_motor::{Motor, VirtualMotor};

/// Pessimistic: the flash's wait states.
const SLOW: u64 = 47_000_000;
/// The sampling interrupt takes the loop for one that hangs after 800 us without a piece of work: it sleeps for 500 of them at most.
const PIECE_US: u32 = 600;
/// And when a turn takes 50 ms.
const TURN_US: u32 = 20_000;

/// A host, and a frame of the greatest length that is damaged, again and again.
struct Babbling {
    session: Session,
    frame: Vec<u8>,
    every: Option<Duration>,
    next: Duration,
}

/// Long, and with so many symbols wrong beside those that are seen to be lost. There are 88 symbols of parity: with fourteen wrong ones just enough is
/// left to mend it, and nothing takes the receiver longer; with twenty it is damaged beyond repair.
fn damaged(wrong: usize) -> Vec<u8> {
    const LOST: usize = 60;
    let mut out = [0; MAX_PROTECTED];
    let mut frame = encode_protected(&&[0x5a_u8; 156][..], &mut out).expect("it fits").to_vec();
    // A symbol is two bytes.
    for place in 0..LOST + wrong {
        frame[6 * place] ^= if place < LOST { 0x01 } else { 0x03 };
    }
    frame
}

impl Remote for Babbling {
    fn turn(&mut self, now: Duration, received: &[u8], send: &mut Vec<u8>, scene: &mut Scene) -> bool {
        if let Some(every) = self.every
            && now >= self.next
        {
            self.next = now + every;
            send.extend(&self.frame);
        }
        self.session.turn(now, received, send, scene)
    }
}

/// What the board says of its main loop, us: from one piece of work to the next, and a turn.
fn longest(told: &[u8]) -> [u32; 2] {
    let messages = terminal::messages(&machine::image(), told);
    let said = messages.iter().find_map(|message| message.strip_prefix("info: main loop: "));
    let said = said.unwrap_or_else(|| panic!("nothing of the main loop: {messages:#?}"));
    let mut numbers = said.split(' ').filter_map(|word| word.parse().ok());
    [(); 2].map(|()| numbers.next().unwrap_or_else(|| panic!("two numbers: {said}")))
}

fn run(rate: u64, bad: f64, frame: Vec<u8>, every: Option<Duration>) -> (Captured, [u32; 2]) {
    let setup = Setup { divider: 1100, amplifier: 1650, ..Setup::default() };
    let shape = Shape::Multisine { amplitude_v: 9.0, low_hz: 0.2, high_hz: 8.0, tones: 8, seed: 2 };
    let capture = Capture::new(setup, &Programme::single("multisine", shape, 2.0), 1);
    let session = Session::new(capture, Duration::from_secs(20), Box::new(|_, _, _| ()));
    let plant = Plant::new(VirtualMotor::new(&Motor::paper(), &[], 3), setup.drive);
    let remote = Babbling { session, frame, every, next: Duration::ZERO };
    let done = bench::run(&machine::image(), rate, plant, Cable::new(bad, 5), remote);
    machine::assert_clean(&done.session);
    (done.remote.session.run().clone(), longest(&done.scene.told))
}

#[test]
fn the_main_loop_says_often_enough_that_it_works() {
    let every = Some(Duration::from_millis(20));
    for rate in [CORE_HZ, SLOW] {
        for (bad, wrong, every) in [(0.0, 20, None), (0.1, 20, None), (0.1, 20, every), (0.0, 14, every)] {
            let (captured, [piece, turn]) = run(rate, bad, damaged(wrong), every);
            println!(
                "{rate} instructions a second, {bad} spoiled, {wrong} wrong {every:?}: {piece} us, a turn {turn} us"
            );
            assert_eq!((captured.cause, captured.samples.len()), (Cause::Finished, 2000));
            assert!(
                piece < PIECE_US && turn < TURN_US,
                "{rate}, {bad}, {wrong}, {every:?}: {piece} us, {turn} us"
            );
        }
    }
}
