//! The virtual bench: the unmodified firmware image on an emulated STM32F4, with what stands around a real board.
//!
//! [`machine`] is the chip, [`plant`] the driver and motor at its pins, [`encoder`] the encoder at them, [`cable`] the serial line and what can
//! happen to it, [`bench`] puts them together and gives a [`bench::Remote`] the line's other end.

pub mod bench;
pub mod cable;
pub mod encoder;
pub mod machine;
pub mod plant;
pub mod remote;
pub mod sines;
pub mod terminal;
mod upset;
