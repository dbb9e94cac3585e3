//! What a function of an image does to the stack and to other functions, read off its instructions.
//!
//! Only the encodings that matter here are looked at; all others are stepped over by their length (ARMv7-M Architecture Reference
//! Manual, A5.1: a halfword that begins with 0b11101, 0b11110 or 0b11111 is the first of two). The Cortex-M0's and M33's
//! instructions are a part and an extension of these.

/// What a function's instructions do that matters outside it.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Facts {
    /// Addresses of other functions that it calls or ends in.
    pub calls: Vec<u32>,
    /// Calls and jumps through a register: their targets are not written down.
    pub indirect: usize,
    /// Bytes by which it moves the stack down, all instructions together: at least what it has of it at any instant.
    pub stack: u32,
    /// It moves the stack by what only the run knows.
    pub unbounded: bool,
    /// Constants that it makes of two halves or finds beside its code, which may be functions' addresses.
    pub constants: Vec<u32>,
}

/// What a register holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Held {
    Other,
    Constant(u32),
    /// The frame pointer, or what lies so little below it that it was pushed there.
    Frame,
    /// The stack pointer without its last bits.
    Stack(u32),
}

/// The frame pointer's, the stack pointer's and the program counter's numbers.
const FP: usize = 7;
const SP: u16 = 13;
const PC: u16 = 15;

