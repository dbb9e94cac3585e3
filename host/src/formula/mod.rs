//! Effects that a user writes as formulas, in a text file and without recompiling.
//!
//! ```toml
//! name = "fan"
//! port = "torque"
//! formula = "-drag * speed * abs(speed)"
//! title = "a fan on the output shaft"
//! [[parameter]]
//! name = "drag"
//! unit = "V s^2/rad^2"
//! low = 0
//! high = 1
//! typical = 0.01
//! ```
//!
//! The port says what the value is: `torque` (V, drives forward), `friction` (V, how large a dry friction is),
//! `voltage` (V, added to the winding's), `drop` (V, how much is lost against the current), `resistance` (share of
//! the winding's, in series), `sensor` (rad, added to the reading). A formula is evaluated at the beginning of
//! every step of a millisecond and held over it, so a jump in it is exact to a step. Only dry friction and drops
//! need more: at rest the right value lies anywhere up to their size, which no formula of the speed can say. They
//! have ports of their own, where the formula gives the size and the step finds the force.

mod definition;
mod file;
mod grammar;
mod library;
#[cfg(test)]
mod lobe;

pub use definition::{Written, WrittenParameter};
pub use file::read;
pub use library::{Library, define, written};

use motorlens_shared::effects::{Definition, Operation, Quantity};

/// What a formula may read, in its numbers.
pub type Look<'a> = &'a dyn Fn(Quantity) -> f64;

/// The value of a formula, once and in double precision: for simulations that share nothing with the fit.
pub fn value(definition: &Definition, parameters: &[f64], look: Look) -> f64 {
    evaluate(definition.program(), parameters, look)
}

fn evaluate(program: &[Operation], parameters: &[f64], look: Look) -> f64 {
    let mut stack: Vec<f64> = Vec::with_capacity(8);
    for operation in program {
        let a = stack.split_off(stack.len() - operation.takes());
        stack.push(match operation {
            Operation::Number(x) => *x,
            Operation::Read(quantity) => look(*quantity),
            Operation::Parameter(k) => parameters[*k],
            Operation::Add => a[0] + a[1],
            Operation::Subtract => a[0] - a[1],
            Operation::Multiply => a[0] * a[1],
            Operation::Divide => a[0] / a[1],
            Operation::Minimum => a[0].min(a[1]),
            Operation::Maximum => a[0].max(a[1]),
            Operation::Negate => -a[0],
            Operation::Absolute => a[0].abs(),
            Operation::Sign if a[0] == 0.0 => 0.0,
            Operation::Sign => a[0].signum(),
            Operation::Sine => a[0].sin(),
            Operation::Cosine => a[0].cos(),
            Operation::Function(_, f) => f(a[0]),
            Operation::FunctionOfTwo(_, f) => f(a[0], a[1]),
        });
    }
    stack.pop().unwrap_or(0.0)
}
