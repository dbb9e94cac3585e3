//! UF2 files: what a Pico's boot loader takes by drag and drop.
//!
//! The format (github.com/microsoft/uf2): blocks of 512 bytes, each with magic numbers, an address, 256 bytes of flash, its
//! number, how many there are, and the family of chips that it is for.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use object::read::elf::{ElfFile32, FileHeader, ProgramHeader};
use object::{Endianness, elf};

use crate::arm;

const MAGIC: [u32; 2] = [0x0a32_4655, 0x9e5d_5157];
const MAGIC_END: u32 = 0x0ab1_6f30;
/// The block names a family in the place of a file's size.
const FAMILY_PRESENT: u32 = 0x2000;
/// Bytes of flash in a block: a page.
const PAGE: u32 = 256;
/// Where a Pico's flash lies, and the largest of both boards.
const FLASH: std::ops::Range<u64> = 0x1000_0000..0x1040_0000;

/// Builds the images of both Picos and writes their UF2 files; returns where they are.
pub fn write_all() -> Result<Vec<PathBuf>> {
    arm::PICOS.iter().map(write).collect()
}

/// Builds a Pico's image and writes its UF2 file.
pub fn write(pico: &arm::Pico) -> Result<PathBuf> {
    let elf = arm::build_pico(pico)?;
    let bytes = std::fs::read(&elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let file = pages(&bytes).map(|pages| encode(&pages, pico.family))?;
    let to = Path::new("target").join(format!("motorlens-{}.uf2", pico.feature));
    let path = crate::process::root().join(&to);
    std::fs::write(&path, &file).with_context(|| format!("cannot write {}", path.display()))?;
    println!(
        "{}: {} KiB; hold BOOTSEL, plug the board in, copy the file onto its drive",
        to.display(),
        file.len() / 1024
    );
    Ok(path)
}

/// The pages of flash that an image fills, by their addresses.
fn pages(image: &[u8]) -> Result<BTreeMap<u32, [u8; PAGE as usize]>> {
    let file = ElfFile32::<Endianness>::parse(image)?;
    let endian = file.endian();
    let mut pages = BTreeMap::new();
    for segment in file.elf_header().program_headers(endian, image)? {
        let size = u64::from(segment.p_filesz(endian));
        if segment.p_type(endian) != elf::PT_LOAD || size == 0 {
            continue;
        }
        // Where it is stored, not where it runs.
        let start = u64::from(segment.p_paddr(endian));
        ensure!(
            FLASH.contains(&start) && start + size <= FLASH.end,
            "a segment at {start:#x} is not in the flash"
        );
        let data = segment.data(endian, image).ok().context("a segment lies outside the file")?;
        for (address, byte) in (start as u32..).zip(data) {
            // What no segment fills stays as erased flash is.
            let page = pages.entry(address / PAGE * PAGE).or_insert([0xff; PAGE as usize]);
            page[(address % PAGE) as usize] = *byte;
        }
    }
    ensure!(!pages.is_empty(), "the image has nothing for the flash");
    Ok(pages)
}

fn encode(pages: &BTreeMap<u32, [u8; PAGE as usize]>, family: u32) -> Vec<u8> {
    let mut file = Vec::with_capacity(512 * pages.len());
    for (number, (address, page)) in (0..).zip(pages) {
        let header = [MAGIC[0], MAGIC[1], FAMILY_PRESENT, *address, PAGE, number, pages.len() as u32, family];
        header.iter().for_each(|word| file.extend(word.to_le_bytes()));
        file.extend(page);
        file.resize(512 * number as usize + 508, 0);
        file.extend(MAGIC_END.to_le_bytes());
    }
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_has_its_fields_where_the_format_puts_them() {
        let pages = BTreeMap::from([(0x1000_0000, [1; 256]), (0x1000_0200, [2; 256])]);
        let file = encode(&pages, 0xe48b_ff56);
        assert_eq!(file.len(), 1024);
        let word = |block: usize, at: usize| {
            u32::from_le_bytes(file[512 * block + at..512 * block + at + 4].try_into().unwrap())
        };
        let second: Vec<u32> = (0..8).map(|field| word(1, 4 * field)).collect();
        assert_eq!(second, [0x0a324655, 0x9e5d5157, 0x2000, 0x1000_0200, 256, 1, 2, 0xe48b_ff56]);
        assert!(file[512 + 32..512 + 288].iter().all(|byte| *byte == 2));
        assert!(file[512 + 288..1020].iter().all(|byte| *byte == 0));
        assert_eq!((word(0, 508), word(1, 508)), (0x0ab1_6f30, 0x0ab1_6f30));
    }
}
