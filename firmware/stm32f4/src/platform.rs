//! Watchdog, identity, boot loader and the reasons for a start.

use core::mem::MaybeUninit;

use motorlens_firmware::Shared;
use motorlens_firmware::station::Platform;
use motorlens_shared::link::Reset;
use motorlens_shared::quickfit::Float;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::signature::Uid;
use stm32f4xx_hal::watchdog::IndependentWatchdog;

use crate::Hardware;

/// The board starts anew when the main loop or the sampling interrupt stood still for so long. Preparing a programme of
/// many multisines takes the larger part of it.
const WATCHDOG_MS: u32 = 500;
/// Looks at the watchdog's registers: more than a millisecond.
const UPDATE_LOOKS: u32 = 30_000;
/// The chip's own boot loader.
const SYSTEM_MEMORY: u32 = 0x1fff_0000;
/// Asks for it across a reset; "boot".
const ASKED: u32 = 0x626f_6f74;

/// Not cleared at the start.
#[unsafe(link_section = ".uninit.BOOT")]
static mut BOOT: MaybeUninit<u32> = MaybeUninit::uninit();

/// Not cleared at the start: what cost the program its control, noted before it waits for the watchdog; "lost" and a number.
#[unsafe(link_section = ".uninit.LOST")]
static mut LOST: MaybeUninit<[u32; 2]> = MaybeUninit::uninit();
const NOTED: u32 = 0x6c6f_7374;

/// Notes why the board is about to be started anew.
pub fn note(reason: Reset) {
    // SAFETY: two words that nothing else uses.
    unsafe { (&raw mut LOST).cast::<[u32; 2]>().write_volatile([NOTED, reason as u32]) };
}

/// What was noted; forgets it.
fn noted() -> Option<Reset> {
    let place = (&raw mut LOST).cast::<[u32; 2]>();
    // SAFETY: two words that nothing else uses; any bytes are a value.
    let [mark, number] = unsafe { place.read_volatile() };
    // SAFETY: as above.
    unsafe { place.write_volatile([0, 0]) };
    Reset::noted(number).filter(|_| mark == NOTED)
}

/// The board, for the main loop.
pub struct Board {
    watchdog: IndependentWatchdog,
    control: &'static Shared<Hardware>,
    ticks: u32,
}

impl Board {
    /// Starts the watchdog.
    pub fn new(watchdog: pac::IWDG, control: &'static Shared<Hardware>) -> Self {
        let mut watchdog = IndependentWatchdog::new(watchdog);
        watchdog.start(WATCHDOG_MS.millis());
        // Its registers take the new time over within five cycles of its own clock (RM0090 21.4.4), and it counts from the old one, which
        // is half a minute, until it is fed after that: a program that ends before would wait as long.
        // SAFETY: reads of a status register.
        let _ = (0..UPDATE_LOOKS).any(|_| unsafe { (*pac::IWDG::ptr()).sr().read().bits() == 0 });
        watchdog.feed();
        Board { watchdog, control, ticks: 0 }
    }
}

impl Platform for Board {
    const CORE_HZ: u32 = crate::CORE_HZ;
    type Arithmetic = Float;
    const VERSION: [u8; 3] = [0, 1, 0];

    fn unique(&self) -> [u8; 12] {
        let uid = Uid::get();
        let mut bytes = [0; 12];
        bytes[0..2].copy_from_slice(&uid.x().to_le_bytes());
        bytes[2..4].copy_from_slice(&uid.y().to_le_bytes());
        bytes[4] = uid.waf_num();
        let lot = uid.lot_num().as_bytes();
        bytes[5..].copy_from_slice(&lot[..7]);
        bytes
    }

    /// Feeds the watchdog, but only while the sampling interrupt comes too.
    fn alive(&mut self) {
        let ticks = critical_section::with(|section| self.control.borrow_ref(section).ticks());
        if core::mem::replace(&mut self.ticks, ticks) != ticks {
            self.watchdog.feed();
        }
    }

    fn has_bootloader(&self) -> bool {
        true
    }

    fn enter_bootloader(&mut self) {
        // SAFETY: one word that nothing else uses; read only after the reset.
        unsafe { (&raw mut BOOT).cast::<u32>().write_volatile(ASKED) };
        cortex_m::peripheral::SCB::sys_reset();
    }
}

/// Jumps to the boot loader when the program asked for it before the reset; the chip is as it is after one.
pub fn leave_for_bootloader_if_asked() {
    let place = (&raw mut BOOT).cast::<u32>();
    // SAFETY: one word that nothing else uses. The jump goes to ST's boot loader, whose vector table stands there.
    unsafe {
        if place.read_volatile() == ASKED {
            place.write_volatile(0);
            // Its memory at address 0, as the boot pins would have it: some loaders read their own vectors there (AN2606).
            (*pac::RCC::ptr()).apb2enr().modify(|_, w| w.syscfgen().set_bit());
            (*pac::SYSCFG::ptr()).memrmp().modify(|_, w| w.mem_mode().bits(0b01));
            cortex_m::asm::bootload(SYSTEM_MEMORY as *const u32);
        }
    }
}

/// Asks for the interrupt of a crystal that stops, and starts the supply detector, which [`supply_sinks`] looks at.
///
/// The brown-out reset is an option byte, which a program should not burn into its user's chip; what the chip does without
/// it below 1.8 V is not defined. The supply detector warns at 2.9 V falling (PLS = 111, RM0090 5.4.1), long before.
pub fn watch_clock_and_supply(pwr: &pac::PWR) {
    // SAFETY: CSSON is set once the crystal runs, which `freeze` has waited for; PWR's clock is on by then too, or is now.
    unsafe {
        (*pac::RCC::ptr()).apb1enr().modify(|_, w| w.pwren().set_bit());
        (*pac::RCC::ptr()).cr().modify(|_, w| w.csson().set_bit());
        pwr.cr().modify(|_, w| w.pls().bits(0b111).pvde().set_bit());
    }
}

/// Whether the supply detector sees the supply below its threshold.
pub fn supply_sinks() -> bool {
    // SAFETY: a read of a status register.
    unsafe { (*pac::PWR::ptr()).csr().read().pvdo().bit_is_set() }
}

/// Why the chip started; forgets it, so that the next start tells its own reason.
pub fn reset_cause(rcc: &pac::RCC) -> Reset {
    let flags = rcc.csr().read();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    let noted = noted();
    if flags.wdgrstf().bit_is_set() {
        noted.unwrap_or(Reset::Watchdog)
    } else if flags.sftrstf().bit_is_set() {
        Reset::Software
    } else {
        Reset::PowerOn
    }
}
