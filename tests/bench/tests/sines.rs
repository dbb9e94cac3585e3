//! The excitation keeps its own sine because it is the faster of the two where it is used, and the more accurate.

use std::f64::consts::TAU;
use std::time::Instant;

use micromath::F32Ext;
use motorlens_bench::sines;
use motorlens_shared::excitation::phase::{TURN, sine};

/// The phases of tests/cortex-m4f.
const CALLS: u32 = 4096;
const APART: u32 = 2_654_435_769;

fn micromath(phase: u32) -> f32 {
    F32Ext::sin(phase as i32 as f32 * (core::f32::consts::TAU / TURN as f32))
}

/// The largest distance from the sine in `f64`.
fn error(f: impl Fn(u32) -> f32) -> f64 {
    let apart = |phase: u32| (f64::from(f(phase)) - (TAU * f64::from(phase) / TURN).sin()).abs();
    (0..1_000_000_u32).map(|step| apart(step.wrapping_mul(APART))).fold(0.0, f64::max)
}

/// The sum of the first loop's phases, whose bits the board tells too.
fn sum(f: impl Fn(u32) -> f32) -> u32 {
    (0..CALLS).map(|step| f(step.wrapping_mul(APART))).sum::<f32>().to_bits()
}

/// Nanoseconds of a call on this machine, the fastest of some.
fn nanoseconds(f: impl Fn(u32) -> f32) -> f64 {
    let once = |_| {
        let begin = Instant::now();
        std::hint::black_box(
            (0..1_000_000_u32)
                .map(|step| f(std::hint::black_box(step.wrapping_mul(APART))))
                .fold(0.0_f32, |sum, value| sum + value),
        );
        begin.elapsed().as_secs_f64() * 1e3
    };
    (0..20).map(once).fold(f64::INFINITY, f64::min)
}

#[test]
fn the_excitations_sine_is_faster_on_the_board_than_micromaths_and_thousands_of_times_as_accurate() {
    let board = sines::count(&sines::program());
    let (ours, theirs) = (error(sine), error(micromath));
    println!("ours: {:.2} instructions on the board, largest error {ours:.1e}", board.ours);
    println!("micromath: {:.2} instructions on the board, largest error {theirs:.1e}", board.micromath);
    println!("on this machine: ours {:.2} ns, micromath {:.2} ns", nanoseconds(sine), nanoseconds(micromath));
    assert_eq!(board.sums, [sum(sine), sum(micromath)], "both compute the host's bits on the board");
    assert!(board.ours < board.micromath, "{board:?}");
    assert!(ours < 2.5e-7 && theirs > 1e3 * ours, "errors {ours} and {theirs}");
}
