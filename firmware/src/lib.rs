//! The firmware logic, without hardware.
#![no_std]
