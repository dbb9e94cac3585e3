//! Works everything out on the host first: the record, its fits, what the decoder makes of spoiled frames, and a run with its fit.

#[path = "src/captured.rs"]
mod captured;
#[path = "src/spoil.rs"]
mod spoil;

use std::path::{Path, PathBuf};
use std::{env, fs};

use motorlens_firmware::log::Log;
use motorlens_firmware::station::Station;
use motorlens_shared::base::{Base, Coefficients};
use motorlens_shared::excitation::{Player, Programme, Shape};
use motorlens_shared::quickfit::{Arithmetic, Fixed, Float, Kept, QuickFit, Request, fit};
use motorlens_shared::step::{Drive, Laws, State, step};

/// Time between samples, s.
const STEP_S: f64 = 5e-3;
/// 1,000 samples.
const SECONDS: f32 = 5.0;
/// Counts per rad of the output shaft.
const COUNTS: f64 = 1000.0;

/// A motor with a little dry friction, an encoder with whole counts.
fn record() -> Vec<Kept> {
    let shape = Shape::Multisine { amplitude_v: 9.0, low_hz: 0.2, high_hz: 8.0, tones: 8, seed: 2 };
    let programme = Programme::single("record", shape, SECONDS);
    let player = Player::new(&programme, (1.0 / STEP_S) as u32).expect("the programme is sound");
    let base = Base { gain: 0.7, tau_m: 0.045, tau_e: 0.0012, viscous_share: 0.0 };
    let coefficients = Coefficients::new(&base, STEP_S);
    let mut state = State::<f64>::rest();
    let mut integral = 0.0;
    let sample = |volts: f32| {
        let kept = [volts, integral as f32, (state.angle * COUNTS).floor() as f32];
        integral += STEP_S * f64::from(volts);
        let drive =
            Drive { friction_forward: 0.05, friction_backward: 0.05, ..Drive::plain(f64::from(volts)) };
        step(&coefficients, Laws { dry: true, ..Laws::default() }, &mut state, &drive);
        kept
    };
    player.map(sample).collect()
}

fn fitted<A: Arithmetic>(record: &[Kept], request: &Request) -> QuickFit {
    fit::<A>(record, STEP_S as f32, request, |_| (), || ()).expect("the host fits")
}

fn bytes(fit: &QuickFit) -> String {
    format!("{:?}", postcard::to_stdvec(fit).expect("numbers alone"))
}

/// A run with its fit, whole.
fn run() -> captured::Captured {
    let run = captured::capture(Box::leak(Box::new(Log::new())), &mut Box::new(Station::new()));
    assert_eq!((run.samples, run.fits), (2000, 1), "the run is logged and fitted on the host: {run:?}");
    run
}

fn main() {
    let record = record();
    let request = Request { rad_per_count: (1.0 / COUNTS) as f32, ..Request::default() };
    let friction = Request { coulomb: true, generations: 5, ..request };
    let rows: Vec<String> = record.iter().map(|sample| format!("{:?}", sample.map(f32::to_bits))).collect();
    let text = format!(
        "pub const STEP_S: f32 = {:?};\n\
         pub const RAD_PER_COUNT: f32 = {:?};\n\
         pub const SAMPLES: [[u32; 3]; {}] = [{}];\n\
         pub const FLOAT: &[u8] = &{};\n\
         pub const FIXED: &[u8] = &{};\n\
         pub const FRICTION: &[u8] = &{};\n\
         pub const VERDICTS: u32 = {};\n\
         #[cfg(target_abi = \"eabihf\")]\n\
         pub const CAPTURED: crate::captured::Captured = crate::captured::{:?};\n",
        STEP_S as f32,
        request.rad_per_count,
        rows.len(),
        rows.join(","),
        bytes(&fitted::<Float>(&record, &request)),
        bytes(&fitted::<Fixed>(&record, &request)),
        bytes(&fitted::<Fixed>(&record, &friction)),
        spoil::verdicts(),
        run(),
    );
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    fs::write(out.join("expected.rs"), text).expect("the build's own directory can be written");
    let here = env::var("CARGO_MANIFEST_DIR").expect("cargo sets it");
    let small = env::var("TARGET").is_ok_and(|target| target.starts_with("thumbv6m"));
    let memory = if small { "microbit.x" } else { "an505.x" };
    fs::copy(Path::new(&here).join(memory), out.join("memory.x")).expect("it stands beside build.rs");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    for input in [memory, "src/spoil.rs", "src/captured.rs"] {
        println!("cargo:rerun-if-changed={input}");
    }
}
