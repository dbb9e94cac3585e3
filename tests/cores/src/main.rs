//! The quick fit and the link's decoder on a Cortex-M0: no floating-point unit, no divider, 16 KiB of RAM. On a Cortex-M33, the Pico 2's
//! core, with its floating-point unit, and there the boards' own program plays, logs and fits a run too. The build has done the same on
//! the host; every bit must agree.
#![no_std]
#![no_main]

#[cfg(target_abi = "eabihf")]
mod captured;
mod spoil;

use cortex_m_rt::{ExceptionFrame, entry, exception};
use cortex_m_semihosting::{debug, hprintln};
// Built for this core like the rest of what runs on boards.
use motorlens_model as _;
use motorlens_shared::quickfit::{Arithmetic, Fixed, Float, Kept, QuickFit, Request, fit};

/// What the host made of it.
mod host {
    include!(concat!(env!("OUT_DIR"), "/expected.rs"));
}

/// The record, in flash: it would fill the RAM.
static SAMPLES: [Kept; host::SAMPLES.len()] = {
    let mut samples = [[0.0; 3]; host::SAMPLES.len()];
    let mut k = 0;
    while k < samples.len() {
        let [voltage, integral, count] = host::SAMPLES[k];
        samples[k] = [f32::from_bits(voltage), f32::from_bits(integral), f32::from_bits(count)];
        k += 1;
    }
    samples
};

/// Fits, and compares every byte with the host's fit.  Not inlined: two frames of a fit would fill the RAM.
#[inline(never)]
fn agrees<A: Arithmetic>(name: &str, request: &Request, host: &[u8]) -> bool {
    let Some(here) = fit::<A>(&SAMPLES, host::STEP_S, request, |_| (), || ()) else {
        hprintln!("{}: no fit", name);
        return false;
    };
    let mut room = [0; 128];
    let same = postcard::to_slice(&here, &mut room).is_ok_and(|bytes| bytes == host);
    let QuickFit { gain, tau_m, tau_e, coulomb, .. } = here;
    hprintln!(
        "{}: gain {} tau_m {} tau_e {} coulomb {:?}; {}",
        name,
        gain.value,
        tau_m.value,
        tau_e.value,
        coulomb.map(|estimate| estimate.value),
        if same { "the host's bits" } else { "NOT the host's bits" }
    );
    same
}

#[entry]
fn main() -> ! {
    let request = Request { rad_per_count: host::RAD_PER_COUNT, ..Request::default() };
    let friction = Request { coulomb: true, generations: 5, ..request };
    let mut good = agrees::<Fixed>("fixed point, 16 x 40", &request, host::FIXED);
    good &= agrees::<Float>("floating point, 16 x 40", &request, host::FLOAT);
    good &= agrees::<Fixed>("fixed point with friction", &friction, host::FRICTION);
    let verdicts = spoil::verdicts();
    hprintln!("decoder's verdicts on spoiled frames: {:08x}, on the host {:08x}", verdicts, host::VERDICTS);
    good &= verdicts == host::VERDICTS;
    #[cfg(target_abi = "eabihf")]
    {
        good &= captures();
    }
    leave(good)
}

/// Plays, logs and fits a run, and compares all that the board says meanwhile with the host's.
#[cfg(target_abi = "eabihf")]
fn captures() -> bool {
    use motorlens_firmware::log::Log;
    use motorlens_firmware::station::Station;

    let log = cortex_m::singleton!(: Log = Log::new()).expect("made once");
    let station = cortex_m::singleton!(: Station = Station::new()).expect("made once");
    let here = captured::capture(log, station);
    hprintln!("a run and its fit: {:?}", here);
    hprintln!("       on the host {:?}", host::CAPTURED);
    here == host::CAPTURED
}

/// Ends the emulation with this outcome.
fn leave(good: bool) -> ! {
    debug::exit(if good { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    loop {}
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    hprintln!("{}", info);
    leave(false)
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    hprintln!("hard fault at {:#x}", frame.pc());
    leave(false)
}
