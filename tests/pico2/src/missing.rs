//! Instructions of the Cortex-M33 that the emulator does not know or takes for others, so that the image is run as it is. Each is carried out by
//! another that is fetched in its place, or by this file.
//!
//! - CPS, of which it takes PRIMASK for FAULTMASK and the other way round (Armv8-M Architecture Reference Manual C2.4.36: I is bit 1, F bit 0).
//! - VSEL, VMAXNM and VMINNM, in which it looks for the condition and for the lowest bit of the destination at each other's places (C2.4, VSEL: D is
//!   bit 6 and the condition bits 5 and 4 of the first half).
//! - Loads and stores with an order (Armv8-M Architecture Reference Manual C2.4, LDA, LDAB, LDAH, STL, STLB, STLH), which it takes for jumps by
//!   a table. On one core that carries out its instructions in turn the same without an order do the same.
//! - Two registers of the floating-point unit that are moved as one (VLDM, VSTM, VPUSH, VPOP, VLDR, VSTR and VMOV of a D register), which a unit
//!   of single precision has too. Lists of them are those of the S registers of which they consist; the others become one that moves nothing,
//!   and [`Move`] does what they do.

use rp2350_emu::CortexM33;
use rp2350_emu::core::CoreBus;

/// `vmov.f32 s0, s0`: what goes with every instruction of the unit, its state being saved and so on, and no more.
const NO_MOVE: [u16; 2] = [0xeeb0, 0x0a40];

/// Barriers. At the first the emulator forgets every instruction that it has decoded, which takes more time than all else does; nothing here
/// writes instructions.
const ISB: [u16; 2] = [0xf3bf, 0x8f6f];
const DSB: [u16; 2] = [0xf3bf, 0x8f4f];

/// What is fetched in the place of an instruction; nothing where the emulator knows it. Those that watch for others (LDAEX, STLEX) are left.
pub fn substitute(first: u16, second: u16) -> Option<[u16; 2]> {
    let plain = match (first & 0xfff0, second & 0x0fff) {
        (0xe8d0, 0xfaf) => 0xf8d0, // LDR
        (0xe8d0, 0xf8f) => 0xf890, // LDRB
        (0xe8d0, 0xf9f) => 0xf8b0, // LDRH
        (0xe8c0, 0xfaf) => 0xf8c0, // STR
        (0xe8c0, 0xf8f) => 0xf880, // STRB
        (0xe8c0, 0xf9f) => 0xf8a0, // STRH
        _ if first & 0xff00 == 0xfe00
            && second & 0x0f10 == 0x0a00
            && (first & 1 << 7 == 0 || first & 0b11 << 4 == 0) =>
        {
            let (lowest, condition) = (first >> 6 & 1, first >> 4 & 0b11);
            return Some([first & 0xff8f | lowest << 4 | condition << 5, second]);
        }
        _ if [first, second] == ISB => return Some(DSB),
        _ if first & 0xfe00 != 0xec00 || second & 0x0f00 != 0x0b00 => return None,
        _ if moves_one(first) => return Some(NO_MOVE),
        _ => return Some([first, second & !0x0100]),
    };
    Some([plain | first & 0xf, second & 0xf000])
}

/// What is fetched in the place of an instruction of one half.
pub fn substitute_short(half: u16) -> u16 {
    if half & 0xffe8 == 0xb660 { half & !0b11 | half >> 1 & 1 | (half & 1) << 1 } else { half }
}

/// Whether the two halves need be looked at: the first may begin one of these.
pub fn may_be(first: u16) -> bool {
    first & 0xffe0 == 0xe8c0 || first & 0xff00 == 0xfe00 || first == ISB[0] || first & 0xfe00 == 0xec00
}

/// VMOV, or VLDR and VSTR, of those that move D registers.
fn moves_one(first: u16) -> bool {
    first & 0xffe0 == 0xec40 || first & 0xff20 == 0xed00
}

