//! Kernel, searches and diagnosis on the paper's three sines: `cargo bench`.

use divan::{Bencher, black_box};
use motorlens::diagnose::discover::{Options, discover};
use motorlens::motor_file::MotorFile;
use motorlens::paper::sines::{motor, records};
use motorlens::search::dispatch::{LANES, Level};
use motorlens::search::{
    Candidates, GaOptions, Records, STARTS, Start, conventional_on, fast_on, genetic_on,
};
use motorlens::simulate::{Excitation, Scenario, plays};
use motorlens_shared::motor::PaperMotor;
use motorlens_virtual_motor::{Effect, Motor};

fn main() {
    divan::main();
}

fn prepared(rate: u32, level: Level) -> Records {
    Records::new(&records(rate), level).expect("good records")
}

/// 16 candidates on three records.
#[divan::bench(args = [100, 1000])]
fn kernel(bencher: Bencher, rate: u32) {
    let records = prepared(rate, Level::best());
    let mut candidates = Candidates::default();
    records.discretise(&[motor().combinations(); LANES], &mut candidates);
    let mut iae = [0.0; LANES];
    bencher.bench_local(|| records.iae_of(black_box(&candidates), &mut iae));
}

/// The same without vector instructions beyond the architecture's own.
#[divan::bench(args = [100, 1000])]
fn kernel_baseline(bencher: Bencher, rate: u32) {
    let records = prepared(rate, Level::Baseline);
    let mut candidates = Candidates::default();
    records.discretise(&[motor().combinations(); LANES], &mut candidates);
    let mut iae = [0.0; LANES];
    bencher.bench_local(|| records.iae_of(black_box(&candidates), &mut iae));
}

/// 80 chromosomes, 800 generations, one thread.
#[divan::bench(args = [100, 1000], sample_count = 10)]
fn genetic(bencher: Bencher, rate: u32) {
    let records = prepared(rate, Level::best());
    let start = Start::Logarithmic { centre: motor(), factor: 4.0 };
    bencher.bench_local(|| genetic_on(&records, &start, &GaOptions::default(), &mut |_, _| ()));
}

/// Variable projection and simplex.
#[divan::bench(args = [100, 1000])]
fn fast(bencher: Bencher, rate: u32) {
    let records = prepared(rate, Level::best());
    let start = Start::Logarithmic { centre: motor(), factor: 4.0 };
    bencher.bench_local(|| fast_on(&records, &start, STARTS, 1));
}

/// Bounded least squares on eight parameters.
#[divan::bench(args = [100], sample_count = 5)]
fn conventional(bencher: Bencher, rate: u32) {
    let records = prepared(rate, Level::best());
    let start = PaperMotor { resistance: 2.0 * motor().resistance, ..motor() };
    bencher.bench_local(|| conventional_on(&records, &start));
}

/// The whole loop on two records of 8 s at 1 kHz with friction in the gear.
#[divan::bench(sample_count = 3)]
fn diagnosis(bencher: Bencher) {
    let effect = Effect::parse("coulomb=0.4").expect("an effect");
    let scenario = Scenario::new(Motor::paper(), vec![effect], 1);
    let plays = plays(Excitation::Default, 6.0, 12.0, None, 1);
    let records = scenario.records(&plays[..2]).expect("records");
    let motor = MotorFile { gear_ratio: Some(104.0), ..MotorFile::default() };
    bencher.bench_local(|| discover(&records, &[], &motor, &Options::default(), &mut |_| ()));
}
