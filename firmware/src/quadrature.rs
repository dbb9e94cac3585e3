//! A quadrature decoder for the programmable input/output blocks (PIO) of the RP2040 and the RP2350.
//!
//! Every edge of both lines counts (x4). One turn of the program takes at most [`SLOWEST_TURN`] cycles, so at 125 MHz it
//! looks at the lines more than eleven million times a second. A change of both lines at once has no direction and
//! counts nothing.
//!
//! The program keeps the position in X and the lines as it last saw them in OSR. It looks at the lines, forms the number
//! `before * 4 + now` and jumps to it: the first 16 instructions are a table, so the program must stand at address 0.
//! After each turn it offers the position to the receive FIFO, which drops it when full: who reads empties the FIFO and
//! takes the next word, which is fresh. Instruction encoding: RP2040 datasheet, section 3.4; the RP2350 keeps it.

/// Length of the table and of the program, instructions.
const TABLE: usize = 16;
const LENGTH: usize = TABLE + 11;
/// A block's memory for programs.
const _: () = assert!(LENGTH <= 32);
/// The longest turn: a step up, from one look at the lines to the next, cycles.
pub const SLOWEST_TURN: u32 = 11;
/// Where the program begins.
pub const ENTRY: u8 = LOOK;
/// Where it wraps: the last instruction jumps by itself, so it never does.
pub const WRAP: (u8, u8) = (0, LENGTH as u8 - 1);

const UP: u8 = TABLE as u8;
const DOWN: u8 = UP + 4;
const OFFER: u8 = DOWN + 1;
const LOOK: u8 = OFFER + 2;

/// `jmp`: always, or while X is not zero, after which X is one less in any case.
const fn jump(to: u8) -> u16 {
    to as u16
}
const fn jump_x_decrement(to: u8) -> u16 {
    0b010 << 5 | to as u16
}

/// `mov`, its operands by their numbers.
const fn mov(to: u16, operation: u16, from: u16) -> u16 {
    0b101 << 13 | to << 5 | operation << 3 | from
}
const X: u16 = 1;
const TO_PC: u16 = 5;
const ISR: u16 = 6;
const OSR: u16 = 7;
const PLAIN: u16 = 0;
const INVERTED: u16 = 1;

/// `out isr, 2`, `in pins, 2`, `push noblock`.
const OUT_ISR_2: u16 = 0b011 << 13 | 6 << 5 | 2;
const IN_PINS_2: u16 = 0b010 << 13 | 2;
const PUSH: u16 = 0b100 << 13;

/// The program. Line A is the first pin, B the next; A leads B while the count rises.
pub const PROGRAM: [u16; LENGTH] = program();

const fn program() -> [u16; LENGTH] {
    let mut program = [0; LENGTH];
    // The lines as a number, B above A, in the order of a rising count.
    let order = [0b00, 0b01, 0b11, 0b10];
    let mut index = 0;
    while index < TABLE {
        program[index] = jump(OFFER);
        index += 1;
    }
    let mut place = 0;
    while place < order.len() {
        let (before, now) = (order[place], order[(place + 1) % order.len()]);
        program[before * 4 + now] = jump(UP);
        program[now * 4 + before] = jump(DOWN);
        place += 1;
    }
    let tail = [
        // UP: one up is one down of the complement. X is one less whether the jump is taken or not, so a jump to the
        // next instruction only counts.
        mov(X, INVERTED, X),
        jump_x_decrement(UP + 2),
        mov(X, INVERTED, X),
        jump(OFFER),
        // DOWN
        jump_x_decrement(OFFER),
        // OFFER
        mov(ISR, PLAIN, X),
        PUSH,
        // LOOK
        OUT_ISR_2,
        IN_PINS_2,
        mov(OSR, PLAIN, ISR),
        mov(TO_PC, PLAIN, ISR),
    ];
    let mut at = 0;
    while at < tail.len() {
        program[TABLE + at] = tail[at];
        at += 1;
    }
    program
}

#[cfg(test)]
#[path = "quadrature_tests.rs"]
mod tests;
