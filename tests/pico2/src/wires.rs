//! What the core's accesses reach: the emulator's chip, and in front of it what the emulator has not ([`Beside`]).

use std::sync::Arc;

use rp2350_emu::Bus;
use rp2350_emu::core::CoreBus;
use rp2350_emu::threaded::CoreAtomics;

use crate::chip::CORE_HZ;
use crate::contact::{self, Contact};
use crate::converter::{CONVERTER, Converter};
use crate::dma::{DMA, Dma};
use crate::missing::{may_be, substitute, substitute_short};
use crate::registers::{address, written};
use crate::usb::{USB, Usb};
use crate::watchdog::{WATCHDOG, Watchdog};

/// TIMER0's raw interrupts: where the sampling interrupt takes back what caused it (bit 0, the first alarm).
const TIMER0_INTR: u32 = 0x400b_003c;
/// PIO 0, which holds the encoder's counter (RP2350 data sheet 11.7).
const PIO0: std::ops::Range<u32> = 0x5020_0000..0x5020_0188;
/// Where it stands between edges and looks at it, it would only look at the lines and offer the same count to a full FIFO: after either it goes
/// on for so many turns, of which one holds two of its program.
pub(crate) const PIO_TURNS: u32 = 3;
/// The tick generators, three registers each (RP2350 data sheet 8.5): their second is the cycles of clk_ref, which is the crystal, to a tick.
/// The emulator takes them for the core's.
const TICKS: std::ops::Range<u32> = 0x4010_8000..0x4010_8048;
const CORE_MHZ: u32 = (CORE_HZ / 1_000_000) as u32;
const CRYSTAL_MHZ: u32 = 12;
/// The core's own register of the interrupts 0 to 31 that go to its NMI (RP2350 data sheet 3.7.5.2, EPPB: NMI_MASK0).
const NMI_MASK0: u32 = 0xe008_0000;

/// The parts that the emulator lacks, or has otherwise than the data sheet.
#[derive(Default)]
pub struct Beside {
    /// USB's device.
    pub usb: Usb,
    /// The watchdog.
    pub watchdog: Watchdog,
    /// The contact's edges.
    pub contact: Contact,
    /// The converter.
    pub converter: Converter,
    /// The DMA.
    pub dma: Dma,
    /// The interrupts that are the NMI.
    pub nmi_mask: u32,
    /// Interrupts of the sampling timer so far.
    pub beats: u64,
    /// Turns in which the PIO has to go on.
    pub(crate) pio_turns: u32,
    /// The instruction that is carried out.
    pub(crate) fetched: u32,
}

/// Both, for the time of some instructions.
pub struct Wires<'a> {
    /// The emulator's.
    pub bus: &'a mut Bus,
    /// What stands in front of it.
    pub beside: &'a mut Beside,
}

