//! The motor model, the physical effects and the compact genetic algorithm of motorlens, without std.
#![no_std]
#[cfg(test)]
extern crate std;
