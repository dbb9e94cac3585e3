//! What a sine costs: the excitation's own and micromath's, on the emulated Cortex-M4F (tests/cortex-m4f).

use std::path::{Path, PathBuf};

use rigless::emulator::{Driver, Host, Stop};
use rigless::session::Session;
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use crate::machine::{self, CORE_HZ, Machine};

/// Phases in each of the program's loops.
const CALLS: f64 = 4096.0;
/// Instructions in a cycle of the program's clock: it stays at the chip's own oscillator of 16 MHz, and the emulated core completes
/// [`CORE_HZ`] instructions a second all the same.
const PER_CYCLE: f64 = CORE_HZ as f64 / 16e6;
/// The program is looked at so often, ns.
const STOP_NS: u64 = 1_000_000;
/// It takes less than this, ns.
const PATIENCE_NS: u64 = 1_000_000_000;

/// Instructions of one call, inlined, its loop not counted.
#[derive(Debug, Clone, Copy)]
pub struct Sines {
    /// `motorlens_shared::excitation::phase::sine`.
    pub ours: f64,
    /// micromath's, of an `f32` in rad made of the same phase.
    pub micromath: f64,
    /// The bits of both sums over the phases: ours, micromath's.
    pub sums: [u32; 2],
}

/// The program: `MOTORLENS_SINES`, which `cargo xtask test` sets to the ELF it has just built.
pub fn program() -> PathBuf {
    std::env::var_os("MOTORLENS_SINES")
        .expect("MOTORLENS_SINES names the program's ELF; run the bench by `cargo xtask test --only bench`")
        .into()
}

struct Reader {
    cycles: u64,
    sums: u64,
    read: Option<Sines>,
}

impl Driver<Machine> for Reader {
    fn on_stop(&mut self, _: &mut Session<Machine>, stop: Stop, host: &mut dyn Host) -> Option<VirtualNanos> {
        let mut word = |address: u64| host.read(address, Width::W32).expect("the program's memory is read");
        if word(self.cycles + 12) == 0 {
            assert!(stop.at.0 < PATIENCE_NS, "the program has not ended");
            return Some(VirtualNanos(stop.at.0 + STOP_NS));
        }
        let [empty, ours, micromath] = [0, 4, 8].map(|at| word(self.cycles + at) as f64);
        let sums = [4, 8].map(|at| word(self.sums + at) as u32);
        let of_call = |cycles: f64| (cycles - empty) * PER_CYCLE / CALLS;
        self.read = Some(Sines { ours: of_call(ours), micromath: of_call(micromath), sums });
        None
    }
}

/// Runs the program and counts.
///
/// # Panics
/// When it does not end.
pub fn count(program: &Path) -> Sines {
    let (cycles, sums) = (machine::address_of(program, "CYCLES"), machine::address_of(program, "SUMS"));
    let reader = Reader { cycles, sums, read: None };
    let finished = Machine::new(CORE_HZ).run(program, VirtualNanos(STOP_NS), reader);
    machine::assert_clean(&finished.session);
    finished.driver.read.expect("the program ended")
}
