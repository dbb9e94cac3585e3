//! What the image takes of the chip, and what is proved of it.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use object::{Object, ObjectSection, SectionFlags, elf};

use crate::{arm, image};

/// Flash that the image may take, bytes.
const FLASH_LIMIT: u64 = 128 * 1024;
/// RAM that statics may take, bytes; the stack has its own place below them.
const RAM_LIMIT: u64 = 48 * 1024;

/// Bytes of flash and RAM that an ELF takes.
#[derive(Debug, Default, PartialEq, Eq)]
struct Sizes {
    flash: u64,
    ram: u64,
}

/// Builds every board's image, prints its sizes and proofs, fails when one is over its limit or has none.
pub fn print() -> Result<()> {
    for board in &arm::BOARDS {
        print_one(board.feature, &arm::build_image_for(board)?)?;
    }
    for pico in &arm::PICOS {
        print_one(pico.feature, &arm::build_pico(pico)?)?;
    }
    Ok(())
}

/// The same for images that are built.
pub fn print_of(images: &[PathBuf]) -> Result<()> {
    images.iter().try_for_each(|image| print_one(&image.display().to_string(), image))
}

fn print_one(board: &str, elf: &Path) -> Result<()> {
    let bytes = std::fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let Sizes { flash, ram } = measure(&bytes)?;
    println!(
        "{:<22} flash {:.1} KiB of {}, RAM {:.1} KiB of {} without the stack",
        board,
        flash as f64 / 1024.0,
        FLASH_LIMIT / 1024,
        ram as f64 / 1024.0,
        RAM_LIMIT / 1024,
    );
    ensure!(flash <= FLASH_LIMIT, "the image for {} takes more flash than it may", board);
    ensure!(ram <= RAM_LIMIT, "the image for {} takes more RAM than it may", board);
    println!("{:<22} {}", "", image::prove(&bytes).with_context(|| format!("the image for {board}"))?);
    Ok(())
}

/// Sums the sections that are loaded: what is written at run time is RAM, and what carries bytes is flash; initialised
/// data is both.
fn measure(elf: &[u8]) -> Result<Sizes> {
    let file = object::File::parse(elf)?;
    let mut sizes = Sizes::default();
    for section in file.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else {
            continue;
        };
        if sh_flags & u64::from(elf::SHF_ALLOC) == 0 {
            continue;
        }
        if sh_flags & u64::from(elf::SHF_WRITE) != 0 {
            sizes.ram += section.size();
        }
        if section.file_range().is_some_and(|(_, length)| length > 0) {
            sizes.flash += section.size();
        }
    }
    Ok(sizes)
}
