//! What a sine costs on a Cortex-M4F: the excitation's own and micromath's, over the same phases.
//!
//! The cycle counter is read before and after each loop; the bench (tests/bench) reads the counts out of the memory, and knows how many
//! instructions its core completes in a cycle.
#![no_std]
#![no_main]

use core::hint::black_box;
use core::sync::atomic::AtomicU32;

use cortex_m::peripheral::{DWT, Peripherals};
use cortex_m_rt::entry;
use micromath::F32Ext;
// Built for this core like the rest of what runs on boards.
use motorlens_model as _;
use motorlens_shared::excitation::phase::sine;

/// Phases per loop.
const CALLS: u32 = 4096;
/// Phases apart, an odd number of 2^-32 turns: they fall everywhere in the turn.
const APART: u32 = 2_654_435_769;
/// rad per unit of the phase.
const RAD: f32 = core::f32::consts::TAU / 4_294_967_296.0;

/// Cycles of the loops: without a sine, with ours, with micromath's; then 1.
static CYCLES: [AtomicU32; 4] = [const { AtomicU32::new(0) }; 4];
/// The bits of each loop's sum.
static SUMS: [AtomicU32; 3] = [const { AtomicU32::new(0) }; 3];

/// Puts a word where the bench finds it.
fn keep(place: &AtomicU32, word: u32) {
    // SAFETY: the address of a static that nothing else uses meanwhile. Volatile, because this program never reads it.
    unsafe { place.as_ptr().write_volatile(word) };
}

/// Sums `f` over the phases, and keeps what that took.
#[inline(never)]
fn count(place: usize, f: impl Fn(u32) -> f32) {
    let begin = DWT::cycle_count();
    let mut sum = 0.0;
    let mut phase = 0_u32;
    for _ in 0..CALLS {
        sum += f(black_box(phase));
        phase = phase.wrapping_add(APART);
    }
    let end = DWT::cycle_count();
    keep(&SUMS[place], sum.to_bits());
    keep(&CYCLES[place], end.wrapping_sub(begin));
}

#[entry]
fn main() -> ! {
    if let Some(mut core) = Peripherals::take() {
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
        count(0, f32::from_bits);
        count(1, sine);
        count(2, |phase| (phase as i32 as f32 * RAD).sin());
        keep(&CYCLES[3], 1);
    }
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}
