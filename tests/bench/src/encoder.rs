//! The encoder's two lines at the chip's timer, and what can be wired wrongly around a board.

use rigless::device::{DeviceContext, Level, RegisterFile};
use rigless::soc::st::tim::{Channel, Tim};
use rigless::soc::stm32f427::generated::tim3::Register as GeneralRegister;
use rigless::soc::stm32f427::peripherals::tim::General;
use rigless::time::VirtualNanos;

use crate::machine::Machine;

/// TIM3 among the general timers.
const TIMER_3: usize = 1;
/// Both fields ICxF of a timer's CCMR1.
const FILTERS: u64 = 0xf0f0;
/// The channel of the encoder's second line.
const SECOND_LINE: u8 = 2;

/// A mistake of whoever has wired the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mistake {
    /// The encoder's A and B are swapped.
    SwappedLines,
    /// The encoder's B does not arrive.
    MissingLine,
    /// Nothing divides the supply: its input floats.
    NoDivider,
    /// The driver has no supply.
    DeadDriver,
    /// The wire of the direction forward does not arrive.
    NoForward,
}

/// The encoder's lines.
#[derive(Debug, Default)]
pub struct Encoder {
    phase: u8,
    edges: i64,
}

impl Encoder {
    /// Edges so far, those back taken off.
    pub fn edges(&self) -> i64 {
        self.edges
    }

    /// Gives the edges up to this count to the chip.
    pub fn follow(&mut self, count: i64, mistake: Option<Mistake>, at: VirtualNanos, machine: &mut Machine) {
        let target = if mistake == Some(Mistake::SwappedLines) { -count } else { count };
        if self.edges == target {
            return;
        }
        // The edges come together, at the instant of the look, and are clean: the counter's filter, which lets a level through
        // after 0.76 us, is left out while they do.
        let filtered = machine.mcu.timer(TIMER_3).1.get(GeneralRegister::Ccmr1Input);
        machine.mcu.timer(TIMER_3).1.set(GeneralRegister::Ccmr1Input, filtered & !FILTERS);
        while self.edges != target {
            let step = if target > self.edges { 1 } else { 3 };
            let next = (self.phase + step) & 3;
            let lines = |phase: u8| (phase == 1 || phase == 2, phase >= 2);
            let (old, new) = (lines(self.phase), lines(next));
            let (channel, level) = if old.0 != new.0 { (1, new.0) } else { (SECOND_LINE, new.1) };
            let level = if level { Level::High } else { Level::Low };
            let input =
                |timer: &mut Tim<General>, registers: &mut RegisterFile, context: &mut DeviceContext<'_>| {
                    timer.drive_input(Channel::new(channel).expect("1 or 2"), level, registers, context);
                };
            if channel != SECOND_LINE || mistake != Some(Mistake::MissingLine) {
                machine.mcu.drive_timer(at, TIMER_3, input);
            }
            self.phase = next;
            self.edges += if step == 1 { 1 } else { -1 };
        }
        machine.mcu.timer(TIMER_3).1.set(GeneralRegister::Ccmr1Input, filtered);
    }
}