impl CoreBus for Wires<'_> {
    fn read32(&mut self, at: u32, core: u8) -> u32 {
        let register = address(at);
        let own = match register {
            contact::INTR | contact::INTE | contact::INTS => Some(self.beside.contact.read(register)),
            _ if USB.contains(&register) => self.beside.usb.read(register),
            _ if CONVERTER.contains(&register) => Some(self.beside.converter.read(register)),
            _ if DMA.contains(&register) => Some(self.beside.dma.read(register)),
            _ if PIO0.contains(&register) => {
                self.beside.pio_turns = PIO_TURNS;
                None
            }
            _ if WATCHDOG.contains(&register) => Some(self.beside.watchdog.read(register - WATCHDOG.start)),
            _ => None,
        };
        own.unwrap_or_else(|| self.bus.read32(at, core))
    }

    fn write32(&mut self, at: u32, value: u32, core: u8) {
        let register = address(at);
        match register {
            contact::INTR | contact::INTE => return self.beside.contact.write(at, value),
            _ if USB.contains(&register) && self.beside.usb.write(at, value) => return,
            _ if CONVERTER.contains(&register) => return self.beside.converter.write(at, value),
            _ if DMA.contains(&register) => return self.beside.dma.write(at, value),
            _ if WATCHDOG.contains(&register) => return self.beside.watchdog.write(at, value),
            _ if PIO0.contains(&register) => self.beside.pio_turns = PIO_TURNS,
            _ if TICKS.contains(&register) && (register - TICKS.start) % 12 == 4 => {
                return self.bus.write32(at, value * CORE_MHZ / CRYSTAL_MHZ, core);
            }
            TIMER0_INTR if value & 1 != 0 => self.beside.beats += 1,
            _ => {}
        }
        self.bus.write32(at, value, core);
    }

    /// The core tells of its own registers this way alone.
    fn mmio_trace_enabled(&self) -> bool {
        true
    }

    fn emit_mmio_trace(&mut self, rw: char, _: u32, at: u32, value: u32, _: u8) {
        if rw == 'W' && address(at) == NMI_MASK0 {
            self.beside.nmi_mask = written(self.beside.nmi_mask, value, at);
        }
    }

    fn read8(&mut self, at: u32, core: u8) -> u8 {
        self.bus.read8(at, core)
    }

    fn read16(&mut self, at: u32, core: u8) -> u16 {
        let half = self.bus.read16(at, core);
        // An instruction is fetched by its halves.
        let [first, second] = match at.wrapping_sub(self.beside.fetched) {
            0 if may_be(half) => [half, self.bus.read16(at + 2, core)],
            0 => return substitute_short(half),
            2 => [self.bus.read16(at - 2, core), half],
            _ => return half,
        };
        substitute(first, second).map_or(half, |halves| halves[usize::from(at != self.beside.fetched)])
    }

    fn write8(&mut self, at: u32, value: u8, core: u8) {
        self.bus.write8(at, value, core);
    }

    fn write16(&mut self, at: u32, value: u16, core: u8) {
        self.bus.write16(at, value, core);
    }

    fn set_active_pc(&mut self, pc: u32, core: u8) {
        self.beside.fetched = pc;
        self.bus.set_active_pc(pc, core);
    }

    fn bus_fault(&self, core: u8) -> bool {
        self.bus.bus_fault(core.into())
    }

    fn bus_fault_addr(&self, core: u8) -> u32 {
        self.bus.bus_fault_addr(core.into())
    }

    fn clear_bus_fault(&mut self, core: u8) {
        self.bus.clear_bus_fault(core.into());
    }

    fn set_burst_mode(&mut self, on: bool) {
        CoreBus::set_burst_mode(self.bus, on);
    }

    fn add_extra_wait_states(&mut self, states: u32) {
        self.bus.add_extra_wait_states(states);
    }

    fn take_extra_wait_states(&mut self) -> u32 {
        self.bus.take_extra_wait_states()
    }

    fn extra_wait_states(&self) -> u32 {
        self.bus.extra_wait_states()
    }

    fn reset_extra_wait_states(&mut self) {
        self.bus.reset_extra_wait_states();
    }

    fn last_fetch_addr(&self) -> u32 {
        self.bus.last_fetch_addr()
    }

    fn set_last_fetch_addr(&mut self, at: u32) {
        self.bus.set_last_fetch_addr(at);
    }

    fn atomics(&self) -> &Arc<CoreAtomics> {
        &self.bus.atomics
    }

    fn gpio_read_out(&self) -> u32 {
        self.bus.gpio_read_out()
    }

    fn gpio_write_out(&mut self, value: u32) {
        self.bus.gpio_write_out(value);
    }

    fn gpio_set_out(&mut self, mask: u32) {
        self.bus.gpio_set_out(mask);
    }

    fn gpio_clear_out(&mut self, mask: u32) {
        self.bus.gpio_clear_out(mask);
    }

    fn gpio_xor_out(&mut self, mask: u32) {
        self.bus.gpio_xor_out(mask);
    }

    fn gpio_read_oe(&self) -> u32 {
        self.bus.gpio_read_oe()
    }

    fn gpio_write_oe(&mut self, value: u32) {
        self.bus.gpio_write_oe(value);
    }

    fn gpio_set_oe(&mut self, mask: u32) {
        self.bus.gpio_set_oe(mask);
    }

    fn gpio_clear_oe(&mut self, mask: u32) {
        self.bus.gpio_clear_oe(mask);
    }

    fn gpio_xor_oe(&mut self, mask: u32) {
        self.bus.gpio_xor_oe(mask);
    }

    fn gpio_read_in(&self) -> u32 {
        self.bus.gpio_read_in()
    }
}
