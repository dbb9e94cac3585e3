//! What differs between the RP2040 and the RP2350.

use crate::hal;
use hal::clocks::{ClocksManager, UsbClock};
use hal::pac;

/// The crystal's frequency on both boards, Hz.
pub const CRYSTAL_HZ: u32 = 12_000_000;

#[cfg(feature = "pico")]
mod this {
    use super::*;

    /// The second boot stage, which sets up the flash.
    #[unsafe(link_section = ".boot2")]
    #[used]
    static BOOT2: [u8; 256] = rp2040_boot2::BOOT_LOADER_GENERIC_03H;

    /// The core's frequency, Hz.
    pub const CORE_HZ: u32 = 125_000_000;
    /// The interrupt of the first alarm.
    pub const SAMPLING: pac::Interrupt = pac::Interrupt::TIMER_IRQ_0;
    /// No floating-point unit: the fit searches in integers.
    pub type Arithmetic = motorlens_shared::quickfit::Fixed;
    /// The microsecond timer.
    pub type Clock = hal::Timer;
    pub type ClockRegisters = pac::TIMER;

    pub fn clock(timer: pac::TIMER, resets: &mut pac::RESETS, clocks: &ClocksManager) -> Clock {
        hal::Timer::new(timer, resets, clocks)
    }

    pub fn usb(
        registers: pac::USBCTRL_REGS,
        memory: pac::USBCTRL_DPRAM,
        clock: UsbClock,
        resets: &mut pac::RESETS,
    ) -> hal::usb::UsbBus {
        hal::usb::UsbBus::new(registers, memory, clock, true, resets)
    }

    pub fn bootloader() {
        hal::rom_data::reset_to_usb_boot(0, 0);
    }

    /// The second alarm (interrupt 1) and the pins (13): RP2040 data sheet 2.3.2.
    pub fn route_to_nmi() {
        // SAFETY: neither interrupt is enabled otherwise.
        unsafe { (*pac::SYSCFG::ptr()).proc0_nmi_mask().write(|w| w.bits(1 << 1 | 1 << 13)) };
    }

    /// Closes the last 256 bytes of the stack to every access, outside of the faults' handlers (ARMv6-M Architecture Reference Manual
    /// B3.5, RP2040 data sheet 2.4.5): below them this chip answers some addresses instead of refusing them.
    pub fn close_stack() {
        unsafe extern "C" {
            static _stack_end: u32;
        }
        // SAFETY: the address of a symbol alone; nothing else uses the protection unit. Region 0, valid; 2^8 bytes, no access, no
        // execution; on, with the default map for all else.
        unsafe {
            let unit = &*cortex_m::peripheral::MPU::PTR;
            unit.rbar.write((&raw const _stack_end) as u32 | 1 << 4);
            unit.rasr.write(1 << 28 | 7 << 1 | 1);
            unit.ctrl.write(0b101);
        }
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
    }

    /// What makes a channel of the DMA keep readings of the converter in a ring of `1 << ring_bits` bytes and then begin channel `next`, as its
    /// control register's bits: halfwords to addresses that rise, at the converter's pace (RP2040 data sheet 2.5.7, CH0_CTRL_TRIG; 2.5.3.1, DREQ 36).
    pub fn control_of_readings(next: u8, ring_bits: u8) -> u32 {
        1 | 1 << 2 | 1 << 5 | u32::from(ring_bits) << 6 | 1 << 10 | u32::from(next) << 11 | 36 << 15 | 1 << 21
    }

    pub fn start_cycle_counter() {}

    /// This core counts none: so many as its clock makes in the microseconds of the timer.
    pub fn cycles() -> u32 {
        // SAFETY: a read of the clock.
        unsafe { (*pac::TIMER::ptr()).timerawl().read().bits().wrapping_mul(CORE_HZ / 1_000_000) }
    }
}

#[cfg(feature = "pico2")]
mod this {
    use super::*;
    use cortex_m::peripheral::{DCB, DWT};

    /// What the boot ROM looks for.
    #[unsafe(link_section = ".start_block")]
    #[used]
    static IMAGE: hal::block::ImageDef = hal::block::ImageDef::secure_exe();

    /// The core's frequency, Hz.
    pub const CORE_HZ: u32 = 150_000_000;
    /// The interrupt of the first alarm.
    pub const SAMPLING: pac::Interrupt = pac::Interrupt::TIMER0_IRQ_0;
    /// A floating-point unit.
    pub type Arithmetic = motorlens_shared::quickfit::Float;
    /// The microsecond timer.
    pub type Clock = hal::Timer<hal::timer::CopyableTimer0>;
    pub type ClockRegisters = pac::TIMER0;

    pub fn clock(timer: pac::TIMER0, resets: &mut pac::RESETS, clocks: &ClocksManager) -> Clock {
        hal::Timer::new_timer0(timer, resets, clocks)
    }

    pub fn usb(
        registers: pac::USB,
        memory: pac::USB_DPRAM,
        clock: UsbClock,
        resets: &mut pac::RESETS,
    ) -> hal::usb::UsbBus {
        hal::usb::UsbBus::new(registers, memory, clock, true, resets)
    }

    pub fn bootloader() {
        let kind = hal::reboot::RebootKind::BootSel { picoboot_disabled: false, msd_disabled: false };
        hal::reboot::reboot(kind, hal::reboot::RebootArch::Normal);
    }

    /// The second alarm of timer 0 (interrupt 1) and the pins (21): RP2350 data sheet 3.2.
    pub fn route_to_nmi() {
        // SAFETY: neither interrupt is enabled otherwise.
        unsafe { (*pac::EPPB::ptr()).nmi_mask0().write(|w| w.bits(1 << 1 | 1 << 21)) };
    }

    /// The core compares the stack with its end by itself, from the start on.
    pub fn close_stack() {}

    /// What makes a channel of the DMA keep readings of the converter in a ring of `1 << ring_bits` bytes and then begin channel `next`, as its
    /// control register's bits: halfwords to addresses that rise, at the converter's pace (RP2350 data sheet 12.6.10, CH0_CTRL_TRIG; 12.6.4.1, DREQ 48).
    pub fn control_of_readings(next: u8, ring_bits: u8) -> u32 {
        1 | 1 << 2 | 1 << 6 | u32::from(ring_bits) << 8 | 1 << 12 | u32::from(next) << 13 | 48 << 17 | 1 << 23
    }

    pub fn start_cycle_counter() {
        // SAFETY: nothing else uses the debug blocks of the core.
        let mut core = unsafe { cortex_m::Peripherals::steal() };
        DCB::enable_trace(&mut core.DCB);
        core.DWT.enable_cycle_counter();
    }

    pub fn cycles() -> u32 {
        DWT::cycle_count()
    }
}

pub use this::*;
