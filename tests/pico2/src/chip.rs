//! The chip: the emulator, turn by turn, with what it lacks.

use std::sync::atomic::Ordering;

use rp2350_emu::bus::RESET_PIO0;
use rp2350_emu::{Config, Emulator, EmulatorBuilder};

use crate::contact::{CONTACT, CONTACT_IRQ};
use crate::missing::Move;
use crate::wires::{Beside, PIO_TURNS, Wires};

/// The core's cycles in a second, as the image sets its clock.
pub const CORE_HZ: u64 = 150_000_000;
/// Cycles of a turn: so long the core goes on alone, then everything else does.
const TURN: u32 = 32;
/// Where the flash is seen, and where the image's vectors are in it, which the boot ROM looks up.
const FLASH: u32 = 0x1000_0000;
/// The RAM.
const RAM: std::ops::Range<u32> = 0x2000_0000..0x2008_2000;
/// UF2's magic number and the family of the RP2350's secure Arm images (github.com/microsoft/uf2, utils/uf2families.json).
const UF2: u32 = 0x0a32_4655;
const FAMILY: u32 = 0xe48b_ff59;
/// The core's vector table offset, and what asks it for the NMI (Armv8-M Architecture Reference Manual D1.2.117).
const VTOR: u32 = 0xe000_ed08;
const ICSR: u32 = 0xe000_ed04;
const NMIPENDSET: u32 = 1 << 31;
/// Exception numbers.
const NMI: u32 = 2;
const HARD_FAULT: u32 = 3;
const FIRST_INTERRUPT: u32 = 16;
/// Tick generators of the first timer and of the watchdog (RP2350 data sheet 8.5.2): control and cycles to a tick.
const TICKS_TIMER0: u32 = 0x4010_8018;
const TICKS_WATCHDOG: u32 = 0x4010_8030;
/// Where a test puts an instruction: RAM above all that the image uses. Twice a jump to itself, or an instruction without a meaning.
const SPARE: u32 = 0x2007_ff00;
/// A program that stands.
pub const CIRCLE: u32 = 0xe7fe_e7fe;
/// A fault of the core.
pub const UNDEFINED: u32 = 0xde00_de00;
/// Pins of both lines of the encoder, and of the contact.
const INPUTS: u32 = 0b11 << ENCODER | 1 << CONTACT;
/// The first of the encoder's.
pub const ENCODER: u32 = 2;

/// The chip with an image in its flash.
pub struct Chip {
    emulator: Emulator,
    flash: Vec<u8>,
    inputs: u32,
    /// What the emulator lacks.
    pub beside: Beside,
    cycles: u64,
    owed: u64,
    restarts: u32,
}

impl Chip {
    /// Puts the UF2 file into the flash and starts, with the contact closed.
    pub fn new(uf2: &[u8]) -> Self {
        let flash = flash(uf2);
        let mut chip = Self {
            emulator: started(&flash),
            flash,
            inputs: 0,
            beside: Beside::default(),
            cycles: 0,
            owed: 0,
            restarts: 0,
        };
        chip.show_inputs();
        chip
    }

    /// Seconds since the power came.
    pub fn now(&self) -> f64 {
        self.cycles as f64 / CORE_HZ as f64
    }

    /// How often the watchdog has started the chip anew.
    pub fn restarts(&self) -> u32 {
        self.restarts
    }

