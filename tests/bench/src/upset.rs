//! What can happen to the chip, and how it is done to the emulated one.

use rigless::emulator::{Error, Host};
use rigless::soc::Width;
use rigless::soc::stm32f427::generated::tim3::Register as GeneralRegister;
use rigless::time::VirtualNanos;

use crate::machine::Machine;

/// TIM4 among the general timers.
const TIMER_4: usize = 2;
/// The stack; its far end is never reached.
const STACK: std::ops::Range<u64> = 0x2000_0000..0x2000_c000;

/// What can happen to the chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Upset {
    /// The sampling timer asks for no more interrupts.
    DeadSampling,
    /// The control looks borrowed already, and the sampling interrupt stops for good over it.
    Panic,
    /// The same, and the sampling timer asks for no more interrupts: the main loop finds it, and panics.
    PanicOfMainLoop,
    /// The core does nothing more, as a program that holds all interrupts off and runs in a circle, and goes on.
    Hang,
    /// It goes on.
    GoOn,
    /// From its next sleep on the main loop runs in a circle, and the interrupts go on; also once the program is started anew.
    Circle,
    /// After its next sleep the main loop comes upon an instruction without a meaning, which is a fault of the core; also once the program is
    /// started anew.
    Fault,
    /// After its next sleep the main loop asks for the NMI, as the clock security does of a crystal that stops (RM0090 7.2.7) and the emulated
    /// clocks do not; also once the program is started anew.
    Nmi,
    /// None of the three once it is started anew.
    Straight,
    /// The crystal stops.
    ClockLoss,
    /// The chip's own supply, mV.
    Supply(u32),
}

impl Upset {
    pub(crate) fn strike(
        self,
        now: VirtualNanos,
        machine: &mut Machine,
        host: &mut dyn Host,
        control: u64,
    ) -> Result<(), Error> {
        match self {
            Upset::DeadSampling => machine.mcu.timer(TIMER_4).1.set(GeneralRegister::Dier, 0),
            Upset::Panic | Upset::PanicOfMainLoop => {
                if self == Upset::PanicOfMainLoop {
                    machine.mcu.timer(TIMER_4).1.set(GeneralRegister::Dier, 0);
                }
                // A `RefCell` begins with its flag.
                let flag = host.read(control, Width::W32)?;
                host.write(flag, Width::W32, 1)?;
            }
            Upset::Hang => host.hold(true),
            Upset::GoOn => host.hold(false),
            // The next interrupt of the main loop's sleep does it.
            Upset::Circle | Upset::Fault | Upset::Nmi | Upset::Straight => {}
            Upset::ClockLoss => {
                machine
                    .mcu
                    .drive_clocks(now, |clocks, registers, context| clocks.fail_hse(registers, context));
            }
            Upset::Supply(millivolts) => machine.mcu.set_supply(millivolts),
        }
        Ok(())
    }
}

/// Lets the main loop, which slept before this interrupt, come back from it to this program: where it comes back to stands in the frame
/// that the core has put on the stack (ARMv7-M Architecture Reference Manual B1.5.6). False where it did not sleep.
pub(crate) fn lead_to(program: &[u64], sleep: u64, host: &mut dyn Host) -> Result<bool, Error> {
    let mut found = false;
    for place in STACK.step_by(4) {
        if host.read(place, Width::W32)? == sleep + 2 {
            for (place, half) in (STACK.start..).step_by(2).zip(program) {
                host.write(place, Width::W16, *half)?;
            }
            host.write(place, Width::W32, STACK.start)?;
            found = true;
        }
    }
    Ok(found)
}
