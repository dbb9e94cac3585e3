//! The geared DC motor: model, physical effects, genetic algorithm, excitations and link messages.
//!
//! No std, no heap. The same source runs on the board and on the host.
#![no_std]

pub mod excitation;

#[cfg(test)]
extern crate std;

pub mod base;
mod brush;
pub mod effects;
pub mod fixed;
mod friction;
pub mod ga;
pub mod lanes;
pub mod linear;
pub mod link;
pub mod loss;
pub mod motor;
pub mod per_unit;
pub mod quickfit;
pub mod random;
pub mod scalar;
pub mod simulator;
pub mod step;
