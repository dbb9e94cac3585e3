//! The Raspberry Pi Pico 2's unmodified image on an emulated RP2350.

pub mod board;
pub mod chip;
pub mod contact;
pub mod host;
mod missing;
pub mod pins;
mod registers;
pub mod usb;
pub mod watchdog;
pub mod wires;
