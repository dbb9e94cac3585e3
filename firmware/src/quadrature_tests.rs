//! The decoder's program on a state machine of our own, cycle by cycle, after section 3.4 of the RP2040's datasheet.

use super::*;
use proptest::prelude::*;
use std::collections::VecDeque;
use std::vec::Vec;

/// A state machine: just what the datasheet says of the instructions that the program has.
#[derive(Default)]
struct Machine {
    pc: u8,
    x: u32,
    isr: u32,
    osr: u32,
    fifo: VecDeque<u32>,
    looks: u64,
}

/// Words that the receive FIFO holds.
const FIFO: usize = 4;

impl Machine {
    fn new() -> Self {
        Self { pc: ENTRY, ..Self::default() }
    }

    /// One cycle, with the lines as they are in it. OUT shifts right and IN left, as the board sets it up.
    fn cycle(&mut self, pins: u32) {
        let instruction = PROGRAM[usize::from(self.pc)];
        assert_eq!(instruction & 0x1f00, 0, "no delay, no side-set");
        let next = if self.pc == WRAP.1 { WRAP.0 } else { self.pc + 1 };
        let argument = instruction & 0xff;
        self.pc = match instruction >> 13 {
            0b000 => {
                let taken = match argument >> 5 {
                    0b000 => true,
                    0b010 => {
                        let was = self.x;
                        self.x = was.wrapping_sub(1);
                        was != 0
                    }
                    other => panic!("jump condition {other}"),
                };
                if taken { (argument & 31) as u8 } else { next }
            }
            0b010 => {
                assert_eq!(argument, 2, "in pins, 2");
                self.isr = self.isr << 2 | pins & 3;
                self.looks += 1;
                next
            }
            0b011 => {
                assert_eq!(argument, 6 << 5 | 2, "out isr, 2");
                // OUT to ISR replaces it whole.
                self.isr = self.osr & 3;
                self.osr >>= 2;
                next
            }
            0b100 => {
                assert_eq!(argument, 0, "push noblock");
                if self.fifo.len() < FIFO {
                    self.fifo.push_back(self.isr);
                }
                self.isr = 0;
                next
            }
            0b101 => {
                let from = match argument & 7 {
                    1 => self.x,
                    6 => self.isr,
                    7 => self.osr,
                    other => panic!("mov from {other}"),
                };
                let value = if argument >> 3 & 3 == 1 { !from } else { from };
                match argument >> 5 {
                    1 => self.x = value,
                    5 => return self.pc = (value & 31) as u8,
                    6 => self.isr = value,
                    7 => self.osr = value,
                    other => panic!("mov to {other}"),
                }
                next
            }
            other => panic!("instruction {other}"),
        };
    }

    /// The position as the board reads it: what is in the FIFO is old, the next word is not.
    fn read(&mut self, pins: u32) -> u16 {
        self.fifo.clear();
        for _ in 0..=2 * SLOWEST_TURN {
            self.cycle(pins);
            if let Some(word) = self.fifo.pop_front() {
                return word as u16;
            }
        }
        panic!("no fresh word");
    }
}

/// The lines of an encoder that stands at `count`, A in bit 0.
fn lines(count: i64) -> u32 {
    [0b00, 0b01, 0b11, 0b10][count.rem_euclid(4) as usize]
}

/// Moves the encoder by these steps, each after so many cycles, and returns the position read and the true one.
fn turn(steps: impl IntoIterator<Item = (i64, u32)>) -> (u16, i64) {
    let mut machine = Machine::new();
    let mut count = 0;
    for (step, cycles) in steps {
        count += step;
        for _ in 0..cycles {
            machine.cycle(lines(count));
        }
    }
    // Time to see the last step.
    for _ in 0..2 * SLOWEST_TURN {
        machine.cycle(lines(count));
    }
    (machine.read(lines(count)), count)
}

#[test]
fn a_million_counts_a_second_are_followed_both_ways() {
    // 125 cycles a count at 125 MHz; through zero, where X wraps.
    let up = std::iter::repeat_n((1, 125), 40_000);
    let down = std::iter::repeat_n((-1, 125), 110_000);
    let (read, count) = turn(up.chain(down));
    assert_eq!((read, count), (count as u16, -70_000));
}

#[test]
fn the_fastest_encoder_that_is_followed_is_one_turn_of_the_program_a_count() {
    let fastest = std::iter::repeat_n((1, SLOWEST_TURN), 10_000).chain(std::iter::repeat_n((-1, 11), 3000));
    let (read, count) = turn(fastest);
    assert_eq!(i64::from(read), count);
    // The bound is one: a quarter of the time is too little.
    let (read, count) = turn(std::iter::repeat_n((1, SLOWEST_TURN / 4), 10_000));
    assert_ne!(i64::from(read), count);
}

#[test]
fn no_turn_takes_longer_than_said() {
    let mut machine = Machine::new();
    let (mut last, mut longest) = (0, 0);
    let mut at = Vec::new();
    for cycle in 0..20_000_u32 {
        let looks = machine.looks;
        let place = i64::from(cycle / 40);
        machine.cycle(lines(if place % 50 < 25 { place % 50 } else { 50 - place % 50 }));
        if machine.looks > looks {
            longest = longest.max(cycle - last);
            last = cycle;
            at.push(cycle);
        }
    }
    assert_eq!(longest, SLOWEST_TURN);
}

#[test]
fn a_reader_that_comes_late_gets_the_position_of_now() {
    let mut machine = Machine::new();
    for count in 0..500 {
        for _ in 0..100 {
            machine.cycle(lines(count));
        }
    }
    // Nobody read: the FIFO is full of the beginning.
    assert_eq!(machine.fifo.front(), Some(&0));
    assert_eq!(machine.read(lines(499)), 499);
}

proptest! {
    #[test]
    fn any_motion_that_is_slow_enough_is_followed(
        steps in proptest::collection::vec((-1_i64..=1, SLOWEST_TURN..200), 1..400),
    ) {
        let (read, count) = turn(steps);
        prop_assert_eq!(read, count as u16);
    }

    #[test]
    fn a_line_that_bounces_ends_where_it_settles(bounces in 0_usize..40, cycles in 1_u32..60) {
        // Back and forth over one edge, however fast, and then up.
        let steps = (0..2 * bounces).map(|at| (if at % 2 == 0 { 1 } else { -1 }, cycles)).chain([(1, 50)]);
        let (read, count) = turn(steps);
        prop_assert_eq!((read, count), (1, 1));
    }
}
