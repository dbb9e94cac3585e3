//! The converter's inputs, and what they were shown.

use rigless::soc::stm32f427::peripherals::adc::Channel as AdcChannel;
use rigless::time::VirtualNanos;

use super::{NS_PER_TICK, Plant};
use crate::encoder::Mistake;
use crate::machine::Machine;

/// Inputs of the converter.
const CURRENT_INPUT: u8 = 1;
const SUPPLY_INPUT: u8 = 4;
/// What the supply's input reads where nothing is wired to it, V.
const FLOATING_V: f64 = 0.2;

/// What the converter's inputs were shown after a sampling interrupt: sums over looks.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sensed {
    supply_v: f64,
    current_a: f64,
    looks: f64,
}

impl Plant {
    /// The means of supply, V, and current, A, that the converter's inputs were shown in the interval after sample number `index` of the
    /// first run.
    pub fn sensed(&self, index: usize) -> Option<(f64, f64)> {
        let first = self.first_driven? + 1 + index * self.beats;
        let mut all = Sensed::default();
        for at in first..first + self.beats {
            let part = self.sensed.get(&at)?;
            all.supply_v += part.supply_v;
            all.current_a += part.current_a;
            all.looks += part.looks;
        }
        Some((all.supply_v / all.looks, all.current_a / all.looks))
    }

    /// The converter's inputs follow supply and current.
    pub fn sense(&mut self, at: VirtualNanos, machine: &mut Machine) {
        let period = self.ticks * NS_PER_TICK;
        let since = at.0.saturating_sub(self.period_began.0) as f64 % period;
        // High or low, its mean over the period is zero.
        let high = self.enabled && since < self.duty * period;
        let pulse = if high { self.duty - 1.0 } else { self.duty };
        let swing = (std::f64::consts::TAU * 10.0 * at.0 as f64 * 1e-9).sin();
        let rippled = if self.enabled { pulse } else { 0.0 };
        let supply_v = self.motor.supply_v() + self.pumped_v + self.swing_v * swing + self.ripple_v * rippled;
        let current_a = self.motor.current_a() + self.short_a - self.ripple_a * rippled;
        let sensed = self.sensed.entry(self.sampled.len()).or_default();
        sensed.supply_v += supply_v;
        sensed.current_a += current_a;
        sensed.looks += 1.0;
        let (converter, _) = machine.mcu.converter(0);
        let current = 1.65 + 0.165 * current_a;
        let supply = if self.mistake == Some(Mistake::NoDivider) { FLOATING_V } else { supply_v / 11.0 };
        for (input, volts) in [(SUPPLY_INPUT, supply), (CURRENT_INPUT, current)] {
            let millivolts = (volts * 1000.0).round().clamp(0.0, 3300.0) as u32;
            converter.set_input(AdcChannel::new(input).expect("the converter has it"), millivolts);
        }
    }
}
