//! The emulated board: an STM32F4 with an 8 MHz crystal and a supply, run at a fixed rate of instructions.

use std::fmt::Debug;
use std::num::{NonZeroU32, NonZeroU64};
use std::path::{Path, PathBuf};

use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use rigless::cpu;
use rigless::emulator::{self, Driver, Finished, Start};
use rigless::image::Image;
use rigless::machine::{Board, Target, armv7m};
use rigless::mcu::{Mcu, Operate};
use rigless::session::Session;
use rigless::snapshot::Store;
use rigless::soc::stm32f427::Stm32f427;
use rigless::time::VirtualNanos;

/// The core's clock, Hz, which the image's clock tree must reach.
pub const CORE_HZ: u64 = 84_000_000;

/// The board with nothing but the chip, its crystal and its supply.
#[derive(Debug)]
pub struct Machine {
    /// The chip; what stands around it is driven and read here.
    pub mcu: Stm32f427,
    instructions_per_second: u64,
}

impl Machine {
    /// A board whose core completes so many instructions a second: 84 million where every instruction takes one
    /// cycle, fewer to stand for the flash's wait states.
    pub fn new(instructions_per_second: u64) -> Self {
        Self::with_crystal(instructions_per_second, 8_000_000)
    }

    /// The same with another crystal, Hz.
    pub fn with_crystal(instructions_per_second: u64, crystal_hz: u64) -> Self {
        let mut mcu = Stm32f427::new().expect("the part's own tables are sound");
        mcu.rcc.attach_crystals(crystal_hz, 0);
        mcu.set_supply(3300);
        Machine { mcu, instructions_per_second }
    }

    /// Runs an image until the driver ends the run; the driver is first asked at `first_stop`.
    pub fn run<D: Driver<Machine> + 'static>(
        self,
        image: &Path,
        first_stop: VirtualNanos,
        driver: D,
    ) -> Finished<Machine, D> {
        let session = Session::new(Box::new(self), 0, first_stop).expect("the board is composed soundly");
        let images =
            [Image::read(image, None).unwrap_or_else(|error| panic!("{}: {error:?}", image.display()))];
        emulator::run(session, &Start::new(&images), driver)
            .unwrap_or_else(|error| panic!("the emulator: {error:?}"))
    }
}

impl Store for Machine {}

impl Board for Machine {
    fn name(&self) -> &'static str {
        "motorlens"
    }

    fn target_names(&self) -> Vec<&'static str> {
        vec!["stm32f4"]
    }

    fn mcu(&mut self, target: usize) -> Option<&mut dyn Mcu> {
        (target == 0).then_some(&mut self.mcu)
    }

    fn targets(&mut self) -> Vec<Target<'_>> {
        let lines = u32::from(Operate::cpu(&self.mcu).interrupt_lines);
        let core = armv7m::Core {
            variant: armv7m::Variant::M4,
            clock_hz: NonZeroU64::new(CORE_HZ).expect("not zero"),
            interrupt_lines: NonZeroU32::new(lines).expect("the part has interrupts"),
            priority_bits: 4,
            refclk_divider: NonZeroU32::new(8).expect("not zero"),
            instructions_per_second: NonZeroU64::new(self.instructions_per_second).expect("not zero"),
            boot: "flash",
        };
        let windows = cpu::armv7m::windows(Mcu::bus(&self.mcu));
        let core = core.spec_with_parts(&windows, armv7m::Fpu::FpV4Sp, armv7m::MpuRegions::Eight);
        vec![Target::new("stm32f4", &mut self.mcu, core)]
    }
}

/// The image under test: `MOTORLENS_IMAGE`, which `cargo xtask test` sets to the ELF it has just built.
pub fn image() -> PathBuf {
    std::env::var_os("MOTORLENS_IMAGE")
        .expect("MOTORLENS_IMAGE names the firmware's ELF; run the bench by `cargo xtask test --only bench`")
        .into()
}

/// The images of the other boards, as the README has them, and their crystals, Hz: `MOTORLENS_NUCLEO`, `MOTORLENS_BLACKPILL`.
pub fn other_images() -> [(PathBuf, u64); 2] {
    [("MOTORLENS_NUCLEO", 8_000_000), ("MOTORLENS_BLACKPILL", 25_000_000)].map(|(variable, crystal_hz)| {
        let image = std::env::var_os(variable);
        (
            image.unwrap_or_else(|| panic!("{variable} names no ELF; run the bench by cargo xtask")).into(),
            crystal_hz,
        )
    })
}