/// A D register that is to be moved.
pub struct Move {
    pc: u32,
    /// The first of its S registers.
    single: usize,
    to: Place,
    /// Into the register, and not out of it.
    loads: bool,
}

enum Place {
    Registers([usize; 2]),
    Memory(u32),
}

impl Move {
    /// What the core is about to carry out, if it is one of these and its condition holds.
    pub fn next(core: &CortexM33, first: u16, second: u16) -> Option<Self> {
        if !moves_one(first) || second & 0x0f00 != 0x0b00 {
            return None;
        }
        // The condition of the IT block it stands in.
        let block = core.it_state();
        if block & 0xf != 0 && !core.regs.condition_passed(block >> 4) {
            return None;
        }
        let [vd, low, rn] = [second >> 12, second, first].map(|half| usize::from(half & 0xf));
        let pc = core.regs.pc();
        let to_left = first & 1 << 4 != 0;
        if first & 0xffe0 == 0xec40 {
            return Some(Self { pc, single: 2 * low, to: Place::Registers([vd, rn]), loads: !to_left });
        }
        let base = if rn == 15 { (pc + 4) & !3 } else { core.reg(rn) };
        let offset = u32::from(second & 0xff) * 4;
        let up = first & 1 << 7 != 0;
        let at = if up { base.wrapping_add(offset) } else { base.wrapping_sub(offset) };
        Some(Self { pc, single: 2 * vd, to: Place::Memory(at), loads: to_left })
    }

    /// Does it, where the core has gone past it and not into an exception.
    pub fn done(&self, core: &mut CortexM33, bus: &mut impl CoreBus) {
        if core.regs.pc() != self.pc + 4 {
            return;
        }
        for half in 0..2 {
            let single = &mut core.regs.s[self.single + half];
            match (&self.to, self.loads) {
                (Place::Registers(names), true) => *single = f32::from_bits(core.regs.r[names[half]]),
                (Place::Registers(names), false) => core.regs.r[names[half]] = single.to_bits(),
                (Place::Memory(at), true) => *single = f32::from_bits(bus.read32(at + 4 * half as u32, 0)),
                (Place::Memory(at), false) => bus.write32(at + 4 * half as u32, single.to_bits(), 0),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_known_is_fetched_as_what_does_the_same() {
        // lda r1, [r9] as ldr.w r1, [r9]; vpush {d8-d15} as vpush {s16-s31}; vldr d13, [pc, #856] as no move.
        assert_eq!(substitute(0xe8d9, 0x1faf), Some([0xf8d9, 0x1000]));
        assert_eq!(substitute(0xed2d, 0x8b10), Some([0xed2d, 0x8a10]));
        assert_eq!(substitute(0xed9f, 0xdbd6), Some(NO_MOVE));
        // vselge.f32 s2, s4, s2 and vselgt.f32 s3, s4, s2 with their bits as the emulator has them.
        assert_eq!(substitute(0xfe22, 0x1a01), Some([0xfe42, 0x1a01]));
        assert_eq!(substitute(0xfe72, 0x1a01), Some([0xfe72, 0x1a01]));
    }

    #[test]
    fn cps_has_its_masks_in_the_order_that_the_emulator_looks_for_them() {
        // cpsid i, cpsie i, cpsid f
        assert_eq!([0xb672, 0xb662, 0xb671].map(substitute_short), [0xb671, 0xb661, 0xb672]);
    }

    #[test]
    fn what_is_known_is_left() {
        // tbb [r9, r1]; ldrd r0, r1, [r2]; vldr s0, [r0]; vmul.f32 s0, s0, s0
        for [first, second] in [[0xe8d9, 0xf001], [0xe9d2, 0x0100], [0xed90, 0x0a00], [0xee20, 0x0a00]] {
            assert_eq!(substitute(first, second), None, "{first:x} {second:x}");
        }
    }
}