    /// One turn.
    pub fn turn(&mut self) {
        let Emulator { cores, bus, clock, .. } = &mut self.emulator;
        let core = &mut cores.expect_arm_mut()[0];
        let pending = bus.atomics.irq_pending_load(0);
        let contact = self.beside.contact.asks() && self.beside.nmi_mask & 1 << CONTACT_IRQ != 0;
        if (pending as u32 & self.beside.nmi_mask != 0 || contact) && core.regs.ipsr() != NMI {
            core.ppb.write32(ICSR, NMIPENDSET);
        }
        // A line that is still up while its handler runs asks for it again when that has ended, not once more for what it has done since.
        bus.atomics.set_irq_pending(0, pending & !u64::from(self.beside.nmi_mask) & !handled(core));
        let until = clock.cycles + u64::from(TURN);
        while core.cycles() < until && !core.is_halted() && !core.is_wfe_waiting() {
            core.ppb.update_latest_cycles(core.cycles());
            let mut wires = Wires { bus, beside: &mut self.beside };
            let at = core.regs.pc().wrapping_sub(FLASH) as usize;
            let moved = match self.flash.get(at..at.saturating_add(4)) {
                Some(&[a, b, c, d]) => {
                    Move::next(core, u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]))
                }
                _ => None,
            };
            core.step(&mut wires);
            if let Some(moved) = moved {
                moved.done(core, &mut wires);
            }
        }
        core.invalidate_decode_cache_entries(&bus.pending_cache_invalidations);
        bus.pending_cache_invalidations.clear();
        let resets = bus.resets_state;
        if self.beside.pio_turns == 0 {
            bus.resets_state |= 1 << RESET_PIO0;
        }
        self.beside.pio_turns = self.beside.pio_turns.saturating_sub(1);
        // The core is where this would take it: what goes on is everything else.
        self.emulator.step().expect("the emulator steps in this thread");
        self.emulator.bus.resets_state = resets;
        self.cycles += u64::from(TURN);
        self.convert();
        self.tick_watchdog();
        if self.beside.watchdog.expired() {
            self.restart();
        }
    }

    /// The converter goes on, and the DMA puts what it reads into the RAM.
    fn convert(&mut self) {
        let Beside { converter, dma, .. } = &mut self.beside;
        converter.advance(TURN);
        while converter.asks()
            && let Some(at) = dma.carry()
        {
            // A half of the word there: a write over the bus would cost the core time.
            let (word, shift) = (at & !3, 8 * (at & 2));
            let kept = self.emulator.peek(word) & !(0xffff << shift);
            self.emulator.poke(word, kept | u32::from(converter.take()) << shift);
        }
    }

    fn tick_watchdog(&mut self) {
        self.owed += u64::from(TURN);
        let a_tick = CORE_HZ / 1_000_000;
        if self.owed < a_tick {
            return;
        }
        self.owed -= a_tick;
        if !self.beside.watchdog.counts() {
            return;
        }
        // Ticks of a microsecond, or none.
        let [control, cycles] = [0, 4].map(|offset| self.emulator.mmio_read32(TICKS_WATCHDOG + offset));
        if control & 1 != 0 {
            assert_eq!((u64::from(cycles), self.emulator.bus.ref_clk_hz()), (a_tick, 12_000_000), "the tick");
            self.beside.watchdog.tick();
        }
    }

    /// What the watchdog does: all is as at the start but the RAM, the watchdog's notes and what is at the pins.
    fn restart(&mut self) {
        let mut emulator = started(&self.flash);
        for at in RAM.step_by(4) {
            emulator.poke(at, self.emulator.peek(at));
        }
        self.emulator = emulator;
        self.beside = Beside { watchdog: self.beside.watchdog.restarted(), ..Beside::default() };
        self.restarts += 1;
        self.show_inputs();
    }

    /// Runs for so many seconds, with a look after each turn.
    pub fn run(&mut self, seconds: f64, mut look: impl FnMut(&mut Self)) {
        let until = self.cycles + (seconds * CORE_HZ as f64) as u64;
        while self.cycles < until {
            self.turn();
            look(self);
        }
    }

    /// Puts both lines of an encoder at the pins, which has this count.
    pub fn show_count(&mut self, count: i64) {
        let [a, b] = [matches!(count.rem_euclid(4), 1 | 2), count.rem_euclid(4) >= 2];
        self.inputs = self.inputs & !(0b11 << ENCODER) | (u32::from(a) | u32::from(b) << 1) << ENCODER;
        self.show_inputs();
    }

    /// Opens or closes the emergency contact.
    pub fn set_contact(&mut self, open: bool) {
        if open && self.inputs & 1 << CONTACT == 0 {
            self.beside.contact.rises();
        }
        self.inputs = self.inputs & !(1 << CONTACT) | u32::from(open) << CONTACT;
        self.show_inputs();
    }

    /// Stops the crystal, or lets it swing again: ticks are made of it (RP2350 data sheet 8.5). The PLL, which the core hangs on, swings on by
    /// itself.
    pub fn set_crystal(&mut self, swings: bool) {
        for ticks in [TICKS_TIMER0, TICKS_WATCHDOG] {
            self.write(ticks, swings.into());
        }
    }

    fn show_inputs(&mut self) {
        self.beside.pio_turns = PIO_TURNS;
        self.emulator.bus.gpio_external_mask = INPUTS;
        self.emulator.bus.gpio_external_in.store(self.inputs, Ordering::Relaxed);
    }

    /// Whether a fault has stopped the core's program.
    pub fn at_fault(&self) -> bool {
        let core = self.emulator.core(0);
        core.regs.ipsr() == HARD_FAULT || core.is_halted()
    }

    /// A register or word of memory.
    pub fn read(&mut self, at: u32) -> u32 {
        self.emulator.mmio_read32(at)
    }

    /// Writes a register or word of memory.
    pub fn write(&mut self, at: u32, value: u32) {
        self.emulator.mmio_write32(at, value);
    }

    /// Has the core carry out this from here on, instead of its program.
    pub fn go_to(&mut self, instruction: u32) {
        self.write(SPARE, instruction);
        self.core().regs.set_pc(SPARE);
    }

    /// The core.
    pub fn core(&mut self) -> &mut rp2350_emu::CortexM33 {
        self.emulator.core_mut(0)
    }
}

/// The interrupt whose handler the core is in, as a bit.
fn handled(core: &rp2350_emu::CortexM33) -> u64 {
    core.regs.ipsr().checked_sub(FIRST_INTERRUPT).map_or(0, |interrupt| 1 << interrupt)
}

/// An emulator at the image's first instruction, as the boot ROM leaves the chip.
fn started(flash: &[u8]) -> Emulator {
    let mut emulator =
        EmulatorBuilder::new(Config::default()).step_quantum(TURN).build().expect("in one thread");
    emulator.load_flash(flash);
    let word = |at: usize| u32::from_le_bytes(flash[at..at + 4].try_into().expect("four bytes"));
    // The second core waits in the boot ROM to be called.
    emulator.core_mut(1).halt();
    let core = emulator.core_mut(0);
    core.ppb.write32(VTOR, FLASH);
    core.regs.msp = word(0);
    core.regs.set_sp(word(0));
    core.regs.set_pc(word(4) & !1);
    core.regs.xpsr = 1 << 24;
    emulator
}

/// What a UF2 file puts into the flash.
fn flash(uf2: &[u8]) -> Vec<u8> {
    let mut flash = Vec::new();
    for block in uf2.chunks_exact(512) {
        let word = |at: usize| u32::from_le_bytes(block[at..at + 4].try_into().expect("four bytes"));
        assert_eq!((word(0), word(28)), (UF2, FAMILY), "not a UF2 file for this chip");
        let (at, size) = ((word(12) - FLASH) as usize, word(16) as usize);
        flash.resize(flash.len().max(at + size), 0xff);
        flash[at..at + size].copy_from_slice(&block[32..32 + size]);
    }
    flash
}
