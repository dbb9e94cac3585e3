//! Counts instructions on the emulated core and prints `name count` lines: the sampling interrupt at its longest,
//! what the quick fit takes for each candidate and sample, and a sine of the excitation beside micromath's.

use std::path::PathBuf;
use std::time::Duration;

use motorlens::device::{Capture, Inquiry};
use motorlens_bench::bench;
use motorlens_bench::cable::Cable;
use motorlens_bench::machine;
use motorlens_bench::plant::Plant;
use motorlens_bench::remote::Session;
use motorlens_bench::sines;
use motorlens_shared::excitation::Programme;
use motorlens_shared::link::{FromBoard, Setup, ToBoard};
use motorlens_shared::quickfit::Request;
use motorlens_virtual_motor::{Motor, VirtualMotor};

/// Chromosomes that 16 x 40 evaluates: one of 16 passes each generation unchanged.
const CANDIDATES: f64 = 16.0 + 39.0 * 15.0;
/// The core's instructions in a microsecond.
const PER_MICROSECOND: f64 = machine::CORE_HZ as f64 * 1e-6;

/// The default protocol's shapes in 8 s: the interrupt that begins a segment is a long one.
fn every_shape() -> Programme {
    let protocol = Programme::default_protocol(12.0);
    let segments = protocol.training.iter().flat_map(|programme| programme.segments.clone());
    let mut programme = Programme::sequence("every shape", segments).expect("they are few enough");
    let scale = 8.0 / programme.seconds();
    programme.segments.iter_mut().for_each(|segment| segment.seconds *= scale);
    programme
}

fn main() {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let image = arguments.next().expect("the image's ELF is the first argument");
    let program = arguments.next().expect("the sines' program is the second");
    // Both inputs of the converter are wired: their sums are a good part of the interrupt.
    let setup = Setup { keep_every: 4, divider: 1100, amplifier: 1650, ..Setup::default() };
    let capture = Capture::new(setup, &every_shape(), 1);
    let request = Request { rad_per_count: 0.001, ..Request::default() };
    let session = Session::new(capture, Duration::from_secs(30), Box::new(|_, _, _| ()))
        .then(Inquiry::new([ToBoard::QuickFit(request)]));
    let plant = Plant::new(VirtualMotor::new(&Motor::paper(), &[], 3), setup.drive);
    let done = bench::run_at_full_rate(&image, plant, Cable::new(0.0, 1), session);
    machine::assert_clean(&done.session);
    let answers = done.remote.answers.expect("the board answers").expect("the board fits");
    let Some(FromBoard::Fit(Some(fit))) = answers.last() else { panic!("no fit: {answers:?}") };
    let samples = f64::from(fit.samples);
    let search = f64::from(fit.micros_search) * PER_MICROSECOND / (CANDIDATES * samples);
    let polish = f64::from(fit.micros - fit.micros_search) * PER_MICROSECOND
        / ((f64::from(fit.evaluations) - CANDIDATES) * samples);
    println!("interrupt, longest {}", done.scene.longest_interrupt);
    println!("search, per candidate and sample {search:.2}");
    println!("polish, per candidate and sample {polish:.2}");
    let sines = sines::count(&program);
    println!("sine, ours {:.2}", sines.ours);
    println!("sine, micromath {:.2}", sines.micromath);
}
