//! The chains of sectors in a compound file (`.xls`): whoever follows one that comes back to itself never ends.
//!
//! Layout of \[MS-CFB\] (Compound File Binary File Format, Microsoft): a header of 512 bytes, sectors behind it, and tables in which
//! each sector names the one that follows it.

use super::Fault;

/// Numbers from here on are no sectors but ends and marks.
const NO_SECTOR: u32 = 0xFFFF_FFFA;
/// Sectors of the table that the header itself names.
const NAMED: usize = 109;

/// Refuses a file of which a chain comes back to itself.
///
/// # Errors
/// A fault that names the table.
pub fn check(all: &[u8]) -> Result<(), Fault> {
    let number = |at: usize| {
        let four = all.get(at..at + 4)?;
        Some(u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
    };
    let shift = all.get(30).copied().unwrap_or_default();
    if ![9, 12].contains(&shift) {
        return Err(Fault::broken(30, "where the size of its sectors stands"));
    }
    let size = 1_usize << shift;
    let begin = |sector: u32| (sector as usize + 1) << shift;
    let numbers = |sector: u32| (0..size / 4).map_while(move |k| number(begin(sector) + 4 * k));
    let is_sector = |sector: &u32| *sector < NO_SECTOR;
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
    let mut short = Vec::new();
    let mut sector = number(60).filter(is_sector);
    while let Some(now) = sector {
        short.extend(numbers(now));
        sector = following.get(now as usize).copied().filter(is_sector);
    }
    comes_back(&short).map_or(Ok(()), |sector| Err(fault(sector)))
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
        assert_eq!(check(SHEET), Ok(()));
        let table = u32::from_le_bytes(SHEET[76..80].try_into().unwrap()) as usize;
        let begin = (table + 1) << SHEET[30];
        for (place, next) in [(0_u32, 0_u32), (1, 0), (3, 2)] {
            let mut bytes = SHEET.to_vec();
            for (place, next) in [(place, next), (next, place)] {
                let at = begin + 4 * place as usize;
                bytes[at..at + 4].copy_from_slice(&next.to_le_bytes());
            }
            let fault = check(&bytes).unwrap_err();
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
