//! The chains of sectors in a compound file (`.xls`): whoever follows one that comes back to itself never ends.
//!
//! Layout of \[MS-CFB\] (Compound File Binary File Format, Microsoft): a header of 512 bytes, sectors behind it, and tables in which
//! each sector names the one that follows it.

use super::Fault;
use super::bytes::u32_at;

/// Numbers from here on are no sectors but ends and marks.
const NO_SECTOR: u32 = 0xFFFF_FFFA;
/// Sectors of the table that the header itself names.
const NAMED: usize = 109;

/// Streams shorter than this stand in short sectors.
const SHORT: u32 = 4096;
/// Size of a short sector, as a power of two.
const SHORT_SHIFT: u32 = 6;
/// Bytes of an entry of the directory.
const ENTRY: usize = 128;

/// A compound file of which every chain ends.
#[derive(Debug, Clone)]
pub struct Chains<'a> {
    all: &'a [u8],
    shift: u32,
    /// What follows each sector, and each short one.
    following: Vec<u32>,
    short: Vec<u32>,
}

impl<'a> Chains<'a> {
    /// Follows the chains of the file `all`.
    ///
    /// # Errors
    /// A fault that names the table where a chain comes back to itself.
    pub fn of(all: &'a [u8]) -> Result<Self, Fault> {
        let number = |at: usize| u32_at(all, at);
        let shift = all.get(30).copied().unwrap_or_default();
        if ![9, 12].contains(&shift) {
            return Err(Fault::broken(30, "where the size of its sectors stands"));
        }
        let size = 1_usize << shift;
        let begin = |sector: u32| (sector as usize + 1) << shift;
        let numbers = |sector: u32| (0..size / 4).map_while(move |k| number(begin(sector) + 4 * k));
        // The header names the first sectors of the table, further ones stand in sectors of their own, each of which ends with the next.
        let mut table: Vec<u32> = (0..NAMED).filter_map(|k| number(76 + 4 * k)).collect();
        let (mut more, mut left) = (number(68).filter(is_sector), all.len() >> shift);
        while let Some(sector) = more.filter(|sector| begin(*sector) < all.len()) {
            let inside: Vec<u32> = numbers(sector).collect();
            if left == 0 {
                return Err(Fault::broken(68, "whose list of tables comes back to itself"));
            }
            left -= 1;
            let Some((next, named)) = inside.split_last() else { break };
            table.extend(named);
            more = Some(*next).filter(is_sector);
        }
        table.retain(is_sector);
        if table.len() > all.len() >> shift {
            return Err(Fault::broken(76, "whose list of tables is longer than the file"));
        }
        let following: Vec<u32> = table.into_iter().flat_map(numbers).collect();
        let fault = |sector: usize| {
            let at = begin(u32::try_from(sector).unwrap_or(u32::MAX)) as u64;
            Fault::broken(at, "where a chain of sectors comes back to itself")
        };
        if let Some(sector) = comes_back(&following) {
            return Err(fault(sector));
        }
        // Short streams have a table of their own, which is itself a chain of sectors.
        let first = number(60).unwrap_or(NO_SECTOR);
        let short: Vec<u32> = chain(&following, first).flat_map(numbers).collect();
        if let Some(sector) = comes_back(&short) {
            return Err(fault(sector));
        }
        Ok(Self { all, shift: u32::from(shift), following, short })
    }

    /// The bytes of the first stream that has one of `names`; none where there is no such.
    pub fn stream(&self, names: &[&str]) -> Option<Vec<u8>> {
        let directory = self.sectors(u32_at(self.all, 48)?);
        let entry = |name: &str| {
            let name: Vec<u8> = name.encode_utf16().chain([0]).flat_map(u16::to_le_bytes).collect();
            directory.chunks_exact(ENTRY).find(|entry| entry.starts_with(&name))
        };
        let entry = names.iter().find_map(|name| entry(name))?;
        let (first, length) = (u32_at(entry, 116)?, u32_at(entry, 120)?);
        let mut bytes = if length < SHORT {
            let held = self.sectors(u32_at(&directory, 116)?);
            let sector = |k: u32| held.get((k as usize) << SHORT_SHIFT..(k as usize + 1) << SHORT_SHIFT);
            chain(&self.short, first).filter_map(sector).flatten().copied().collect()
        } else {
            self.sectors(first)
        };
        bytes.truncate(length as usize);
        Some(bytes)
    }

    /// The bytes of the chain that begins with the sector `first`.
    fn sectors(&self, first: u32) -> Vec<u8> {
        let from = |sector: u32| (sector as usize + 1) << self.shift;
        let bytes = |sector: u32| {
            let end = self.all.len().min(from(sector) + (1 << self.shift));
            self.all.get(from(sector)..end)
        };
        chain(&self.following, first).filter_map(bytes).flatten().copied().collect()
    }
}

fn is_sector(number: &u32) -> bool {
    *number < NO_SECTOR
}

/// The places of a chain that ends, `first` and what follows.
fn chain(following: &[u32], first: u32) -> impl Iterator<Item = u32> {
    let next = |place: &u32| following.get(*place as usize).copied().filter(is_sector);
    std::iter::successors(Some(first).filter(is_sector), next)
}

/// A place of a chain that comes back to itself, if there is one: `following` names what comes behind each place.
fn comes_back(following: &[u32]) -> Option<usize> {
    // 0 for a place that was not looked at, else the walk that came past it.
    let mut walks = vec![0_usize; following.len()];
    for start in 0..following.len() {
        if walks[start] != 0 {
            continue;
        }
        let mut place = start;
        while walks.get(place) == Some(&0) {
            walks[place] = start + 1;
            place = following[place] as usize;
        }
        if walks.get(place) == Some(&(start + 1)) {
            return Some(place);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHEET: &[u8] = include_bytes!("../../../tests/formats/sheet.xls");

    #[test]
    fn a_chain_that_comes_back_to_itself_is_refused_and_one_that_ends_is_not() {
        let chains = Chains::of(SHEET).unwrap();
        let book = chains.stream(&["Workbook", "Book"]).unwrap();
        assert_eq!(&book[..2], &[0x09, 0x08], "a workbook begins with its version");
        assert!(chains.stream(&["Nothing"]).is_none());
        let table = u32::from_le_bytes(SHEET[76..80].try_into().unwrap()) as usize;
        let begin = (table + 1) << SHEET[30];
        for (place, next) in [(0_u32, 0_u32), (1, 0), (3, 2)] {
            let mut bytes = SHEET.to_vec();
            for (place, next) in [(place, next), (next, place)] {
                let at = begin + 4 * place as usize;
                bytes[at..at + 4].copy_from_slice(&next.to_le_bytes());
            }
            let fault = Chains::of(&bytes).unwrap_err();
            assert!(fault.why.contains("comes back to itself"), "{fault:?}");
        }
    }

    #[test]
    fn chains_that_join_end_all_the_same_and_longer_rings_do_not() {
        let end = 0xFFFF_FFFE;
        assert_eq!(comes_back(&[1, 2, end, 1, 3]), None);
        assert_eq!(comes_back(&[end, 0, 3, 4, 2]), Some(2));
        assert_eq!(comes_back(&[1, 2, 1]), Some(1));
        assert_eq!(comes_back(&[0]), Some(0));
        assert_eq!(comes_back(&[]), None);
    }
}
