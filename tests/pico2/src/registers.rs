//! How the chip's registers take what is written to them.

/// The address without the bits that say how it is written (RP2350 data sheet 2.1.3).
pub fn address(address: u32) -> u32 {
    address & !0x3000
}

/// What a register holds that had `old`, after `value` was written to it at `address`: as it is, or bits of it turned over, set or cleared.
pub fn written(old: u32, value: u32, address: u32) -> u32 {
    match address >> 12 & 3 {
        0 => value,
        1 => old ^ value,
        2 => old | value,
        _ => old & !value,
    }
}
