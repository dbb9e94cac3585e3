//! An effect that a user wrote as a formula.
//!
//! Whoever reads the formula turns it into a short program for a stack of numbers, which runs in every lane at
//! once and needs no heap. Formulas are explicit: they are evaluated at the beginning of a step and held over it.
//! Dry friction and drops, which no explicit formula can hold at rest, have entries of their own, in which the
//! formula says how large they are and the step solves for their sign.

mod definition;
#[cfg(test)]
mod tests;

pub use definition::{Definition, Entry, Operation, Quantity, Unsound, UserDefined};

use definition::DEPTH;

use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::simulator::MAX_PARAMETERS;
use crate::step::{Drive, State};

/// A formula with its parameters fixed.
#[derive(Debug, Clone, Copy)]
pub struct Formula<S> {
    entry: Entry,
    program: &'static [Operation],
    parameters: [S; MAX_PARAMETERS],
    gear_ratio: S,
    cell: S,
}

impl<S: Scalar> Formula<S> {
    pub(super) fn new(definition: &Definition, parameters: &[S], setting: &Setting<S>) -> Self {
        let mut own = [S::zero(); MAX_PARAMETERS];
        own[..parameters.len()].copy_from_slice(parameters);
        Self {
            entry: definition.entry(),
            program: definition.program(),
            parameters: own,
            gear_ratio: setting.gear_ratio,
            cell: setting.cell,
        }
    }

    #[inline(always)]
    fn evaluate(&self, state: &State<S>, [voltage, command, time]: [S; 3]) -> S {
        let mut stack = [S::zero(); DEPTH + 1];
        // One above the topmost number; `Definition::new` proved that it stays within.
        let mut top = 0;
        for operation in self.program {
            let below = top - operation.takes();
            let (a, b) = (stack[below], stack[below + 1]);
            stack[below] = match operation {
                Operation::Number(x) => S::lit(*x),
                Operation::Read(Quantity::Voltage) => voltage,
                Operation::Read(Quantity::Command) => command,
                Operation::Read(Quantity::Current) => state.current,
                Operation::Read(Quantity::Speed) => state.load_speed,
                Operation::Read(Quantity::Angle) => state.load_angle,
                Operation::Read(Quantity::MotorSpeed) => state.speed * self.gear_ratio,
                Operation::Read(Quantity::MotorAngle) => state.angle * self.gear_ratio,
                Operation::Read(Quantity::Time) => time,
                Operation::Parameter(k) => self.parameters[*k],
                Operation::Add => a + b,
                Operation::Subtract => a - b,
                Operation::Multiply => a * b,
                Operation::Divide => a / b,
                Operation::Minimum => a.min(b),
                Operation::Maximum => a.max(b),
                Operation::Negate => -a,
                Operation::Absolute => a.abs(),
                Operation::Sign => a.sign(),
                Operation::Sine => (a * S::lit(PER_TURN)).sin_turns(),
                Operation::Cosine => (a * S::lit(PER_TURN)).cos_turns(),
                Operation::Function(_, f) => a.map(*f),
                Operation::FunctionOfTwo(_, f) => a.map_with(b, *f),
            };
            top = below + 1;
        }
        stack[0]
    }
}

const PER_TURN: f64 = 1.0 / core::f64::consts::TAU;

impl<S: Scalar> Effect<S> for Formula<S> {
    #[inline(always)]
    fn drive(&self, now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        if self.entry == Entry::Sensor {
            return;
        }
        let time = (S::count(now.index) - S::one()) * self.cell;
        let value = self.evaluate(&now.state, [drive.voltage, now.command, time]);
        let size = value.max(S::zero());
        match self.entry {
            Entry::Torque => drive.load_torque += value,
            Entry::Voltage => drive.voltage += value,
            Entry::Drop => drive.drop += size,
            Entry::Resistance => drive.series += size,
            Entry::Friction => {
                drive.friction_forward += size;
                drive.friction_backward += size;
            }
            Entry::Sensor => {}
        }
    }
    #[inline(always)]
    fn read(&self, state: &State<S>, _memory: &Memory<S>, reading: &mut S) {
        if self.entry == Entry::Sensor {
            *reading += self.evaluate(state, [S::zero(); 3]);
        }
    }
}