/// Reads a function of `code` that begins at `start`; `data` tells whether an address holds data between instructions.
pub fn read(code: &[u8], start: u32, data: impl Fn(u32) -> bool) -> Facts {
    let half = |at: usize| code.get(at..at + 2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
    let word = |at: usize| Some(u32::from(half(at)?) | u32::from(half(at + 2)?) << 16);
    let end = start + code.len() as u32;
    let mut facts = Facts::default();
    // What each register was last made to hold, as far as that matters. Other writes to it are not seen: a compiler puts what makes a
    // value for the stack pointer just before its use.
    let mut held = [Held::Other; 16];
    let mut at = 0;
    while let Some(first) = half(at) {
        let address = start + at as u32;
        if data(address) {
            facts.constants.extend(word(at).filter(|_| address.is_multiple_of(4)));
            at += 2;
            continue;
        }
        let wide = first >> 11 >= 0b11101;
        let mut branch = None;
        if let (true, Some(second)) = (wide, half(at + 2)) {
            branch = wide_branch(first, second);
            wide_effects(first, second, &mut held, &mut facts);
        } else {
            branch = branch.or_else(|| narrow_branch(first));
            let literal = |offset: u32| word(((address & !3) + 4 + offset).wrapping_sub(start) as usize);
            narrow_effects(first, literal, &mut held, &mut facts);
        }
        if let Some(offset) = branch {
            let target = address.wrapping_add(4).wrapping_add_signed(offset);
            if !(start..end).contains(&target) || (target == start && is_call(first, half(at + 2))) {
                facts.calls.push(target);
            }
        }
        at += if wide { 4 } else { 2 };
    }
    facts
}

/// BL: a call of the function itself is one too.
fn is_call(first: u16, second: Option<u16>) -> bool {
    first >> 11 == 0b11110 && second.is_some_and(|second| second & 0xd000 == 0xd000)
}

/// Keeps the low `bits` of a number as a signed one.
fn signed(value: u32, bits: u32) -> i32 {
    ((value << (32 - bits)) as i32) >> (32 - bits)
}

/// The offset of B (A7.7.12, T1 and T2), CBZ and CBNZ (A7.7.21).
fn narrow_branch(code: u16) -> Option<i32> {
    if code & 0xf000 == 0xd000 && code & 0x0f00 < 0x0e00 {
        Some(signed(u32::from(code & 0xff) << 1, 9))
    } else if code & 0xf800 == 0xe000 {
        Some(signed(u32::from(code & 0x7ff) << 1, 12))
    } else if code & 0xf500 == 0xb100 {
        Some(i32::from(code >> 9 & 1) << 6 | i32::from(code >> 3 & 0x1f) << 1)
    } else {
        None
    }
}

/// The offset of BL (A7.7.18) and of B (A7.7.12, T3 and T4).
fn wide_branch(first: u16, second: u16) -> Option<i32> {
    if first & 0xf800 != 0xf000 || second & 0x8000 == 0 {
        return None;
    }
    let (sign, j1, j2) =
        (u32::from(first >> 10 & 1), u32::from(second >> 13 & 1), u32::from(second >> 11 & 1));
    let low = u32::from(second & 0x7ff) << 1;
    if second & 0x1000 != 0 {
        let (i1, i2) = (1 ^ j1 ^ sign, 1 ^ j2 ^ sign);
        let high = sign << 24 | i1 << 23 | i2 << 22 | u32::from(first & 0x3ff) << 12;
        Some(signed(high | low, 25))
    } else if second & 0x4000 == 0 && first & 0x0380 != 0x0380 {
        Some(signed(sign << 20 | j2 << 19 | j1 << 18 | u32::from(first & 0x3f) << 12 | low, 21))
    } else {
        None
    }
}

fn narrow_effects(code: u16, literal: impl Fn(u32) -> Option<u32>, held: &mut [Held; 16], facts: &mut Facts) {
    let low = |shift: u16| usize::from(code >> shift & 7);
    let register = usize::from(code >> 3 & 0xf);
    let bits = u32::from(code >> 6 & 0x1f);
    match code {
        _ if code & 0xfe00 == 0xb400 => facts.stack += 4 * (code & 0x1ff).count_ones(), // PUSH (A7.7.101)
        _ if code & 0xff80 == 0xb080 => facts.stack += 4 * u32::from(code & 0x7f),      // SUB SP (A7.7.177)
        _ if code & 0xf800 == 0x4800 => {
            // LDR literal (A7.7.44)
            held[low(8)] = literal(4 * u32::from(code & 0xff)).map_or(Held::Other, Held::Constant);
        }
        _ if code & 0xff87 == 0x4485 => match held[register] {
            // ADD SP, register (A7.7.6): a frame too large for the Cortex-M0's SUB.
            Held::Constant(value) => facts.stack += (value as i32).min(0).unsigned_abs(),
            _ => facts.unbounded = true,
        },
        _ if code & 0xff87 == 0x4685 => match held[register] {
            // MOV SP, register (A7.7.77): another stack; the end of a frame; a frame on a rounder address.
            Held::Constant(_) | Held::Frame => {}
            Held::Stack(bits) => facts.stack += (1 << bits) - 1,
            Held::Other => facts.unbounded = true,
        },
        _ if code & 0xff78 == 0x4668 => {
            // MOV register, SP
            held[usize::from(code >> 4 & 8 | code & 7)] = Held::Stack(0);
        }
        _ if code & 0xff00 == 0xaf00 => held[FP] = Held::Frame, // ADD FP, SP, constant (A7.7.5)
        _ if code & 0xfe00 == 0x1e00 => held[low(0)] = lower(held[low(3)]), // SUBS of three bits (A7.7.174)
        _ if code & 0xf800 == 0x3800 => held[low(8)] = lower(held[low(8)]), // SUBS of eight
        _ if code & 0xf800 == 0x0800 => {
            // LSRS (A7.7.70) and LSLS (A7.7.68) by as much: the last bits are cleared.
            held[low(0)] = if held[low(3)] == Held::Stack(0) { Held::Stack(bits) } else { Held::Other };
        }
        _ if code & 0xf800 == 0 => {
            held[low(0)] = if held[low(3)] == Held::Stack(bits) { held[low(3)] } else { Held::Other };
        }
        // BLX, and BX but of the return address (A7.7.19, 20)
        _ if code & 0xff07 == 0x4700 && register != 14 => facts.indirect += 1,
        // ADD and MOV to the PC are the jump tables of the Cortex-M0, which stay within the function.
        _ => {}
    }
}

/// What a register holds after something is taken off it.
fn lower(held: Held) -> Held {
    if held == Held::Frame { held } else { Held::Other }
}

fn wide_effects(first: u16, second: u16, held: &mut [Held; 16], facts: &mut Facts) {
    let immediate =
        u32::from(first >> 10 & 1) << 11 | u32::from(second >> 12 & 7) << 8 | u32::from(second & 0xff);
    let target = usize::from(second >> 8 & 0xf);
    let to_sp = second & 0x0f00 == SP << 8 && second & 0x8000 == 0;
    match first {
        0xe92d => facts.stack += 4 * second.count_ones(), // STMDB SP! (A7.7.160)
        0xe96d => facts.stack += 4 * u32::from(second & 0xff), // STRD with SP! (A7.7.166)
        0xf84d if second & 0x0f00 == 0x0d00 => facts.stack += u32::from(second & 0xff), // STR with SP! (A7.7.161)
        _ if first & 0xffbf == 0xed2d => facts.stack += 4 * u32::from(second & 0xff),   // VPUSH (A7.7.252)
        _ if first & 0xfbef == 0xf1ad && to_sp => facts.stack += expanded(immediate),   // SUB.W SP (A7.7.177)
        _ if first & 0xfbff == 0xf2ad && to_sp => facts.stack += immediate,             // SUBW SP
        _ if first & 0xffef == 0xebad && to_sp => facts.unbounded = true, // SUB SP, register (A7.7.178)
        _ if first & 0xfbf0 == 0xf240 && second & 0x8000 == 0 => {
            held[target] = Held::Constant(u32::from(first & 0xf) << 12 | immediate); // MOVW (A7.7.76)
        }
        _ if first & 0xfbf0 == 0xf2c0 && second & 0x8000 == 0 => {
            let Held::Constant(low) = held[target] else { return }; // MOVT (A7.7.79)
            let value = low & 0xffff | (u32::from(first & 0xf) << 12 | immediate) << 16;
            held[target] = Held::Constant(value);
            facts.constants.push(value);
        }
        // LDR to the PC (A7.7.43), but not from the stack, which is a return.
        _ if first & 0xff70 == 0xf850 && second >> 12 == PC && first & 0xf != SP => facts.indirect += 1,
        _ => {}
    }
}

/// ThumbExpandImm of twelve bits (A5.3.2).
fn expanded(immediate: u32) -> u32 {
    let low = immediate & 0xff;
    match immediate >> 8 {
        0 => low,
        1 => low << 16 | low,
        2 => low << 24 | low << 8,
        3 => low << 24 | low << 16 | low << 8 | low,
        _ => (0x80 | low & 0x7f).rotate_right(immediate >> 7),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facts(code: &[u16]) -> Facts {
        let bytes: Vec<u8> = code.iter().flat_map(|half| half.to_le_bytes()).collect();
        read(&bytes, 0x0800_1000, |_| false)
    }

    #[test]
    fn what_moves_the_stack_is_summed() {
        // push {r4, r5, r7, lr}; sub sp, #16; push.w {r8, r9, r10}; vpush {d8, d9}; str r11, [sp, #-4]!; bx lr
        let code = [0xb5b0, 0xb084, 0xe92d, 0x0700, 0xed2d, 0x8b04, 0xf84d, 0xbd04, 0x4770];
        assert_eq!(facts(&code), Facts { stack: 16 + 16 + 12 + 16 + 4, ..Facts::default() });
        // sub.w sp, sp, #0x1a80; subw sp, sp, #0x123; sub.w sp, sp, r4
        assert_eq!(facts(&[0xf5ad, 0x5dd4]).stack, 0x1a80);
        assert_eq!(facts(&[0xf2ad, 0x1d23]).stack, 0x123);
        assert!(facts(&[0xebad, 0x0d04]).unbounded);
    }

    #[test]
    fn calls_leave_the_function_and_branches_within_it_do_not() {
        // bl +0x100; b.w -0x100; beq +2; cbz r0, +0; blx r3; bx lr
        let code = [0xf000, 0xf880, 0xf7ff, 0xbf80, 0xd000, 0xb100, 0x4798, 0x4770];
        let found = facts(&code);
        assert_eq!(found.calls, [0x0800_1000 + 4 + 0x100, 0x0800_1004 + 4 - 0x100]);
        assert_eq!(found.indirect, 1);
        // bl to itself
        assert_eq!(facts(&[0xf7ff, 0xfffe]).calls, [0x0800_1000]);
    }

    #[test]
    fn constants_of_two_halves_and_large_frames_of_the_smallest_core_are_seen() {
        // movw r0, #0x2345; movt r0, #0x0800
        assert_eq!(facts(&[0xf242, 0x3045, 0xf6c0, 0x0000]).constants, [0x0800_2345]);
        // ldr r6, [pc, #0]; add sp, r6; -1024
        let found = facts(&[0x4e00, 0x44b5, 0xfc00, 0xffff]);
        assert_eq!((found.stack, found.unbounded), (1024, false));
        // mov r4, sp; lsrs r4, r4, #5; lsls r4, r4, #5; mov sp, r4
        assert_eq!(facts(&[0x466c, 0x0964, 0x0164, 0x46a5]), Facts { stack: 31, ..Facts::default() });
        // add r7, sp, #12; subs r6, r7, #7; subs r6, #5; mov sp, r6
        assert_eq!(facts(&[0xaf03, 0x1ffe, 0x3e05, 0x46b5]), Facts::default());
        // mov sp, r3
        assert!(facts(&[0x469d]).unbounded);
    }
}