/// Where the image keeps a static variable.
///
/// # Panics
/// When the image cannot be read, or has no such variable.
pub fn address_of(image: &Path, variable: &str) -> u64 {
    // Mangled: the name's length stands before it.
    let mangled = format!("{}{variable}", variable.len());
    let found = symbols(image).into_iter().find(|(name, _)| name == variable || name.contains(&mangled));
    found.unwrap_or_else(|| panic!("the image has no variable {variable}")).1
}

/// An instruction of Thumb.
pub const WAIT_FOR_INTERRUPT: u64 = 0xbf30;
/// Programs of Thumb by their halves: one that runs in a circle; one that is permanently undefined (ARMv7-M Architecture Reference Manual
/// A7.7.191); and one that asks for the NMI, by NMIPENDSET in ICSR (B3.2.4), whose address and value stand behind it.
pub const CIRCLE: &[u64] = &[0xe7fe];
pub const UNDEFINED: &[u64] = &[0xde00];
pub const ASK_FOR_NMI: &[u64] = &[0x4801, 0x4902, 0x6001, 0xe7fe, 0xed04, 0xe000, 0x0000, 0x8000];

/// Where the image's main loop waits for the next interrupt.
///
/// # Panics
/// When the image cannot be read, or its main function does not sleep at one place.
pub fn sleep_of(image: &Path) -> u64 {
    let bytes = std::fs::read(image).unwrap_or_else(|error| panic!("{}: {error}", image.display()));
    let file = object::File::parse(&*bytes).expect("the image is an ELF file");
    let is_main = |name: &str| name.contains("___cortex_m_rt_main") && !name.contains("VAR");
    let main =
        file.symbols().find(|symbol| symbol.kind() == SymbolKind::Text && symbol.name().is_ok_and(is_main));
    let main = main.expect("the image has a main function");
    let section = main.section_index().and_then(|index| file.section_by_index(index).ok());
    // A function's address is odd in Thumb.
    let begin = main.address() & !1;
    let code = section.and_then(|section| section.data_range(begin, main.size()).ok().flatten());
    let code = code.expect("its code is in the image");
    let sleeps = |pair: &[u8]| u64::from(u16::from_le_bytes([pair[0], pair[1]])) == WAIT_FOR_INTERRUPT;
    let places: Vec<usize> = (0..code.len() / 2).filter(|k| sleeps(&code[2 * k..2 * k + 2])).collect();
    assert_eq!(places.len(), 1, "{places:?}");
    begin + 2 * places[0] as u64
}

/// The image's symbols and their addresses.
///
/// # Panics
/// When the image cannot be read.
pub fn symbols(image: &Path) -> Vec<(String, u64)> {
    let bytes = std::fs::read(image).unwrap_or_else(|error| panic!("{}: {error}", image.display()));
    let file = object::File::parse(&*bytes).expect("the image is an ELF file");
    let named = |symbol: object::Symbol<'_, '_>| Some((symbol.name().ok()?.to_owned(), symbol.address()));
    file.symbols().filter_map(named).collect()
}

/// What the image touched that the emulated chip has not: an address without a register, a register without a model, an
/// access the bus refused, space that the manual leaves undefined, an interrupt without a line. `None` when there is nothing.
pub fn stray(session: &Session<Machine>) -> Option<String> {
    // Looked at while the bench serves, so nothing is put into words unless there is something.
    let checks: [(&str, bool, &dyn Debug); 5] = [
        ("unmapped", session.unmapped().is_empty(), &session.unmapped()),
        ("unimplemented", session.unimplemented().is_empty(), &session.unimplemented()),
        ("refused", session.refused().is_empty(), &session.refused()),
        ("undefined", session.undefined().is_empty(), &session.undefined()),
        ("unrouted", session.unrouted().is_empty(), &session.unrouted()),
    ];
    checks.into_iter().find(|(_, none, _)| !none).map(|(kind, _, what)| format!("{kind}: {what:?}"))
}

/// Panics when the image touched anything the emulated chip has not.
pub fn assert_clean(session: &Session<Machine>) {
    assert_eq!(stray(session), None);
}
