//! The paper's search beside that of others, on the same records, in one go, one thread each.
//!
//! Arguments: a directory to work in, a Python with scipy, pygad, pymoo and DEAP, and Octave with its control
//! package. `cargo xtask peers` provides all three.

mod outside;
mod peak;
mod rust_ga;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use motorlens::paper::sines;
use motorlens::search::dispatch::Level;
use motorlens::search::{GaOptions, Records, STARTS, Start, fast_on, genetic_on};
use motorlens_peers::clock;
use motorlens_peers::peer::{FACTOR, Peer};

/// Seeds that the fast search is held against the genetic one on.
const SEEDS: u64 = 60;

fn main() -> Result<()> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [directory, python, octave] = &arguments[..] else {
        anyhow::bail!("usage: motorlens-peers DIRECTORY PYTHON OCTAVE (see cargo xtask peers)");
    };
    println!("{}; {}", processor(), Level::best().name());
    kernels();
    for rate in [100, 1000] {
        searches(rate, directory, python, octave)?;
    }
    Ok(())
}

fn processor() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|line| line.strip_prefix("model name")).unwrap_or(": unknown processor");
    name.trim_start_matches(['\t', ' ', ':']).to_owned()
}

fn kernels() {
    let peak = peak::multiply_adds();
    println!("\nf32 multiply-adds, measured peak: {:.1} G/s", peak / 1e9);
    for rate in [100, 1000] {
        let seconds = peak::linear_kernel(rate);
        let share = peak::LINEAR_MULTIPLY_ADDS / seconds / peak;
        println!(
            "linear kernel, 3 records at {rate} Hz: {:.4} ns per candidate and sample, {:.1} % of the peak",
            seconds * 1e9,
            100.0 * share
        );
    }
    let (lanes, scalar) = peak::nonlinear_kernel();
    println!(
        "nonlinear kernel (dead zone, Stribeck friction, gravity): {:.2} ns in lanes, {:.1} ns as scalar f64: {:.1} x",
        lanes * 1e9,
        scalar * 1e9,
        scalar / lanes
    );
}

fn searches(rate: u32, directory: &Path, python: &Path, octave: &Path) -> Result<()> {
    let records = sines::records(rate);
    let prepared = Records::new(&records, Level::best())?;
    let samples = prepared.samples();
    let centre = sines::motor();
    let start = Start::Logarithmic { centre, factor: FACTOR };
    println!("\n{samples} samples, 80 x 800");

    // A neighbour on the same core comes and goes: our runs stand between those of the others.
    let mut runs = Vec::new();
    ours(&prepared, &start, &mut runs);
    let mut peers = vec![rust_ga::run(&records, &centre)];
    let file = outside::write(directory, &records, &centre)?;
    let file = file.to_str().context("the path is not UTF-8")?;
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let script = |name: &str| here.join(name).to_str().map(str::to_owned).context("the path is not UTF-8");
    for package in ["scipy", "pygad", "pymoo", "deap"] {
        ours(&prepared, &start, &mut runs);
        peers.extend(outside::run(python, &[&script("peers.py")?, file, package])?);
    }
    ours(&prepared, &start, &mut runs);
    let few = if rate > 100 { "2" } else { "10" };
    peers.extend(outside::run(octave, &["--no-gui", "--quiet", &script("octave_peer.m")?, file, few])?);

    runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let (ours, median) = (&runs[0], runs[runs.len() / 2].seconds);
    println!("motorlens ga: fastest of {} runs {:.4} s, median {median:.4} s", runs.len(), ours.seconds);
    println!(
        "| search | CPU s, whole run | x | x our median | evaluations | x per evaluation | IAE | |\n\
         |---|---|---|---|---|---|---|---|"
    );
    for peer in std::iter::once(ours).chain(&peers) {
        // Octave does a few evaluations only: its run is extrapolated to as many as the others make.
        let seconds = if peer.remark.is_empty() { peer.seconds } else { peer.seconds_of_the_run() };
        println!(
            "| {} | {seconds:.3} | {:.1} | {:.1} | {} | {:.1} | {:.6} | {} |",
            peer.name,
            seconds / ours.seconds,
            seconds / median,
            peer.evaluations,
            peer.seconds_of_the_run() / ours.seconds_of_the_run(),
            peer.iae,
            peer.remark
        );
    }
    fast(&prepared, &start, ours);
    threads(&prepared, &start);
    Ok(())
}

/// Seeds of our own search that are run before each of the others.
const BETWEEN: u64 = 8;

fn ours(records: &Records, start: &Start, runs: &mut Vec<Peer>) {
    for seed in 1..=BETWEEN {
        let began = clock::processor_seconds();
        let options = GaOptions { seed, ..GaOptions::default() };
        let result = genetic_on(records, start, &options, &mut |_, _| ());
        runs.push(Peer {
            name: "motorlens ga".to_owned(),
            seconds: clock::processor_seconds() - began,
            evaluations: result.evaluations,
            iae: result.iae,
            remark: String::new(),
        });
    }
}

fn fast(records: &Records, start: &Start, ga: &Peer) {
    let results: Vec<_> = (0..SEEDS).map(|seed| fast_on(records, start, STARTS, seed)).collect();
    let mut seconds: Vec<f64> = results.iter().map(|r| r.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    let median = seconds[seconds.len() / 2];
    let same = results.iter().filter(|r| (r.iae / ga.iae - 1.0).abs() < 1e-3).count();
    println!(
        "fast: {:.2} ms (median of {SEEDS} seeds), {:.0} x faster than ga; IAE within 0.1 % of ga's in {same} of {SEEDS}",
        median * 1e3,
        ga.seconds / median
    );
}

fn threads(records: &Records, start: &Start) {
    let (mut one, mut two) = (f64::INFINITY, f64::INFINITY);
    for seed in 1..=BETWEEN {
        let run = |threads| {
            let options = GaOptions { seed, threads, ..GaOptions::default() };
            genetic_on(records, start, &options, &mut |_, _| ()).seconds
        };
        (one, two) = (one.min(run(1)), two.min(run(2)));
    }
    println!("two threads: {:.2} x one (wall time, fastest of {BETWEEN} each)", one / two);
}
