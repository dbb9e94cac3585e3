//! The firmware's logic, without hardware: it runs on a board, on the virtual bench and in host tests alike.
//!
//! [`control::Control`] runs in the sampling interrupt: it reads the encoder, supervises, plays the programme and logs.
//! [`station::Station`] runs in the main loop: it talks to the host, sends the log and fits. They share one cell
//! ([`Shared`]). Hardware is what [`hardware::Hardware`] and [`station::Platform`] ask for, and no more;
//! [`board::Parts`] makes the former of embedded-hal pins.
#![no_std]

#[cfg(test)]
extern crate std;

pub mod analog;
pub mod beat;
pub mod board;
pub mod bridge;
pub mod control;
#[cfg(feature = "defmt")]
pub mod diagnostics;
pub mod encoder;
mod fault;
pub mod hardware;
pub mod log;
pub mod outbox;
pub mod quadrature;
pub mod standing;
pub mod station;
pub mod supervisor;
pub mod turns;

use core::cell::RefCell;
use critical_section::Mutex;

/// The control, shared by the sampling interrupt and the main loop.
pub type Shared<H> = Mutex<RefCell<control::Control<H>>>;
