//! The Raspberry Pi Pico 2's unmodified image on an emulated RP2350, with a driver, a motor, an encoder and a USB host.
//!
//! `rp2350-emu` 0.2.6 has the core, the flash, the port, PIO, PWM, timers and clocks. What it lacks, or has otherwise than the data sheet, stands
//! in front of it ([`wires::Beside`]): USB's device side, the watchdog, the contact's edges, the converter and the DMA of its readings, the core's
//! mask of interrupts that go to its NMI, the rate of the tick generators; and instructions that it does not know or mistakes are fetched as
//! others (`missing`).
//!
//! Shown: the image starts without a fault and with its bridge off, samples in time by its own timer, counts by its own PIO program,
//! talks over USB from the bus's reset on, plays programmes, measures supply and current, fits with the host's bits, and takes its pins off and
//! comes back by the watchdog, with the reason noted, after faults of its core, its program, its timer, its crystal, its contact and its host.
//!
//! Not shown: the boot ROM and what it makes of the image's definition (the image is entered at its vector table); cycles to the last one,
//! for the core goes on alone for 32 of them and then all else does; the electrical side of USB.
//! The PIO goes on after edges and looks at it alone, for between them it repeats itself; its `jmp x--` leaves an X of zero as it is
//! (RP2350 data sheet 11.4.2: it is one less in any case), so no count goes below zero here, and the shaft is turned ahead first.

pub mod board;
pub mod chip;
pub mod contact;
pub mod converter;
pub mod dma;
pub mod host;
mod missing;
pub mod pins;
mod registers;
pub mod usb;
pub mod watchdog;
pub mod wires;
